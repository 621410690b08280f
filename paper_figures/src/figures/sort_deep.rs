//! Resolve times over those of reading and blending unsorted on the same layout, against the number
//! of fragments: what sorting costs, and which sorts are the fastest where pixels are deep.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, RESOLVE, Ratio, Tables, compare};
use oit_record::Verdict;

use super::Figure;
use super::ratios::families;
use crate::FigureError;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, all_groups, random_depth, slug};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::sort_colour;

/// Sorts over the floor, against depth.
pub(super) struct SortDeep;

/// What reads and blends without sorting.
const FLOOR: &str = "passthrough";
/// How many of the fastest at each depth are drawn. Tables have all.
const FASTEST: usize = 3;
/// What is drawn beside them: the papers' own.
const ALWAYS: [&str; 3] = ["insertion", "merge", "rbs"];
/// One depth is no line.
const LEAST_DEPTHS: usize = 2;

impl Figure for SortDeep {
    fn name(&self) -> &'static str {
        "sort-deep"
    }

    fn source(&self) -> &'static str {
        "resolve time over that of blending unsorted against fragments per pixel; our extension of RBS \
         2014, section 5"
    }

    fn needs(&self) -> &'static str {
        "passthrough and a sort, all else equal, at two depths or more, each the same in all covered \
         pixels and in random order"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut devices: BTreeMap<String, Families> = BTreeMap::new();
        for group in all_groups(tables) {
            add(&group, devices.entry(group.run.device()).or_default())?;
        }
        for families in devices.values_mut() {
            families.retain(|_, depths| depths.len() >= LEAST_DEPTHS);
        }
        let drawn = devices.iter().filter(|(_, families)| !families.is_empty());
        Ok(drawn.map(|(device, families)| output(device, families)).collect())
    }
}

/// A sort beside the floor of its own run.
struct Point<'a> {
    ratio: Ratio,
    cell: &'a CellResult,
    group: Group<'a>,
}

/// Points by all that is no sort, then by depth, then by sort.
type Families<'a> = BTreeMap<String, BTreeMap<u64, BTreeMap<&'a str, Point<'a>>>>;

/// Which of two runs speaks for a sort at a depth.
fn rank(group: &Group) -> (bool, u64, String) {
    let area = u64::from(group.width_px) * u64::from(group.height_px);
    let run = &group.run.run;
    (run.profile == "full", area, run.started.clone())
}

fn is_exact(cell: &CellResult) -> bool {
    cell.verification.as_ref().is_some_and(|said| said.verdict == Verdict::Exact)
}

fn add<'a>(group: &Group<'a>, all: &mut Families<'a>) -> Result<(), FigureError> {
    let Some(depth) = random_depth(group) else { return Ok(()) };
    for (family, sorts) in families(group) {
        let floor = sorts.get(FLOOR).filter(|floor| floor.times.contains_key(RESOLVE));
        let Some(&floor) = floor else { continue };
        let competing = sorts.into_iter().filter(|(sort, cell)| *sort != FLOOR && is_exact(cell));
        for (sort, cell) in competing.filter(|(_, cell)| cell.times.contains_key(RESOLVE)) {
            let ratio = compare(cell, floor, RESOLVE)?;
            let point = Point { ratio, cell, group: group.clone() };
            let depths = all.entry(family.clone()).or_default();
            let known = depths.entry(depth).or_default();
            if known.get(sort).is_none_or(|other| rank(group) > rank(&other.group)) {
                known.insert(sort, point);
            }
        }
    }
    Ok(())
}

/// The sorts that are among the fastest at some depth, and those that are always drawn.
fn drawn<'a>(depths: &BTreeMap<u64, BTreeMap<&'a str, Point<'a>>>) -> BTreeSet<&'a str> {
    let mut names = BTreeSet::new();
    for sorts in depths.values() {
        let mut order: Vec<(&str, f64)> =
            sorts.iter().map(|(sort, point)| (*sort, point.ratio.ratio)).collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        names.extend(order.iter().take(FASTEST).map(|(sort, _)| *sort));
        names.extend(sorts.keys().filter(|sort| ALWAYS.contains(sort)));
    }
    names
}

