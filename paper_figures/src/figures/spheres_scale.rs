//! The time of ways of drawing spheres against how many there are.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables, scene_name};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups, slug};
use crate::output::{Csv, Output, Stamp, Table, Value, fullest};
use crate::style::SERIES;

/// Time and memory against spheres.
pub(super) struct SpheresScale;

/// Run, scene, view and resolution: what groups of one chart share.
type Series<'a> = (String, &'a str, &'a str, [u32; 2]);

impl Figure for SpheresScale {
    fn name(&self) -> &'static str {
        "spheres-scale"
    }

    fn source(&self) -> &'static str {
        "this project; scenes of Biomolecular scenes 2018"
    }

    fn needs(&self) -> &'static str {
        "a way of drawing spheres on one view of a scene in three sizes or more"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut series: BTreeMap<Series, BTreeMap<u64, Group>> = BTreeMap::new();
        for group in groups(tables, |cell| cell.name.technique.starts_with("spheres/")) {
            let Some(&spheres) = group.run.spheres.get(&group.name()) else { continue };
            let size = [group.width_px, group.height_px];
            let key = (group.run.name.clone(), scene_name(group.scene), group.view, size);
            series.entry(key).or_default().insert(spheres, group);
        }
        let whole = series.into_iter().filter(|(_, sizes)| sizes.len() >= 3);
        let drawn =
            whole.map(|((_, scene, view, _), sizes)| (sizes.len(), output(scene, view, &sizes)));
        Ok(fullest(drawn))
    }
}

/// What a cell came to: its median and the ends of its interval in ms; or why there is none.
fn told(cell: &CellResult) -> Result<[f64; 3], String> {
    match cell.times.get(TOTAL) {
        Some(timing) => {
            let s = timing.summary;
            Ok([s.median, s.low, s.high].map(|ns| ns / 1e6))
        }
        None => Err(cell.reason.clone().unwrap_or_else(|| cell.state.name().to_owned())),
    }
}

fn output(scene: &str, view: &str, sizes: &BTreeMap<u64, Group>) -> Output {
    let first = sizes.values().next().expect("a series has sizes");
    let mut names: Vec<&str> = Vec::new();
    for cell in sizes.values().flat_map(|group| &group.cells) {
        let name = cell.name.technique.as_str();
        if name.starts_with("spheres/") && !names.contains(&name) {
            names.push(name);
        }
    }
    let of = |spheres: &u64, name: &str| {
        sizes[spheres].cells.iter().find(|cell| cell.name.technique == name).copied()
    };
    let short = |name: &str| name.trim_start_matches("spheres/").to_owned();
    let bytes = |cell: &CellResult| {
        cell.verification.as_ref().map(|v| v.memory_bytes).filter(|&bytes| bytes > 0)
    };
    let x =
        Scale::logarithmic("spheres, every object in full detail", sizes.keys().map(|&n| n as f64));
    let panel = |title: &str, value: &dyn Fn(&CellResult, u64) -> Option<[f64; 3]>| {
        let lines: Vec<Line> = names
            .iter()
            .enumerate()
            .map(|(place, name)| Line {
                label: short(name),
                colour: SERIES[place % SERIES.len()],
                points: sizes
                    .keys()
                    .filter_map(|n| Some((*n, value(of(n, name)?, *n)?)))
                    .map(|(n, y)| LinePoint { x: n as f64, y, hollow: false })
                    .collect(),
            })
            .filter(|line| !line.points.is_empty())
            .collect();
        let values: Vec<f64> =
            lines.iter().flat_map(|line| &line.points).flat_map(|p| p.y).collect();
        let y = Scale::logarithmic(title, values.into_iter());
        LinePanel { title: title.to_owned(), x: x.clone(), y, across: None, lines }
    };
    let mut csv = Csv {
        columns: vec![
            "technique",
            "scene",
            "spheres",
            "total_ms",
            "low_ms",
            "high_ms",
            "memory_bytes",
            "reason",
        ],
        rows: Vec::new(),
    };
    let (mut rows, mut memory, mut reasons) = (Vec::new(), Vec::new(), Vec::new());
    for name in &names {
        let (mut row, mut of_memory) =
            (vec![Value::from(short(name))], vec![Value::from(short(name))]);
        for n in sizes.keys() {
            let Some(cell) = of(n, name) else {
                row.push("–".into());
                of_memory.push("–".into());
                continue;
            };
            let taken = bytes(cell);
            let mut line = vec![(*name).to_owned(), sizes[n].scene.to_owned(), n.to_string()];
            match told(cell) {
                Ok(ms) => {
                    row.push(three_digits(ms[0]).into());
                    line.extend(ms.map(|ms| format!("{ms}")));
                    line.extend([taken.map_or(String::new(), |b| b.to_string()), String::new()]);
                }
                Err(reason) => {
                    row.push("stops".into());
                    reasons.push(format!("{}, {n} spheres: {reason}", short(name)));
                    line.extend([
                        String::new(),
                        String::new(),
                        String::new(),
                        String::new(),
                        reason,
                    ]);
                }
            }
            of_memory
                .push(taken.map_or("–".to_owned(), |b| three_digits(b as f64 / *n as f64)).into());
            csv.rows.push(line);
        }
        rows.push(row);
        memory.push(of_memory);
    }
    let columns: Vec<String> =
        ["way of drawing".to_owned()].into_iter().chain(sizes.keys().map(u64::to_string)).collect();
    let mut notes = vec![
        "Medians of the whole frame, with 95 % bootstrap intervals; log scales. Memory is of all buffers \
         and targets, over the spheres there are: objects that share a kind share its atoms."
            .to_owned(),
    ];
    notes.extend(reasons);
    Output {
        name: format!("spheres-scale-{}-{}", slug(&format!("{scene}-{view}")), first.device_slug()),
        title: format!("Time against the number of spheres: {scene}, {view}"),
        subtitle: first.conditions(),
        chart: Box::new(Lines(vec![
            panel("Total time, ms", &|cell, _| told(cell).ok()),
            panel("Memory, bytes a sphere", &|cell, n| Some([bytes(cell)? as f64 / n as f64; 3])),
        ])),
        tables: vec![
            Table { heading: "Total time, ms".to_owned(), columns: columns.clone(), rows },
            Table { heading: "Memory, bytes a sphere".to_owned(), columns, rows: memory },
        ],
        csv,
        notes,
        stamps: sizes.values().map(|group| Stamp::of(group.run)).collect(),
    }
}
