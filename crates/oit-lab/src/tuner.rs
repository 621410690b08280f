//! Chooses what a technique leaves to measurements: its strategies (`auto`), its intervals
//! (`intervals-optimal`).

use std::path::Path;

use oit_bma::{CostModel, optimal_intervals};
use oit_fragments::DepthHistogram;
use oit_record::DeviceInfo;
use oit_sort::{SortChoice, SortPart};

use crate::assemble::intervals;
use crate::engine::{CellError, FrameSize};
use crate::technique::{IntervalChoice, Sorted, Stage, Technique};
use crate::tuning::{Tuning, TuningError, tuning_path};

/// A device's tuning, or why there is none. Without one, techniques that leave nothing open are what
/// they are, and others are not supported: nothing is guessed.
#[derive(Clone, Debug)]
pub struct Tuner {
    tuning: Result<Tuning, String>,
}

impl Tuner {
    /// The tuning of a device from a folder of tuning files.
    #[must_use]
    pub fn open(folder: &Path, device: &DeviceInfo) -> Self {
        let DeviceInfo { name, backend, .. } = device;
        let path = tuning_path(folder, name, backend);
        if !path.exists() {
            let path = path.display();
            let reason = format!("no tuning for {name} ({backend}) in {path}: run `oit tune`");
            return Self { tuning: Err(reason) };
        }
        let tuning = Tuning::load(&path).map_err(|error| error.to_string()).and_then(|tuning| {
            if (&tuning.device, &tuning.backend) == (name, backend) {
                return Ok(tuning);
            }
            let (path, other, through) = (path.display(), &tuning.device, &tuning.backend);
            Err(format!("{path} is of {other} ({through}), not of {name} ({backend})"))
        });
        Self { tuning }
    }

    /// The tuning of a file, whatever device it is of.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn load(path: &Path) -> Result<Self, TuningError> {
        Ok(Self { tuning: Ok(Tuning::load(path)?) })
    }

    /// No tuning, for a reason.
    #[must_use]
    pub fn none(reason: &str) -> Self {
        Self { tuning: Err(reason.to_owned()) }
    }

    /// The technique with everything chosen: itself, where it leaves nothing open, as methods do.
    ///
    /// # Errors
    /// [`CellError::Unsupported`] where what it asks for was not measured on the device.
    pub fn choose(
        &self,
        technique: &Technique,
        histogram: &DepthHistogram,
        size: FrameSize,
    ) -> Result<Technique, CellError> {
        match technique {
            Technique::Sorted(sorted) => Ok(self.choose_sorted(sorted, histogram, size)?.into()),
            Technique::Method(_) | Technique::Spheres(_) => Ok(technique.clone()),
        }
    }

    fn choose_sorted(
        &self,
        technique: &Sorted,
        histogram: &DepthHistogram,
        size: FrameSize,
    ) -> Result<Sorted, CellError> {
        let mut chosen = technique.clone();
        let is_auto = technique.sort.is_auto();
        if !is_auto && technique.intervals != IntervalChoice::Optimal {
            return Ok(chosen);
        }
        let unsupported = CellError::Unsupported;
        let tuning = self.tuning.as_ref().map_err(|reason| unsupported(reason.clone()))?;
        if is_auto {
            chosen.sort = fastest(tuning, technique).map_err(unsupported)?;
        }
        let peak = histogram.peak();
        if technique.intervals == IntervalChoice::Optimal {
            let histogram = held(&chosen, histogram);
            let (model, _) = model(tuning, &chosen, histogram.peak(), size).map_err(unsupported)?;
            let best = optimal_intervals(&histogram, &model)
                .map_err(|error| unsupported(format!("{}: {error}", asked(tuning, &chosen))))?;
            let uppers = best.iter().map(|interval| interval.high).collect();
            chosen.intervals = IntervalChoice::Uppers(uppers);
        }
        if is_auto {
            let deepest = intervals(&chosen, peak)?.deepest();
            chosen.sort.for_max_frags(deepest).map_err(|error| {
                unsupported(format!("{}: {error}; run `oit tune`", asked(tuning, technique)))
            })?;
        }
        Ok(chosen)
    }

    /// Nanoseconds to group and resolve a view, for a technique with intervals that leaves nothing
    /// open. `None` where something that it takes was not measured.
    #[must_use]
    pub fn predicted_ns(
        &self,
        technique: &Technique,
        histogram: &DepthHistogram,
        size: FrameSize,
    ) -> Option<f64> {
        let Technique::Sorted(technique) = technique else { return None };
        let tuning = self.tuning.as_ref().ok()?;
        if !technique.schedule.has_intervals() {
            return None;
        }
        let intervals = intervals(technique, histogram.peak()).ok()?;
        let histogram = held(technique, histogram);
        let (model, grouping_ns) = model(tuning, technique, histogram.peak(), size).ok()?;
        Some(grouping_ns + model.total_ns(&histogram, &intervals)?)
    }
}