fn output(device: &str, families: &Families) -> Output {
    let columns = vec![
        "family",
        "sort",
        "fragments",
        "over_passthrough",
        "low",
        "high",
        "ms",
        "width_px",
        "height_px",
        "technique",
        "scene",
        "run",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut panels, mut stamps) = (Vec::new(), Vec::new(), BTreeSet::new());
    let points = || families.values().flat_map(BTreeMap::values).flat_map(BTreeMap::values);
    let heads: BTreeSet<u64> = families.values().flat_map(BTreeMap::keys).copied().collect();
    let mut x = Scale::logarithmic("fragments of every pixel", heads.iter().map(|d| *d as f64));
    x.ticks = heads.iter().map(|depth| *depth as f64).collect();
    // All panels on the same scales, of what is drawn.
    let mut ends = vec![1.0];
    for depths in families.values() {
        let names = drawn(depths);
        let shown = depths.values().flatten().filter(|(sort, _)| names.contains(*sort));
        ends.extend(shown.flat_map(|(_, point)| [point.ratio.low, point.ratio.high]));
    }
    let y = Scale::logarithmic(
        "resolve time over that of passthrough, log scales",
        ends.iter().copied().filter(|end| *end > 0.0),
    );
    for (family, depths) in families {
        let sorts: BTreeSet<&str> = depths.values().flat_map(BTreeMap::keys).copied().collect();
        let names = drawn(depths);
        let columns = ["sort".to_owned()].into_iter().chain(depths.keys().map(u64::to_string));
        let mut table =
            Table { heading: family.clone(), columns: columns.collect(), rows: Vec::new() };
        let mut lines = Vec::new();
        for sort in sorts {
            let mut row: Vec<Value> = vec![sort.into()];
            let mut line = Vec::new();
            for (depth, known) in depths {
                let best = known.values().map(|p| p.ratio.ratio).fold(f64::INFINITY, f64::min);
                let Some(Point { ratio, cell, group }) = known.get(sort) else {
                    row.push("–".into());
                    continue;
                };
                let text = format!("{:.2}", ratio.ratio);
                row.push(Value { text, marked: ratio.ratio <= best });
                let y = [ratio.ratio, ratio.low, ratio.high];
                if ratio.low > 0.0 {
                    line.push(LinePoint { x: *depth as f64, y, hollow: false });
                }
                csv.rows.push(vec![
                    family.clone(),
                    sort.to_owned(),
                    depth.to_string(),
                    format!("{}", ratio.ratio),
                    format!("{}", ratio.low),
                    format!("{}", ratio.high),
                    cell.median_ms(RESOLVE).map(|ms| format!("{ms}")).unwrap_or_default(),
                    group.width_px.to_string(),
                    group.height_px.to_string(),
                    cell.name.technique.clone(),
                    group.scene.to_owned(),
                    group.run.name.clone(),
                ]);
            }
            table.rows.push(row);
            if names.contains(sort) && !line.is_empty() {
                lines.push(Line {
                    label: sort.to_owned(),
                    colour: sort_colour(sort),
                    points: line,
                });
            }
        }
        tables.push(table);
        let (title, x, y) = (family.clone(), x.clone(), y.clone());
        panels.push(LinePanel { title, x, y, across: Some(1.0), lines });
    }
    stamps.extend(points().map(|point| Stamp::of(point.group.run)));
    Output {
        name: format!("sort-deep-{}", slug(device)),
        title: "What sorting costs over reading and blending, against fragments per pixel"
            .to_owned(),
        subtitle: format!("{device}; every covered pixel alike, random order of depth"),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![format!(
            "Ratios of medians of resolve with grouping, with 95 % bootstrap intervals; each ratio is \
             of one run, and of several runs the one of the largest picture speaks. Drawn are the \
             {FASTEST} fastest at each depth and {}; the table has all, the fastest marked. passthrough \
             loads one fragment after the other: what loads many at once may take less.",
            ALWAYS.join(", ")
        )],
        stamps,
    }
}
