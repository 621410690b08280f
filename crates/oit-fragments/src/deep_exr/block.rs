//! ZIPS: one row's bytes, rearranged so that they deflate well, and deflated.

use crate::deflate::{Wrapper, deflate, inflate};

/// zlib's level; the OpenEXR library's own default.
const LEVEL: u32 = 4;

/// Packs bytes. What does not become smaller stays as it is: a reader sees that by the length.
pub(super) fn pack(bytes: Vec<u8>) -> Vec<u8> {
    let packed = deflate(&rearrange(&bytes), LEVEL, Wrapper::Zlib);
    if packed.len() < bytes.len() { packed } else { bytes }
}

/// Unpacks bytes that must give exactly `len` bytes.
///
/// # Errors
/// What is wrong with them.
pub(super) fn unpack(packed: &[u8], len: usize) -> Result<Vec<u8>, String> {
    if packed.len() == len {
        return Ok(packed.to_vec());
    }
    Ok(restore(inflate(packed, len, Wrapper::Zlib)?))
}

/// Even bytes first, then odd ones, each less the one before, plus 128.
fn rearrange(bytes: &[u8]) -> Vec<u8> {
    let mut out: Vec<u8> =
        bytes.iter().step_by(2).chain(bytes.iter().skip(1).step_by(2)).copied().collect();
    for i in (1..out.len()).rev() {
        out[i] = out[i].wrapping_sub(out[i - 1]).wrapping_add(128);
    }
    out
}

fn restore(mut bytes: Vec<u8>) -> Vec<u8> {
    for i in 1..bytes.len() {
        bytes[i] = bytes[i].wrapping_add(bytes[i - 1]).wrapping_sub(128);
    }
    let (even, odd) = bytes.split_at(bytes.len().div_ceil(2));
    (0..bytes.len()).map(|i| if i % 2 == 0 { even[i / 2] } else { odd[i / 2] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_rearranged_as_openexr_does() {
        assert_eq!(rearrange(&[1, 10, 2, 20, 5]), [1, 129, 131, 133, 138]);
        for len in 0..9u8 {
            let bytes: Vec<u8> = (0..len).map(|i| i.wrapping_mul(77)).collect();
            assert_eq!(restore(rearrange(&bytes)), bytes);
        }
    }

    #[test]
    fn what_does_not_shrink_is_kept() {
        assert_eq!(pack(vec![1, 2, 3]), [1, 2, 3]);
        assert!(pack(vec![]).is_empty());
        let zeros = pack(vec![0; 1000]);
        assert!(zeros.len() < 100);
        assert_eq!(unpack(&zeros, 1000).unwrap(), [0; 1000]);
        assert_eq!(unpack(&[1, 2, 3], 3).unwrap(), [1, 2, 3]);
        assert!(unpack(&zeros, 999).is_err());
    }
}
