//! `oit probe`.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use miette::miette;
use oit_lab::ProfileName;

use crate::command::sweep::{profile, setup, summary, with_bar};
use crate::command::{device_id, report};

/// What is measured.
#[derive(Subcommand)]
pub(crate) enum Arguments {
    /// What an array costs by its size alone: a full-screen pass against the array's size, in local
    /// and in workgroup memory (BMA 2013, Figure 3).
    Array(Array),
    /// What the device's memory moves: bytes a second copied and filled by compute shaders, and written
    /// to colour attachments.
    Bandwidth(Bandwidth),
}

/// How the bandwidth probe is run.
#[derive(clap::Args)]
pub(crate) struct Bandwidth {
    /// The device: auto, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// The run folder, if it is to be recorded.
    #[arg(long)]
    out: Option<PathBuf>,
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
    match arguments {
        Arguments::Array(arguments) => arrays(arguments),
        Arguments::Bandwidth(arguments) => bandwidth(arguments),
    }
}

fn bandwidth(Bandwidth { device, out }: &Bandwidth) -> miette::Result<()> {
    let device = device_id(device)?;
    let setup = setup(&device, ProfileName::Full, &[], out.clone().unwrap_or_default())?;
    let measured = oit_lab::probe_bandwidth(&setup, out.is_some()).map_err(report)?;
    let mib = measured.buffer_bytes >> 20;
    let line =
        |what: &str, bytes_per_s: f64| println!("  {what:<44} {:>9.1} GB/s", bytes_per_s / 1e9);
    println!("{device}: buffers of {mib} MiB, the best of {} repeats", measured.repeats);
    line("copied in compute, read and written", measured.copy_bytes_per_s);
    line("filled in compute", measured.fill_bytes_per_s);
    match measured.attachment {
        Some(told) => {
            let what = format!("drawn to attachments, {} bytes a pixel", told.bytes_per_px);
            line(&what, told.bytes_per_s);
        }
        None => println!("  it draws to no attachments as large"),
    }
    if let Some(out) = out {
        println!("recorded in {}", out.display());
    }
    Ok(())
}

fn arrays(Array { profile: name, device, out }: &Array) -> miette::Result<()> {
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
