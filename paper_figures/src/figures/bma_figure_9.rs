//! Figure 9 of the backwards memory allocation paper: each sort relative to insertion sort, interval by
//! interval of one frame.

use std::collections::BTreeMap;

use analysis::{CellResult, Ratio, Tables, part};

use super::Figure;
use super::bma_views::{OUR_SCENES, on_a_view};
use crate::FigureError;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::sort_colour;

/// Figure 9 of the backwards memory allocation paper.
pub(super) struct BmaFigure9;

/// What the others are compared with.
const REFERENCE: &str = "insertion";

impl Figure for BmaFigure9 {
    fn name(&self) -> &'static str {
        "bma-figure-9"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 9"
    }

    fn needs(&self) -> &'static str {
        "insertion and another sort under bma, timed by intervals and all else equal, on the view bma \
         of atrium, smoke or powerplant"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let enough = |group: &Group| !compared(group).is_empty();
        Ok(groups_with(tables, wanted, enough).iter().map(output).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    on_a_view(cell)
        && technique.schedule.starts_with("bma-")
        && (technique.max == "peak" && technique.whole_pool())
        && cell.times.contains_key(&part("resolve", 8))
}

/// Times of a sort in one interval over those of insertion sort.
struct Compared<'a> {
    sort: &'a str,
    interval: u32,
    ratio: Ratio,
}

/// The intervals that a cell was timed by.
fn intervals(cell: &CellResult) -> Vec<u32> {
    let upper = |stage: &String| stage.strip_prefix("resolve[")?.strip_suffix(']')?.parse().ok();
    let mut uppers: Vec<u32> = cell.times.keys().filter_map(upper).collect();
    uppers.sort_unstable();
    uppers
}

/// By all that is no sort: the comparisons of each sort with insertion sort.
fn compared<'a>(group: &Group<'a>) -> BTreeMap<String, Vec<Compared<'a>>> {
    let mut families: BTreeMap<String, Vec<&CellResult>> = BTreeMap::new();
    for cell in group.cells.iter().copied().filter(|cell| wanted(cell)) {
        let t = &cell.technique;
        let order = &t.ties;
        let name =
            format!("{}, {}, {} stage, {order} order", t.capture, t.schedule, t.shader_stage);
        families.entry(name).or_default().push(cell);
    }
    let mut all = BTreeMap::new();
    for (family, cells) in families {
        let Some(reference) = cells.iter().find(|cell| cell.technique.sort == REFERENCE) else {
            continue;
        };
        let mut found = Vec::new();
        for cell in cells.iter().filter(|cell| cell.technique.sort != REFERENCE) {
            for interval in intervals(cell) {
                // An interval without pixels says nothing of sorts.
                let empty = covered(group, interval) == 0;
                let ratio = analysis::compare(cell, reference, &part("resolve", interval));
                if let (false, Ok(ratio)) = (empty, ratio) {
                    found.push(Compared { sort: &cell.technique.sort, interval, ratio });
                }
            }
        }
        if !found.is_empty() {
            all.insert(family, found);
        }
    }
    all
}

/// Pixels of the interval that ends at `upper`.
fn covered(group: &Group, upper: u32) -> u64 {
    let lower = if upper == 8 { 1 } else { upper as usize / 2 + 1 };
    let histogram = group.run.histogram(&group.name()).unwrap_or(&[]);
    histogram.iter().take(upper as usize + 1).skip(lower).sum()
}

fn output(group: &Group) -> Output {
    let families = compared(group);
    let all = || families.values().flatten();
    let mut intervals: Vec<u32> = all().map(|one| one.interval).collect();
    intervals.sort_unstable();
    intervals.dedup();
    let mut x = Scale::logarithmic(
        "interval, by the most fragments of its pixels",
        intervals.iter().map(|&upper| f64::from(upper)),
    );
    x.ticks = intervals.iter().map(|&upper| f64::from(upper)).collect();
    let values = all().flat_map(|one| [one.ratio.low, one.ratio.high]).chain([1.0]);
    let values: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    let title = "resolve of the interval over that by insertion sort, log scale";
    let y = Scale::logarithmic(title, values.iter().copied());
    let columns = vec!["family", "sort", "interval", "pixels", "ratio", "low", "high", "verdict"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut panels, mut tables) = (Vec::new(), Vec::new());
    for (family, found) in &families {
        let mut sorts: BTreeMap<&str, Vec<&Compared>> = BTreeMap::new();
        for one in found {
            sorts.entry(one.sort).or_default().push(one);
            let Ratio { ratio, low, high, .. } = one.ratio;
            let mut row = vec![family.clone(), one.sort.to_owned(), one.interval.to_string()];
            row.push(covered(group, one.interval).to_string());
            row.extend([ratio, low, high].map(|value| format!("{value}")));
            row.push(one.ratio.word().to_owned());
            csv.rows.push(row);
        }
        let heads = intervals.iter().map(u32::to_string);
        let rows = sorts.iter().map(|(sort, points)| {
            let mut row = vec![(*sort).into()];
            for interval in &intervals {
                let own = points.iter().find(|one| one.interval == *interval);
                row.push(own.map_or("–".into(), |one| format!("{:.2}", one.ratio.ratio).into()));
            }
            row
        });
        tables.push(Table {
            heading: family.clone(),
            rows: rows.collect(),
            columns: ["sort".to_owned()].into_iter().chain(heads).collect(),
        });
        let lines = sorts.into_iter().map(|(sort, points)| Line {
            label: sort.to_owned(),
            colour: sort_colour(sort),
            points: points
                .into_iter()
                .map(|one| LinePoint {
                    x: f64::from(one.interval),
                    y: [one.ratio.ratio, one.ratio.low, one.ratio.high],
                    hollow: false,
                })
                .collect(),
        });
        panels.push(LinePanel {
            title: family.clone(),
            x: x.clone(),
            y: y.clone(),
            across: Some(1.0),
            lines: lines.collect(),
        });
    }
    Output {
        name: format!("bma-figure-9-{}-{}", group.slug(), group.device_slug()),
        title: format!("BMA 2013, Figure 9: sorts relative to insertion sort: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![format!(
            "Ratios of medians with 95 % bootstrap intervals, of the resolve of one interval's \
             pixels by that interval's program; below 1 is faster than insertion sort. The paper \
             prints its figure, of the power plant in the fragment stage, without numbers. \
             {OUR_SCENES}"
        )],
        stamps: [Stamp::of(group.run)].into(),
    }
}
