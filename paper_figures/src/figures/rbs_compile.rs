//! How long resolve programs take to compile, by sort and size of the array, and to make again from the
//! pipeline cache.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, RunInfo, Tables};
use oit_record::statistics::median;

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::slug;
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::SERIES;

/// Compile times with and without the pipeline cache.
pub(super) struct RbsCompile;

/// The option of a run whose caches are known: an empty folder, or what an earlier run left in it.
const OPTION: &str = "--cache";

impl Figure for RbsCompile {
    fn name(&self) -> &'static str {
        "rbs-compile"
    }

    fn source(&self) -> &'static str {
        "compile times of sorts, with and without the pipeline cache"
    }

    fn needs(&self) -> &'static str {
        "two runs with the same --cache, the first on an empty folder, and programs of one sort for two \
         sizes of its array in both"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut devices: BTreeMap<String, Device> = BTreeMap::new();
        for cell in &tables.results {
            let run = &tables.runs[cell.run];
            let [program] = cell.programs.as_slice() else { continue };
            let Some(ns) = program.compile_ns.filter(|_| known_caches(run)) else { continue };
            let device = devices.entry(run.device()).or_default();
            let found = device.programs.entry(family(cell)).or_default();
            let found = found.entry(cell.technique.sort.clone()).or_default();
            let found = found.entry(program.high).or_default();
            let ms = ns as f64 / 1e6;
            match program.from_cache {
                Some(true) => found.cached_ms.push(ms),
                Some(false) => found.compiled_ms.push(ms),
                // Whoever does not say may mean either.
                None => continue,
            }
            device.stamps.insert(Stamp::of(run));
        }
        let enough = |device: &Device| {
            let mut sorts = device.programs.values().flat_map(BTreeMap::values);
            sorts.any(|sizes| sizes.values().filter(|times| times.both().is_some()).count() >= 2)
        };
        let outputs = devices.iter().filter(|(_, device)| enough(device));
        Ok(outputs.map(|(name, device)| output(name, device)).collect())
    }
}

/// What is recorded of a device.
#[derive(Default)]
struct Device {
    /// By family, sort and size.
    programs: BTreeMap<String, BTreeMap<String, BTreeMap<u32, Times>>>,
    stamps: BTreeSet<Stamp>,
}

/// Milliseconds to make a program, of every run.
#[derive(Default)]
struct Times {
    compiled_ms: Vec<f64>,
    cached_ms: Vec<f64>,
}

impl Times {
    fn compiled(&self) -> Option<f64> {
        median(&self.compiled_ms)
    }

    fn cached(&self) -> Option<f64> {
        median(&self.cached_ms)
    }

    fn both(&self) -> Option<(f64, f64)> {
        Some((self.compiled()?, self.cached()?))
    }
}

fn known_caches(run: &RunInfo) -> bool {
    let words = run.run.command.iter();
    words.into_iter().any(|word| word == OPTION || word.starts_with("--cache="))
}

/// All that a technique is besides its sort and the size of its array.
fn family(cell: &CellResult) -> String {
    let t = &cell.technique;
    format!("{}, {}, {} stage, {} order", t.capture, t.schedule, t.shader_stage, t.ties)
}

fn panel(
    title: String,
    sorts: &BTreeMap<String, BTreeMap<u32, Times>>,
    of: fn(&Times) -> Option<f64>,
) -> Option<LinePanel> {
    let lines = sorts.iter().zip(SERIES.iter().cycle()).map(|((sort, sizes), colour)| {
        let points = sizes.iter().filter_map(|(size, times)| {
            let ms = of(times).filter(|ms| *ms > 0.0)?;
            Some(LinePoint { x: f64::from(*size), y: [ms; 3], hollow: false })
        });
        Line { label: sort.clone(), colour: *colour, points: points.collect() }
    });
    let lines: Vec<Line> = lines.filter(|line| !line.points.is_empty()).collect();
    let values = || lines.iter().flat_map(|line| &line.points).flat_map(|point| point.y);
    values().next()?;
    let sizes: BTreeSet<u32> = sorts.values().flat_map(BTreeMap::keys).copied().collect();
    let heads = || sizes.iter().map(|&size| f64::from(size));
    let mut x = Scale::logarithmic("fragments that the array holds, log scale", heads());
    x.ticks = heads().collect();
    let y = Scale::logarithmic("ms to make the program, log scale", values());
    Some(LinePanel { title, x, y, across: None, lines })
}

fn output(name: &str, device: &Device) -> Output {
    let columns =
        vec!["family", "sort", "array", "runs_compiled", "compiled_ms", "runs_cached", "cached_ms"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut panels) = (Vec::new(), Vec::new());
    for (family, sorts) in &device.programs {
        panels.extend(panel(format!("in no cache: {family}"), sorts, Times::compiled));
        panels.extend(panel(format!("from the cache: {family}"), sorts, Times::cached));
        let columns = ["sort", "array", "in no cache\nms", "from the cache\nms", "times as long"];
        let columns = columns.map(str::to_owned).to_vec();
        let mut table = Table { heading: family.clone(), columns, rows: Vec::new() };
        for (sort, sizes) in sorts {
            for (size, times) in sizes {
                let dash = |ms: Option<f64>| ms.map_or("–".to_owned(), three_digits);
                table.rows.push(vec![
                    sort.as_str().into(),
                    size.to_string().into(),
                    dash(times.compiled()).into(),
                    dash(times.cached()).into(),
                    dash(times.both().map(|(compiled, cached)| compiled / cached)).into(),
                ]);
                let empty = |ms: Option<f64>| ms.map(|ms| format!("{ms}")).unwrap_or_default();
                csv.rows.push(vec![
                    family.clone(),
                    sort.clone(),
                    size.to_string(),
                    times.compiled_ms.len().to_string(),
                    empty(times.compiled()),
                    times.cached_ms.len().to_string(),
                    empty(times.cached()),
                ]);
            }
        }
        tables.push(table);
    }
    Output {
        name: format!("rbs-compile-{}", slug(name)),
        title: "What resolve programs take to compile, and from the pipeline cache".to_owned(),
        subtitle: format!("{name}; log scales"),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![
            "Times of the driver's call that makes the pipeline, by the host's clock: of runs with \
             --cache on an empty folder, and of runs by a new process on what an earlier run left \
             there. Which of the two a program is, its driver says. WGSL has been turned into SPIR-V \
             before."
                .to_owned(),
            "NVIDIA's driver and Mesa were asked to keep no cache on disk in these runs; what \
             another driver keeps of its own is not known. Medians where there are several runs."
                .to_owned(),
        ],
        stamps: device.stamps.clone(),
    }
}
