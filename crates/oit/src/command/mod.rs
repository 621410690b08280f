//! One file a verb.

pub(crate) mod advise;
pub(crate) mod compare;
mod compare_trace;
pub(crate) mod devices;
pub(crate) mod generate;
pub(crate) mod list;
pub(crate) mod pareto;
pub(crate) mod plan;
pub(crate) mod probe;
pub(crate) mod render;
pub(crate) mod sweep;
pub(crate) mod trace;
pub(crate) mod tune;
pub(crate) mod worker;

use std::path::PathBuf;

use clap::Subcommand;
use miette::miette;
use oit_record::DeviceInfo;

/// What the program does.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Print what there is: techniques, captures, schedules, sorts, scenes, experiments.
    List(list::Arguments),
    /// Print what can be used: each device with its limits, and what it lacks and why.
    Devices,
    /// Run experiments: verify every cell, then time it, and record everything.
    Sweep(sweep::Arguments),
    /// Check one sort, measure it against others, and print who wins where.
    Compare(compare::Arguments),
    /// Name the cheapest technique that a scene needs within bounds, by what was recorded.
    Advise(advise::Arguments),
    /// Measure one view by exact and approximate techniques, and print which of them nothing beats.
    Pareto(pareto::Arguments),
    /// Write what recorded runs say of a device to its tuning file, for the sort `auto` and for
    /// `intervals-optimal`.
    Tune(tune::Arguments),
    /// Render one view of a scene with one technique to PNG and EXR.
    Render(render::Arguments),
    /// Save captured fragments to a file, and resolve them again without rasterising.
    #[command(subcommand)]
    Trace(trace::Arguments),
    /// Print the plan of a technique on a view: its buffers, targets, passes, and shaders.
    Plan(plan::Arguments),
    /// Measure what is no technique: what a sorting array costs by its size and place alone.
    #[command(subcommand)]
    Probe(probe::Arguments),
    /// Write the pages that are generated from the registries, or check that they are up to date.
    Generate(generate::Arguments),
    /// Serve a runner on standard input and output.
    #[command(hide = true)]
    Worker,
}

/// Any error as a report.
pub(crate) fn report(error: impl std::error::Error) -> miette::Report {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        // Transparent errors repeat their source.
        if !text.contains(&cause.to_string()) {
            text = format!("{text}: {cause}");
        }
        source = cause.source();
    }
    miette!("{text}")
}

/// Every device that can be used, best first: real GPUs before software ones, `vulkan` before
/// `wgpu`, the CPU last.
pub(crate) fn usable_devices() -> Vec<DeviceInfo> {
    let mut devices: Vec<DeviceInfo> =
        oit_gpu::enumerate().into_iter().filter_map(|listed| listed.info.ok()).collect();
    devices.sort_by_key(|device| {
        let kind = match device.kind.as_str() {
            "discrete-gpu" => 0,
            "integrated-gpu" => 1,
            "virtual-gpu" => 2,
            _ => 3,
        };
        (kind, device.backend != "vulkan", device.id.clone())
    });
    devices.push(oit_lab::cpu_info());
    devices
}

/// The id of the device asked for; `auto` is the best there is.
pub(crate) fn device_id(asked: &str) -> miette::Result<String> {
    let devices = usable_devices();
    if asked == "auto" {
        return Ok(devices[0].id.clone());
    }
    if devices.iter().any(|device| device.id == asked) {
        return Ok(asked.to_owned());
    }
    let ids: Vec<&str> = devices.iter().map(|device| device.id.as_str()).collect();
    Err(miette!("no device is called {asked:?}; there is auto, {}", ids.join(", ")))
}

/// The folder of tuning files, if none is named.
pub(crate) const TUNING: &str = "experiments/tuning";

/// Where compiled pipelines are kept between runs.
pub(crate) fn cache_folder() -> PathBuf {
    let base = std::env::var_os("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .or_else(|| std::env::home_dir().map(|home| home.join(".cache")))
        .unwrap_or_else(std::env::temp_dir);
    base.join("oit")
}
