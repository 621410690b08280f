//! Time against error over all scenes in one chart.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables, Technique, scene_name};

use super::Figure;
use super::pareto::{charted, mark_front, trades, wanted};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::{ErrorScatter, ScatterPanel, ScatterPoint};
use crate::data::{Group, by_device, groups_with, slug};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::technique_names::{is_floor, label};

/// Time against error over all scenes.
pub(super) struct ParetoAll;

/// Techniques on fewer scenes say nothing of all.
const LEAST_SCENES: usize = 2;

impl Figure for ParetoAll {
    fn name(&self) -> &'static str {
        "pareto-all"
    }

    fn source(&self) -> &'static str {
        "time against error over all scenes: times over the fastest exact technique's"
    }

    fn needs(&self) -> &'static str {
        "two scenes with an exact technique and one that is off"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let groups = groups_with(tables, wanted, |group| trades(&charted(group)));
        let devices = by_device(groups);
        Ok(devices.iter().filter_map(|(device, groups)| output(device, groups)).collect())
    }
}

/// A technique on the views of one scene.
#[derive(Default)]
struct OnScene {
    /// Over the time of the fastest exact technique of each view.
    ratios: Vec<f64>,
    rmse: f64,
    max_error: f64,
    memory_bytes: Vec<f64>,
}

/// A technique over scenes.
struct Overall<'a> {
    name: &'a str,
    technique: &'a Technique,
    scenes: usize,
    views: usize,
    /// Geometric mean over scenes of that over each scene's views.
    ratio: f64,
    lowest: f64,
    highest: f64,
    /// The worst of all views.
    rmse: f64,
    max_error: f64,
    /// Geometric mean, as of the ratio.
    memory_bytes: f64,
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len().max(1) as f64).exp()
}

fn fastest_exact_ms(cells: &[&CellResult]) -> Option<f64> {
    let exact =
        cells.iter().filter(|cell| cell.rmse() == Some(0.0) && !is_floor(&cell.technique.sort));
    exact.filter_map(|cell| cell.median_ms(TOTAL)).filter(|ms| *ms > 0.0).min_by(f64::total_cmp)
}

/// Every technique that is on at least a third of the scenes, and how many scenes there are.
fn overall<'a>(groups: &[Group<'a>]) -> (Vec<Overall<'a>>, usize) {
    let mut found: BTreeMap<&str, (&Technique, BTreeMap<&str, OnScene>)> = BTreeMap::new();
    let mut scenes: Vec<&str> = Vec::new();
    for group in groups {
        let cells = charted(group);
        let Some(fastest_ms) = fastest_exact_ms(&cells) else { continue };
        let scene = scene_name(group.scene);
        scenes.push(scene);
        // Blending unsorted is the floor of times, not a choice between time and error.
        for cell in cells.into_iter().filter(|cell| !is_floor(&cell.technique.sort)) {
            let (Some(ms), Some(rmse), Some(verification)) =
                (cell.median_ms(TOTAL).filter(|ms| *ms > 0.0), cell.rmse(), &cell.verification)
            else {
                continue;
            };
            let (_, by_scene) = found
                .entry(&cell.name.technique)
                .or_insert_with(|| (&cell.technique, BTreeMap::new()));
            let on = by_scene.entry(scene).or_default();
            on.ratios.push(ms / fastest_ms);
            on.rmse = on.rmse.max(rmse);
            let max_error = if rmse == 0.0 { 0.0 } else { verification.max_error };
            on.max_error = on.max_error.max(max_error);
            on.memory_bytes.push((verification.memory_bytes as f64).max(1.0));
        }
    }
    scenes.sort_unstable();
    scenes.dedup();
    let most = scenes.len();
    let all =
        found.into_iter().filter(|(_, (_, on))| on.len() >= LEAST_SCENES && 3 * on.len() >= most);
    let all = all.map(|(name, (technique, on))| {
        let over = |of: &dyn Fn(&OnScene) -> f64| on.values().map(of).collect::<Vec<f64>>();
        let ratios = over(&|on| geometric_mean(&on.ratios));
        Overall {
            name,
            technique,
            scenes: on.len(),
            views: on.values().map(|on| on.ratios.len()).sum(),
            ratio: geometric_mean(&ratios),
            lowest: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            highest: ratios.iter().copied().fold(0.0, f64::max),
            rmse: over(&|on| on.rmse).into_iter().fold(0.0, f64::max),
            max_error: over(&|on| on.max_error).into_iter().fold(0.0, f64::max),
            memory_bytes: geometric_mean(&over(&|on| geometric_mean(&on.memory_bytes))),
        }
    });
    let mut all: Vec<Overall> = all.collect();
    all.sort_by(|a, b| {
        a.rmse.total_cmp(&b.rmse).then(a.ratio.total_cmp(&b.ratio)).then(a.name.cmp(b.name))
    });
    (all, most)
}

