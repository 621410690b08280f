//! Deflate, to and from memory, for both file formats.

use flate2::{Compress, Compression, Decompress, FlushCompress, FlushDecompress, Status};

/// Deflate makes at most this many bytes of one: 258 bytes a match, which takes two bits at least.
const MAX_EXPANSION: u64 = 1032;

/// What stands around deflated bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Wrapper {
    /// Nothing.
    None,
    /// zlib's header and checksum.
    Zlib,
}

/// Whether that many deflated bytes can hold `len` bytes: asked before `len` bytes are allocated.
pub(crate) fn may_hold(packed_len: u64, len: u64) -> bool {
    len <= packed_len.saturating_mul(MAX_EXPANSION)
}

/// Deflates.
pub(crate) fn deflate(bytes: &[u8], level: u32, wrapper: Wrapper) -> Vec<u8> {
    let mut compress = Compress::new(Compression::new(level), wrapper == Wrapper::Zlib);
    let mut packed = Vec::with_capacity(bytes.len() / 2 + 64);
    loop {
        let taken = compress.total_in() as usize;
        let status = compress
            .compress_vec(&bytes[taken..], &mut packed, FlushCompress::Finish)
            .expect("there is always room to deflate to");
        if status == Status::StreamEnd {
            return packed;
        }
        packed.reserve(packed.len() / 2 + 64);
    }
}

/// Inflates bytes that must give exactly `len` bytes, no fewer and no more.
///
/// # Errors
/// What is wrong with them.
pub(crate) fn inflate(packed: &[u8], len: usize, wrapper: Wrapper) -> Result<Vec<u8>, String> {
    if !may_hold(packed.len() as u64, len as u64) {
        return Err(format!("{} bytes cannot inflate to {len}", packed.len()));
    }
    // One more than needed, so that the stream's end is read however full the buffer is.
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(len + 1).map_err(|_| format!("no memory for {len} bytes"))?;
    bytes.resize(len + 1, 0);
    let mut decompress = Decompress::new(wrapper == Wrapper::Zlib);
    let status = decompress
        .decompress(packed, &mut bytes, FlushDecompress::Finish)
        .map_err(|error| format!("the deflated bytes are damaged: {error}"))?;
    if decompress.total_out() != len as u64 || status != Status::StreamEnd {
        return Err(format!("the deflated bytes do not give {len} bytes"));
    }
    if decompress.total_in() != packed.len() as u64 {
        return Err("there are bytes after the deflated ones".to_owned());
    }
    bytes.truncate(len);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_whatever_it_is_like() {
        let mixed: Vec<u8> =
            (0..100_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for bytes in [&[][..], b"a", &[7; 100_000], &mixed] {
            for wrapper in [Wrapper::None, Wrapper::Zlib] {
                let packed = deflate(bytes, 6, wrapper);
                assert_eq!(inflate(&packed, bytes.len(), wrapper).unwrap(), bytes);
            }
        }
    }

    #[test]
    fn another_length_is_an_error() {
        let packed = deflate(&[7; 1000], 6, Wrapper::None);
        assert!(inflate(&packed, 999, Wrapper::None).is_err());
        assert!(inflate(&packed, 1001, Wrapper::None).is_err());
        assert!(inflate(&packed[..packed.len() - 1], 1000, Wrapper::None).is_err());
        assert!(inflate(&[&packed[..], b"x"].concat(), 1000, Wrapper::None).is_err());
    }

    #[test]
    fn what_cannot_be_is_not_allocated() {
        assert!(
            inflate(b"ten bytes!", usize::MAX / 2, Wrapper::None).unwrap_err().contains("cannot")
        );
        // The densest there is still passes.
        let packed = deflate(&vec![0; 10_000_000], 9, Wrapper::Zlib);
        assert!(may_hold(packed.len() as u64, 10_000_000));
        assert!(!may_hold(packed.len() as u64, 11_000_000));
    }
}
