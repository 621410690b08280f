//! The resolve time of each sort against depth complexity, where every covered pixel has the same:
//! where one sort overtakes another.

use std::collections::BTreeMap;

use analysis::{RESOLVE, Tables, scene_name};

use super::Figure;
use super::ratios::{self, families};
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups, slug};
use crate::output::{Csv, Output, Stamp, Table, fullest};
use crate::style::sort_colour;

/// Sorts against depth complexity.
pub(super) struct SortDepths;

/// Run, scene, view, resolution and covered pixels: all that groups of one chart share. The depth
/// differs.
type Series<'a> = (String, &'a str, &'a str, [u32; 2], u64);

/// Depths, and the median and the ends of its interval in ms.
type Times = Vec<(u64, [f64; 3])>;

impl Figure for SortDepths {
    fn name(&self) -> &'static str {
        "sort-depths"
    }

    fn source(&self) -> &'static str {
        "resolve time against depth complexity, after LFB 2012, Figure 20.12"
    }

    fn needs(&self) -> &'static str {
        "a scene at three depths or more, each the same in all covered pixels"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut series: BTreeMap<Series, BTreeMap<u64, Group>> = BTreeMap::new();
        for group in groups(tables, ratios::wanted) {
            let Some((depth, covered_px)) = uniform_depth(&group) else { continue };
            let size = [group.width_px, group.height_px];
            let key =
                (group.run.name.clone(), scene_name(group.scene), group.view, size, covered_px);
            series.entry(key).or_default().insert(depth, group);
        }
        let whole = series.into_iter().filter(|(_, depths)| depths.len() >= 3);
        let drawn = whole.filter_map(|((_, scene, view, _, _), depths)| {
            Some((depths.len(), output(scene, view, &depths)?))
        });
        Ok(fullest(drawn))
    }
}

/// The depth of the covered pixels, if it is the same in all, and how many there are.
pub(super) fn uniform_depth(group: &Group) -> Option<(u64, u64)> {
    let histogram = group.run.histogram(&group.name())?;
    let mut depths = (0_u64..).zip(histogram).skip(1).filter(|(_, pixels)| **pixels > 0);
    let (depth, &covered_px) = depths.next()?;
    depths.next().is_none().then_some((depth, covered_px))
}

fn output(scene: &str, view: &str, depths: &BTreeMap<u64, Group>) -> Option<Output> {
    let (_, first) = depths.first_key_value()?;
    let columns = vec![
        "family",
        "sort",
        "fragments",
        "n",
        "median_ns",
        "low_ns",
        "high_ns",
        "technique",
        "scene",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let mut lines: BTreeMap<String, BTreeMap<&str, Times>> = BTreeMap::new();
    for (depth, group) in depths {
        for (family, sorts) in families(group) {
            for (sort, cell) in sorts {
                let Some(timing) = cell.times.get(RESOLVE) else { continue };
                let s = timing.summary;
                if s.low <= 0.0 {
                    continue;
                }
                let ms = [s.median / 1e6, s.low / 1e6, s.high / 1e6];
                lines
                    .entry(family.clone())
                    .or_default()
                    .entry(sort)
                    .or_default()
                    .push((*depth, ms));
                let mut row = vec![family.clone(), sort.to_owned(), depth.to_string()];
                row.push(s.samples.to_string());
                row.extend([s.median, s.low, s.high].map(|ns| format!("{ns}")));
                row.extend([cell.name.technique.clone(), group.scene.to_owned()]);
                csv.rows.push(row);
            }
        }
    }
    let mut tables = Vec::new();
    let mut panels = Vec::new();
    // All panels on the same scales.
    let heads = depths.keys().map(|&depth| depth as f64);
    let mut x = Scale::logarithmic("fragments of every pixel", heads.clone());
    x.ticks = heads.collect();
    let times = lines.values().filter(|sorts| sorts.len() > 1).flat_map(BTreeMap::values).flatten();
    let y = Scale::logarithmic("resolve with grouping, ms", times.flat_map(|(_, ms)| ms).copied());
    // A sort alone overtakes none.
    for (family, sorts) in lines.into_iter().filter(|(_, sorts)| sorts.len() > 1) {
        let heads = depths.keys().map(|depth| format!("{depth}"));
        let columns = ["sort".to_owned()].into_iter().chain(heads).collect();
        let rows = sorts.iter().map(|(sort, points)| {
            let mut row = vec![(*sort).into()];
            for depth in depths.keys() {
                let ms = points.iter().find(|(known, _)| known == depth).map(|(_, ms)| ms[0]);
                row.push(ms.map_or("–".to_owned(), three_digits).into());
            }
            row
        });
        tables.push(Table { heading: family.clone(), columns, rows: rows.collect() });
        let lines = sorts.into_iter().map(|(sort, points)| Line {
            label: sort.to_owned(),
            colour: sort_colour(sort),
            points: points
                .into_iter()
                .map(|(depth, y)| LinePoint { x: depth as f64, y, hollow: false })
                .collect(),
        });
        let lines = lines.collect();
        panels.push(LinePanel { title: family, x: x.clone(), y: y.clone(), across: None, lines });
    }
    if panels.is_empty() {
        return None;
    }
    Some(Output {
        name: format!("sort-depths-{}-{}", slug(&format!("{scene}-{view}")), first.device_slug()),
        title: format!("Resolve time against depth complexity: {scene}, {view}"),
        subtitle: format!("{}; ms, log scales", first.conditions()),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![
            "Medians of resolve with grouping in ms, with 95 % bootstrap intervals. passthrough \
             reads and blends unsorted: the floor."
                .to_owned(),
        ],
        stamps: depths.values().map(|group| Stamp::of(group.run)).collect(),
    })
}
