//! From runs to tuning files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use oit_record::statistics::median;
use oit_record::{Event, Record, Verdict};

use crate::assemble::{intervals, sort_spec};
use crate::runner::samples_by_cell;
use crate::technique::{IntervalChoice, MaxFrags, Pool, Schedule, Sorted};
use crate::tuning::{Fastest, FromRun, IntervalCost, PixelCost, Tuning};

/// Why runs are no tuning.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// A run that was not completed: the order in which cells were sampled is part of it.
    #[error("{}: the run is not finished; go on with it (`oit sweep --resume`)", folder.display())]
    Unfinished {
        /// The run folder.
        folder: PathBuf,
    },
    /// No run says anything of strategies or intervals.
    #[error("no exact cell of bma on a view whose pixels are all as deep: nothing to tune by")]
    Nothing,
}

/// What runs say of their devices, one tuning a device and backend. Of two runs that say the same
/// thing, the later one counts.
///
/// Only cells count that are exact, hold all fragments, and are on a view whose covered pixels all
/// have as many fragments as each other (`stack`):
///
/// - With powers of two for intervals and one strategy, where the array is as large as pixels are
///   deep: of each capture, stage, tie rule and depth the strategy of the least median resolve time
///   is the fastest.
/// - With given bounds that make one interval: the median resolve time over the covered pixels is
///   what a pixel of this depth costs in an array of this size.
/// - The same with more intervals behind it, which are empty: what grouping and resolving take more,
///   over the number of those intervals, is what an interval costs.
///
/// # Errors
/// Where a run is not finished, or none has such a cell.
pub fn tune(records: &[Record]) -> Result<Vec<Tuning>, TuneError> {
    let mut records: Vec<&Record> = records.iter().collect();
    records.sort_by(|a, b| a.run.started.cmp(&b.run.started));
    let mut tunings: BTreeMap<(&str, &str), Tuning> = BTreeMap::new();
    for record in records {
        if !record.finished() {
            return Err(TuneError::Unfinished { folder: record.folder.clone() });
        }
        let device = &record.run.device;
        let own = of_run(record);
        if own.fastest.is_empty() && own.intervals.is_empty() && own.pixels.is_empty() {
            continue;
        }
        let key = (device.name.as_str(), device.backend.as_str());
        tunings.entry(key).or_insert_with(|| Tuning::of(device)).update(own);
    }
    if tunings.is_empty() { Err(TuneError::Nothing) } else { Ok(tunings.into_values().collect()) }
}

/// A cell that says something.
struct Measured {
    technique: Sorted,
    group: String,
    frame_px: u64,
    /// Fragments of each covered pixel.
    depth: u32,
    /// Upper bounds of its intervals.
    uppers: Vec<u32>,
    /// Strategy and store of the program that its pixels run.
    sort: String,
    /// Median nanoseconds of the resolve, over the covered pixels.
    pixel_ns: f64,
    /// Median nanoseconds of grouping, and of grouping and resolving.
    group_ns: f64,
    both_ns: f64,
}

/// The depth of all covered pixels, if they are as deep as each other, and how many they are.
fn uniform(histogram: &[u64]) -> Option<(u32, u64)> {
    let mut covered = (1u32..).zip(histogram.get(1..)?).filter(|(_, pixels)| **pixels > 0);
    let (depth, pixels) = covered.next()?;
    covered.next().is_none().then_some((depth, *pixels))
}

fn measured(record: &Record) -> Vec<Measured> {
    let samples = samples_by_cell(record);
    let mut views: BTreeMap<&str, (u32, u64)> = BTreeMap::new();
    let mut exact = vec![false; record.run.cells.len()];
    for event in &record.events {
        match event {
            Event::Counted { group, histogram, .. } => {
                views.extend(uniform(histogram).map(|found| (group.as_str(), found)));
            }
            Event::Verified { cell, result } => exact[*cell] = result.verdict == Verdict::Exact,
            _ => {}
        }
    }
    let mut all = Vec::new();
    for (place, cell) in record.run.cells.iter().enumerate().filter(|(place, _)| exact[*place]) {
        let group = cell.group();
        let Some(&(depth, pixels)) = views.get(group.as_str()) else { continue };
        // A record may be older than this program, or hold what has no such name.
        let Ok(technique) = cell.technique.parse::<Sorted>() else { continue };
        if !technique.schedule.has_intervals() || technique.pool != Pool::WHOLE {
            continue;
        }
        let Ok(intervals) = intervals(&technique, depth) else { continue };
        let own = intervals.index(depth).and_then(|place| intervals.iter().nth(place));
        let Some(Ok((strategy, spec))) = own.map(|own| sort_spec(&technique, own)) else {
            continue;
        };
        let Some(stages) = samples.get(&place) else { continue };
        let (Some(resolve), Some(grouping)) = (stages.get("resolve"), stages.get("group")) else {
            continue;
        };
        let both: Vec<f64> = resolve.iter().zip(grouping).map(|(a, b)| a + b).collect();
        let (Some(resolve_ns), Some(group_ns), Some(both_ns)) =
            (median(resolve), median(grouping), median(&both))
        else {
            continue;
        };
        let alone = oit_sort::SortPart { strategy, store: spec.store, most: None };
        all.push(Measured {
            group,
            frame_px: u64::from(cell.width_px) * u64::from(cell.height_px),
            depth,
            uppers: intervals.iter().map(|interval| interval.high).collect(),
            sort: alone.to_string(),
            pixel_ns: resolve_ns / pixels as f64,
            group_ns,
            both_ns,
            technique,
        });
    }
    all
}

