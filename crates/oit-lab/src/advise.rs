//! What the registries know of techniques that may be advised on a view: how accurate they must be, how
//! much memory their plans take, and what a tuning says of intervals that nobody has timed yet.

use oit_advise::{Candidate, Evidence, Told, is_candidate};
use oit_bma::Interval;
use oit_capture::{Accuracy, CAPTURES, Geometry};
use oit_fragments::{DepthHistogram, Ties};
use oit_gpu::{Buffer, Plan};
use oit_sort::SortChoice;

use crate::assemble::{Fragments, array, assemble, intervals, slots, sort_spec};
use crate::engine::{CellError, FrameSize};
use crate::technique::{IntervalChoice, MaxFrags, Pool, PoolPolicy, Schedule};
use crate::technique::{Sorted, Stage, Technique};
use crate::tuner::Tuner;

/// A view as techniques are planned for it.
#[derive(Clone, Copy, Debug)]
pub struct Planned<'a> {
    /// What is drawn.
    pub geometry: &'a Geometry,
    /// The frame.
    pub size: FrameSize,
    /// Fragments of each pixel, row by row.
    pub counts: &'a [u32],
    /// The same as a histogram.
    pub histogram: &'a DepthHistogram,
}

/// What a technique does on a view.
#[derive(Clone, PartialEq, Debug)]
pub struct Description {
    /// Which pixels run which program: interval of depth complexity, sort with its store, pixels.
    /// Empty for methods.
    pub intervals: Vec<(Interval, String, u64)>,
    /// Passes of each stage, in the order in which stages first appear.
    pub passes: Vec<(&'static str, usize)>,
    /// Room in the pool at first, in slots; `None` for methods, which have none.
    pub pool_slots: Option<u64>,
    /// Device memory of all buffers and targets, as planned.
    pub memory_bytes: u64,
    /// The largest buffer.
    pub largest_bytes: u64,
}

impl Planned<'_> {
    /// What a technique does here. It must leave nothing to a tuning.
    ///
    /// # Errors
    /// Where it cannot draw the view.
    pub fn describe(&self, technique: &Technique) -> Result<Description, CellError> {
        let Self { geometry, size, counts, histogram } = *self;
        match technique {
            Technique::Method(choice) => {
                let plan = choice.plan(geometry, size, histogram)?;
                Ok(described(&plan, Vec::new(), None))
            }
            Technique::Spheres(variation) => Err(CellError::Unsupported(format!(
                "{variation} draws opaque spheres: no technique for transparency"
            ))),
            Technique::Sorted(sorted) => {
                let whole = slots(sorted, size, counts, histogram)?;
                let pool =
                    whole.saturating_mul(u64::from(sorted.pool.percent)).div_ceil(100).max(1);
                let fragments = Fragments::Drawn(geometry);
                let plan = assemble(sorted, fragments, size, histogram, pool)?;
                let programs = programs(sorted, histogram)?;
                Ok(described(&plan, programs, Some(pool)))
            }
        }
    }

    /// What is known of a technique beside measurements. It must leave nothing to a tuning. Buffers
    /// may have up to `most_bytes`, where that is not 0.
    fn candidate(&self, technique: &Technique, most_bytes: u64) -> Candidate {
        let described = self.describe(technique).map_err(|error| error.to_string());
        let described = described.and_then(|it| {
            if most_bytes > 0 && it.largest_bytes > most_bytes {
                let (bytes, most) = (it.largest_bytes, most_bytes);
                return Err(format!(
                    "a buffer of {bytes} bytes, and the device binds up to {most}"
                ));
            }
            Ok(it)
        });
        Candidate {
            technique: technique.to_string(),
            guaranteed: self.guaranteed(technique),
            memory_bytes: described.as_ref().ok().map(|it| it.memory_bytes),
            resolve: None,
            refused: described.err(),
        }
    }

    /// The largest error a technique can have here by what it is.
    fn guaranteed(&self, technique: &Technique) -> Option<f64> {
        let peak = self.histogram.peak();
        match technique {
            // Where fragments share a depth, those that are exact without may lose some.
            Technique::Method(choice) => {
                (choice.accuracy(self.histogram) == Accuracy::Exact).then_some(0.0)
            }
            Technique::Spheres(_) => None,
            Technique::Sorted(sorted) => {
                let drops = sorted.pool.policy == PoolPolicy::Drop;
                if drops || sorted.ties == Ties::Depth || sorted.max_frags.truncates(peak) {
                    return None;
                }
                let intervals = intervals(sorted, peak).ok()?;
                let mut bound = 0.0_f64;
                for interval in intervals.iter() {
                    let (strategy, _) =
                        sort_spec(sorted, array(sorted, &intervals, interval)).ok()?;
                    if !strategy.sorts() {
                        return None;
                    }
                    bound = bound.max(strategy.error_bound().map_or(0.0, f64::from));
                }
                Some(bound)
            }
        }
    }

