//! What became of each cell of a run.

use std::collections::{BTreeMap, BTreeSet};

use oit_record::statistics::{Summary, median};
use oit_record::{Cell, Event, PassWork, Program, Record, Verdict, Verification};

use crate::{AnalysisError, RESOLVE, TOTAL, Technique};

/// What became of a cell. Only [`State::Charted`] cells have times in summaries and figures.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum State {
    /// Exact or approximate as it should be, and has its samples, or most of them where the run was
    /// ended.
    Charted,
    /// Must be exact and is not.
    Wrong,
    /// The device cannot run it.
    Skipped,
    /// It broke.
    Failed,
    /// It was verified and lacks too many samples.
    Incomplete,
    /// It has not been verified.
    Unverified,
}

impl State {
    /// The word for it in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Charted => "charted",
            Self::Wrong => "wrong",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
            Self::Incomplete => "incomplete",
            Self::Unverified => "unverified",
        }
    }
}

/// The samples of one stage of a cell and their summary, in nanoseconds.
#[derive(Clone, PartialEq, Debug)]
pub struct Timing {
    /// The raw samples, in the order of their numbers.
    pub samples_ns: Vec<u64>,
    /// Their summary.
    pub summary: Summary,
}

/// A cell, what became of it, and its times.
#[derive(Clone, PartialEq, Debug)]
pub struct CellResult {
    /// Its run's place in [`crate::Tables::runs`].
    pub run: usize,
    /// Its place in the run.
    pub cell: usize,
    /// Scene, view, resolution and coordinate, as recorded.
    pub name: Cell,
    /// The coordinate, taken apart.
    pub technique: Technique,
    /// What became of it.
    pub state: State,
    /// Why, where it is skipped, failed or not exact.
    pub reason: Option<String>,
    /// The comparison with the oracle, if it came to that.
    pub verification: Option<Verification>,
    /// Its resolve programs, from the shallowest interval; empty in older records and on the CPU.
    pub programs: Vec<Program>,
    /// How much work its passes are, in order; empty where the experiment does not ask for it.
    pub work: Vec<PassWork>,
    /// How many samples it has.
    pub samples: usize,
    /// By stage, with its parts (`resolve[16]`) and the sums [`RESOLVE`] and [`TOTAL`]; empty unless
    /// [`State::Charted`].
    pub times: BTreeMap<String, Timing>,
}

impl CellResult {
    /// The median of a stage in milliseconds, if the cell is charted and has that stage. Of stages joined
    /// by `+` (`preprocess+draw`) it is the median of each sample's sum.
    #[must_use]
    pub fn median_ms(&self, stage: &str) -> Option<f64> {
        if let Some(timing) = self.times.get(stage) {
            return Some(timing.summary.median / 1e6);
        }
        let mut stages = stage.split('+').map(|stage| self.times.get(stage));
        let mut sums: Vec<f64> = stages.next()??.samples_ns.iter().map(|&ns| ns as f64).collect();
        for timing in stages {
            // A charted cell's samples have the same stages.
            for (sum, &ns) in sums.iter_mut().zip(&timing?.samples_ns) {
                *sum += ns as f64;
            }
        }
        median(&sums).map(|ns| ns / 1e6)
    }

    /// Root mean square error of the picture: 0 for cells found exact.
    #[must_use]
    pub fn rmse(&self) -> Option<f64> {
        let verification = self.verification.as_ref()?;
        Some(if verification.verdict == Verdict::Exact { 0.0 } else { verification.rmse })
    }
}

/// The raw samples of one cell: sample number to (stage, ns), [`TOTAL`] among the stages.
pub(crate) type RawSamples = BTreeMap<u32, Vec<(String, u64)>>;

/// Sorts a record's events by cell.
pub(crate) fn collect(
    record: &Record,
    run: usize,
) -> Result<Vec<(CellResult, RawSamples)>, AnalysisError> {
    let folder = &record.folder;
    let count = record.run.cells.len();
    let mut raw: Vec<RawSamples> = vec![BTreeMap::new(); count];
    let mut verified: Vec<Option<Verification>> = vec![None; count];
    let mut skipped: Vec<Option<String>> = vec![None; count];
    let mut failed: Vec<Option<String>> = vec![None; count];
    let mut programs: Vec<Vec<Program>> = vec![Vec::new(); count];
    let mut work: Vec<Vec<PassWork>> = vec![Vec::new(); count];
    for event in &record.events {
        match event {
            Event::Verified { cell, result } => verified[*cell] = Some(result.clone()),
            Event::Programs { cell, programs: told } => programs[*cell].clone_from(told),
            Event::Work { cell, passes } => work[*cell].clone_from(passes),
            Event::Skipped { cell, reason } => skipped[*cell] = Some(reason.clone()),
            Event::Failed { cell, reason } => failed[*cell] = Some(reason.clone()),
            Event::Sample { cell, sample, stages_ns, parts_ns, total_ns } => {
                if let Some(stage) =
                    stages_ns.keys().find(|stage| [RESOLVE, TOTAL].contains(&stage.as_str()))
                {
                    let stage = stage.clone();
                    return Err(AnalysisError::ReservedStage { folder: folder.clone(), stage });
                }
                // Parts are stages of their own in tables: their names are no stage's.
                let stages = stages_ns.iter().chain(parts_ns);
                let mut stages: Vec<_> = stages.map(|(name, &ns)| (name.clone(), ns)).collect();
                stages.push((TOTAL.to_owned(), *total_ns));
                if raw[*cell].insert(*sample, stages).is_some() {
                    let (folder, cell, sample) = (folder.clone(), *cell, *sample);
                    return Err(AnalysisError::SampleTwice { folder, cell, sample });
                }
            }
            Event::Counted { .. }
            | Event::Bandwidth { .. }
            | Event::Clocks { .. }
            | Event::Finished { .. } => {}
        }
    }
    // A run takes its samples in rounds over the techniques of a group. Where it was ended, a cell needs
    // most of the samples of the run's fullest: the interval of its median tells how sure the rest are.
    let most = raw.iter().map(BTreeMap::len).max().unwrap_or(0);
    let needed = if record.finished() { 1 } else { (most / 2 + 1).min(most).max(1) };
    let results = record.run.cells.iter().enumerate().zip(raw).map(|((cell, name), raw)| {
        let verification = verified[cell].take();
        let verdict = verification.as_ref().map(|verification| verification.verdict);
        // A sample whose stages differ from the others' would leave a stage with fewer samples.
        let stage_sets: BTreeSet<Vec<&str>> = raw
            .values()
            .map(|stages| stages.iter().map(|(stage, _)| stage.as_str()).collect())
            .collect();
        let state = match (&failed[cell], &skipped[cell], verdict) {
            (Some(_), _, _) => State::Failed,
            (None, Some(_), _) => State::Skipped,
            (None, None, None) => State::Unverified,
            (None, None, Some(Verdict::Wrong)) => State::Wrong,
            _ if raw.len() < needed || stage_sets.len() != 1 => State::Incomplete,
            _ => State::Charted,
        };
        let note = verification.as_ref().and_then(|verification| verification.note.clone());
        let result = CellResult {
            run,
            cell,
            technique: Technique::parse(&name.technique),
            name: name.clone(),
            state,
            reason: failed[cell].take().or(skipped[cell].take()).or(note),
            verification,
            programs: std::mem::take(&mut programs[cell]),
            work: std::mem::take(&mut work[cell]),
            samples: raw.len(),
            times: BTreeMap::new(),
        };
        (result, raw)
    });
    Ok(results.collect())
}