/// To a tenth of a picosecond: below what any clock tells.
fn rounded(ns: f64) -> f64 {
    (ns * 1e4).round() / 1e4
}

fn of_run(record: &Record) -> Tuning {
    let from = FromRun::run(&record.run);
    let cells = measured(record);
    let mut tuning = Tuning::of(&record.run.device);
    tuning.fastest = fastest(&cells, &from);
    tuning.pixels = pixels(&cells, &from);
    tuning.intervals = interval_costs(&cells, &from);
    tuning
}

/// Capture, stage and tie rule.
fn words(technique: &Sorted) -> (String, String, String) {
    let Sorted { capture, stage, ties, .. } = technique;
    (capture.name().to_owned(), stage.name().to_owned(), ties.name().to_owned())
}

fn fastest(cells: &[Measured], from: &FromRun) -> Vec<Fastest> {
    let mut best: BTreeMap<_, BTreeMap<u32, (f64, &str)>> = BTreeMap::new();
    for cell in cells {
        let technique = &cell.technique;
        let is_full = cell.uppers.last() == Some(&cell.depth);
        let alone = technique.sort.to_string() == cell.sort;
        let usual = technique.schedule == Schedule::Bma
            && technique.intervals == IntervalChoice::PowersOfTwo
            && technique.max_frags == MaxFrags::Peak;
        if is_full && alone && usual {
            let sizes = best.entry(words(technique)).or_default();
            let own = (cell.pixel_ns, cell.sort.as_str());
            let known = sizes.entry(cell.depth).or_insert(own);
            if own.0 < known.0 {
                *known = own;
            }
        }
    }
    let entry = |((capture, stage, ties), sizes): (_, BTreeMap<u32, (f64, &str)>)| {
        let size = |(size, (ns, sort)): (u32, (f64, &str))| (size, sort.to_owned(), rounded(ns));
        let sizes = sizes.into_iter().map(size).collect();
        Fastest { capture, stage, ties, sizes, run: from.clone() }
    };
    best.into_iter().map(entry).collect()
}

/// Whether a cell's one interval was made for it.
fn is_one(cell: &Measured) -> bool {
    matches!(cell.technique.intervals, IntervalChoice::Uppers(_)) && cell.uppers.len() == 1
}

fn pixels(cells: &[Measured], from: &FromRun) -> Vec<PixelCost> {
    let mut costs: BTreeMap<_, BTreeMap<(u32, u32), f64>> = BTreeMap::new();
    for cell in cells.iter().filter(|cell| is_one(cell)) {
        let points = costs.entry((words(&cell.technique), cell.sort.clone())).or_default();
        // Measured twice where two choices have the strategy in common.
        let known = points.entry((cell.uppers[0], cell.depth)).or_insert(cell.pixel_ns);
        *known = known.min(cell.pixel_ns);
    }
    let entry = |(((capture, stage, ties), sort), points): (_, BTreeMap<(u32, u32), f64>)| {
        let point = |((size, depth), ns): ((u32, u32), f64)| (size, depth, rounded(ns));
        let points = points.into_iter().map(point).collect();
        PixelCost { capture, stage, ties, sort, points, run: from.clone() }
    };
    costs.into_iter().map(entry).collect()
}

/// What one comparison says of the cost of an interval.
#[derive(Clone, Copy)]
struct Compared {
    frame_px: u64,
    interval_ns: f64,
    grouping_ns: f64,
}

fn interval_costs(cells: &[Measured], from: &FromRun) -> Vec<IntervalCost> {
    let mut costs: BTreeMap<(&str, &str), Vec<Compared>> = BTreeMap::new();
    for many in cells.iter().filter(|cell| cell.uppers.len() > 1 && cell.depth <= cell.uppers[0]) {
        let same = |one: &&Measured| {
            let (a, b) = (&many.technique, &one.technique);
            is_one(one)
                && one.group == many.group
                && one.uppers[0] == many.uppers[0]
                && (a.capture.name(), a.schedule, a.stage, a.ties, &a.sort)
                    == (b.capture.name(), b.schedule, b.stage, b.ties, &b.sort)
        };
        for one in cells.iter().filter(same) {
            let more = (many.uppers.len() - 1) as f64;
            // Noise may say that it costs less than nothing.
            let interval_ns = ((many.both_ns - one.both_ns) / more).max(0.0);
            let grouping_ns = (one.group_ns - interval_ns).max(0.0);
            let key = (one.technique.capture.name(), one.technique.schedule_name());
            let frame_px = one.frame_px;
            costs.entry(key).or_default().push(Compared { frame_px, interval_ns, grouping_ns });
        }
    }
    let entry = |((capture, schedule), found): ((&str, &str), Vec<Compared>)| {
        // Of several frame sizes the largest says most.
        let frame_px = found.iter().map(|one| one.frame_px).max()?;
        let of_frame = || found.iter().filter(|one| one.frame_px == frame_px);
        let interval: Vec<f64> = of_frame().map(|one| one.interval_ns).collect();
        let grouping: Vec<f64> = of_frame().map(|one| one.grouping_ns).collect();
        Some(IntervalCost {
            capture: capture.to_owned(),
            schedule: schedule.to_owned(),
            frame_px,
            interval_ns: rounded(median(&interval)?),
            grouping_ns: rounded(median(&grouping)?),
            run: from.clone(),
        })
    };
    costs.into_iter().filter_map(entry).collect()
}
