//! Fragment traces: a captured layered fragment buffer as one file, to be loaded exactly as it was.
//!
//! A trace is compressed, checksummed in every byte, and written whole or not at all. Damage gives
//! an error that says where; it gives neither a wrong buffer nor an allocation larger than what the
//! bytes read so far can inflate to.
//!
//! # Format, version 1
//!
//! Integers are little-endian; checksums are CRC-32 (IEEE).
//!
//! | part | bytes |
//! |---|---|
//! | start | magic `89 4F 49 54 54 0D 0A 1A`, version `u32`, length of the header `u32` (at most 64 KiB), the header, checksum of all before |
//! | each chunk | `CHNK`, its first pixel `u64`, pixels `u32`, fragments `u32`, form `u32`, length of the payload `u64`, checksum of the payload, checksum of this record, payload |
//! | end | `END.`, chunks `u64`, fragments `u64`, length of the file up to here `u64`, checksum of all chunks' checksums, checksum of this record |
//!
//! The header is a [`TraceInfo`] as JSON. Chunks follow one another without gaps. A chunk has at
//! most 65,536 pixels and 262,144 fragments, but a pixel with more is a chunk of its own. Its payload
//! is one raw deflate stream of byte planes: each value is replaced by its difference from a
//! predicted one, and all highest bytes come first, then all second highest, and so on, because the
//! high bytes of differences are mostly zero.
//!
//! - Four planes for the pixels: the count of fragments less that of the pixel before.
//! - Four planes for the depth keys, then one each for red, green, blue and alpha. The form says what
//!   they are predicted from. Bit 0: from the fragment of the same rank in the pixel before (its
//!   depth key carried on from the pixel before that), which suits smooth surfaces; else from
//!   nothing. Bit 1: red and blue are first replaced by their difference from green.
//!
//! Differences wrap, and those of counts and depth keys are folded (0, -1, 1, -2 become 0, 1, 2, 3),
//! those of colours too.

mod chunk;
mod error;
mod file;
mod info;

pub use error::TraceError;
pub use file::{info, info_from, load, load_from, save, save_to};
pub use info::{FragmentOrder, TraceInfo};

/// What the name of a trace ends in, without the dot.
pub const TRACE_EXTENSION: &str = "oitt";

/// The version of the format that is written, and the only one that is read.
pub const TRACE_VERSION: u32 = 1;
