//! `oit compare`: one sort against others. Whether it sorts, first; then the times, by depth
//! complexity, order of submission and in whole scenes; or, of a trace, its CPU twin.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use miette::{IntoDiagnostic, miette};
use oit_lab::{Experiment, ProfileName, Sorted, samples_by_cell};
use oit_record::statistics::{Comparison, compare, median};
use oit_record::{Conformance, Event, Record, Subject, SubjectPart, Verdict};
use oit_sort::{SortChoice, Store};

use crate::command::compare_trace;
use crate::command::render::size;
use crate::command::sweep::{profile, run_with_bar, setup, summary};
use crate::command::{cache_folder, device_id, report};

/// What is compared, on what.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The sort: a strategy, a strategy and store, or several joined by `+`.
    pub(super) sort: String,
    /// What it is compared with, joined by commas or given several times: sorts, or `all`.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "passthrough,insertion,rbs,network,network_merge,cooperative"
    )]
    pub(super) against: Vec<String>,
    /// A trace (.oitt) or deep image (.exr): resolve its fragments with the CPU twins, and count their
    /// comparisons. Needs no GPU.
    #[arg(long)]
    pub(super) trace: Option<PathBuf>,
    /// With a trace, the most pixels of an interval of depth complexity.
    #[arg(long, default_value_t = 20_000)]
    pub(super) pixels: usize,
    /// The depths of pixels, powers of two from 8 to 512 joined by commas; where not given those up
    /// to 128 in the quick profile, and all in the full one.
    #[arg(long, value_delimiter = ',')]
    depths: Vec<u32>,
    /// The orders of submission.
    #[arg(
        long,
        value_delimiter = ',',
        value_parser = ["front", "reverse", "random"],
        default_value = "front,reverse,random"
    )]
    orders: Vec<String>,
    /// Whole scenes, `scene:view` joined by commas, or `none`.
    #[arg(long, value_delimiter = ',', default_value = "planes:front,atrium:rbs-v2")]
    scenes: Vec<String>,
    /// `fragment` measures the fragment stage beside compute.
    #[arg(long, value_parser = ["fragment", "compute"], default_value = "compute")]
    stage: String,
    /// The captures whose layouts are read. The first has all orders, the others `random`.
    #[arg(long, value_delimiter = ',', default_value = "linked_list,linearized")]
    captures: Vec<String>,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// 160x90 or 1920x1080.
    #[arg(long, value_parser = ["quick", "full"], default_value = "quick")]
    profile: String,
    /// Another width and height in pixels.
    #[arg(long)]
    size: Option<String>,
    /// Samples of each cell, in the place of the profile's.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) samples: Option<u32>,
    /// The run folder.
    #[arg(long)]
    pub(super) out: Option<PathBuf>,
    /// Go on with the run that is in the folder.
    #[arg(long)]
    resume: bool,
    /// The folder of scene files.
    #[arg(long, default_value = "scenes")]
    scene_folder: PathBuf,
}

/// The seed of the bootstrap: that of `analysis`, so that what is printed and the page agree.
pub(super) const SEED: u64 = 2014;

/// The depths there are.
const DEPTHS: [u32; 7] = [8, 16, 32, 64, 128, 256, 512];

/// What sorts where a sort does not hold the deepest pixels of a scene.
const BEYOND: &str = "rbs_hier";

impl Arguments {
    fn depths(&self) -> miette::Result<Vec<u32>> {
        if let Some(depth) = self.depths.iter().find(|depth| !DEPTHS.contains(depth)) {
            return Err(miette!("no depth is {depth}: there are {DEPTHS:?}"));
        }
        Ok(match (self.depths.is_empty(), profile(&self.profile)) {
            (false, _) => self.depths.clone(),
            (true, ProfileName::Quick) => DEPTHS[..5].to_vec(),
            (true, ProfileName::Full) => DEPTHS.to_vec(),
        })
    }

