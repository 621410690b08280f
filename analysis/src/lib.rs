//! Records to tidy tables: polars frames, summaries with intervals, comparisons.
//!
//! [`load`] turns records into [`Tables`]: one row a sample, one row a cell, one row a cell and
//! stage, one row a resolve program, one row a figure that a driver tells of one, one row a pass
//! whose work was counted. Statistics come from [`oit_record::statistics`] only.

mod cell;
mod compare;
mod error;
pub mod occupancy;
mod programs;
mod run;
mod tables;
mod technique;
mod work;

pub use cell::{CellResult, State, Timing};
pub use compare::{Ratio, compare};
pub use error::{AnalysisError, CompareError};
pub use programs::{ProgramFigures, executable};
pub use run::RunInfo;
pub use tables::{BOOTSTRAP_SEED, Tables, load};
pub use technique::{Technique, path_frame, scene_name, scene_parameters};
pub use work::WorkSum;

/// The stage name under which the sum of `group` and `resolve` is summarised: what the papers call
/// the resolve pass, which under backwards memory allocation includes grouping the pixels.
pub const RESOLVE: &str = "resolve+group";

/// The name of the part of a stage that is spent on the pixels of the interval that ends at `upper`:
/// `resolve[16]`.
#[must_use]
pub fn part(stage: &str, upper: u32) -> String {
    format!("{stage}[{upper}]")
}

/// The stage name of the time from before the first stage to after the last.
pub const TOTAL: &str = "total";
