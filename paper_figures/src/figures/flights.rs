//! Flights along a camera path: the frames of one run, and how deep their pixels are.

use std::collections::BTreeMap;

use analysis::{CellResult, RunInfo, Tables, path_frame};

use crate::canvas::Colour;
use crate::chart::FlightSeries;
use crate::data::{Group, frames};
use crate::output::{Csv, Table};
use crate::style::INK;

/// Fewer frames are no flight.
const LEAST_FRAMES: usize = 3;

/// The intervals of the backwards memory allocation paper's Figure 7, and the shade each is drawn
/// in: the share of white in it.
pub(super) const INTERVALS: [(usize, usize, f64); 6] =
    [(1, 8, 0.91), (9, 16, 0.83), (17, 32, 0.73), (33, 64, 0.55), (65, 128, 0.3), (129, 256, 0.0)];

/// One frame.
pub(super) struct Frame<'a> {
    /// Its number on the path.
    pub(super) number: u32,
    /// Its cells.
    pub(super) group: Group<'a>,
    /// `histogram[n]` pixels have `n` fragments.
    pub(super) histogram: &'a [u64],
}

/// The frames of one path that one run holds, in order.
pub(super) struct FlightData<'a> {
    /// The run.
    pub(super) run: &'a RunInfo,
    /// The scene with its parameters, and the path.
    pub(super) name: String,
    /// The frames.
    pub(super) frames: Vec<Frame<'a>>,
}

impl FlightData<'_> {
    /// Where the axis ends: one step after the last frame, as recorded ones are evenly spaced.
    pub(super) fn end(&self) -> f64 {
        let number = |index: usize| self.frames.get(index).map_or(0, |frame| frame.number);
        let last = number(self.frames.len().saturating_sub(1));
        f64::from(last) + f64::from(number(1).saturating_sub(number(0)).max(1))
    }

    /// Pixels of an interval on each frame.
    pub(super) fn pixels(&self, (low, high, shade): (usize, usize, f64)) -> FlightSeries {
        let of = |frame: &Frame| (f64::from(frame.number), pixels_in(frame, low, high) as f64);
        FlightSeries {
            label: format!("{low}–{high} fragments"),
            colour: interval_colour(shade),
            points: self.frames.iter().map(of).collect(),
        }
    }

    /// How many pixels each of some intervals has, as a table for readers.
    pub(super) fn table(&self, intervals: &[(usize, usize, f64)]) -> Table {
        let heads = [
            "fragments",
            "pixels, least",
            "pixels, mean",
            "pixels, most",
            "most at",
            "frames with any",
        ];
        let rows = intervals.iter().map(|&(low, high, _)| {
            let pixels =
                self.frames.iter().map(|frame| (pixels_in(frame, low, high), frame.number));
            let all: Vec<(u64, u32)> = pixels.collect();
            let least = all.iter().map(|(pixels, _)| *pixels).min().unwrap_or(0);
            // The first of the frames with most.
            let (most, at) =
                all.iter().rev().max_by_key(|(pixels, _)| *pixels).copied().unwrap_or((0, 0));
            let mean = all.iter().map(|(px, _)| *px as f64).sum::<f64>() / all.len().max(1) as f64;
            let any = all.iter().filter(|(pixels, _)| *pixels > 0).count();
            let at = if most > 0 { format!("frame {at}") } else { "–".to_owned() };
            let (of, mean) = (format!("{low}–{high}"), format!("{mean:.0}"));
            let any = format!("{any} of {}", all.len());
            [of, least.to_string(), mean, most.to_string(), at, any].map(Into::into).to_vec()
        });
        let columns = heads.map(str::to_owned).to_vec();
        Table { heading: "depth complexity".to_owned(), columns, rows: rows.collect() }
    }

    /// The deepest pixel of all frames.
    pub(super) fn peak(&self) -> usize {
        self.frames.iter().map(peak).max().unwrap_or(0)
    }

    /// The least and the greatest number of fragments of a frame.
    pub(super) fn fragments(&self) -> (u64, u64) {
        let totals =
            || self.frames.iter().filter_map(|f| f.group.run.total_fragments(&f.group.name()));
        (totals().min().unwrap_or(0), totals().max().unwrap_or(0))
    }

    /// The populations of intervals for programs, one row a frame and interval.
    pub(super) fn csv(&self, intervals: &[(usize, usize, f64)]) -> Csv {
        let columns = vec!["frame", "from_fragments", "to_fragments", "pixels", "peak"];
        let mut rows = Vec::new();
        for frame in &self.frames {
            for &(low, high, _) in intervals {
                let pixels = pixels_in(frame, low, high);
                let number = frame.number as usize;
                rows.push([number, low, high].map(|n| n.to_string()).to_vec());
                let row = rows.len() - 1;
                rows[row].extend([pixels.to_string(), peak(frame).to_string()]);
            }
        }
        Csv { columns, rows }
    }
}

/// The colour of an interval's area.
fn interval_colour(shade: f64) -> Colour {
    INK.tint(shade)
}

/// Pixels of a frame with `low..=high` fragments.
pub(super) fn pixels_in(frame: &Frame, low: usize, high: usize) -> u64 {
    let range = low.min(frame.histogram.len())..(high + 1).min(frame.histogram.len());
    frame.histogram[range].iter().fold(0, |sum, pixels| sum.saturating_add(*pixels))
}

/// Fragments of a frame's deepest pixel.
pub(super) fn peak(frame: &Frame) -> usize {
    frame.histogram.iter().rposition(|&pixels| pixels > 0).unwrap_or(0)
}

/// The flights that hold cells that are wanted, one a run, scene, path and resolution.
pub(super) fn flights<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
) -> Vec<FlightData<'a>> {
    let mut found: BTreeMap<(String, String, [u32; 2]), FlightData<'a>> = BTreeMap::new();
    for group in frames(tables, wanted) {
        let Some((path, number)) = path_frame(group.view) else { continue };
        let Some(histogram) = group.run.histogram(&group.name()) else { continue };
        let name = format!("{}, {path}", group.scene);
        let key = (group.run.name.clone(), name.clone(), [group.width_px, group.height_px]);
        let flight = found.entry(key).or_insert_with(|| FlightData {
            run: group.run,
            name,
            frames: Vec::new(),
        });
        flight.frames.push(Frame { number, group, histogram });
    }
    let mut all: Vec<FlightData> = found.into_values().collect();
    all.retain(|flight| flight.frames.len() >= LEAST_FRAMES);
    for flight in &mut all {
        flight.frames.sort_by_key(|frame| frame.number);
    }
    all
}
