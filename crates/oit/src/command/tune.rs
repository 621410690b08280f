//! `oit tune`: from recorded runs to tuning files.

use std::path::PathBuf;

use miette::IntoDiagnostic;
use oit_lab::{Tuning, tune, tuning_path};
use oit_record::Record;

use crate::command::{TUNING, report};

/// Which runs, and where to.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Run folders, or folders of them: of the experiments sort-intervals (for `auto`) and bma-cost
    /// (for `intervals-optimal`), or others with such cells.
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// The folder of tuning files: one a device and backend. What a file has of other captures,
    /// stages, tie rules and sorts stays.
    #[arg(long, default_value = TUNING)]
    out: PathBuf,
}

/// Writes a file for each device of the runs.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let mut records = Vec::new();
    for folder in &arguments.runs {
        records.extend(Record::read_all(folder).map_err(report)?);
    }
    std::fs::create_dir_all(&arguments.out).into_diagnostic()?;
    for newer in tune(&records).map_err(report)? {
        let path = tuning_path(&arguments.out, &newer.device, &newer.backend);
        let said = summary(&newer);
        let mut tuning = newer;
        if path.exists() {
            let mut older = Tuning::load(&path).map_err(report)?;
            older.update(tuning);
            tuning = older;
        }
        // Never half a file: another program may be reading it.
        let partial = path.with_extension("toml.partial");
        std::fs::write(&partial, tuning.text()).into_diagnostic()?;
        std::fs::rename(&partial, &path).into_diagnostic()?;
        println!("{}\n{said}", path.display());
    }
    Ok(())
}

/// What runs said, a line each.
fn summary(tuning: &Tuning) -> String {
    let mut lines = Vec::new();
    for entry in &tuning.fastest {
        let size = |(size, sort, _): &(u32, String, f64)| format!("{size} {sort}");
        let sizes: Vec<String> = entry.sizes.iter().map(size).collect();
        let (capture, stage) = (&entry.capture, &entry.stage);
        lines.push(format!("  {capture}, {stage}: the fastest up to {}", sizes.join(", ")));
    }
    for entry in &tuning.intervals {
        let (capture, schedule) = (&entry.capture, &entry.schedule);
        let us = entry.interval_ns / 1e3;
        lines.push(format!("  {capture}, {schedule}: {us:.2} us an interval"));
    }
    for entry in &tuning.pixels {
        let (capture, stage, sort) = (&entry.capture, &entry.stage, &entry.sort);
        let points = entry.points.len();
        lines.push(format!("  {capture}, {stage}, {sort}: what a pixel costs at {points} points"));
    }
    lines.join("\n")
}
