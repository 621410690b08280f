//! How far the advice of `oit advise` is from the best technique measured, held out by scene.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{RESOLVE, TOTAL, Tables, path_frame};
use oit_advise::{Evidence, LEAST_TECHNIQUES, Measured, Regret, Trial, View, regret, trials};
use oit_record::Verdict;

use super::Figure;
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::canvas::Colour;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::slug;
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::SERIES;

/// Regret, held out by scene.
pub(super) struct AdviseRegret;

/// Errors allowed of a channel: none, an 8-bit step, and what an eye may see.
const BOUNDS: [f64; 4] = [0.0, 1.0 / 255.0, 0.02, 0.1];
/// Fewer scenes are too few to hold one out.
const LEAST_SCENES: usize = 3;

impl Figure for AdviseRegret {
    fn name(&self) -> &'static str {
        "advise-regret"
    }

    fn source(&self) -> &'static str {
        "what the advice of `oit advise` costs over the best measured, held out by scene"
    }

    fn needs(&self) -> &'static str {
        "a device with three scenes on which several techniques were measured"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let devices = evidence(tables);
        Ok(devices.iter().filter_map(|(evidence, stamps)| output(evidence, stamps)).collect())
    }
}

/// What tables say of each device, and of which runs.
fn evidence(tables: &Tables) -> Vec<(Evidence, BTreeSet<Stamp>)> {
    let mut devices: BTreeMap<String, (Evidence, BTreeSet<Stamp>)> = BTreeMap::new();
    let mut places: BTreeMap<(usize, String), usize> = BTreeMap::new();
    for cell in &tables.results {
        let run = &tables.runs[cell.run];
        let group = cell.name.group();
        let (Some(verification), Some(total), Some(histogram), Some(triangles), None) = (
            &cell.verification,
            cell.times.get(TOTAL),
            run.histogram(&group),
            run.triangles(&group),
            path_frame(&cell.name.view),
        ) else {
            continue;
        };
        // Opaque spheres are another task, and pools that are too small are so on purpose.
        let whole_pool = cell.technique.is_method() || cell.technique.whole_pool();
        if total.summary.median <= 0.0 || !whole_pool || histogram.is_empty() {
            continue;
        }
        let (evidence, stamps) = devices.entry(run.device()).or_default();
        evidence.device.clone_from(&run.run.device.name);
        evidence.backend.clone_from(&run.run.device.backend);
        stamps.insert(Stamp::of(run));
        let view = *places.entry((cell.run, group)).or_insert_with(|| {
            evidence.runs.push(run.name.clone());
            evidence.views.push(View {
                scene: cell.name.scene.clone(),
                view: cell.name.view.clone(),
                width_px: cell.name.width_px,
                height_px: cell.name.height_px,
                triangles,
                histogram: histogram.to_vec(),
            });
            evidence.views.len() - 1
        });
        let technique = verification.tuned.clone().unwrap_or(cell.name.technique.clone());
        let (max_error, rmse) = Measured::errors(verification);
        let resolve = cell.times.get(RESOLVE).filter(|_| !cell.technique.is_method());
        evidence.cells.push(Measured {
            view,
            technique,
            total_ns: total.summary.median,
            resolve_ns: resolve.map(|timing| timing.summary.median),
            predicted_resolve_ns: verification.predicted_ns,
            max_error,
            rmse,
            exact: verification.verdict == Verdict::Exact,
            memory_bytes: verification.memory_bytes,
        });
    }
    devices.into_values().collect()
}

fn bound_name(bound: f64) -> String {
    match bound {
        0.0 => "exact".to_owned(),
        bound => format!("error up to {}", number(bound)),
    }
}

fn panel(bound: f64, trials: &[&Trial], colour: Colour) -> RatioPanel {
    let mut scenes: BTreeMap<&str, Vec<&Trial>> = BTreeMap::new();
    for trial in trials {
        scenes.entry(&trial.scene).or_default().push(trial);
    }
    let bar = |(scene, trials): (&&str, &Vec<&Trial>)| {
        let all = regret(trials.iter().copied())?;
        let ratios: Vec<f64> = trials.iter().filter_map(|trial| trial.regret()).collect();
        if ratios.is_empty() {
            return None;
        }
        let without = match all.without + all.broken {
            0 => String::new(),
            _ => format!(", {} without a choice, {} broken", all.without, all.broken),
        };
        Some(RatioBar {
            label: (*scene).to_owned(),
            colour,
            ratio: all.mean,
            low: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            high: all.worst,
            annotation: format!("{:.3}, {} views{without}", all.mean, all.trials),
        })
    };
    RatioPanel { title: bound_name(bound), bars: scenes.iter().filter_map(bar).collect() }
}

