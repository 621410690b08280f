//! What can go wrong between records and tables.

use std::path::PathBuf;

use polars::error::PolarsError;

/// Why records do not become tables.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// A record cannot be read.
    #[error(transparent)]
    Record(#[from] oit_record::RecordError),
    /// Two events are the same sample of the same cell.
    #[error("{}: cell {cell} has sample {sample} twice", folder.display())]
    SampleTwice {
        /// The run folder.
        folder: PathBuf,
        /// The cell.
        cell: usize,
        /// The sample.
        sample: u32,
    },
    /// A stage has the name of a sum that is computed here.
    #[error("{}: a stage is named {stage}, which is a computed sum", folder.display())]
    ReservedStage {
        /// The run folder.
        folder: PathBuf,
        /// The stage.
        stage: String,
    },
    /// The same run folder was given twice.
    #[error("{}: given twice", folder.display())]
    RunTwice {
        /// The run folder.
        folder: PathBuf,
    },
    /// A frame operation failed.
    #[error("tables: {0}")]
    Frame(#[from] PolarsError),
    /// A file cannot be written.
    #[error("{}: {error}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        error: std::io::Error,
    },
}

/// Why two cells are not compared.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum CompareError {
    /// Only cells of one run and one group (scene, view, resolution) are compared.
    #[error("{0} and {1} are not of one run and one view")]
    OtherGroup(String, String),
    /// A cell has no times that may be used.
    #[error("{technique} has no time for {stage}: {state}")]
    NoTime {
        /// The technique.
        technique: String,
        /// The stage asked for.
        stage: String,
        /// The cell's state.
        state: String,
    },
}
