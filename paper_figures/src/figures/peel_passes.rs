//! Peeling against the number of layers, where every covered pixel has the same: what each way of
//! peeling takes, and from which number on it loses the picture.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables, scene_name};

use super::Figure;
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups, slug, uniform_depth};
use crate::output::{Csv, Output, Stamp, Table, fullest};
use crate::style::SERIES;

/// Ways of peeling against the number of layers.
pub(super) struct PeelPasses;

/// Run, scene, view, resolution and covered pixels: all that groups of one chart share.
type Series<'a> = (String, &'a str, &'a str, [u32; 2], u64);

/// The median and the ends of its interval in ms, and the largest error.
type Point = ([f64; 3], f64);

/// Smaller errors are drawn as this: those of exact pictures are rounding.
const FLOOR: f64 = 1e-7;

/// A step of a channel of eight bits.
const EIGHT_BITS: f64 = 1.0 / 255.0;

impl Figure for PeelPasses {
    fn name(&self) -> &'static str {
        "peel-passes"
    }

    fn source(&self) -> &'static str {
        "Enev, The disastrous failures to optimize dual-depth peeling with NSight"
    }

    fn needs(&self) -> &'static str {
        "two ways of peeling, with as many passes as it takes, at three depths or more, each the same \
         in all covered pixels"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut series: BTreeMap<Series, BTreeMap<u64, Group>> = BTreeMap::new();
        for group in groups(tables, peels) {
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

/// Peeling with as many passes as it takes.
fn peels(cell: &CellResult) -> bool {
    cell.technique.method.contains("peel") && cell.technique.method_size.is_empty()
}

/// The largest error of a colour channel of a cell that is timed.
fn largest_error(cell: &CellResult) -> Option<f64> {
    cell.verification.as_ref().filter(|_| !cell.times.is_empty()).map(|result| result.max_error)
}

fn output(scene: &str, view: &str, depths: &BTreeMap<u64, Group>) -> Option<Output> {
    let (_, first) = depths.first_key_value()?;
    let mut csv = Csv {
        columns: vec![
            "method",
            "fragments",
            "verdict_is_exact",
            "max_error",
            "max_alpha_error",
            "rmse",
            "n",
            "median_ns",
            "low_ns",
            "high_ns",
            "memory_bytes",
            "scene",
        ],
        rows: Vec::new(),
    };
    // Methods in the order of the experiment.
    let mut methods: Vec<&str> = Vec::new();
    let mut points: BTreeMap<(&str, u64), Point> = BTreeMap::new();
    for (&depth, group) in depths {
        for cell in &group.cells {
            let (Some(error), Some(timing)) = (largest_error(cell), cell.times.get(TOTAL)) else {
                continue;
            };
            let (method, s) = (cell.technique.method.as_str(), timing.summary);
            let Some(result) = cell.verification.as_ref().filter(|_| s.low > 0.0) else { continue };
            if !methods.contains(&method) {
                methods.push(method);
            }
            points.insert((method, depth), ([s.median, s.low, s.high].map(|ns| ns / 1e6), error));
            let mut row = vec![method.to_owned(), depth.to_string()];
            row.push((cell.rmse() == Some(0.0)).to_string());
            let errors = [result.max_error, result.max_alpha_error, result.rmse];
            row.extend(errors.map(|error| format!("{error}")));
            row.push(s.samples.to_string());
            row.extend([s.median, s.low, s.high].map(|ns| format!("{ns}")));
            row.extend([result.memory_bytes.to_string(), group.scene.to_owned()]);
            csv.rows.push(row);
        }
    }
    if methods.len() < 2 {
        return None;
    }
    let heads = depths.keys().map(|&depth| depth as f64);
    let mut x = Scale::logarithmic("fragments of every pixel", heads.clone());
    x.ticks = heads.collect();
    let panel = |title: &str, across: Option<f64>, of: &dyn Fn(&Point) -> [f64; 3]| {
        let values = points.values().flat_map(of).chain(across);
        let lines = methods.iter().enumerate().map(|(place, &method)| Line {
            label: method.to_owned(),
            colour: SERIES[place % SERIES.len()],
            points: depths
                .keys()
                .filter_map(|&depth| Some((depth, points.get(&(method, depth))?)))
                .map(|(depth, point)| LinePoint { x: depth as f64, y: of(point), hollow: false })
                .collect(),
        });
        let y = Scale::logarithmic(title, values.collect::<Vec<_>>().into_iter());
        LinePanel { title: title.to_owned(), x: x.clone(), y, across, lines: lines.collect() }
    };
    let panels = vec![
        panel("Total time, ms", None, &|(ms, _)| *ms),
        panel("Largest error of a colour; across: 1/255", Some(EIGHT_BITS), &|(_, error)| {
            [error.max(FLOOR); 3]
        }),
    ];
    let table = |heading: &str, text: &dyn Fn(&Point) -> String| {
        let heads = depths.keys().map(|depth| format!("{depth}"));
        let rows = methods.iter().map(|&method| {
            let cells = depths
                .keys()
                .map(|&depth| points.get(&(method, depth)).map_or("–".to_owned(), text).into());
            [method.into()].into_iter().chain(cells).collect()
        });
        let columns = ["method".to_owned()].into_iter().chain(heads).collect();
        Table { heading: heading.to_owned(), columns, rows: rows.collect() }
    };
    Some(Output {
        name: format!("peel-passes-{}-{}", slug(&format!("{scene}-{view}")), first.device_slug()),
        title: format!("Peeling against the number of layers: {scene}, {view}"),
        subtitle: format!("{}; log scales", first.conditions()),
        chart: Box::new(Lines(panels)),
        tables: vec![
            table("Total time, ms", &|(ms, _)| three_digits(ms[0])),
            table("Largest error of a colour channel", &|(_, error)| number(*error)),
        ],
        csv,
        notes: vec![format!(
            "Medians of the whole frame, with 95 % bootstrap intervals. Dual peeling draws the scene \
             once for every two layers and once more, the others once a layer; all with as many passes \
             as the deepest pixel takes. Errors below {FLOOR:e} are drawn as that. Those of alpha are \
             in the CSV: dual_peel_forward11 has no room for it behind the front layers."
        )],
        stamps: depths.values().map(|group| Stamp::of(group.run)).collect(),
    })
}
