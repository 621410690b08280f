//! Figure 7 of the backwards memory allocation paper: times along a flight, before the numbers of
//! pixels in each interval of depth complexity.

use analysis::{CellResult, RESOLVE, TOTAL, Tables};
use oit_record::Verdict;
use oit_record::statistics::median;

use super::Figure;
use super::flights::{FlightData, Frame, INTERVALS, flights, peak, pixels_in};
use crate::FigureError;
use crate::axis::three_digits;
use crate::canvas::Colour;
use crate::chart::{Flight, FlightPanel, FlightSeries};
use crate::output::{Csv, Output, Stamp, Table, Value, fullest};
use crate::style::SERIES;
use crate::technique_names::{coordinates, find};

/// Figure 7 of the backwards memory allocation paper.
pub(super) struct BmaFigure7;

/// A technique that is drawn.
struct Drawn {
    coordinate: &'static str,
    label: &'static str,
    shader_stage: &'static str,
    colour: Colour,
}

const fn drawn(
    coordinate: &'static str,
    label: &'static str,
    shader_stage: &'static str,
    colour: usize,
) -> Drawn {
    Drawn { coordinate, label, shader_stage, colour: SERIES[colour] }
}

/// The paper's techniques in its stage, and those of today in compute. Each is compared with the
/// last of its stage.
const DRAWN: [Drawn; 5] = [
    drawn("linked_list/base/insertion_merge64/fragment/max64", "OIT, array of 64", "fragment", 4),
    drawn("linked_list/base/insertion_merge64/fragment/max128", "OIT, array of 128", "fragment", 1),
    drawn(
        "linked_list/bma-stencil/insertion@16+merge/fragment/max128",
        "BMA-OIT, up to 128",
        "fragment",
        0,
    ),
    drawn(
        "linked_list/base/network+rbs/compute/max128",
        "OIT, array of 128, network+rbs",
        "compute",
        3,
    ),
    drawn(
        "linked_list/bma-list/network+rbs/compute/max128",
        "BMA-OIT by lists, network+rbs",
        "compute",
        2,
    ),
];

/// What is drawn of a frame's time.
const STAGES: [(&str, &str); 2] = [(TOTAL, "whole frame"), (RESOLVE, "resolve and grouping")];

impl Figure for BmaFigure7 {
    fn name(&self) -> &'static str {
        "bma-figure-7"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 7"
    }

    fn needs(&self) -> &'static str {
        "three frames or more of a camera path, linked_list with max64 and max128: base with \
         insertion_merge64 and bma-stencil with insertion@16+merge in the fragment stage, or base and bma-list with \
         network+rbs in compute"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let all = flights(tables, wanted);
        Ok(fullest(all.iter().map(|flight| (flight.frames.len(), output(flight)))))
    }
}

fn wanted(cell: &CellResult) -> bool {
    DRAWN.iter().any(|drawn| coordinates(drawn.coordinate).contains(&cell.name.technique))
}

impl Drawn {
    /// The technique's cell of a frame, if it has times.
    fn of<'a>(&self, frame: &Frame<'a>) -> Option<&'a CellResult> {
        find(&frame.group.cells, self.coordinate).filter(|cell| !cell.times.is_empty())
    }

    /// The median of a stage on each frame that has one.
    fn times(&self, flight: &FlightData, stage: &str) -> Vec<(u32, f64)> {
        let of = |frame: &Frame| Some((frame.number, self.of(frame)?.median_ms(stage)?));
        flight.frames.iter().filter_map(of).collect()
    }

    /// Frames on which it is not exact.
    fn inexact(&self, flight: &FlightData) -> usize {
        let verdict = |frame: &Frame| self.of(frame)?.verification.as_ref().map(|v| v.verdict);
        let cells = flight.frames.iter().filter_map(verdict);
        cells.filter(|verdict| *verdict != Verdict::Exact).count()
    }
}

