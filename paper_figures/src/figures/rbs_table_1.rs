//! Table 1 of the register-based block sort paper: average and best speed-ups over the baseline.

use analysis::Tables;

use super::Figure;
use super::rbs_table_2::techniques;
use super::rbs_table_3::{STARRED, speedup};
use super::rbs_views::{Device, QUANTITIES, VIEWS, devices};
use crate::FigureError;
use crate::chart::TableImage;
use crate::output::{Csv, Output, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::label;

/// Table 1 of the register-based block sort paper.
pub(super) struct RbsTable1;

impl Figure for RbsTable1 {
    fn name(&self) -> &'static str {
        "rbs-table-1"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Table 1"
    }

    fn needs(&self) -> &'static str {
        "BASE-IS and another technique of RBS 2014, Table 2, on all nine of its views"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("rbs-table-1")?;
        let of_views = published::table("rbs-table-2")?;
        let devices: Vec<Device> = devices(tables)
            .into_iter()
            .filter(|device| VIEWS.iter().all(|(view, _, _)| device.group(view).is_some()))
            .collect();
        if devices.is_empty() {
            return Ok(Vec::new());
        }
        let mut csv = Csv {
            columns: vec![
                "device",
                "technique",
                "quantity",
                "views",
                "published_average",
                "average",
                "published_best",
                "best",
            ],
            rows: Vec::new(),
        };
        let shown: Vec<Table> =
            devices.iter().map(|device| block(device, &published, &of_views, &mut csv)).collect();
        Ok(vec![Output {
            name: self.name().to_owned(),
            title: "RBS 2014, Table 1: average and best speed-up over BASE-IS, the baseline".to_owned(),
            subtitle: format!("Published: {}, {} px", published.device, published.resolution),
            chart: Box::new(TableImage(shown.clone())),
            tables: shown,
            csv,
            notes: vec![
                "T: total. R: resolve, with the grouping of pixels where the schedule is bma. Means and \
                 largest of the speed-ups of Table 3, over as many of the nine views as a technique \
                 ran exactly on. BMA-RBS-L*: BMA-RBS-L over the fastest of the paper's techniques \
                 without RBS."
                    .to_owned(),
            ],
            stamps: devices.iter().flat_map(Device::stamps).collect(),
        }])
    }
}

fn block(device: &Device, published: &Published, of_views: &Published, csv: &mut Csv) -> Table {
    let mut columns = vec!["technique".to_owned()];
    for summary in ["average", "best"] {
        for (quantity, _) in QUANTITIES {
            columns.push(format!("{summary}\n{quantity}\n2014"));
            columns.push(format!("{summary}\n{quantity}\nours"));
        }
    }
    columns.push("views".to_owned());
    let mut names = techniques(device, of_views);
    names.push(STARRED);
    let mut rows = Vec::new();
    for technique in names {
        let mut row = vec![Value::from(label(technique))];
        let mut counted = 0;
        let ours: Vec<Option<[f64; 2]>> = QUANTITIES
            .iter()
            .map(|(_, stage)| {
                let ratios: Vec<f64> = VIEWS
                    .iter()
                    .filter_map(|(view, _, _)| speedup(device, technique, view, stage))
                    .map(|ratio| ratio.ratio)
                    .collect();
                counted = ratios.len();
                let average = ratios.iter().sum::<f64>() / ratios.len() as f64;
                let best = ratios.iter().copied().fold(0.0, f64::max);
                (!ratios.is_empty()).then_some([average, best])
            })
            .collect();
        let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
        for (place, summary) in ["Average", "Best"].into_iter().enumerate() {
            for ((quantity, _), ours) in QUANTITIES.iter().zip(&ours) {
                let theirs = published.value(technique, summary, quantity);
                for value in [theirs, ours.map(|ours| ours[place])] {
                    row.push(value.map_or("–".to_owned(), |value| format!("{value:.1}")).into());
                }
            }
        }
        for ((quantity, _), ours) in QUANTITIES.iter().zip(&ours) {
            csv.rows.push(vec![
                device.name.clone(),
                technique.to_owned(),
                (*quantity).to_owned(),
                counted.to_string(),
                say(published.value(technique, "Average", quantity)),
                say(ours.map(|ours| ours[0])),
                say(published.value(technique, "Best", quantity)),
                say(ours.map(|ours| ours[1])),
            ]);
        }
        row.push(counted.to_string().into());
        rows.push(row);
    }
    Table { heading: format!("{}, {}", device.name, device.conditions), rows, columns }
}
