//! Figure 20.12 of the layered fragment buffer chapter: time against depth complexity, as layers are
//! added and shrunk so that the number of fragments stays, and the share of it that is sorting.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables};

use super::Figure;
use super::lfb_views::{AS_PUBLISHED, LAYOUTS};
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::output::{Csv, Output, Stamp, Table, Value, fullest};
use crate::series::{Point, Varies, passes, series};
use crate::style::{layout_colour, sort_colour};
use crate::technique_names::is_floor;

/// Figure 20.12 of the layered fragment buffer chapter.
pub(super) struct LfbFigure20_12;

/// Schedule and stage: as the chapter's, and as one would today.
const VARIANTS: [(&str, &str); 2] = [AS_PUBLISHED, ("bma-list", "compute")];

/// What a resolve does but sort: it fills the array and blends from it.
const UNSORTED: &str = "unsorted";
/// The sort whose share is drawn.
const SORTED: &str = "insertion";
/// Sorting dominates where it takes more than this of the frame.
const HALF: f64 = 0.5;

impl Figure for LfbFigure20_12 {
    fn name(&self) -> &'static str {
        "lfb-figure-20-12"
    }

    fn source(&self) -> &'static str {
        "LFB 2012, Figure 20.12"
    }

    fn needs(&self) -> &'static str {
        "grid in three depths or more with the same number of fragments, linearized or linked_list, \
         base-stencil in the fragment stage or bma-list in compute"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let all = series(tables, "grid", Varies::DepthAtSameTotal, wanted);
        let drawn = all.iter().filter_map(|points| Some((points.len(), output(points)?)));
        Ok(fullest(drawn))
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    let variant = (technique.schedule.as_str(), technique.shader_stage.as_str());
    VARIANTS.contains(&variant)
        && LAYOUTS.iter().any(|(_, capture)| *capture == technique.capture)
        && (technique.max == "peak" && technique.ties == "total")
        && technique.whole_pool()
}

/// Layers, and the total time with its interval in ms.
type Times = Vec<(u64, [f64; 3])>;

/// What one layout takes in one stage, by sort.
struct Panel {
    layout: &'static str,
    name: String,
    stage: &'static str,
    sorts: BTreeMap<String, Times>,
}

impl Panel {
    fn of(points: &[Point], layout: &'static str, (schedule, stage): (&str, &'static str)) -> Self {
        let mut sorts: BTreeMap<String, Times> = BTreeMap::new();
        for point in points {
            for cell in point.group.cells.iter().filter(|cell| wanted(cell)) {
                let t = &cell.technique;
                let own = (t.capture.as_str(), t.schedule.as_str(), t.shader_stage.as_str());
                let Some(timing) = cell.times.get(TOTAL) else { continue };
                if own == (layout, schedule, stage) {
                    let s = timing.summary;
                    let ms = [s.median, s.low, s.high].map(|ns| ns / 1e6);
                    sorts.entry(t.sort.clone()).or_default().push((point.depth, ms));
                }
            }
        }
        Self { layout, name: format!("{layout}, {schedule}, {stage} stage"), stage, sorts }
    }

    /// The share of the frame that a sort takes more than no sort: layers and share.
    fn shares(&self, sort: &str) -> Vec<(f64, f64)> {
        let (Some(sorted), Some(unsorted)) = (self.sorts.get(sort), self.sorts.get(UNSORTED))
        else {
            return Vec::new();
        };
        let share = |(layers, [ms, ..]): &(u64, [f64; 3])| {
            let (_, [floor, ..]) = unsorted.iter().find(|(known, _)| known == layers)?;
            Some((*layers as f64, (ms - floor) / ms))
        };
        sorted.iter().filter_map(share).collect()
    }
}

fn output(points: &[Point]) -> Option<Output> {
    let first = points.first()?;
    let all = VARIANTS
        .into_iter()
        .flat_map(|variant| LAYOUTS.map(|(_, layout)| Panel::of(points, layout, variant)));
    let all: Vec<Panel> = all.filter(|panel| !panel.sorts.is_empty()).collect();
    let layers = || points.iter().map(|point| point.depth as f64);
    let x = Scale::from_zero("layers", layers());
    let mut panels: Vec<LinePanel> = Vec::new();
    for (_, stage) in VARIANTS {
        // The two layouts beside each other on one scale.
        let same = || all.iter().filter(|panel| panel.stage == stage);
        let times = same().flat_map(|panel| panel.sorts.values()).flatten();
        let y = Scale::from_zero("total time, ms", times.flat_map(|(_, ms)| ms).copied());
        panels.extend(same().map(|panel| LinePanel {
            title: panel.name.clone(),
            x: x.clone(),
            y: y.clone(),
            across: None,
            lines: panel.sorts.iter().map(|(sort, times)| line(sort, times)).collect(),
        }));
    }
    for (_, stage) in VARIANTS {
        let shares = all.iter().filter(|panel| panel.stage == stage).map(share_line);
        let lines: Vec<Line> = shares.flatten().collect();
        if lines.is_empty() {
            continue;
        }
        let values = lines.iter().flat_map(|line| &line.points).map(|point| point.y[0]);
        let least = values.clone().fold(0.0, f64::min);
        let mut y = Scale::from_zero(
            "share of the total; above the grey line it is more than half",
            values,
        );
        (y.low, y.high) = (least, y.high.max(0.6));
        let title = format!("sorting: insertion less unsorted, {stage} stage");
        panels.push(LinePanel { title, x: x.clone(), y, across: Some(HALF), lines });
    }
    let group = &first.group;
    let totals = points.iter().map(|point| point.total as f64 / 1e6);
    let (least, most) = (totals.clone().fold(f64::INFINITY, f64::min), totals.fold(0.0, f64::max));
    Some(Output {
        name: format!("lfb-figure-20-12-{}", group.device_slug()),
        title: "LFB 2012, Figure 20.12: time against depth complexity".to_owned(),
        subtitle: format!("{}; {least:.2} to {most:.2} M fragments", group.conditions()),
        chart: Box::new(Lines(panels)),
        tables: all.iter().map(|panel| table(panel, points)).collect(),
        csv: csv(&all, points),
        notes: vec![
            "Medians of the whole frame with 95 % bootstrap intervals. Layers are added and shrunk, \
             so that the number of fragments stays about the same. unsorted fills the sorting array \
             and blends from it; passthrough blends from memory."
                .to_owned(),
            "The share of sorting is what the frame takes more than with unsorted, over all that it \
             takes. It is more than half from the layers given: interpolated between the two depths \
             around them, after the last that is not."
                .to_owned(),
        ],
        stamps: points.iter().map(|point| Stamp::of(point.group.run)).collect(),
    })
}

