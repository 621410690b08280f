//! `oit sweep`.

use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, miette};
use oit_lab::{Experiment, Outcome, ProfileName, Progress, RunError, Setup};
use oit_record::Verdict;
use oit_scene::SceneEntry;
use regex_lite::Regex;

use crate::command::{TUNING, cache_folder, device_id, report};

/// What is swept, and how.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Experiment files.
    #[arg(required = true)]
    experiments: Vec<PathBuf>,
    /// How much of them: small enough for two processor cores, or as in the papers.
    #[arg(long, value_parser = ["quick", "full"], default_value = "quick")]
    profile: String,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// Run only the cells whose "technique scene:view@size" matches this regular expression.
    #[arg(long)]
    only: Option<String>,
    /// The run folder; with several experiments each has a folder of its name in it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on with the run that is in the folder.
    #[arg(long)]
    resume: bool,
    /// The folder of scene files.
    #[arg(long, default_value = "scenes")]
    scenes: PathBuf,
    /// The folder of tuning files, for the sort `auto` and for `intervals-optimal`.
    #[arg(long, default_value = TUNING)]
    tuning: PathBuf,
    /// The folder of the pipeline cache. The drivers' own caches on disk are switched off with it, so
    /// that times to compile are those of an empty folder, or of what an earlier run left in it.
    #[arg(long)]
    cache: Option<PathBuf>,
    /// Print the cells and stop.
    #[arg(long)]
    dry_run: bool,
}

/// What asks drivers to keep no cache on disk: NVIDIA's (documented for OpenGL; that its Vulkan goes by
/// it has not been verified) and Mesa's (docs.mesa3d.org/envvars).
const NO_DRIVER_CACHE: [(&str, &str); 2] =
    [("__GL_SHADER_DISK_CACHE", "0"), ("MESA_SHADER_CACHE_DISABLE", "true")];

/// The commit the program was built from.
pub(crate) const COMMIT: Option<&str> = option_env!("OIT_GIT_COMMIT");

/// The profile of this name.
pub(crate) fn profile(name: &str) -> ProfileName {
    if name == "full" { ProfileName::Full } else { ProfileName::Quick }
}

/// What every run of this program has in common.
pub(crate) fn setup(
    device: &str,
    profile: ProfileName,
    scenes: &[SceneEntry],
    out: PathBuf,
) -> miette::Result<Setup> {
    let program = std::env::current_exe().into_diagnostic()?;
    Ok(Setup {
        device: device.to_owned(),
        profile,
        scenes: scenes.to_vec(),
        out,
        resume: false,
        cache: cache_folder(),
        tuning: TUNING.into(),
        commit: COMMIT
            .map(|commit| (commit.to_owned(), option_env!("OIT_GIT_DIRTY") == Some("true"))),
        command: command_line(),
        worker: vec![program.to_string_lossy().into_owned(), "worker".into()],
        worker_environment: Vec::new(),
    })
}

/// The command line as it is recorded: the program by its name, wherever it lies.
fn command_line() -> Vec<String> {
    let mut command: Vec<String> = std::env::args().collect();
    if let Some(program) = command.first_mut() {
        *program = "oit".into();
    }
    command
}

