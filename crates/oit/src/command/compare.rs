//! `oit compare`: one strategy against all others.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use miette::miette;
use oit_lab::{Experiment, Sorted, samples_by_cell};
use oit_record::statistics::{Comparison, compare, median};
use oit_record::{Event, Record, Verdict};
use oit_sort::{STRATEGIES, SortChoice};

use crate::command::sweep::{profile, run_with_bar, setup, summary};
use crate::command::{device_id, report};

/// What is compared, on what.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The sort: a strategy, a strategy and store, or several joined by `+`.
    sort: String,
    /// What it is compared with; every strategy if none is named. May be given several times.
    #[arg(long)]
    against: Vec<String>,
    /// The scenes: `depths` (a stack of 8, 16, 32, 64, 128 quads), `papers` (planes and hairball).
    #[arg(long, value_parser = ["depths", "papers"], default_value = "depths")]
    set: String,
    /// The stage: fragment or compute.
    #[arg(long, value_parser = ["fragment", "compute"], default_value = "compute")]
    stage: String,
    /// The capture whose layout is read.
    #[arg(long, default_value = "linked_list")]
    capture: String,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// 480x270 or 1920x1080.
    #[arg(long, value_parser = ["quick", "full"], default_value = "quick")]
    profile: String,
    /// The run folder.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on with the run that is in the folder.
    #[arg(long)]
    resume: bool,
    /// The folder of scene files.
    #[arg(long, default_value = "scenes")]
    scenes: PathBuf,
}

/// A set of scenes, as the axes of a sweep.
fn views(set: &str) -> String {
    if set == "papers" {
        return "views = [\"planes:front\", \"planes:back\", \"hairball:inside-front\", \
                \"hairball:inside-back\"]"
            .into();
    }
    let stack = |n: u32| format!("{{ count = {n}, order = \"random\", size = 1.8 }}");
    let stacks = [8, 16, 32, 64, 128].map(stack).join(", ");
    format!("views = [\"stack:front\"]\nscene = [{stacks}]")
}

fn experiment(arguments: &Arguments, sorts: &[String]) -> miette::Result<Experiment> {
    let quoted: Vec<String> = sorts.iter().map(|sort| format!("{sort:?}")).collect();
    let mut text = format!(
        "about = \"{} against {} other sorts, on the scenes `{}`\"\n\
         source = \"oit compare\"\n\
         [profile.quick]\nresolution = [480, 270]\nsamples = 9\nwarmup_ms = 0\ntimeout_s = 120\n\
         scene.hairball = {{ strands = 400 }}\n\
         [profile.full]\nresolution = [1920, 1080]\nsamples = 25\nwarmup_ms = 500\ntimeout_s = 120\n",
        arguments.sort,
        sorts.len() - 1,
        arguments.set
    );
    let _ = write!(
        text,
        "[[sweep]]\n{}\ncaptures = [{:?}]\nschedules = [\"bma\"]\nsorts = [{}]\nstages = [{:?}]\n",
        views(&arguments.set),
        arguments.capture,
        quoted.join(", "),
        arguments.stage,
    );
    Experiment::parse(Path::new("compare.toml"), text).map_err(report)
}

/// Measures, then prints who wins where.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let subject: SortChoice = arguments.sort.parse().map_err(report)?;
    let mut sorts = vec![subject.to_string()];
    let others: Vec<String> = if arguments.against.is_empty() {
        STRATEGIES.iter().map(|strategy| strategy.name().to_owned()).collect()
    } else {
        let parse = |text: &String| text.parse::<SortChoice>().map(|sort| sort.to_string());
        arguments.against.iter().map(parse).collect::<Result<_, _>>().map_err(report)?
    };
    sorts.extend(others.into_iter().filter(|other| *other != subject.to_string()));
    if sorts.len() < 2 {
        return Err(miette!("{subject} has nothing to be compared with"));
    }
    let experiment = experiment(arguments, &sorts)?;
    let device = device_id(&arguments.device)?;
    let profile = profile(&arguments.profile);
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = arguments.sort.replace('+', "-");
        PathBuf::from(format!("runs/compare-{name}-{}", device.replace(':', "-")))
    });
    let scenes = oit_scene::list(&arguments.scenes).map_err(report)?;
    let mut setup = setup(&device, profile, &scenes, folder.clone())?;
    setup.resume = arguments.resume;
    let outcome = run_with_bar(&experiment, &setup, &|_| true)?;
    println!("{}\n", summary(&outcome));
    print!("{}", page(&Record::read(&folder).map_err(report)?, &subject.to_string())?);
    Ok(())
}

