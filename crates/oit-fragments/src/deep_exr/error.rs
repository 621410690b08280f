//! What can go wrong with a deep image.

use std::io;
use std::path::{Path, PathBuf};

/// Why a deep image was not written or not read.
#[derive(Debug, thiserror::Error)]
pub enum DeepExrError {
    /// Something is wrong with this file.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<DeepExrError>,
    },
    /// The system could not read or write.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The first bytes are not those of an OpenEXR file.
    #[error("not an OpenEXR file: it begins with {found:02x?}")]
    NotExr {
        /// The first bytes, four at most.
        found: Vec<u8>,
    },
    /// An OpenEXR file, but not of the kind that is read here.
    #[error(
        "{found}: only single-part deep scanline images are read, without compression or with ZIPS"
    )]
    Unsupported {
        /// What it is.
        found: String,
    },
    /// There is no depth.
    #[error("no channel Z, only {found:?}")]
    NoDepth {
        /// The channels there are.
        found: Vec<String>,
    },
    /// Bytes that no such file has.
    #[error("damaged at byte {offset}: {what}")]
    Damaged {
        /// Where what is damaged begins, from the start of the file.
        offset: u64,
        /// What is wrong there.
        what: String,
    },
    /// A sample that no fragment can have.
    #[error("pixel ({x}, {y}), sample {sample}: {channel} is {value}")]
    Value {
        /// Column, from the left of the data window.
        x: u32,
        /// Row, from the top of the data window.
        y: u32,
        /// Which sample of the pixel.
        sample: usize,
        /// The channel.
        channel: &'static str,
        /// NaN, or an infinite colour.
        value: f32,
    },
    /// OpenEXR has no images without pixels.
    #[error("an image of {width}x{height} pixels cannot be written")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A row is larger than the 2 GiB that the OpenEXR library reads.
    #[error("row {row} has {samples} samples, at most {max} can be written")]
    RowTooLarge {
        /// The row.
        row: u32,
        /// Its samples.
        samples: usize,
        /// The most there may be.
        max: usize,
    },
}

impl DeepExrError {
    /// The same error, naming the file.
    pub(super) fn of_file(self, path: &Path) -> Self {
        Self::File { path: path.to_owned(), source: Box::new(self) }
    }

    /// The error itself, without the file's name.
    #[must_use]
    pub fn fault(&self) -> &Self {
        match self {
            Self::File { source, .. } => source.fault(),
            other => other,
        }
    }
}