    /// The subject, then what it is compared with.
    pub(super) fn sorts(&self) -> miette::Result<Vec<SortChoice>> {
        let subject: SortChoice = self.sort.parse().map_err(report)?;
        if subject.is_auto() {
            return Err(miette!("auto is no sort of its own: name what it is to be compared"));
        }
        let mut sorts = vec![subject];
        for word in &self.against {
            let named = match word.as_str() {
                "all" => SortChoice::all(),
                word => vec![word.parse().map_err(report)?],
            };
            for sort in named {
                if !sorts.contains(&sort) {
                    sorts.push(sort);
                }
            }
        }
        if sorts.len() < 2 {
            return Err(miette!("{} has nothing to be compared with", self.sort));
        }
        Ok(sorts)
    }
}

/// A sort that holds any scene: [`BEYOND`] where it ends.
fn for_any_depth(sort: &SortChoice) -> SortChoice {
    let mut parts = sort.parts().to_vec();
    parts.extend(BEYOND.parse::<SortChoice>().iter().flat_map(|beyond| beyond.parts().to_vec()));
    // Where the sort holds as many by itself, the other would never be reached.
    SortChoice::from_parts(parts).unwrap_or_else(|_| sort.clone())
}

fn list<T: ToString>(words: impl IntoIterator<Item = T>) -> String {
    let quoted: Vec<String> =
        words.into_iter().map(|word| format!("{:?}", word.to_string())).collect();
    quoted.join(", ")
}

/// Squares behind one another, so large that the deepest pixels' fragments have room in a buffer.
fn stack(depth: u32, order: &str) -> String {
    let order = match order {
        "front" => "front_to_back",
        "reverse" => "back_to_front",
        random => random,
    };
    let (size, gap) = match depth {
        0..=128 => (1.8, 0.015),
        129..=256 => (1.25, 0.005),
        _ => (0.9, 0.005),
    };
    format!("{{ count = {depth}, order = {order:?}, size = {size}, gap = {gap} }}")
}

fn experiment(arguments: &Arguments, sorts: &[SortChoice]) -> miette::Result<Experiment> {
    let sizes = match &arguments.size {
        Some(text) => {
            let size = size(text)?;
            [[size.width_px, size.height_px]; 2]
        }
        None => [[160, 90], [1920, 1080]],
    };
    let samples = |profile: u32| arguments.samples.unwrap_or(profile);
    let mut text = format!(
        "about = {:?}\nsource = \"oit compare\"\n\
         [profile.quick]\nresolution = {:?}\nsamples = {}\nwarmup_ms = 50\ntimeout_s = 120\n\
         scene.hairball = {{ strands = 400 }}\n\
         [profile.full]\nresolution = {:?}\nsamples = {}\nwarmup_ms = 200\ntimeout_s = 120\n",
        format!("{} against {} other sorts", sorts[0], sorts.len() - 1),
        sizes[0],
        samples(7),
        sizes[1],
        samples(9),
    );
    let stages: &[&str] =
        if arguments.stage == "fragment" { &["compute", "fragment"] } else { &["compute"] };
    let mut sweep = |views: &str, captures: &[String], sorts: &[SortChoice]| {
        let _ = write!(
            text,
            "[[sweep]]\n{views}\ncaptures = [{}]\nschedules = [\"bma\"]\nsorts = [{}]\n\
             stages = [{}]\n",
            list(captures),
            list(sorts),
            list(stages)
        );
    };
    for depth in arguments.depths()? {
        let mut held = sorts.to_vec();
        held.retain(|sort| sort.for_max_frags(depth).is_ok());
        // What the subject does not hold says nothing of it.
        if held.first() != Some(&sorts[0]) {
            continue;
        }
        for order in &arguments.orders {
            let all = order == "random" || arguments.captures.len() < 2;
            let captures = if all { &arguments.captures[..] } else { &arguments.captures[..1] };
            let views = format!("views = [\"stack:front\"]\nscene = {}", stack(depth, order));
            sweep(&views, captures, &held);
        }
    }
    let whole: Vec<SortChoice> = sorts.iter().map(for_any_depth).collect();
    let scenes: Vec<&String> = arguments.scenes.iter().filter(|scene| *scene != "none").collect();
    if !scenes.is_empty() {
        sweep(&format!("views = [{}]", list(scenes)), &arguments.captures, &whole);
    }
    Experiment::parse(Path::new("compare.toml"), text).map_err(report)
}

