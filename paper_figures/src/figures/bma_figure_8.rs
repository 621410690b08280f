//! Figure 8 of the backwards memory allocation paper: the deep pixels of Figure 7 apart.

use analysis::Tables;

use super::Figure;
use super::flights::{FlightData, INTERVALS, flights};
use crate::FigureError;
use crate::chart::{Flight, FlightPanel};
use crate::output::{Output, Stamp, fullest};

/// Figure 8 of the backwards memory allocation paper.
pub(super) struct BmaFigure8;

impl Figure for BmaFigure8 {
    fn name(&self) -> &'static str {
        "bma-figure-8"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 8"
    }

    fn needs(&self) -> &'static str {
        "counts of three frames or more of a camera path"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let all = flights(tables, |_| true);
        Ok(fullest(all.iter().map(|flight| (flight.frames.len(), output(flight)))))
    }
}

fn output(flight: &FlightData) -> Output {
    let deep = &INTERVALS[3..5];
    let group = &flight.frames[0].group;
    let panel = |title: &str, intervals: &[(usize, usize, f64)]| FlightPanel {
        title: title.to_owned(),
        line_title: String::new(),
        lines: Vec::new(),
        areas: intervals.iter().map(|interval| flight.pixels(*interval)).collect(),
    };
    let panels = vec![panel("33–64 fragments", &deep[..1]), panel("65–128 fragments", &deep[1..])];
    Output {
        name: format!("bma-figure-8-{}", group.device_slug()),
        title: "BMA 2013, Figure 8: deep pixels during the flight".to_owned(),
        subtitle: format!("{}; {}", flight.name, group.conditions()),
        chart: Box::new(Flight { panels, frames: flight.end() }),
        tables: vec![flight.table(deep)],
        csv: flight.csv(deep),
        notes: vec![format!(
            "{} frames of a path of our own; the paper's is not published. The deepest pixel of all \
             has {} fragments. The two panels have scales of their own.",
            flight.frames.len(),
            flight.peak()
        )],
        stamps: [Stamp::of(flight.run)].into(),
    }
}