fn output(flight: &FlightData) -> Output {
    let group = &flight.frames[0].group;
    let areas: Vec<FlightSeries> = INTERVALS
        .iter()
        .filter(|(low, ..)| *low <= flight.peak())
        .map(|interval| flight.pixels(*interval))
        .collect();
    let mut panels = Vec::new();
    for shader_stage in ["fragment", "compute"] {
        for (stage, of) in STAGES {
            let lines = DRAWN.iter().filter(|drawn| drawn.shader_stage == shader_stage);
            let lines = lines.map(|drawn| FlightSeries {
                label: drawn.label.to_owned(),
                colour: drawn.colour,
                points: {
                    let times = drawn.times(flight, stage).into_iter();
                    times.map(|(frame, ms)| (f64::from(frame), ms)).collect()
                },
            });
            let lines: Vec<FlightSeries> = lines.filter(|line| !line.points.is_empty()).collect();
            if lines.is_empty() {
                continue;
            }
            let title = format!("{shader_stage} stage: {of}");
            panels.push(FlightPanel {
                title,
                line_title: "ms".to_owned(),
                lines,
                areas: areas.clone(),
            });
        }
    }
    let (least, most) = flight.fragments();
    let (least, most) = (least as f64 / 1e6, most as f64 / 1e6);
    let mut notes = vec![format!(
        "Medians of each of {} frames. The areas are the pixels with so many fragments, those with none \
         left out. The path is our own, through a mesh of our own: the paper's are not published.",
        flight.frames.len()
    )];
    notes.push(match DRAWN[0].inexact(flight) {
        0 => "No frame here has a pixel that an array of 64 cannot hold.".to_owned(),
        frames => format!(
            "An array of 64 is too small for some pixels of {frames} of the frames: the picture is wrong \
             there."
        ),
    });
    Output {
        name: format!("bma-figure-7-{}", group.device_slug()),
        title: "BMA 2013, Figure 7: a flight through the atrium".to_owned(),
        subtitle: format!(
            "{}; {}; {least:.2} to {most:.2} M fragments, up to {} on a pixel",
            flight.name,
            group.conditions(),
            flight.peak()
        ),
        chart: Box::new(Flight { panels, frames: flight.end() }),
        tables: vec![table(flight), flight.table(&INTERVALS)],
        csv: csv(flight),
        notes,
        stamps: [Stamp::of(flight.run)].into(),
    }
}

/// The times of each technique over the flight, and how many times those of bma they are.
fn table(flight: &FlightData) -> Table {
    let heads = ["least ms", "median ms", "most ms", "over BMA-OIT"];
    let mut columns = vec!["stage".to_owned(), "technique".to_owned()];
    for (_, of) in STAGES {
        columns.extend(heads.map(|head| format!("{of}\n{head}")));
    }
    columns.push("frames not exact".to_owned());
    let mut rows = Vec::new();
    for drawn in &DRAWN {
        let bma = DRAWN.iter().rfind(|other| other.shader_stage == drawn.shader_stage);
        let mut row: Vec<Value> = vec![drawn.shader_stage.into(), drawn.label.into()];
        for (stage, _) in STAGES {
            let times = drawn.times(flight, stage);
            let of_bma = bma.map(|bma| bma.times(flight, stage)).unwrap_or_default();
            let ratio = |(frame, ms): &(u32, f64)| {
                let (_, own) = of_bma.iter().find(|(known, _)| known == frame)?;
                Some(ms / own)
            };
            let ratios: Vec<f64> = times.iter().filter_map(ratio).collect();
            let ms: Vec<f64> = times.iter().map(|(_, ms)| *ms).collect();
            let Some(middle) = median(&ms) else {
                row.extend(["–", "–", "–", "–"].map(Value::from));
                continue;
            };
            let least = ms.iter().copied().fold(f64::INFINITY, f64::min);
            let most = ms.iter().copied().fold(0.0, f64::max);
            row.extend([least, middle, most].map(|ms| Value::from(three_digits(ms))));
            let ratio = median(&ratios).map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
            row.push(ratio.into());
        }
        row.push(drawn.inexact(flight).to_string().into());
        rows.push(row);
    }
    Table { heading: "times".to_owned(), columns, rows }
}

fn csv(flight: &FlightData) -> Csv {
    let mut columns = vec!["frame", "technique", "exact", "total_ms", "resolve_ms", "peak"];
    columns.extend(["px_1_8", "px_9_16", "px_17_32", "px_33_64", "px_65_128", "px_129_256"]);
    let mut rows = Vec::new();
    for frame in &flight.frames {
        for drawn in &DRAWN {
            let Some(cell) = drawn.of(frame) else { continue };
            let exact = cell.verification.as_ref().is_some_and(|v| v.verdict == Verdict::Exact);
            let ms = |stage| cell.median_ms(stage).map_or(String::new(), |ms| format!("{ms}"));
            let mut row = vec![frame.number.to_string(), cell.name.technique.clone()];
            row.extend([exact.to_string(), ms(TOTAL), ms(RESOLVE), peak(frame).to_string()]);
            row.extend(INTERVALS.map(|(low, high, _)| pixels_in(frame, low, high).to_string()));
            rows.push(row);
        }
    }
    Csv { columns, rows }
}
