//! `oit plan`.

use std::path::PathBuf;

use oit_capture::MeshBytes;
use oit_fragments::DepthHistogram;
use oit_lab::{Fragments, FrameSize, Stage, Technique, Tuner, assemble, cuda_source};

use crate::command::render::{overrides, size};
use crate::command::report;

/// Which plan is printed.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The technique, by coordinate or alias.
    technique: String,
    /// A scene file.
    #[arg(long, default_value = "scenes/planes.toml")]
    scene: PathBuf,
    /// A scene parameter, `name=value`; may be given several times.
    #[arg(long = "set")]
    set: Vec<String>,
    /// Width and height in pixels.
    #[arg(long, default_value = "1920x1080")]
    size: String,
    /// The peak depth complexity it is assembled for.
    #[arg(long, default_value_t = 128)]
    peak: u32,
    /// The tuning file of a device, for the sort `auto` and for `intervals-optimal`: which intervals
    /// are optimal is asked of a view whose pixels all have the peak.
    #[arg(long)]
    tuning: Option<PathBuf>,
    /// Print the shaders too.
    #[arg(long)]
    shaders: bool,
}

/// Prints a plan. No device is needed.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let technique: Technique = arguments.technique.parse().map_err(report)?;
    let size = size(&arguments.size)?;
    let scene = oit_scene::load(&arguments.scene, &overrides(&arguments.set)?).map_err(report)?;
    let bytes = MeshBytes::new(&scene.mesh);
    let FrameSize { width_px, height_px } = size;
    let geometry = bytes.view(&scene.shading, &scene.views[0].camera, width_px, height_px);
    let histogram = DepthHistogram::from_counts([arguments.peak]);
    let tuner = match &arguments.tuning {
        Some(path) => Tuner::load(path).map_err(report)?,
        None => Tuner::none("no device to choose for: name its tuning file with --tuning"),
    };
    let technique = tuner.choose(&technique, &histogram, size).map_err(report)?;
    let pool = size.pixels() * u64::from(arguments.peak);
    let fragments = Fragments::Drawn(&geometry);
    let plan = assemble(&technique, fragments, size, &histogram, pool).map_err(report)?;
    print!("{plan}");
    let in_cuda = technique.stage == Stage::Cuda;
    let resolve = in_cuda.then(|| cuda_source(&technique, size, arguments.peak));
    let resolve = resolve.transpose().map_err(report)?;
    if let Some((label, _)) = &resolve {
        println!("then, in CUDA, {label}");
    }
    if arguments.shaders {
        for pass in &plan.passes {
            let shader = match &pass.work {
                oit_gpu::Work::Compute { shader, .. } => shader,
                oit_gpu::Work::Raster(raster) => &raster.shader,
                oit_gpu::Work::Clear { .. } => continue,
            };
            println!("\n// {}\n{}", shader.label, shader.wgsl);
        }
        if let Some((label, source)) = resolve {
            println!("\n// {label}\n{source}");
        }
    }
    Ok(())
}
