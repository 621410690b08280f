//! `oit probe`.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use miette::miette;

use crate::command::device_id;
use crate::command::sweep::{profile, setup, summary, with_bar};

/// What is measured.
#[derive(Subcommand)]
pub(crate) enum Arguments {
    /// What an array costs by its size alone: a full-screen pass against the array's size, in local
    /// and in workgroup memory (BMA 2013, Figure 3).
    Array(Array),
}

/// How the array probe is run.
#[derive(clap::Args)]
pub(crate) struct Array {
    /// How much of it: small enough for two processor cores, or as in the paper.
    #[arg(long, value_parser = ["quick", "full"], default_value = "quick")]
    profile: String,
    /// The device: auto, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// The run folder.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Measures, records, and says what came of it.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let Arguments::Array(Array { profile: name, device, out }) = arguments;
    let (device, profile) = (device_id(device)?, profile(name));
    let default = || oit_lab::default_folder(Path::new("runs"), "array-probe", &device, profile);
    let setup = setup(&device, profile, &[], out.clone().unwrap_or_else(default))?;
    let probe = |progress: &mut dyn FnMut(_)| oit_lab::probe_arrays(&setup, progress);
    let outcome = with_bar("array-probe", &setup, probe)?;
    println!("array-probe: {} in {}", summary(&outcome), setup.out.display());
    if outcome.wrong + outcome.failed > 0 {
        return Err(miette!(
            "{} cells are wrong and {} failed: see above",
            outcome.wrong,
            outcome.failed
        ));
    }
    Ok(())
}