/// One row for each view and rival.
fn page(record: &Record, subject: &str) -> miette::Result<String> {
    let samples = samples_by_cell(record);
    let mut views: BTreeMap<usize, (String, BTreeMap<String, usize>)> = BTreeMap::new();
    let mut order: Vec<String> = Vec::new();
    for (index, cell) in record.run.cells.iter().enumerate() {
        let group = cell.group();
        let place = order.iter().position(|known| *known == group).unwrap_or_else(|| {
            order.push(group.clone());
            order.len() - 1
        });
        let technique: Sorted = cell.technique.parse().map_err(report)?;
        let row = views.entry(place).or_insert_with(|| (group, BTreeMap::new()));
        row.1.insert(technique.sort.to_string(), index);
    }
    let resolve = |cell: usize| -> Option<Vec<f64>> {
        let stages = samples.get(&cell)?;
        let mut sums = stages.get("resolve")?.clone();
        if let Some(group) = stages.get("group") {
            sums.iter_mut().zip(group).for_each(|(sum, group)| *sum += group);
        }
        Some(sums)
    };
    let mut text = format!(
        "Time to group and resolve, {subject} over each other sort: below 1 is faster.\n\
         Medians with 95 % intervals; 'same' where the interval holds 1.\n"
    );
    for (group, cells) in views.values() {
        let _ = writeln!(text, "\n{group}");
        let own = cells.get(subject).copied();
        let own_samples = own.and_then(resolve);
        let Some(own_samples) = own_samples.filter(|_| own.is_some_and(|c| timed(record, c)))
        else {
            let why =
                own.and_then(|cell| ending(record, cell)).unwrap_or_else(|| "not timed".into());
            let _ = writeln!(text, "  {subject}: {why}");
            continue;
        };
        let own_ms = median(&own_samples).unwrap_or_default() / 1e6;
        let _ = writeln!(text, "  {subject:<18} {own_ms:>9.3} ms");
        for (other, &cell) in cells.iter().filter(|(other, _)| *other != subject) {
            let Some(theirs) = resolve(cell).filter(|_| timed(record, cell)) else {
                let why = ending(record, cell).unwrap_or_else(|| "not timed".into());
                let _ = writeln!(text, "  {other:<18} {why}");
                continue;
            };
            let Some((ratio, low, high, verdict)) = compare(&own_samples, &theirs, record.run.seed)
            else {
                continue;
            };
            let word = match verdict {
                Comparison::Faster => "faster",
                Comparison::Slower => "slower",
                Comparison::Same => "same",
            };
            let ms = median(&theirs).unwrap_or_default() / 1e6;
            let _ = writeln!(
                text,
                "  {other:<18} {ms:>9.3} ms   {ratio:>6.3} [{low:.3}, {high:.3}]  {word:<6}  {}",
                bar(ratio)
            );
        }
    }
    Ok(text)
}

/// A ratio as a bar on a logarithmic scale: to the left of the middle is faster.
fn bar(ratio: f64) -> String {
    const HALF: i32 = 12;
    let length = ((ratio.log2() * 4.0).round() as i32).clamp(-HALF, HALF);
    let (left, right) = (length.min(0).unsigned_abs() as usize, length.max(0) as usize);
    format!("{:>12}|{:<12}", "█".repeat(left), "█".repeat(right))
}

fn timed(record: &Record, cell: usize) -> bool {
    record.events.iter().any(|event| {
        matches!(event, Event::Verified { cell: of, result }
            if *of == cell && result.verdict != Verdict::Wrong)
    })
}

/// Why a cell has no time.
fn ending(record: &Record, cell: usize) -> Option<String> {
    record.events.iter().find_map(|event| match event {
        Event::Skipped { cell: of, reason } if *of == cell => Some(format!("skipped: {reason}")),
        Event::Failed { cell: of, reason } if *of == cell => Some(format!("failed: {reason}")),
        Event::Verified { cell: of, result } if *of == cell && result.verdict == Verdict::Wrong => {
            Some(format!("wrong: {}", result.note.clone().unwrap_or_default()))
        }
        _ => None,
    })
}
