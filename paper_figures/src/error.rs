//! What can go wrong between tables and figures.

use std::path::PathBuf;

/// Why figures are not made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Records cannot be read or do not make tables.
    #[error(transparent)]
    Analysis(#[from] analysis::AnalysisError),
    /// Two cells that cannot be compared were.
    #[error(transparent)]
    Compare(#[from] analysis::CompareError),
    /// The vendored font is damaged.
    #[error("the vendored font cannot be read")]
    Font,
    /// The drawing library refused.
    #[error("drawing: {0}")]
    Draw(String),
    /// A file of published numbers or claims is not what it should be.
    #[error("{file}: {reason}")]
    Data {
        /// The file, within this crate.
        file: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A file beside a record is damaged.
    #[error("{}: {reason}", path.display())]
    Sidecar {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A name that is none of those there are.
    #[error("no {what} is named {name}; there are: {known}")]
    Unknown {
        /// What kind of name.
        what: &'static str,
        /// The name.
        name: String,
        /// All there are.
        known: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        error: std::io::Error,
    },
}