    /// Every technique that was measured on the device and may be advised, then those whose sorts or
    /// intervals the device's tuning chooses for this view and that were not measured as such. What a
    /// tuning predicts is corrected by what recorded predictions were off.
    #[must_use]
    pub fn candidates(&self, evidence: &Evidence, tuner: &Tuner) -> Vec<Candidate> {
        let most = evidence.max_buffer_bytes;
        let known = evidence.techniques().into_iter().filter(|name| is_candidate(name));
        let mut known: Vec<String> =
            known.filter_map(|name| Some(self.as_here(name.parse().ok()?).to_string())).collect();
        known.sort();
        known.dedup();
        let known = known.iter().filter_map(|name| name.parse::<Technique>().ok());
        let mut all: Vec<Candidate> =
            known.map(|technique| self.candidate(&technique, most)).collect();
        for open in left_open() {
            let Some((technique, resolve)) = self.tuned(open, evidence, tuner) else { continue };
            let name = technique.to_string();
            if all.iter().all(|candidate| candidate.technique != name) {
                let told = Candidate { resolve: Some(resolve), ..self.candidate(&technique, most) };
                all.push(told);
            }
        }
        all
    }

    /// An array that holds the deepest pixel is as good as one made for it: the two have one name.
    fn as_here(&self, technique: Technique) -> Technique {
        match technique {
            Technique::Sorted(sorted) if !sorted.max_frags.truncates(self.histogram.peak()) => {
                Sorted { max_frags: MaxFrags::Peak, ..sorted }.into()
            }
            other => other,
        }
    }

    /// What a technique that leaves something open comes to here, and its time to group and resolve.
    fn tuned(&self, open: Sorted, evidence: &Evidence, tuner: &Tuner) -> Option<(Technique, Told)> {
        let chosen = tuner.choose(&open.into(), self.histogram, self.size).ok()?;
        let ns = tuner.predicted_ns(&chosen, self.histogram, self.size)?;
        let (ns, corrected, off) = match evidence.correction(&chosen.to_string()) {
            Some((by, off, cells)) => {
                let text = format!("times {by:.2}, which {cells} recorded predictions were off");
                (ns * by, text, Some(off))
            }
            None => (ns, "uncorrected: no prediction was recorded beside a time".into(), None),
        };
        let from = format!("the device's tuning, {corrected}");
        Some((chosen, Told { ns, from, off }))
    }
}

/// Techniques that leave sorts or intervals to a tuning.
fn left_open() -> Vec<Sorted> {
    let mut all = Vec::new();
    for &capture in CAPTURES {
        for stage in Stage::SHADERS {
            for sort in ["auto", "network+rbs", "insertion"] {
                let Ok(sort) = sort.parse::<SortChoice>() else { continue };
                for intervals in [IntervalChoice::PowersOfTwo, IntervalChoice::Optimal] {
                    all.push(Sorted {
                        capture,
                        schedule: Schedule::Bma,
                        sort: sort.clone(),
                        stage,
                        max_frags: MaxFrags::Peak,
                        ties: Ties::Total,
                        pool: Pool::WHOLE,
                        intervals,
                    });
                }
            }
        }
    }
    all
}

fn programs(
    technique: &Sorted,
    histogram: &DepthHistogram,
) -> Result<Vec<(Interval, String, u64)>, CellError> {
    let intervals = intervals(technique, histogram.peak())?;
    let last = intervals.deepest();
    let entry = |interval: Interval| {
        let compiled = array(technique, &intervals, interval);
        let (strategy, spec) = sort_spec(technique, compiled)?;
        let part = oit_sort::SortPart { strategy, store: spec.store, most: None };
        let depths = (0_u32..).zip(&histogram.pixels).skip(1);
        // The last one also takes what is deeper.
        let own = depths.filter(|(depth, _)| {
            *depth >= interval.low && (*depth <= interval.high || interval.high == last)
        });
        Ok((interval, part.to_string(), own.map(|(_, pixels)| pixels).sum()))
    };
    intervals.iter().map(entry).collect()
}

fn described(
    plan: &Plan,
    intervals: Vec<(Interval, String, u64)>,
    pool_slots: Option<u64>,
) -> Description {
    let count = |stage: &'static str| plan.passes.iter().filter(|pass| pass.stage == stage).count();
    Description {
        intervals,
        passes: plan.stages().into_iter().map(|stage| (stage, count(stage))).collect(),
        pool_slots,
        memory_bytes: plan.bytes(),
        largest_bytes: plan.buffers.iter().map(|Buffer { bytes, .. }| *bytes).max().unwrap_or(0),
    }
}
