//! `oit worker`: the process that touches the device.

use crate::command::report;

/// Serves until standard input ends.
pub(crate) fn run() -> miette::Result<()> {
    oit_lab::serve().map_err(report)
}
