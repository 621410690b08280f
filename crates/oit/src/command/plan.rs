//! `oit plan`.

use std::path::PathBuf;

use miette::miette;
use oit_capture::Geometry;
use oit_fragments::DepthHistogram;
use oit_gpu::Compiled;
use oit_lab::{Fragments, FrameSize, Stage, Technique, Tuner, assemble, cuda_source};
use oit_record::Statistic;

use crate::command::render::{overrides, size};
use crate::command::{cache_folder, device_id, report};

/// Which plan is printed.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The technique, by coordinate or alias, or a method.
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
    /// Compile the shaders on a device (`auto` for the best there is) and print what its driver
    /// tells of each: registers, spills, sizes. Its buffers are allocated too: a small `--size` will
    /// do.
    #[arg(long, value_name = "DEVICE")]
    statistics: Option<String>,
}

/// Prints a plan. No device is needed, but for statistics.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let technique: Technique = arguments.technique.parse().map_err(report)?;
    let size = size(&arguments.size)?;
    let scene = oit_scene::load(&arguments.scene, &overrides(&arguments.set)?).map_err(report)?;
    let FrameSize { width_px, height_px } = size;
    let camera = &scene.views[0].camera;
    let geometry = Geometry::of_scene(&scene, camera, width_px, height_px).map_err(report)?;
    let histogram = DepthHistogram::from_counts([arguments.peak]);
    let tuner = match &arguments.tuning {
        Some(path) => Tuner::load(path).map_err(report)?,
        None => Tuner::none("no device to choose for: name its tuning file with --tuning"),
    };
    let technique = tuner.choose(&technique, &histogram, size).map_err(report)?;
    let (plan, resolve) = match &technique {
        Technique::Sorted(sorted) => {
            let pool = size.pixels() * u64::from(arguments.peak);
            let fragments = Fragments::Drawn(&geometry);
            let plan = assemble(sorted, fragments, size, &histogram, pool).map_err(report)?;
            let in_cuda = sorted.stage == Stage::Cuda;
            let resolve = in_cuda.then(|| cuda_source(sorted, size, arguments.peak));
            (plan, resolve.transpose().map_err(report)?)
        }
        Technique::Method(choice) => {
            (choice.plan(&geometry, size, &histogram).map_err(report)?, None)
        }
    };
    print!("{plan}");
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
            if let oit_gpu::Work::Raster(raster) = &pass.work {
                for (stage, source) in raster.pre_raster.glsl_stages() {
                    println!("\n// {}, {stage} stage in GLSL\n{source}", shader.label);
                }
            }
        }
        if let Some((label, source)) = resolve {
            println!("\n// {label}\n{source}");
        }
    }
    if let Some(asked) = &arguments.statistics {
        let id = device_id(asked)?;
        if id == "cpu" {
            return Err(miette!("the CPU compiles no shaders; name a GPU"));
        }
        let mut device = oit_gpu::open(&id, &cache_folder()).map_err(report)?;
        let prepared = device.prepare(&plan).map_err(report)?;
        println!("\n{id}: {}, {}", device.info().name, device.info().driver);
        device.compiled(prepared).map_err(report)?.iter().for_each(print_compiled);
    }
    Ok(())
}

fn print_compiled(compiled: &Compiled) {
    println!("\n{}", compiled.shader);
    if let Some(main) = &compiled.main {
        let [x, y, z] = main.workgroup_size;
        println!("  workgroup of {x} x {y} x {z}, {} bytes declared", main.workgroup_bytes);
    }
    if let Some(ns) = compiled.compile_ns {
        let cache = match compiled.from_cache {
            Some(true) => "from the cache",
            Some(false) => "not from the cache",
            None => "it does not say whether from the cache",
        };
        println!("  made in {:.3} ms, {cache}", ns as f64 / 1e6);
    }
    let Some(executables) = &compiled.executables else {
        println!("  the driver tells nothing of it");
        return;
    };
    for executable in executables {
        let stages = executable.stages.join(", ");
        println!("  {} ({stages}), subgroups of {}", executable.name, executable.subgroup_size);
        for Statistic { name, description, value } in &executable.statistics {
            println!("    {name:<28} {:>12}  {description}", value.number());
        }
    }
}