fn line(sort: &str, times: &Times) -> Line {
    let points = times.iter().map(|&(layers, y)| LinePoint { x: layers as f64, y, hollow: false });
    Line { label: sort.to_owned(), colour: sort_colour(sort), points: points.collect() }
}

fn share_line(panel: &Panel) -> Option<Line> {
    let shares = panel.shares(SORTED);
    let from = said(passes(&shares, HALF), "half from {} layers", "never half");
    let points = shares.into_iter().map(|(x, y)| LinePoint { x, y: [y; 3], hollow: false });
    let points: Vec<LinePoint> = points.collect();
    let (label, colour) = (format!("{}: {from}", panel.layout), layout_colour(panel.layout));
    (!points.is_empty()).then_some(Line { label, colour, points })
}

fn said(layers: Option<f64>, with: &str, without: &str) -> String {
    layers.map_or(without.to_owned(), |layers| with.replace("{}", &format!("{layers:.0}")))
}

fn table(panel: &Panel, points: &[Point]) -> Table {
    let mut columns = vec!["sort".to_owned()];
    columns.extend(points.iter().map(|point| format!("ms at layers\n{}", point.depth)));
    columns
        .extend(points.iter().map(|point| format!("share of sorting at layers\n{}", point.depth)));
    columns.push("more than half from".to_owned());
    let at = |layers: u64| {
        let times = panel.sorts.iter().filter(|(sort, _)| !is_floor(sort));
        let times = times.flat_map(|(_, times)| times).filter(move |(known, _)| *known == layers);
        times.map(|(_, ms)| ms[0]).fold(f64::INFINITY, f64::min)
    };
    let rows = panel.sorts.iter().map(|(sort, times)| {
        let mut row = vec![Value::from(sort.as_str())];
        for point in points {
            let ms = times.iter().find(|(layers, _)| *layers == point.depth).map(|(_, ms)| ms[0]);
            let marked = !is_floor(sort) && ms.is_some_and(|ms| ms <= at(point.depth));
            row.push(Value { text: ms.map_or("–".to_owned(), three_digits), marked });
        }
        let shares = if is_floor(sort) { Vec::new() } else { panel.shares(sort) };
        for point in points {
            let share = shares.iter().find(|(layers, _)| *layers == point.depth as f64);
            row.push(share.map_or("–".to_owned(), |(_, share)| format!("{share:.2}")).into());
        }
        row.push(match shares.is_empty() {
            true => "–".into(),
            false => said(passes(&shares, HALF), "{} layers", "never").into(),
        });
        row
    });
    Table { heading: panel.name.clone(), rows: rows.collect(), columns }
}

fn csv(panels: &[Panel], points: &[Point]) -> Csv {
    let columns = vec![
        "layout",
        "shader_stage",
        "sort",
        "scene",
        "layers",
        "fragments",
        "median_ms",
        "low_ms",
        "high_ms",
        "share_of_sorting",
    ];
    let mut rows = Vec::new();
    for panel in panels {
        for (sort, times) in &panel.sorts {
            let shares = if is_floor(sort) { Vec::new() } else { panel.shares(sort) };
            for (layers, ms) in times {
                let Some(point) = points.iter().find(|point| point.depth == *layers) else {
                    continue;
                };
                let share = shares.iter().find(|(known, _)| *known == *layers as f64);
                let mut row = vec![panel.layout.to_owned(), panel.stage.to_owned(), sort.clone()];
                row.push(point.group.scene.to_owned());
                row.extend([layers.to_string(), point.total.to_string()]);
                row.extend(ms.map(|ms| format!("{ms}")));
                row.push(share.map_or(String::new(), |(_, share)| format!("{share}")));
                rows.push(row);
            }
        }
    }
    Csv { columns, rows }
}
