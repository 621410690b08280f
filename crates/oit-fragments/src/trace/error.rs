//! What can go wrong with a trace.

use std::io;
use std::path::{Path, PathBuf};

use super::TRACE_VERSION;

/// Why a trace was not written or not read.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// Something is wrong with this file.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<TraceError>,
    },
    /// The system could not read or write.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The first bytes are not those of a trace.
    #[error("not a fragment trace: it begins with {found:02x?}")]
    NotATrace {
        /// The first eight bytes.
        found: [u8; 8],
    },
    /// A trace of a version that this program does not read.
    #[error("a fragment trace of version {found}; this program reads version {TRACE_VERSION}")]
    Version {
        /// The version it says it has.
        found: u32,
    },
    /// Bytes that are not what was written.
    #[error("damaged at byte {offset}: {what}")]
    Damaged {
        /// Where what is damaged begins, from the start of the file.
        offset: u64,
        /// What is wrong there.
        what: String,
    },
    /// The header to be written is not that of the buffer.
    #[error("the header says {what} is {header}, the buffer has {lfb}")]
    Mismatch {
        /// Which field.
        what: &'static str,
        /// What the header says.
        header: u64,
        /// What the buffer has.
        lfb: u64,
    },
    /// The header's texts are too long.
    #[error("the header has {bytes} bytes, at most {max} can be written")]
    HeaderTooLong {
        /// Its length as JSON.
        bytes: usize,
        /// The longest there may be.
        max: usize,
    },
    /// More fragments on one pixel than the format counts.
    #[error("pixel {pixel} has {fragments} fragments, more than {}", u32::MAX)]
    PixelTooDeep {
        /// The pixel.
        pixel: usize,
        /// Its fragments.
        fragments: usize,
    },
}

impl TraceError {
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