fn output(device: &str, groups: &[Group]) -> Option<Output> {
    let (all, scenes) = overall(groups);
    let is_exact = |of: &&Overall| of.rmse == 0.0;
    if scenes < LEAST_SCENES
        || !all.iter().any(|of| of.rmse > 0.0)
        || !all.iter().any(|of| is_exact(&of))
    {
        return None;
    }
    let mut points: Vec<ScatterPoint> = all
        .iter()
        .map(|of| ScatterPoint {
            technique: of.technique.clone(),
            label: label(of.name),
            rmse: of.rmse,
            time: of.ratio,
            // A byte stands where memory is not known.
            memory_bytes: if of.memory_bytes > 1.5 { of.memory_bytes as u64 } else { 0 },
            front: false,
        })
        .collect();
    mark_front(&mut points);
    let columns = vec![
        "technique",
        "scenes",
        "views",
        "relative_total",
        "lowest",
        "highest",
        "worst_rmse",
        "worst_max_error",
        "memory_bytes",
        "front",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "technique",
        "scenes",
        "time over the\nfastest exact",
        "lowest\nscene",
        "highest\nscene",
        "worst\nrmse",
        "worst\nerror",
        "memory\nMiB",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for (of, point) in all.iter().zip(&points) {
        let known = point.memory_bytes > 0;
        csv.rows.push(vec![
            of.name.to_owned(),
            of.scenes.to_string(),
            of.views.to_string(),
            format!("{}", of.ratio),
            format!("{}", of.lowest),
            format!("{}", of.highest),
            format!("{}", of.rmse),
            format!("{}", of.max_error),
            if known { point.memory_bytes.to_string() } else { String::new() },
            point.front.to_string(),
        ]);
        let mib = of.memory_bytes / f64::from(1 << 20);
        table.rows.push(vec![
            label(of.name).into(),
            of.scenes.to_string().into(),
            Value { text: three_digits(of.ratio), marked: point.front },
            three_digits(of.lowest).into(),
            three_digits(of.highest).into(),
            if of.rmse == 0.0 { "exact".to_owned() } else { number(of.rmse) }.into(),
            if of.rmse == 0.0 { "exact".to_owned() } else { number(of.max_error) }.into(),
            if known { format!("{mib:.1}") } else { "–".to_owned() }.into(),
        ]);
    }
    let panel = ScatterPanel {
        title: "Total time over the fastest exact technique's (log scale)".to_owned(),
        unit: "",
        errors: "root mean square error, the worst of all scenes (log scale right of the break)",
        points,
    };
    Some(Output {
        name: format!("pareto-all-{}", slug(device)),
        title: "Time against error over all scenes".to_owned(),
        subtitle: format!("{device}; {} views of {scenes} scenes", groups.len()),
        chart: Box::new(ErrorScatter(vec![panel])),
        tables: vec![table],
        csv,
        notes: vec![
            "Each time is over that of the fastest exact technique of the same view and run; over a \
             scene's views and then over scenes these are averaged geometrically, and so is memory. \
             Errors are the worst of all. A technique stands here if it was measured on at least a third \
             of the scenes; one that is exact on all stands on the axis at zero. Marked: no other is \
             both faster and nearer to exact."
                .to_owned(),
        ],
        stamps: groups.iter().map(|group| Stamp::of(group.run)).collect(),
    })
}
