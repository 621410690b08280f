//! Figure 20.11 of the layered fragment buffer chapter: time against the number of fragments, as ten
//! layers grow until they fill the view. One line a layout.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::output::{Csv, Output, Stamp, Table, Value, fullest};
use crate::series::{Fit, Point, Varies, series};
use crate::style::{layout_colour, layout_place};

/// Figure 20.11 of the layered fragment buffer chapter.
pub(super) struct LfbFigure20_11;

/// Schedule, sort and stage of each panel: as the chapter's, and as one would today.
const RESOLVES: [(&str, &str, &str); 2] =
    [("base-stencil", "insertion", "fragment"), ("bma-list", "insertion", "compute")];

impl Figure for LfbFigure20_11 {
    fn name(&self) -> &'static str {
        "lfb-figure-20-11"
    }

    fn source(&self) -> &'static str {
        "LFB 2012, Figure 20.11"
    }

    fn needs(&self) -> &'static str {
        "grid in three sizes or more with base-stencil/insertion/fragment or \
         bma-list/insertion/compute"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let all = series(tables, "grid", Varies::Size, wanted);
        let drawn = all.iter().filter_map(|points| Some((points.len(), output(points)?)));
        Ok(fullest(drawn))
    }
}

fn is_of(cell: &CellResult, (schedule, sort, stage): (&str, &str, &str)) -> bool {
    let t = &cell.technique;
    (t.schedule.as_str(), t.sort.as_str(), t.shader_stage.as_str()) == (schedule, sort, stage)
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    RESOLVES.iter().any(|&resolve| is_of(cell, resolve))
        && (technique.max == "peak" && technique.ties == "total")
        && technique.whole_pool()
}

/// The points of a line: total fragments, and the total time with its interval in ms.
type Layout = Vec<(u64, [f64; 3])>;

fn output(points: &[Point]) -> Option<Output> {
    let first = points.first()?;
    let columns = vec![
        "resolve",
        "layout",
        "scene",
        "fragments",
        "layers",
        "covered_px",
        "n",
        "median_ns",
        "low_ns",
        "high_ns",
        "r_squared",
        "slope_ns_per_fragment",
        "intercept_ns",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut panels) = (Vec::new(), Vec::new());
    let millions = || points.iter().map(|point| point.total as f64 / 1e6);
    let x = Scale::from_zero("fragments, millions", millions());
    for resolve in RESOLVES {
        let mut layouts: BTreeMap<(usize, &str), Layout> = BTreeMap::new();
        for point in points {
            for cell in point.group.cells.iter().filter(|cell| wanted(cell) && is_of(cell, resolve))
            {
                let Some(timing) = cell.times.get(TOTAL) else { continue };
                let (s, layout) = (timing.summary, cell.technique.capture.as_str());
                let ms = [s.median, s.low, s.high].map(|ns| ns / 1e6);
                let key = (layout_place(layout), layout);
                layouts.entry(key).or_default().push((point.total, ms));
            }
        }
        if layouts.is_empty() {
            continue;
        }
        let name = format!("{}/{}/{}", resolve.0, resolve.1, resolve.2);
        rows(&mut csv, &name, resolve, points, &layouts);
        tables.push(table(&name, points, &layouts));
        let values = layouts.values().flatten().flat_map(|(_, ms)| ms).copied();
        panels.push(LinePanel {
            title: name,
            x: x.clone(),
            y: Scale::from_zero("total time, ms", values),
            across: None,
            lines: layouts.iter().map(|((_, layout), points)| line(layout, points)).collect(),
        });
    }
    let group = &first.group;
    let parameters: String = match group.scene.split_once('{') {
        Some((_, parameters)) => {
            let kept = parameters.trim_end_matches('}').split(',');
            let kept = kept.filter(|pair| !pair.starts_with("size="));
            kept.map(|pair| format!("-{}", crate::data::slug(pair))).collect()
        }
        None => String::new(),
    };
    Some(Output {
        name: format!("lfb-figure-20-11{parameters}-{}", group.device_slug()),
        title: format!("LFB 2012, Figure 20.11: time against fragments, {} layers", first.depth),
        subtitle: group.conditions(),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![
            "Medians of the whole frame with 95 % bootstrap intervals. The grid grows until it fills \
             the view; every covered pixel has the same number of fragments. The line of a layout is \
             by least squares; R² is the share of the variance of the medians that it explains."
                .to_owned(),
        ],
        stamps: points.iter().map(|point| Stamp::of(point.group.run)).collect(),
    })
}

