//! Deep images: a layered fragment buffer as an OpenEXR 2 deep scanline file, for other programs to
//! read, and back, from other programs' files too.
//!
//! The format is the [OpenEXR file layout](https://openexr.com/en/latest/OpenEXRFileLayout.html):
//! one part of type `deepscanline`, uncompressed or ZIPS. It is read and written here because the
//! `exr` crate leaves deep data out.
//!
//! # What is written
//!
//! Five channels of 32-bit floats, one sample a fragment, in the buffer's order (deep samples need
//! no order):
//!
//! - `R`, `G`, `B`: the colour times alpha, as OpenEXR has it for deep compositing. Values are
//!   linear steps of 1/255; no transfer function is applied.
//! - `A`: alpha.
//! - `Z`: the window depth, 0 at the near plane and 1 at the far plane, not a distance. The string
//!   attribute [`DEPTH_ATTRIBUTE`] says so in the file.
//!
//! What is written is read back exactly, but for the colour of fragments whose alpha is 0: times
//! alpha it is black. A trace ([`crate::trace`]) keeps everything.
//!
//! # What is read
//!
//! Any single-part deep scanline image without compression or with ZIPS, with any data window, line
//! order and channel types. Other channels are skipped, `ZBack` among them: a sample that fills a
//! range of depths becomes a fragment at its front. Colours are divided by alpha and rounded to 8
//! bits; [`DeepInfo`] says how far off that is at most. Depths may be any number, below 0 and above
//! 1 too.

mod block;
mod channel;
mod error;
mod header;
mod read;
mod write;

pub use channel::{Channel, SampleType};
pub use error::DeepExrError;
pub use header::{Compression, LineOrder, Window};
pub use read::{DeepInfo, read, read_from};
pub use write::{write, write_to};

/// The string attribute by which a file says what `Z` is.
pub const DEPTH_ATTRIBUTE: &str = "oitDepth";

/// What a file that is written says there.
pub const WINDOW_DEPTH: &str = "window depth: 0 at the near plane, 1 at the far plane";
