//! Table 1 of the backwards memory allocation paper: how much faster each interval is.

use std::collections::BTreeMap;

use analysis::{Ratio, Tables, part};

use super::Figure;
use super::bma_views::{OUR_SCENES, STAGES, VIEWS, charted, conditions, devices};
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::TableImage;
use crate::data::Group;
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::coordinates;

/// Table 1 of the backwards memory allocation paper.
pub(super) struct BmaTable1;

impl Figure for BmaTable1 {
    fn name(&self) -> &'static str {
        "bma-table-1"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Table 1"
    }

    fn needs(&self) -> &'static str {
        "BMA-OIT and OIT-intervals, both peak, on the view bma of atrium, smoke or powerplant"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("bma-table-1")?;
        let named: Vec<String> = STAGES
            .iter()
            .flat_map(|(_, suffix)| coordinates(&format!("OIT-intervals{suffix} peak")))
            .collect();
        let devices = devices(tables, |cell| named.contains(&cell.name.technique));
        let mut csv = Csv { columns: CSV_COLUMNS.to_vec(), rows: Vec::new() };
        let (mut shown, mut stamps) = (Vec::new(), Vec::new());
        for (device, groups) in &devices {
            let before = csv.rows.len();
            let table = block(device, groups, &published, &mut csv);
            if csv.rows.len() > before {
                shown.push(table);
                stamps.extend(groups.values().map(|group| Stamp::of(group.run)));
            }
        }
        if shown.is_empty() {
            return Ok(Vec::new());
        }
        Ok(vec![Output {
            name: self.name().to_owned(),
            title: "BMA 2013, Table 1: speed-up of BMA-OIT over OIT at each interval".to_owned(),
            subtitle: format!("Published: {}, {} px", published.device, published.resolution),
            chart: Box::new(TableImage(shown.clone())),
            tables: shown,
            csv,
            stamps: stamps.into_iter().collect(),
            notes: vec![
                "An interval's head is its upper bound. Ratios of medians of the resolve of its \
                 pixels: by OIT's one program, with the array for the deepest pixel, over by the \
                 interval's own. Frag. and comp.: ours in the fragment stage, as the paper's, and in \
                 compute. OIT has no intervals: its program is run on one interval's pixels after \
                 another (base-intervals), where the paper estimated. Grouping is in neither time. \
                 95 % intervals, times and pixels are in the CSV file."
                    .to_owned(),
                OUR_SCENES.to_owned(),
            ],
        }])
    }
}

const CSV_COLUMNS: [&str; 16] = [
    "device",
    "paper_view",
    "scene",
    "view",
    "width_px",
    "height_px",
    "shader_stage",
    "interval",
    "pixels",
    "published_speedup",
    "oit_ms",
    "bma_oit_ms",
    "speedup",
    "low",
    "high",
    "run",
];

fn block(
    device: &str,
    groups: &BTreeMap<&str, Group>,
    published: &Published,
    csv: &mut Csv,
) -> Table {
    let mut columns = vec!["Interval".to_owned()];
    for view in &VIEWS {
        columns.extend(["2013", "frag.", "comp."].map(|of| format!("{}\n{of}", view.paper)));
    }
    let quantity = &published.quantities[0];
    let mut rows = Vec::new();
    for (index, interval) in published.rows.iter().enumerate() {
        let Ok(upper) = interval.name.parse::<u32>() else { continue };
        let lower = if index == 0 { 1 } else { upper / 2 + 1 };
        let mut row = vec![Value::from(interval.name.as_str())];
        for view in &VIEWS {
            let paper = published.value(&interval.name, view.paper, quantity);
            row.push(paper.map_or("–".to_owned(), |value| format!("{value:.2}")).into());
            for (stage, suffix) in STAGES {
                let group = groups.get(view.paper);
                let own = group.and_then(|group| {
                    let pixels = pixels(group, lower, upper).filter(|&pixels| pixels > 0)?;
                    Some((group, pixels, speedup(group, suffix, upper)?))
                });
                row.push(own.as_ref().map_or("–".into(), |(_, _, (ratio, _))| {
                    format!("{:.2}", ratio.ratio).into()
                }));
                let Some((group, pixels, (ratio, [oit_ms, bma_ms]))) = own else { continue };
                let mut line = vec![device.to_owned(), view.paper.to_owned()];
                line.extend([group.scene, group.view].map(str::to_owned));
                line.extend([group.width_px, group.height_px].map(|px| px.to_string()));
                line.extend([stage.to_owned(), interval.name.clone(), pixels.to_string()]);
                line.push(paper.map_or(String::new(), |value| format!("{value}")));
                line.extend([oit_ms, bma_ms].map(three_digits));
                line.extend([ratio.ratio, ratio.low, ratio.high].map(|value| format!("{value}")));
                line.push(group.run.name.clone());
                csv.rows.push(line);
            }
        }
        rows.push(row);
    }
    Table { heading: format!("{device}, {}", conditions(groups)), rows, columns }
}

/// Pixels with so many fragments.
fn pixels(group: &Group, lower: u32, upper: u32) -> Option<u64> {
    let histogram = group.run.histogram(&group.name())?;
    let of = histogram
        .iter()
        .enumerate()
        .filter(|(depth, _)| (lower as usize..=upper as usize).contains(depth));
    Some(of.map(|(_, pixels)| pixels).sum())
}

/// The time of OIT's program over that of the interval's own, and both in ms.
fn speedup(group: &Group, suffix: &str, upper: u32) -> Option<(Ratio, [f64; 2])> {
    let base = charted(group, &format!("OIT-intervals{suffix} peak"))?;
    let bma = charted(group, &format!("BMA-OIT{suffix} peak"))?;
    let stage = part("resolve", upper);
    let ratio = analysis::compare(base, bma, &stage).ok()?;
    Some((ratio, [base.median_ms(&stage)?, bma.median_ms(&stage)?]))
}
