//! From measurements and bounds to techniques, the cheapest first.

use crate::evidence::{Evidence, Measured, View, scene_name};
use crate::model::{Basis, Model, Time, Told};
use crate::technique::{Family, is_unsorted};

/// How a picture's error is measured: of red, green and blue, premultiplied, from 0 to 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Metric {
    /// The largest error of a channel over the frame.
    #[default]
    Max,
    /// The root mean square over all pixels and channels.
    Rmse,
}

/// What is asked of a technique.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Bounds {
    /// The largest error allowed; 0: exact, by what the technique is and not by luck.
    pub max_error: f64,
    /// Of which kind.
    pub metric: Metric,
    /// The most device memory, in bytes.
    pub max_memory_bytes: Option<u64>,
}

/// A technique that may be chosen, and what is known of it beside measurements.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Candidate {
    /// Its name.
    pub technique: String,
    /// The largest error it can have on the view by what it is, of any channel; 0: it is exact.
    /// `None`: nothing but measurements tells.
    pub guaranteed: Option<f64>,
    /// Device memory on the view. `None`: as measured, or not known.
    pub memory_bytes: Option<u64>,
    /// Its time to group and resolve, where that comes from elsewhere.
    pub resolve: Option<Told>,
    /// Why it cannot draw the view.
    pub refused: Option<String>,
}

/// An error, measured or expected.
#[derive(Clone, PartialEq, Debug)]
pub struct Estimate {
    /// By the metric asked for.
    pub error: f64,
    /// What it rests on.
    pub basis: ErrorBasis,
}

/// What an error rests on.
#[derive(Clone, PartialEq, Debug)]
pub enum ErrorBasis {
    /// Measured on this very view.
    Measured {
        /// Whether it had to be exact.
        exact: bool,
    },
    /// The technique is exact, by what it is.
    Exact,
    /// It was exact wherever it was measured on other views, some of which are as deep. Where
    /// fragments that share a depth matter to it, that is no promise.
    ExactElsewhere,
    /// It can be no larger by what the technique is.
    Guaranteed,
    /// The largest of so many other views, of so many scenes.
    Worst {
        /// Views.
        views: usize,
        /// Scenes.
        scenes: usize,
    },
}

impl Estimate {
    /// Whether it is within a bound. An approximation that happens to be right is not exact: nothing
    /// says that the next frame is.
    #[must_use]
    pub fn within(&self, max_error: f64) -> bool {
        let by_luck = match self.basis {
            ErrorBasis::Measured { exact } => !exact,
            ErrorBasis::Exact | ErrorBasis::ExactElsewhere => false,
            ErrorBasis::Guaranteed | ErrorBasis::Worst { .. } => true,
        };
        self.error <= max_error && !(max_error == 0.0 && by_luck)
    }
}

/// A technique that meets the bounds.
#[derive(Clone, PartialEq, Debug)]
pub struct Choice {
    /// Its name.
    pub technique: String,
    /// Its time.
    pub time: Time,
    /// Its error.
    pub error: Estimate,
    /// Its memory, where it is known.
    pub memory_bytes: Option<u64>,
}

/// Why a technique is out.
#[derive(Clone, PartialEq, Debug)]
pub enum Reason {
    /// It cannot draw the view, in words.
    Refused(String),
    /// Its error is or may be above the bound.
    Error(Estimate),
    /// Nothing says how large its error is on such a view.
    UnknownError(String),
    /// It takes more memory.
    Memory(u64),
    /// Nothing says how much memory it takes, and that is bounded.
    UnknownMemory,
    /// Nothing says how long it takes.
    UnknownTime(String),
}

/// What is advised.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Advice {
    /// What meets the bounds, the cheapest first.
    pub choices: Vec<Choice>,
    /// What does not, and why, in the order of the candidates.
    pub ruled_out: Vec<(String, Reason)>,
}

/// Scenes on which an approximate technique must have been measured before its error is taken for
/// that on another.
const LEAST_SCENES: usize = 3;

fn metric(cell: &Measured, metric: Metric) -> f64 {
    match metric {
        Metric::Max => cell.max_error,
        Metric::Rmse => cell.rmse,
    }
}

/// What a technique's error will be on a view that it was not measured on.
fn expected(
    candidate: &Candidate,
    view: &View,
    evidence: &Evidence,
    kind: Metric,
) -> Result<Estimate, String> {
    let technique = candidate.technique.as_str();
    if candidate.guaranteed == Some(0.0) {
        return Ok(Estimate { error: 0.0, basis: ErrorBasis::Exact });
    }
    if candidate.guaranteed.is_none() && is_exact(technique, view, evidence) {
        return Ok(Estimate { error: 0.0, basis: ErrorBasis::ExactElsewhere });
    }
    let worst = worst(technique, view, evidence, kind);
    match (candidate.guaranteed, worst) {
        (Some(error), Ok(worst)) if worst.error < error => Ok(worst),
        // A root mean square is no larger than the largest.
        (Some(error), _) => Ok(Estimate { error, basis: ErrorBasis::Guaranteed }),
        (None, worst) => worst,
    }
}

