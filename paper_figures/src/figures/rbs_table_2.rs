//! Table 2 of the register-based block sort paper: times of the techniques.

use analysis::Tables;

use super::Figure;
use super::rbs_views::{Device, PROVENANCE, QUANTITIES, VIEWS, devices, provenance};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::TableImage;
use crate::output::{Csv, Output, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::label;

/// Table 2 of the register-based block sort paper.
pub(super) struct RbsTable2;

/// The paper marks times within this of the fastest.
const NEAR_FASTEST: f64 = 1.05;

impl Figure for RbsTable2 {
    fn name(&self) -> &'static str {
        "rbs-table-2"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Table 2"
    }

    fn needs(&self) -> &'static str {
        "a linked_list technique of the table on one of its nine views (powerplant, atrium, hairball, \
         planes)"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("rbs-table-2")?;
        let devices = devices(tables);
        if devices.is_empty() {
            return Ok(Vec::new());
        }
        let mut shown = Vec::new();
        for device in &devices {
            shown.extend(device.blocks().map(|views| block(device, &published, &views)));
        }
        Ok(vec![Output {
            name: self.name().to_owned(),
            title: "RBS 2014, Table 2: rendering time of exact techniques, ms".to_owned(),
            subtitle: format!("Published: {}, {} px", published.device, published.resolution),
            chart: Box::new(TableImage(shown.clone())),
            tables: shown,
            csv: csv(&devices, &published),
            notes: vec![
                "T: total. R: resolve, with the grouping of pixels where the schedule is bma. \
                 Medians. Marked: within 5 % of the fastest of the column."
                    .to_owned(),
                "Fwd and Rev: what a linked list holds is nearly sorted, and nearly reversed. Lists \
                 are read last in first out, so Fwd is submitted from far to near."
                    .to_owned(),
                "The paper's names mean linked lists and the fragment stage. Our scenes are generated \
                 and not the paper's files: compare ratios, not times."
                    .to_owned(),
            ],
            stamps: devices.iter().flat_map(Device::stamps).collect(),
        }])
    }
}

/// The techniques of the rows: the paper's, then ours.
pub(super) fn techniques<'a>(device: &'a Device, published: &'a Published) -> Vec<&'a str> {
    let paper = published.rows.iter().map(|row| row.name.as_str());
    paper.chain(device.others.iter().map(String::as_str)).collect()
}

/// One device's table of these views.
fn block(device: &Device, published: &Published, views: &[&str]) -> Table {
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
            let cell = device.cell(technique, view);
            for (quantity, stage) in QUANTITIES {
                row.push(published.value(technique, view, quantity));
                row.push(cell.and_then(|cell| cell.median_ms(stage)));
            }
        }
        numbers.push(row);
    }
    let fastest: Vec<f64> = (0..views.len() * QUANTITIES.len() * 2)
        .map(|column| numbers.iter().filter_map(|row| row[column]).fold(f64::INFINITY, f64::min))
        .collect();
    let rows = techniques.iter().zip(&numbers).map(|(technique, numbers)| {
        let mut row = vec![Value::from(label(technique))];
        for (column, (value, fastest)) in numbers.iter().zip(&fastest).enumerate() {
            row.push(match value {
                Some(ms) => Value {
                    // Published numbers stand as they were printed.
                    text: if column % 2 == 0 { number(*ms) } else { three_digits(*ms) },
                    marked: *ms <= fastest * NEAR_FASTEST,
                },
                None => Value::from("–"),
            });
        }
        row.push(device.note(technique).into());
        row
    });
    Table {
        heading: format!("{}, {}", device.name, device.conditions),
        rows: rows.collect(),
        columns,
    }
}

fn csv(devices: &[Device], published: &Published) -> Csv {
    let mut columns = vec![
        "device",
        "technique",
        "coordinate",
        "paper_view",
        "quantity",
        "published_ms",
        "median_ms",
        "low_ms",
        "high_ms",
        "samples",
    ];
    columns.extend(PROVENANCE);
    let mut rows = Vec::new();
    let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
    for device in devices {
        for technique in techniques(device, published) {
            for (view, _, _) in VIEWS {
                let Some(group) = device.group(view) else { continue };
                let cell = device.cell(technique, view);
                for (quantity, stage) in QUANTITIES {
                    let summary = cell.and_then(|cell| cell.times.get(stage)).map(|t| t.summary);
                    let mut row = vec![
                        device.name.clone(),
                        technique.to_owned(),
                        cell.map_or(String::new(), |cell| cell.name.technique.clone()),
                        view.to_owned(),
                        quantity.to_owned(),
                        say(published.value(technique, view, quantity)),
                        say(summary.map(|s| s.median / 1e6)),
                        say(summary.map(|s| s.low / 1e6)),
                        say(summary.map(|s| s.high / 1e6)),
                        summary.map_or(String::new(), |s| s.samples.to_string()),
                    ];
                    row.extend(provenance(group, cell));
                    rows.push(row);
                }
            }
        }
    }
    Csv { columns, rows }
}