/// Runs the conformance suite on the subject, up to the depth that is measured.
fn subject(sort: &SortChoice, device: &str, deepest: u32) -> miette::Result<Subject> {
    let mut parts = Vec::new();
    for part in sort.parts() {
        let (strategy, store) = (part.strategy, part.store);
        let conformance = if device == "cpu" {
            oit_lab::twin_conforms(strategy, store, deepest)
        } else {
            let mut device = oit_gpu::open(device, &cache_folder()).map_err(report)?;
            oit_lab::kernel_conforms(&mut *device, strategy, store, deepest).map_err(report)?
        };
        parts.push(SubjectPart {
            name: strategy.name().to_owned(),
            summary: strategy.summary().to_owned(),
            citation: strategy.citation().to_owned(),
            store: store.name().to_owned(),
            stores: strategy.stores().iter().map(|store: &Store| store.name().into()).collect(),
            limit: part.limit(),
            conformance,
        });
    }
    Ok(Subject { sort: sort.to_string(), device: device.to_owned(), parts })
}

/// Prints what the conformance suite found.
///
/// # Errors
/// Where it found the sort wrong.
pub(super) fn told(subject: &Subject) -> miette::Result<()> {
    for part in &subject.parts {
        let Conformance { compared, up_to, programs, lists, lacking, .. } = &part.conformance;
        let lacking =
            lacking.as_ref().map(|reason| format!("; not run {reason}")).unwrap_or_default();
        println!(
            "{}: {compared}: {programs} programs of up to {up_to} fragments, {lists} lists{lacking}",
            part.name
        );
    }
    match subject.wrong() {
        Some((name, what)) => Err(miette!("{name} does not sort, and is not timed: {what}")),
        None => Ok(()),
    }
}

/// The run folder where none is named.
pub(super) fn folder(arguments: &Arguments, sort: &SortChoice, on: &str) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| {
        let name = sort.to_string().replace('+', "-");
        PathBuf::from(format!("runs/compare-{name}-{}", on.replace(':', "-")))
    })
}

/// Compares, then prints who wins where.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let sorts = arguments.sorts()?;
    if let Some(trace) = &arguments.trace {
        return compare_trace::run(arguments, trace, &sorts);
    }
    let experiment = experiment(arguments, &sorts)?;
    let device = device_id(&arguments.device)?;
    let profile = profile(&arguments.profile);
    let folder = folder(arguments, &sorts[0], &device);
    let scenes = oit_scene::list(&arguments.scene_folder).map_err(report)?;
    // A mistake in a name is found before anything runs.
    if experiment.cells(profile, &scenes).map_err(report)?.is_empty() {
        return Err(miette!("{} holds none of these depths, and no scene is named", sorts[0]));
    }
    if !arguments.resume && folder.join("run.json").exists() {
        return Err(miette!(
            "{} holds a run already: resume it (--resume) or name another folder",
            folder.display()
        ));
    }
    let deepest = arguments.depths()?.into_iter().max().unwrap_or(8);
    let found = subject(&sorts[0], &device, deepest)?;
    found.write(&folder).map_err(report)?;
    told(&found)?;
    let mut setup = setup(&device, profile, &scenes, folder.clone())?;
    setup.resume = arguments.resume;
    let outcome = run_with_bar(&experiment, &setup, &|_| true)?;
    println!("{} in {}\n", summary(&outcome), folder.display());
    print!("{}", page(&Record::read(&folder).map_err(report)?, &sorts[0].to_string())?);
    std::io::Write::flush(&mut std::io::stdout()).into_diagnostic()
}

/// Whether a technique's sort is this one, possibly with another where it ends.
fn is_sort(technique: &str, sort: &str) -> bool {
    technique == sort || technique.strip_prefix(sort).is_some_and(|rest| rest.starts_with('+'))
}