/// The worst that was measured of a technique on other views, some of which are as deep.
fn worst(
    technique: &str,
    view: &View,
    evidence: &Evidence,
    kind: Metric,
) -> Result<Estimate, String> {
    let own = |cell: &&Measured| cell.technique == technique;
    let cells: Vec<&Measured> = evidence.cells.iter().filter(own).collect();
    let mut scenes: Vec<&str> =
        cells.iter().map(|cell| scene_name(&evidence.view_of(cell).scene)).collect();
    scenes.sort_unstable();
    scenes.dedup();
    if scenes.len() < LEAST_SCENES {
        let of = if scenes.is_empty() { "none".into() } else { scenes.join(", ") };
        return Err(format!("it was measured on fewer than {LEAST_SCENES} other scenes: {of}"));
    }
    let (peak, mean) = (view.peak(), view.mean_depth());
    let views = || cells.iter().map(|cell| evidence.view_of(cell));
    let deepest = views().map(View::peak).max().unwrap_or(0);
    if deepest < peak {
        return Err(format!("it was measured up to {deepest} fragments a pixel, here are {peak}"));
    }
    let densest = views().map(View::mean_depth).fold(0.0, f64::max);
    if densest < mean {
        return Err(format!(
            "it was measured up to {densest:.1} fragments a covered pixel on average, here are \
             {mean:.1}"
        ));
    }
    let error = cells.iter().map(|cell| metric(cell, kind)).fold(0.0, f64::max);
    Ok(Estimate { error, basis: ErrorBasis::Worst { views: cells.len(), scenes: scenes.len() } })
}

/// Whether measurements say that a technique is exact on such a view. One that captures and sorts is
/// where all of its kind were that held their pixels; any other where it was on a view no less deep,
/// and was approximate on none that is shallower.
fn is_exact(technique: &str, view: &View, evidence: &Evidence) -> bool {
    let family = Family::of(technique);
    let cells = evidence.cells.iter();
    match &family {
        Family::Sorted { resolve, .. } => {
            let held = |cell: &&Measured| {
                let other = Family::of(&cell.technique);
                matches!(&other, Family::Sorted { resolve: of, .. } if of == resolve)
                    && other.holds(evidence.view_of(cell).peak())
            };
            let all: Vec<&Measured> = cells.filter(held).collect();
            let exact = |cell: &&Measured| cell.exact && cell.max_error == 0.0;
            !is_unsorted(technique)
                && family.holds(view.peak())
                && !all.is_empty()
                && all.iter().all(exact)
        }
        Family::Whole => {
            let own = |cell: &&Measured| cell.technique == technique;
            let peak = view.peak();
            let of: Vec<(u32, bool)> = cells
                .filter(own)
                .map(|cell| (evidence.view_of(cell).peak(), cell.exact && cell.max_error == 0.0))
                .collect();
            of.iter().any(|(deep, exact)| *exact && *deep >= peak)
                && of.iter().all(|(deep, exact)| *exact || *deep > peak)
        }
    }
}

/// The candidates that meet bounds on a view, the cheapest first, and why others do not.
///
/// What was measured on the very view counts as it is, the latest run first; all else is predicted, and
/// comes by [`Time::cautious_ns`]. To hold something out, leave it out of the evidence
/// ([`Evidence::without`]).
#[must_use]
pub fn advise(
    view: &View,
    evidence: &Evidence,
    candidates: &[Candidate],
    bounds: &Bounds,
) -> Advice {
    advise_by(&Model::of(evidence), view, evidence, candidates, bounds)
}

/// The same by a model of the evidence that was made before.
pub(crate) fn advise_by(
    model: &Model,
    view: &View,
    evidence: &Evidence,
    candidates: &[Candidate],
    bounds: &Bounds,
) -> Advice {
    let same: Vec<bool> = evidence.views.iter().map(|other| other.same(view)).collect();
    let mut advice = Advice::default();
    for candidate in candidates {
        let technique = &candidate.technique;
        let here = |cell: &&Measured| same[cell.view] && cell.technique == *technique;
        let measured = evidence.cells.iter().rev().find(here);
        match judge(view, evidence, candidate, bounds, measured, model) {
            Ok(choice) => advice.choices.push(choice),
            Err(reason) => advice.ruled_out.push((technique.clone(), reason)),
        }
    }
    let key = |choice: &Choice| choice.time.cautious_ns();
    advice
        .choices
        .sort_by(|a, b| key(a).total_cmp(&key(b)).then_with(|| a.technique.cmp(&b.technique)));
    advice
}

fn judge(
    view: &View,
    evidence: &Evidence,
    candidate: &Candidate,
    bounds: &Bounds,
    measured: Option<&Measured>,
    model: &Model,
) -> Result<Choice, Reason> {
    let technique = &candidate.technique;
    if let Some(reason) = &candidate.refused {
        return Err(Reason::Refused(reason.clone()));
    }
    let error = match measured {
        Some(cell) => {
            let error = metric(cell, bounds.metric);
            let exact = cell.exact || candidate.guaranteed == Some(0.0);
            Estimate { error, basis: ErrorBasis::Measured { exact } }
        }
        None => expected(candidate, view, evidence, bounds.metric).map_err(Reason::UnknownError)?,
    };
    if !error.within(bounds.max_error) {
        return Err(Reason::Error(error));
    }
    let recorded = measured.map(|cell| cell.memory_bytes).filter(|&bytes| bytes > 0);
    let memory_bytes = recorded.or(candidate.memory_bytes);
    if let Some(most) = bounds.max_memory_bytes {
        match memory_bytes {
            None => return Err(Reason::UnknownMemory),
            Some(bytes) if bytes > most => return Err(Reason::Memory(bytes)),
            Some(_) => {}
        }
    }
    let time = match measured {
        Some(cell) => {
            let run = evidence.runs.get(cell.view).cloned().unwrap_or_default();
            Time { ns: cell.total_ns, basis: Basis::Measured { run } }
        }
        None => model
            .predict(technique, view, candidate.resolve.as_ref())
            .map_err(Reason::UnknownTime)?,
    };
    Ok(Choice { technique: technique.clone(), time, error, memory_bytes })
}