fn line(layout: &str, points: &[(u64, [f64; 3])]) -> Line {
    let points = points.iter().map(|&(total, y)| {
        let hollow = false;
        LinePoint { x: total as f64 / 1e6, y, hollow }
    });
    Line { label: layout.to_owned(), colour: layout_colour(layout), points: points.collect() }
}

fn fit(points: &[(u64, [f64; 3])]) -> Option<Fit> {
    let medians: Vec<(f64, f64)> = points.iter().map(|&(x, [ms, _, _])| (x as f64, ms)).collect();
    Fit::of(&medians)
}

fn table(name: &str, points: &[Point], layouts: &BTreeMap<(usize, &str), Layout>) -> Table {
    let mut columns = vec!["layout".to_owned()];
    let heads =
        points.iter().map(|point| format!("ms at fragments\n{:.2} M", point.total as f64 / 1e6));
    columns.extend(heads);
    columns.extend(["line\nns a fragment", "line\nms at none", "R²"].map(str::to_owned));
    let fastest = |total: u64| {
        let times = layouts.values().flatten().filter(|(known, _)| *known == total);
        times.map(|(_, ms)| ms[0]).fold(f64::INFINITY, f64::min)
    };
    let rows = layouts.iter().map(|((_, layout), own)| {
        let mut row = vec![Value::from(*layout)];
        for point in points {
            let ms = own.iter().find(|(total, _)| *total == point.total).map(|(_, ms)| ms[0]);
            let marked = ms.is_some_and(|ms| ms <= fastest(point.total));
            row.push(Value { text: ms.map_or("–".to_owned(), three_digits), marked });
        }
        let fit = fit(own);
        let say = |value: Option<String>| value.unwrap_or("–".to_owned());
        row.push(say(fit.map(|fit| three_digits(fit.slope * 1e6))).into());
        row.push(say(fit.map(|fit| three_digits(fit.intercept))).into());
        row.push(say(fit.map(|fit| format!("{:.4}", fit.r_squared))).into());
        row
    });
    Table { heading: name.to_owned(), rows: rows.collect(), columns }
}

fn rows(
    csv: &mut Csv,
    name: &str,
    resolve: (&str, &str, &str),
    points: &[Point],
    layouts: &BTreeMap<(usize, &str), Layout>,
) {
    let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
    for ((_, layout), own) in layouts {
        let fit = fit(own);
        for point in points {
            let cells = point.group.cells.iter();
            let mut cells = cells.filter(|cell| wanted(cell) && is_of(cell, resolve));
            let cell = cells.find(|cell| cell.technique.capture == *layout);
            let Some(timing) = cell.and_then(|cell| cell.times.get(TOTAL)) else { continue };
            let s = timing.summary;
            let mut row = vec![
                name.to_owned(),
                (*layout).to_owned(),
                point.group.scene.to_owned(),
                point.total.to_string(),
                point.depth.to_string(),
                point.covered_px.to_string(),
                s.samples.to_string(),
            ];
            row.extend([s.median, s.low, s.high].map(|ns| format!("{ns}")));
            row.push(say(fit.map(|fit| fit.r_squared)));
            row.push(say(fit.map(|fit| fit.slope * 1e6)));
            row.push(say(fit.map(|fit| fit.intercept * 1e6)));
            csv.rows.push(row);
        }
    }
}
