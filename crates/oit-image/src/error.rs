//! What can go wrong with an image.

use std::path::PathBuf;

/// An error of this crate. Each says which file, pixel or channel it is about.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// Two things that describe the same pixels do not have the same number of them.
    #[error("{what}: {found} values for {expected} pixels")]
    Size {
        /// What has the wrong number of values.
        what: &'static str,
        /// Pixels there are.
        expected: usize,
        /// Values there are.
        found: usize,
    },
    /// A count does not fit into 16 bits.
    #[error("pixel {pixel} has count {count}, more than 65535: not writable as 16-bit PNG")]
    CountTooLarge {
        /// Index of the pixel, row by row from the top left.
        pixel: usize,
        /// Its count.
        count: u32,
    },
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The EXR library refused the image or the file.
    #[error("{path}: {source}")]
    Exr {
        /// The file.
        path: PathBuf,
        /// Why.
        source: exr::error::Error,
    },
    /// An EXR file is valid, but not one that [`crate::read_exr`] reads.
    #[error("{path}: {reason}")]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// What is different.
        reason: String,
    },
    /// The PNG library refused the image.
    #[error("{path}: {source}")]
    Png {
        /// The file.
        path: PathBuf,
        /// Why.
        source: png::EncodingError,
    },
}

/// Checks that `what` has one value for each of `width * height` pixels.
pub(crate) fn check_len(
    what: &'static str,
    width: u32,
    height: u32,
    found: usize,
) -> Result<(), ImageError> {
    let expected = width as usize * height as usize;
    if found == expected { Ok(()) } else { Err(ImageError::Size { what, expected, found }) }
}
