//! `oit trace`: captured fragments as files.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use miette::miette;
use oit_capture::CAPTURES;
use oit_fragments::deep_exr::{self, Compression};
use oit_fragments::trace::{self, FragmentOrder, TRACE_EXTENSION, TraceInfo};
use oit_fragments::{DepthHistogram, Lfb};
use oit_lab::{
    DEEP_EXTENSION, Experiment, Origin, STORED_VIEW, Stored, Technique, ViewData,
    cuda_segmented_sort, load_stored, open_engine, provenance, samples_by_cell, scene_name,
    stored_entry,
};
use oit_record::statistics::median;
use oit_record::{Event, Record};

use crate::command::render::{overrides, size};
use crate::command::sweep::{COMMIT, profile, run_with_bar, setup, summary};
use crate::command::{cache_folder, device_id, report};

/// What is done with traces.
#[derive(clap::Subcommand)]
pub(crate) enum Arguments {
    /// Capture one view of a scene, and save its fragments: a trace (.oitt), or a deep OpenEXR
    /// image (.exr).
    Save(Save),
    /// Resolve saved fragments with every sort and schedule, without rasterising: verify each, then
    /// time it, as a sweep does.
    Replay(Replay),
    /// Print what a trace or a deep image holds.
    Info {
        /// The file.
        file: PathBuf,
    },
    /// Turn a trace into a deep OpenEXR image, or a deep image into a trace.
    Convert(Convert),
    /// Time CUDA's own segmented sort (CUB's) on the fragments, where the CUDA toolkit is: it sorts
    /// each pixel's, and composites nothing.
    SegmentedSort {
        /// The trace (.oitt) or deep image (.exr).
        file: PathBuf,
        /// How often it is timed, after a run that is not.
        #[arg(long, default_value_t = 9)]
        samples: u32,
    },
}

/// What is captured, and where to.
#[derive(clap::Args)]
pub(crate) struct Save {
    /// A scene file.
    scene: PathBuf,
    /// The file: NAME.oitt or NAME.exr.
    out: PathBuf,
    /// One of its views; the first if none is named.
    #[arg(long)]
    view: Option<String>,
    /// A scene parameter, `name=value`; may be given several times.
    #[arg(long = "set")]
    set: Vec<String>,
    /// Width and height in pixels.
    #[arg(long, default_value = "1920x1080")]
    size: String,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// Replace the file if it is there.
    #[arg(long)]
    overwrite: bool,
}

/// What is turned into what.
#[derive(clap::Args)]
pub(crate) struct Convert {
    /// The file there is: NAME.oitt or NAME.exr.
    from: PathBuf,
    /// The file to write: NAME.exr or NAME.oitt.
    to: PathBuf,
    /// How a deep image is compressed.
    #[arg(long, value_parser = ["none", "zips"], default_value = "zips")]
    compression: String,
    /// Replace the file if it is there.
    #[arg(long)]
    overwrite: bool,
}

/// What is replayed, and how.
#[derive(clap::Args)]
pub(crate) struct Replay {
    /// The trace (.oitt) or deep image (.exr).
    file: PathBuf,
    /// The sorts, by commas; `all` for every strategy.
    #[arg(long, value_delimiter = ',', default_value = "all")]
    sorts: Vec<String>,
    /// The schedules, by commas.
    #[arg(long, value_delimiter = ',', default_value = "base,bma")]
    schedules: Vec<String>,
    /// The layouts that the fragments are put into, by commas.
    #[arg(long, value_delimiter = ',', default_value = "linked_list")]
    captures: Vec<String>,
    /// The stages, by commas.
    #[arg(long, value_delimiter = ',', default_value = "compute")]
    stages: Vec<String>,
    /// Samples of each.
    #[arg(long, default_value_t = 9)]
    samples: u32,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// The run folder.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on with the run that is in the folder.
    #[arg(long)]
    resume: bool,
}

/// Does it.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    match arguments {
        Arguments::Save(save) => run_save(save),
        Arguments::Replay(replay) => run_replay(replay),
        Arguments::Info { file } => run_info(file),
        Arguments::Convert(convert) => run_convert(convert),
        Arguments::SegmentedSort { file, samples } => run_segmented_sort(file, *samples),
    }
}

fn run_segmented_sort(file: &Path, samples: u32) -> miette::Result<()> {
    check_ending(file)?;
    let stored = load_stored(file).map_err(report)?;
    let runs_ns = cuda_segmented_sort(&stored.lfb, samples).map_err(report)?;
    let ms: Vec<f64> = runs_ns.iter().map(|&ns| ns as f64 / 1e6).collect();
    let total = stored.lfb.fragments().len();
    let middle = median(&ms).map_or("-".to_owned(), |ms| format!("{ms:.3}"));
    println!("{total} fragments of {} pixels, sorted right", stored.lfb.pixels());
    println!("CUB's segmented sort: {middle} ms, median of {}", ms.len());
    Ok(())
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension() == Some(OsStr::new(ending))
}

