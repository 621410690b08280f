//! `analysis tables RUN_OR_ROOT... --out DIR`: records to parquet and CSV.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use analysis::AnalysisError;
use clap::{Parser, Subcommand};
use oit_record::Record;

/// Records to tidy tables.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write samples, cells, their summary, their resolve programs and the work of their passes as
    /// parquet and CSV.
    Tables {
        /// Run folders, or folders of run folders.
        #[arg(required = true)]
        records: Vec<PathBuf>,
        /// Where to write them.
        #[arg(long)]
        out: PathBuf,
    },
}

fn tables(records: &[PathBuf], out: &Path) -> Result<(), AnalysisError> {
    let mut read = Vec::new();
    for root in records {
        read.extend(Record::read_all(root)?);
    }
    let mut tables = analysis::load(&read)?;
    tables.write(out)?;
    let rows = (tables.samples.height(), tables.cells.height(), tables.summary.height());
    println!(
        "{} runs: {} samples, {} cells, {} summaries in {}",
        read.len(),
        rows.0,
        rows.1,
        rows.2,
        out.display()
    );
    Ok(())
}

fn main() -> ExitCode {
    let Command::Tables { records, out } = Arguments::parse().command;
    match tables(&records, &out) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("analysis: {error}");
            ExitCode::FAILURE
        }
    }
}