/// One row for each view, capture and stage, and rival.
fn page(record: &Record, subject: &str) -> miette::Result<String> {
    let samples = samples_by_cell(record);
    // Cells that differ in their sort alone, in the order of the run.
    let mut families: Vec<(String, Vec<(String, usize)>)> = Vec::new();
    for (index, cell) in record.run.cells.iter().enumerate() {
        let technique: Sorted = cell.technique.parse().map_err(report)?;
        let sort = technique.sort.to_string();
        let rest = cell.technique.replace(&format!("/{sort}/"), " ");
        let family = format!("{}, {rest}", cell.group());
        match families.iter_mut().find(|(known, _)| *known == family) {
            Some((_, cells)) => cells.push((sort, index)),
            None => families.push((family, vec![(sort, index)])),
        }
    }
    let resolve = |cell: usize| -> Option<Vec<f64>> {
        let stages = samples.get(&cell)?;
        let mut sums = stages.get("resolve")?.clone();
        if let Some(group) = stages.get("group") {
            sums.iter_mut().zip(group).for_each(|(sum, group)| *sum += group);
        }
        Some(sums).filter(|_| timed(record, cell))
    };
    let mut text = format!(
        "Time to group and resolve, {subject} over each other sort: below 1 is faster.\n\
         Medians with 95 % intervals; 'same' where the interval holds 1.\n"
    );
    for (family, cells) in &families {
        let Some((name, own)) = cells.iter().find(|(sort, _)| is_sort(sort, subject)) else {
            continue;
        };
        let _ = writeln!(text, "\n{family}");
        let Some(own_samples) = resolve(*own) else {
            let _ = writeln!(text, "  {name}: {}", ending(record, *own));
            continue;
        };
        let own_ms = median(&own_samples).unwrap_or_default() / 1e6;
        let _ = writeln!(text, "  {name:<24} {own_ms:>9.3} ms");
        for (other, cell) in cells.iter().filter(|(_, cell)| cell != own) {
            let Some(theirs) = resolve(*cell) else {
                let _ = writeln!(text, "  {other:<24} {}", ending(record, *cell));
                continue;
            };
            let Some((ratio, low, high, verdict)) = compare(&own_samples, &theirs, SEED) else {
                continue;
            };
            let (ms, word) = (median(&theirs).unwrap_or_default() / 1e6, word(verdict));
            let _ = writeln!(
                text,
                "  {other:<24} {ms:>9.3} ms   {ratio:>6.3} [{low:.3}, {high:.3}]  {word:<6}  {}",
                bar(ratio)
            );
        }
    }
    Ok(text)
}

/// A verdict in a word.
pub(super) fn word(verdict: Comparison) -> &'static str {
    match verdict {
        Comparison::Faster => "faster",
        Comparison::Slower => "slower",
        Comparison::Same => "same",
    }
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
fn ending(record: &Record, cell: usize) -> String {
    let why = record.events.iter().find_map(|event| match event {
        Event::Skipped { cell: of, reason } if *of == cell => Some(format!("skipped: {reason}")),
        Event::Failed { cell: of, reason } if *of == cell => Some(format!("failed: {reason}")),
        Event::Verified { cell: of, result } if *of == cell && result.verdict == Verdict::Wrong => {
            Some(format!("wrong: {}", result.note.clone().unwrap_or_default()))
        }
        _ => None,
    });
    why.unwrap_or_else(|| "not timed".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sort_that_ends_is_continued_in_scenes() {
        let name = |sort: &str| for_any_depth(&sort.parse().unwrap()).to_string();
        assert_eq!(name("network"), "network+rbs_hier");
        assert_eq!(name("network+rbs"), "network+rbs+rbs_hier");
        assert_eq!(name("insertion"), "insertion");
        assert_eq!(name(BEYOND), BEYOND);
        assert!(is_sort("network+rbs_hier", "network") && !is_sort("network_merge", "network"));
    }
}