fn output(evidence: &Evidence, stamps: &BTreeSet<Stamp>) -> Option<Output> {
    let all = trials(evidence, &BOUNDS);
    let of = |bound: f64| -> Vec<&Trial> {
        all.iter().filter(|trial| trial.max_error == bound).collect()
    };
    let regrets: Vec<(f64, Regret)> =
        BOUNDS.iter().filter_map(|&bound| Some((bound, regret(of(bound))?))).collect();
    if regrets.iter().all(|(_, regret)| regret.scenes < LEAST_SCENES) {
        return None;
    }
    let columns = [
        "bound",
        "views",
        "scenes",
        "geometric\nmean",
        "median",
        "worst",
        "within\n5 %",
        "without\na choice",
        "bound\nbroken",
        "any technique,\non average",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for (bound, r) in &regrets {
        table.rows.push(
            [
                bound_name(*bound),
                r.trials.to_string(),
                r.scenes.to_string(),
                three_digits(r.mean),
                three_digits(r.median),
                three_digits(r.worst),
                format!("{} of {}", r.near, r.choices),
                r.without.to_string(),
                r.broken.to_string(),
                three_digits(r.any),
            ]
            .map(Into::into)
            .to_vec(),
        );
    }
    let columns = vec![
        "max_error",
        "run",
        "scene",
        "view",
        "candidates",
        "choice",
        "predicted_ms",
        "measured_ms",
        "error",
        "meets",
        "best",
        "best_ms",
        "regret",
        "any",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    for trial in &all {
        let view = &evidence.views[trial.view];
        let tried = trial.choice.as_ref();
        let text = |of: Option<String>| of.unwrap_or_default();
        csv.rows.push(vec![
            format!("{}", trial.max_error),
            evidence.runs[trial.view].clone(),
            view.scene.clone(),
            view.view.clone(),
            trial.candidates.to_string(),
            text(tried.map(|tried| tried.technique.clone())),
            text(tried.map(|tried| format!("{}", tried.predicted_ns / 1e6))),
            text(tried.map(|tried| format!("{}", tried.ns / 1e6))),
            text(tried.map(|tried| format!("{}", tried.error))),
            text(tried.map(|tried| tried.meets.to_string())),
            trial.best.clone(),
            format!("{}", trial.best_ns / 1e6),
            text(trial.regret().map(|ratio| format!("{ratio}"))),
            format!("{}", trial.any),
        ]);
    }
    let panels = BOUNDS
        .iter()
        .zip(SERIES)
        .map(|(&bound, colour)| panel(bound, &of(bound), *colour))
        .filter(|panel| !panel.bars.is_empty())
        .collect();
    let device = evidence.name();
    Some(Output {
        name: format!("advise-regret-{}", slug(&device)),
        title: "What advice costs: the technique chosen over the best measured".to_owned(),
        subtitle: format!("{device}; chosen without any measurement of the scene"),
        chart: Box::new(RatioBars {
            axis_title: "total time of the choice over that of the fastest that meets the bound"
                .to_owned(),
            sides: (String::new(), "slower than the best".to_owned()),
            panels,
        }),
        tables: vec![table],
        csv,
        notes: vec![
            format!(
                "On every recorded view with at least {LEAST_TECHNIQUES} techniques that meet a bound \
                 on the largest error of a colour channel, one of those measured in the view's run is \
                 chosen by a model of all measurements of the device on other scenes, and its measured \
                 time is put over the fastest's. Bars: geometric mean over a scene's views; whiskers: \
                 the least and the most."
            ),
            "The mean is over scenes of the mean over each one's views. Without a choice: nothing that \
             was measured on other scenes is known to meet the bound. Broken: the choice's measured \
             error is above it; its time does not count. Any technique: what one picked at random among \
             those that meet the bound takes over the fastest."
                .to_owned(),
        ],
        stamps: stamps.clone(),
    })
}