/// Refuses a name that says neither of the two kinds of file.
fn check_ending(path: &Path) -> miette::Result<()> {
    if has_ending(path, TRACE_EXTENSION) || has_ending(path, DEEP_EXTENSION) {
        return Ok(());
    }
    let path = path.display();
    Err(miette!("{path}: its name must end in .{TRACE_EXTENSION} or .{DEEP_EXTENSION}"))
}

fn write(path: &Path, stored: &Stored, compression: Compression, over: bool) -> miette::Result<()> {
    if has_ending(path, DEEP_EXTENSION) {
        return deep_exr::write(path, &stored.lfb, compression, over).map_err(report);
    }
    let info = match &stored.origin {
        Origin::Trace(info) => info.clone(),
        Origin::DeepImage(_) => TraceInfo {
            scene: "a deep OpenEXR image".into(),
            oit_version: env!("CARGO_PKG_VERSION").into(),
            git_commit: COMMIT.map(str::to_owned),
            created: provenance::now(),
            ..TraceInfo::new(&stored.lfb)
        },
    };
    trace::save(path, &info, &stored.lfb, over).map_err(report)
}

fn run_save(arguments: &Save) -> miette::Result<()> {
    check_ending(&arguments.out)?;
    let size = size(&arguments.size)?;
    let overrides = overrides(&arguments.set)?;
    let scene = oit_scene::load(&arguments.scene, &overrides).map_err(report)?;
    let view = arguments.view.clone().unwrap_or_else(|| scene.views[0].name.clone());
    let data = ViewData::new(&scene, &view, size).map_err(report)?;
    let device = device_id(&arguments.device)?;
    let mut engine = open_engine(&device, &cache_folder()).map_err(report)?;
    engine.open_view(data).map_err(report)?;
    let (mut lfb, counts) = engine.reference().map_err(report)?;
    if !lfb.counts().eq(counts) {
        return Err(miette!(
            "the capture and the count pass differ: this device cannot be trusted"
        ));
    }
    let order = if engine.info().backend == "cpu" {
        FragmentOrder::Submission
    } else {
        // A list is read from its newest fragment on, and is its own inverse.
        CAPTURES[0].order(&mut lfb);
        FragmentOrder::Unspecified
    };
    let info = TraceInfo {
        scene: scene_name(&scene.name, &overrides),
        view,
        order,
        capture: CAPTURES[0].name().into(),
        device: engine.info().name.clone(),
        oit_version: env!("CARGO_PKG_VERSION").into(),
        git_commit: COMMIT.map(str::to_owned),
        created: provenance::now(),
        ..TraceInfo::new(&lfb)
    };
    let stored = Stored { lfb, origin: Origin::Trace(info) };
    write(&arguments.out, &stored, Compression::Zips, arguments.overwrite)?;
    print_counts(&stored.lfb, &arguments.out);
    Ok(())
}

fn run_convert(arguments: &Convert) -> miette::Result<()> {
    check_ending(&arguments.from)?;
    check_ending(&arguments.to)?;
    let stored = load_stored(&arguments.from).map_err(report)?;
    let compression = match arguments.compression.as_str() {
        "none" => Compression::None,
        _ => Compression::Zips,
    };
    write(&arguments.to, &stored, compression, arguments.overwrite)?;
    print_counts(&stored.lfb, &arguments.to);
    Ok(())
}

fn print_counts(lfb: &Lfb, path: &Path) {
    let (histogram, bytes) = (lfb.histogram(), path.metadata().map_or(0, |file| file.len()));
    let total = histogram.total();
    println!(
        "{total} fragments, up to {} on one of {} covered pixels of {}x{}: {bytes} bytes, {:.2} a \
         fragment",
        histogram.peak(),
        histogram.covered(),
        lfb.width(),
        lfb.height(),
        bytes as f64 / total.max(1) as f64
    );
}

