//! What a run leaves behind: the record schema, its reader and writer, and the statistics on samples.

mod device;
mod folder;
mod program;
mod schema;
pub mod statistics;
mod subject;
mod work;

pub use device::{DeviceInfo, Unsupported};
pub use folder::{Record, RecordError, RunWriter};
pub use program::{Executable, Program, Statistic, StatisticValue};
pub use schema::{
    Cell, Change, Event, Host, LOST, Run, SCHEMA_VERSION, Stability, Verdict, Verification,
};
pub use subject::{Conformance, Subject, SubjectPart};
pub use work::{AttachmentBandwidth, Bandwidth, PassKind, PassWork, RasterCounts};
