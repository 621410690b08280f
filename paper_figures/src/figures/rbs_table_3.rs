//! Table 3 of the register-based block sort paper: speed-ups over the baseline.

use analysis::{CellResult, Ratio, Tables};

use super::Figure;
use super::rbs_table_2::techniques;
use super::rbs_views::{Device, PROVENANCE, QUANTITIES, VIEWS, devices, provenance};
use crate::FigureError;
use crate::chart::TableImage;
use crate::output::{Csv, Output, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::{ALIASES, label};

/// Table 3 of the register-based block sort paper.
pub(super) struct RbsTable3;

/// The paper's last row: [`BEST`] against the fastest technique without register-based block sort.
pub(super) const STARRED: &str = "BMA-RBS-L*";
const BEST: &str = "BMA-RBS-L";
const BASELINE: &str = "BASE-IS";

impl Figure for RbsTable3 {
    fn name(&self) -> &'static str {
        "rbs-table-3"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Table 3"
    }

    fn needs(&self) -> &'static str {
        "BASE-IS and another technique of RBS 2014, Table 2, on one of its views"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("rbs-table-3")?;
        let devices = devices(tables);
        let devices: Vec<Device> = devices
            .into_iter()
            .filter(|device| {
                let charted = |cell: &CellResult| !cell.times.is_empty();
                VIEWS.iter().any(|(view, _, _)| device.cell(BASELINE, view).is_some_and(charted))
            })
            .collect();
        if devices.is_empty() {
            return Ok(Vec::new());
        }
        let mut csv = Csv { columns: csv_columns(), rows: Vec::new() };
        let mut shown = Vec::new();
        for device in &devices {
            for views in device.blocks() {
                shown.push(block(device, &published, &views, &mut csv));
            }
        }
        Ok(vec![Output {
            name: self.name().to_owned(),
            title: "RBS 2014, Table 3: speed-up over BASE-IS, the baseline".to_owned(),
            subtitle: format!("Published: {}, {} px", published.device, published.resolution),
            chart: Box::new(TableImage(shown.clone())),
            tables: shown,
            csv,
            notes: vec![
                "T: total. R: resolve, with the grouping of pixels where the schedule is bma. \
                 Ratios of medians; their 95 % intervals are in the CSV file. Marked: the highest \
                 of the column. BMA-RBS-L*: BMA-RBS-L over the fastest of the paper's techniques \
                 without RBS that the column has."
                    .to_owned(),
            ],
            stamps: devices.iter().flat_map(Device::stamps).collect(),
        }])
    }
}

/// The cell a row is compared with, and the row's own.
fn pair<'a>(
    device: &Device<'a>,
    technique: &str,
    view: &str,
    stage: &str,
) -> Option<(&'a CellResult, &'a CellResult)> {
    if technique != STARRED {
        return Some((device.cell(BASELINE, view)?, device.cell(technique, view)?));
    }
    let rest = ALIASES.iter().filter(|(alias, _)| !alias.contains("RBS"));
    let timed = rest.filter_map(|(alias, _)| {
        let cell = device.cell(alias, view)?;
        Some((cell, cell.median_ms(stage)?))
    });
    let (fastest, _) = timed.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((fastest, device.cell(BEST, view)?))
}

/// The speed-up of a row on a view: the baseline's time over the technique's own.
pub(super) fn speedup(device: &Device, technique: &str, view: &str, stage: &str) -> Option<Ratio> {
    let (base, own) = pair(device, technique, view, stage)?;
    analysis::compare(base, own, stage).ok()
}

fn csv_columns() -> Vec<&'static str> {
    let mut columns = vec![
        "device",
        "technique",
        "compared_with",
        "paper_view",
        "quantity",
        "published_speedup",
        "speedup",
        "low",
        "high",
    ];
    columns.extend(PROVENANCE);
    columns
}

/// One device's table of these views, and its rows of the CSV file.
fn block(device: &Device, published: &Published, views: &[&str], csv: &mut Csv) -> Table {
    let mut columns = vec!["technique".to_owned()];
    for &view in views {
        for (quantity, _) in QUANTITIES {
            columns.push(format!("{view}\n{quantity}\n2014"));
            columns.push(format!("{view}\n{quantity}\nours"));
        }
    }
    columns.push("note".to_owned());
    let techniques = techniques(device, published);
    let mut numbers: Vec<Vec<Option<f64>>> = Vec::new();
    for technique in &techniques {
        let mut row = Vec::new();
        for &view in views {
            for (quantity, stage) in QUANTITIES {
                let pair = pair(device, technique, view, stage);
                let ratio = speedup(device, technique, view, stage);
                let theirs = published.value(technique, view, quantity);
                row.extend([theirs, ratio.map(|ratio| ratio.ratio)]);
                if let Some(group) = device.group(view) {
                    let say = |of: fn(&Ratio) -> f64| {
                        ratio.as_ref().map_or(String::new(), |ratio| format!("{}", of(ratio)))
                    };
                    let mut line = vec![
                        device.name.clone(),
                        (*technique).to_owned(),
                        pair.map_or(String::new(), |(base, _)| base.name.technique.clone()),
                        view.to_owned(),
                        quantity.to_owned(),
                        theirs.map_or(String::new(), |value| format!("{value}")),
                        say(|ratio| ratio.ratio),
                        say(|ratio| ratio.low),
                        say(|ratio| ratio.high),
                    ];
                    line.extend(provenance(group, pair.map(|(_, own)| own)));
                    csv.rows.push(line);
                }
            }
        }
        numbers.push(row);
    }
    // The starred row is compared with something else, so it is not in the race.
    let racing = || techniques.iter().zip(&numbers).filter(|(name, _)| **name != STARRED);
    let highest: Vec<f64> = (0..views.len() * QUANTITIES.len() * 2)
        .map(|column| racing().filter_map(|(_, row)| row[column]).fold(0.0, f64::max))
        .collect();
    let rows = techniques.iter().zip(&numbers).map(|(technique, numbers)| {
        let mut row = vec![Value::from(label(technique))];
        for (number, highest) in numbers.iter().zip(&highest) {
            row.push(match number {
                Some(speedup) => Value {
                    text: format!("{speedup:.1}"),
                    marked: *technique != STARRED && speedup >= highest,
                },
                None => Value::from("–"),
            });
        }
        row.push(if *technique == STARRED { String::new() } else { device.note(technique) }.into());
        row
    });
    Table {
        heading: format!("{}, {}", device.name, device.conditions),
        rows: rows.collect(),
        columns,
    }
}