/// Runs the experiments one after the other.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let only = arguments.only.as_deref().map(Regex::new).transpose().into_diagnostic()?;
    let only = |name: &str| only.as_ref().is_none_or(|regex| regex.is_match(name));
    let load = |path: &PathBuf| Experiment::load(path).map_err(report);
    let experiments: Vec<Experiment> =
        arguments.experiments.iter().map(load).collect::<miette::Result<_>>()?;
    let profile = profile(&arguments.profile);
    let entries = oit_scene::list(&arguments.scenes).map_err(report)?;
    // Every file is checked, and the work counted, before the first cell runs.
    let mut counts = Vec::new();
    for experiment in &experiments {
        let mut cells = experiment.cells(profile, &entries).map_err(report)?;
        cells.retain(|cell| only(&cell.name()));
        println!("{}: {} cells", experiment.name, cells.len());
        if arguments.dry_run {
            for cell in &cells {
                println!("  {}", cell.name());
            }
        }
        counts.push(cells.len());
    }
    if arguments.dry_run {
        return Ok(());
    }
    if counts.iter().sum::<usize>() == 0 {
        return Err(miette!("no cell is left: --only keeps none"));
    }
    let device = device_id(&arguments.device)?;
    let mut all = Outcome::default();
    for (experiment, _) in experiments.iter().zip(&counts).filter(|(_, cells)| **cells > 0) {
        let folder = match &arguments.out {
            Some(out) if experiments.len() > 1 => out.join(&experiment.name),
            Some(out) => out.clone(),
            None => {
                let root = Path::new("runs");
                oit_lab::default_folder(root, &experiment.name, &device, profile)
            }
        };
        let mut setup = setup(&device, profile, &entries, folder)?;
        setup.resume = arguments.resume;
        setup.tuning.clone_from(&arguments.tuning);
        if let Some(cache) = &arguments.cache {
            setup.cache.clone_from(cache);
            let off = NO_DRIVER_CACHE.map(|(name, value)| (name.to_owned(), value.to_owned()));
            setup.worker_environment.extend(off);
        }
        let outcome = run_with_bar(experiment, &setup, &only)?;
        println!("{}: {} in {}", experiment.name, summary(&outcome), setup.out.display());
        all.exact += outcome.exact;
        all.approximate += outcome.approximate;
        all.wrong += outcome.wrong;
        all.skipped += outcome.skipped;
        all.failed += outcome.failed;
    }
    if all.wrong + all.failed > 0 {
        return Err(miette!("{} cells are wrong and {} failed: see above", all.wrong, all.failed));
    }
    Ok(())
}

/// Runs one experiment under a progress bar, and prints what went wrong on the way.
pub(crate) fn run_with_bar(
    experiment: &Experiment,
    setup: &Setup,
    only: &dyn Fn(&str) -> bool,
) -> miette::Result<Outcome> {
    with_bar(&experiment.name, setup, |progress| oit_lab::run(experiment, setup, only, progress))
}

/// Runs something that tells its progress under a bar, and prints what went wrong on the way.
pub(crate) fn with_bar(
    what: &str,
    setup: &Setup,
    run: impl FnOnce(&mut dyn FnMut(Progress)) -> Result<Outcome, RunError>,
) -> miette::Result<Outcome> {
    let bar = ProgressBar::new(0);
    let style = "{msg:40!} {wide_bar} {pos}/{len} steps, {elapsed} gone, {eta} left";
    bar.set_style(ProgressStyle::with_template(style).into_diagnostic()?);
    let (mut cells, mut ended) = (0, 0);
    run(&mut |progress| match progress {
        Progress::Started { cells: count, groups, steps, done, device } => {
            cells = count;
            bar.println(format!(
                "{what}: {count} cells on {groups} views, {} ({}), {} profile",
                device.name,
                device.id,
                setup.profile.name(),
            ));
            bar.set_length(steps);
            bar.set_position(done);
        }
        Progress::Group(name) => bar.set_message(name),
        Progress::Verified(name, result) => {
            ended += 1;
            bar.set_message(format!("{ended}/{cells} cells"));
            if result.verdict == Verdict::Wrong {
                let note = result.note.unwrap_or_default();
                bar.println(format!("  wrong    {name}\n           {note}"));
            }
        }
        Progress::Dropped(name, reason) => {
            ended += 1;
            let reason = reason.trim_end().replace('\n', "\n           ");
            bar.println(format!("  dropped  {name}\n           {reason}"));
        }
        Progress::Steps(steps) => bar.inc(steps),
        Progress::Finished(_) => bar.finish_and_clear(),
    })
    .map_err(report)
}

/// A run in one line.
pub(crate) fn summary(outcome: &Outcome) -> String {
    let Outcome { exact, approximate, wrong, skipped, failed, wall_s, .. } = outcome;
    format!(
        "{exact} exact, {approximate} approximate, {wrong} wrong, {skipped} skipped, {failed} \
         failed; {wall_s:.1} s, {:.0} % of it outside rendering and verification",
        100.0 * outcome.overhead()
    )
}