/// What is asked of a tuning, for errors.
fn asked(tuning: &Tuning, technique: &Sorted) -> String {
    let Tuning { device, backend, .. } = tuning;
    let (capture, stage) = (technique.capture.name(), technique.stage.name());
    let ties = technique.ties.name();
    format!("tuning for {device} ({backend}), {capture}, {stage} stage, {ties} order")
}

/// Pixels as a technique's programs meet them: of those deeper than its arrays, what these hold.
fn held(technique: &Sorted, histogram: &DepthHistogram) -> DepthHistogram {
    let most = technique.max_frags.for_peak(histogram.peak()) as usize;
    let mut pixels = histogram.pixels.clone();
    if pixels.len() > most + 1 {
        let deeper: u64 = pixels.drain(most + 1..).sum();
        pixels[most] += deeper;
    }
    DepthHistogram { pixels }
}

/// The choice that `auto` stands for: for each size that was measured the fastest strategy, up to
/// that size.
fn fastest(tuning: &Tuning, technique: &Sorted) -> Result<SortChoice, String> {
    let wanted = (technique.capture.name(), technique.stage.name(), technique.ties.name());
    let entry = tuning
        .fastest
        .iter()
        .find(|entry| (entry.capture.as_str(), &*entry.stage, &*entry.ties) == wanted);
    let entry = entry.ok_or_else(|| {
        format!("no {}: run `oit tune` on a run of sort-intervals", asked(tuning, technique))
    })?;
    let mut parts: Vec<SortPart> = Vec::new();
    for (max_frags, sort, _) in &entry.sizes {
        let part: SortPart = sort.parse().map_err(|error| format!("{error}"))?;
        // A strategy's own limit is said by its name alone.
        let most = Some(*max_frags).filter(|_| part.strategy.limit() != Some(*max_frags));
        if parts.last().is_some_and(|last| last.alone().to_string() == part.to_string()) {
            parts.pop();
        }
        parts.push(SortPart { most, ..part });
    }
    SortChoice::from_parts(parts).map_err(|error| error.to_string())
}

/// What a technique's pixels and intervals cost, and nanoseconds of grouping besides, up to pixels
/// of `peak` fragments.
fn model(
    tuning: &Tuning,
    technique: &Sorted,
    peak: u32,
    size: FrameSize,
) -> Result<(CostModel, f64), String> {
    let missing = |what: &str| {
        format!(
            "no {what} in the {}: run `oit tune` on a run of bma-cost",
            asked(tuning, technique)
        )
    };
    let (capture, stage, ties) =
        (technique.capture.name(), technique.stage.name(), technique.ties.name());
    let schedule = technique.schedule_name();
    let interval = tuning
        .intervals
        .iter()
        .find(|entry| (entry.capture.as_str(), entry.schedule.as_str()) == (capture, schedule));
    let interval =
        interval.ok_or_else(|| missing(&format!("cost of an interval of {schedule}")))?;
    let mut parts = Vec::new();
    for part in technique.sort.parts() {
        let sort = part.alone().to_string();
        let wanted = (capture, stage, ties, sort.as_str());
        let found = tuning.pixels.iter().find(|entry| {
            (entry.capture.as_str(), &*entry.stage, &*entry.ties, &*entry.sort) == wanted
        });
        let entry = found.ok_or_else(|| missing(&format!("cost of {sort}")))?;
        parts.push((part.limit(), entry.cost()?));
        // What follows is for larger arrays than any of this view.
        let largest = technique.max_frags.for_peak(peak);
        if part.limit().is_none_or(|limit| largest <= limit) {
            break;
        }
    }
    // Every pixel is visited to be grouped: once by lists, once for each interval by masks. What a
    // list costs beside its pixels is a dispatch, whatever the frame.
    let frames = size.pixels() as f64 / interval.frame_px as f64;
    let interval_ns = match technique.stage {
        Stage::Fragment => interval.interval_ns * frames,
        Stage::Compute | Stage::Cuda => interval.interval_ns,
    };
    let model = CostModel::new(interval_ns, parts).map_err(|error| error.to_string())?;
    Ok((model, interval.grouping_ns * frames))
}