fn run_info(file: &Path) -> miette::Result<()> {
    check_ending(file)?;
    // All of it is read: what is printed of a damaged file would be worth nothing.
    let Stored { lfb, origin } = load_stored(file).map_err(report)?;
    match origin {
        Origin::Trace(info) => {
            let text = toml::to_string(&info).map_err(report)?;
            print!("{text}");
        }
        Origin::DeepImage(info) => {
            println!("deep image, {:?}, rows {:?}", info.compression, info.line_order);
            println!("data window {:?} to {:?}", info.data_window.min, info.data_window.max);
            let channels = info.channels.iter();
            let channels =
                channels.map(|channel| format!("{} {:?}", channel.name, channel.sample_type));
            println!("channels {}", channels.collect::<Vec<_>>().join(", "));
            if !info.skipped.is_empty() {
                println!("not read: {}", info.skipped.join(", "));
            }
            if !info.missing.is_empty() {
                println!("missing: {}", info.missing.join(", "));
            }
            let z = info.depth.as_deref().unwrap_or("not said");
            println!("Z is {z}; colours as bytes are off by up to {:.2e}", info.largest_error);
        }
    }
    print_counts(&lfb, file);
    print_histogram(&lfb.histogram());
    Ok(())
}

/// How many pixels each interval of the paper has.
fn print_histogram(histogram: &DepthHistogram) {
    let (mut low, mut high) = (1, 8);
    while low <= histogram.peak() {
        println!("{low:>5} to {high:<5} {:>10} pixels", histogram.pixels_in(low, high));
        (low, high) = (high + 1, high * 2);
    }
}

fn list(words: &[String]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
    quoted.join(", ")
}

fn run_replay(arguments: &Replay) -> miette::Result<()> {
    check_ending(&arguments.file)?;
    let stored = load_stored(&arguments.file).map_err(report)?;
    let entry = stored_entry(&arguments.file);
    let profiles = ["quick", "full"].map(|profile| {
        format!(
            "[profile.{profile}]\nresolution = [{}, {}]\nsamples = {}\nwarmup_ms = 100\n\
             timeout_s = 300\n",
            stored.lfb.width(),
            stored.lfb.height(),
            arguments.samples
        )
    });
    let text = format!(
        "about = {about:?}\nsource = \"oit trace replay\"\n{}\
         [[sweep]]\ncaptures = [{}]\nschedules = [{}]\nsorts = [{}]\nstages = [{}]\n\
         views = [{view:?}]\n",
        profiles.concat(),
        list(&arguments.captures),
        list(&arguments.schedules),
        list(&arguments.sorts),
        list(&arguments.stages),
        about = format!("The fragments of {}, captured before", arguments.file.display()),
        view = format!("{}:{STORED_VIEW}", entry.name),
    );
    drop(stored);
    let experiment = Experiment::parse(Path::new("replay.toml"), text).map_err(report)?;
    let device = device_id(&arguments.device)?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        PathBuf::from(format!("runs/replay-{}-{}", entry.name, device.replace(':', "-")))
    });
    let mut setup = setup(&device, profile("quick"), &[entry], folder.clone())?;
    setup.resume = arguments.resume;
    let outcome = run_with_bar(&experiment, &setup, &|_| true)?;
    println!("{} in {}\n", summary(&outcome), folder.display());
    print_times(&Record::read(&folder).map_err(report)?)
}

/// The resolve times, fastest first, then what was not timed and why.
fn print_times(record: &Record) -> miette::Result<()> {
    let samples = samples_by_cell(record);
    let mut notes: BTreeMap<usize, String> = BTreeMap::new();
    for event in &record.events {
        match event {
            Event::Skipped { cell, reason } | Event::Failed { cell, reason } => {
                notes.insert(*cell, reason.clone());
            }
            Event::Verified { cell, result } => {
                let note = result.note.as_ref().map_or(String::new(), |note| format!(": {note}"));
                notes.insert(*cell, format!("{:?}{note}", result.verdict));
            }
            _ => {}
        }
    }
    let mut rows = Vec::new();
    for (place, cell) in record.run.cells.iter().enumerate() {
        // A name that the runner has recorded is a technique's.
        let technique: Technique = cell.technique.parse().map_err(report)?;
        let stage = |stage: &str| Some(median(samples.get(&place)?.get(stage)?)? / 1e6);
        let note = notes.remove(&place).unwrap_or_default();
        rows.push((stage("resolve"), stage("group"), technique.to_string(), note));
    }
    let ms = |time: Option<f64>| time.map_or("-".to_owned(), |ms| format!("{ms:.3}"));
    rows.sort_by(|a, b| a.0.unwrap_or(f64::MAX).total_cmp(&b.0.unwrap_or(f64::MAX)));
    println!("{:>11} {:>9}  technique", "resolve ms", "group ms");
    for (resolve, group, technique, note) in rows {
        println!("{:>11} {:>9}  {technique}  {note}", ms(resolve), ms(group));
    }
    Ok(())
}
