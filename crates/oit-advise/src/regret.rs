//! How far choices are from the best that was measured, held out by scene.

use std::collections::BTreeMap;

use crate::choice::{Bounds, Candidate, advise_by};
use crate::evidence::{Evidence, Measured, scene_name};
use crate::model::Model;
use crate::technique::is_candidate;

/// Views with fewer techniques that meet a bound leave no choice to speak of.
pub const LEAST_TECHNIQUES: usize = 3;

/// One choice put to the test: a view, a bound, and what was chosen without any measurement of its
/// scene.
#[derive(Clone, PartialEq, Debug)]
pub struct Trial {
    /// The view's place in the evidence.
    pub view: usize,
    /// Its scene, without parameters.
    pub scene: String,
    /// The largest error allowed of a channel; 0: exact.
    pub max_error: f64,
    /// How many techniques were measured on the view in its run and meet the bound.
    pub candidates: usize,
    /// The fastest of them.
    pub best: String,
    /// Its time.
    pub best_ns: f64,
    /// Times the best's that they take, all of them, on geometric average: what picking any of those
    /// would come to.
    pub any: f64,
    /// What was chosen. `None` where nothing was known to meet the bound.
    pub choice: Option<Tried>,
}

/// What was chosen in a trial, and what it turned out to be.
#[derive(Clone, PartialEq, Debug)]
pub struct Tried {
    /// The technique.
    pub technique: String,
    /// The time predicted.
    pub predicted_ns: f64,
    /// The time measured.
    pub ns: f64,
    /// The error measured.
    pub error: f64,
    /// Whether that is within the bound.
    pub meets: bool,
}

/// Trials in numbers.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Regret {
    /// Trials.
    pub trials: usize,
    /// Of these, without a choice.
    pub without: usize,
    /// Of these, with a choice that breaks the bound.
    pub broken: usize,
    /// Choices whose time counts: those that meet the bound.
    pub choices: usize,
    /// Scenes of these.
    pub scenes: usize,
    /// Their time over the best's, on geometric average over scenes of the average over a scene's
    /// views: 1 is none to regret.
    pub mean: f64,
    /// The middle one.
    pub median: f64,
    /// The worst.
    pub worst: f64,
    /// Choices within 5 % of the best.
    pub near: usize,
    /// Over the same views: times the best's that any technique takes, averaged likewise.
    pub any: f64,
}

impl Trial {
    /// The choice's time over the best's, where it met the bound.
    #[must_use]
    pub fn regret(&self) -> Option<f64> {
        self.choice.as_ref().filter(|tried| tried.meets).map(|tried| tried.ns / self.best_ns)
    }
}

/// Whether a cell meets a bound by the rule of [`crate::advise`]: 0 asks for techniques that must be exact.
fn meets(cell: &Measured, max_error: f64) -> bool {
    if max_error == 0.0 {
        return cell.exact && cell.max_error == 0.0;
    }
    cell.max_error <= max_error
}

fn geometric_mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    (values.map(f64::ln).sum::<f64>() / count).exp()
}

/// Every view of every run with enough techniques, for each bound: chosen among them with the
/// measurements of all other scenes, and compared with the fastest of the same run that meets the
/// bound.
#[must_use]
pub fn trials(evidence: &Evidence, bounds: &[f64]) -> Vec<Trial> {
    let mut by_view: BTreeMap<usize, Vec<&Measured>> = BTreeMap::new();
    for cell in evidence.cells.iter().filter(|cell| is_candidate(&cell.technique)) {
        by_view.entry(cell.view).or_default().push(cell);
    }
    // What is held out is the same for all views of a scene.
    let mut models: BTreeMap<String, (Evidence, Model)> = BTreeMap::new();
    let mut all = Vec::new();
    for (place, cells) in by_view {
        if cells.len() < LEAST_TECHNIQUES {
            continue;
        }
        let view = &evidence.views[place];
        let (others, model) =
            models.entry(scene_name(&view.scene).to_owned()).or_insert_with(|| {
                let others = evidence.without(|other| other.same_scene(view));
                let model = Model::of(&others);
                (others, model)
            });
        let candidates: Vec<Candidate> = cells
            .iter()
            .map(|cell| Candidate { technique: cell.technique.clone(), ..Candidate::default() })
            .collect();
        // All that anything is known of: which of them a bound allows is seen below.
        let any = Bounds { max_error: f64::INFINITY, ..Bounds::default() };
        let known = advise_by(model, view, others, &candidates, &any).choices;
        for &max_error in bounds {
            let fit: Vec<&&Measured> = cells.iter().filter(|cell| meets(cell, max_error)).collect();
            let best = fit.iter().min_by(|a, b| a.total_ns.total_cmp(&b.total_ns));
            let Some(best) = best.filter(|_| fit.len() >= LEAST_TECHNIQUES) else { continue };
            let choice = known.iter().find(|choice| choice.error.within(max_error));
            let choice = choice.and_then(|choice| {
                let cell = cells.iter().find(|cell| cell.technique == choice.technique)?;
                Some(Tried {
                    technique: choice.technique.clone(),
                    predicted_ns: choice.time.ns,
                    ns: cell.total_ns,
                    error: cell.max_error,
                    meets: meets(cell, max_error),
                })
            });
            all.push(Trial {
                view: place,
                scene: scene_name(&view.scene).to_owned(),
                max_error,
                candidates: fit.len(),
                best: best.technique.clone(),
                best_ns: best.total_ns,
                any: geometric_mean(fit.iter().map(|cell| cell.total_ns / best.total_ns)),
                choice,
            });
        }
    }
    all
}

/// Trials in numbers; `None` where there are none.
#[must_use]
pub fn regret<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> Option<Regret> {
    let trials: Vec<&Trial> = trials.into_iter().collect();
    if trials.is_empty() {
        return None;
    }
    let ratios: Vec<f64> = trials.iter().filter_map(|trial| trial.regret()).collect();
    let mut scenes: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for trial in &trials {
        if let Some(ratio) = trial.regret() {
            scenes.entry(&trial.scene).or_default().push((ratio, trial.any));
        }
    }
    let by_scene = |of: fn(&(f64, f64)) -> f64| {
        geometric_mean(scenes.values().map(|all| geometric_mean(all.iter().map(of))))
    };
    Some(Regret {
        trials: trials.len(),
        without: trials.iter().filter(|trial| trial.choice.is_none()).count(),
        broken: trials
            .iter()
            .filter(|trial| trial.choice.as_ref().is_some_and(|tried| !tried.meets))
            .count(),
        choices: ratios.len(),
        scenes: scenes.len(),
        mean: by_scene(|(ratio, _)| *ratio),
        median: oit_record::statistics::median(&ratios).unwrap_or(1.0),
        worst: ratios.iter().copied().fold(1.0, f64::max),
        near: ratios.iter().filter(|ratio| **ratio <= 1.05).count(),
        any: by_scene(|(_, any)| *any),
    })
}
