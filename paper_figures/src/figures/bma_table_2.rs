//! Table 2 of the backwards memory allocation paper: standard OIT and BMA-OIT at two sizes of array.

use std::collections::BTreeMap;

use analysis::{CellResult, RESOLVE, TOTAL, Tables};
use oit_record::Verdict;

use super::Figure;
use super::bma_views::{
    ALLOCATIONS, BmaView, OUR_SCENES, STAGES, VIEWS, charted, conditions, devices,
};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::TableImage;
use crate::data::Group;
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::coordinates;

/// Table 2 of the backwards memory allocation paper.
pub(super) struct BmaTable2;

/// The rows of times: the paper's head, the technique, and the stage.
const TIMES: [(&str, &str, &str); 4] = [
    ("OIT (ms)", "OIT", TOTAL),
    ("BMA-OIT (ms)", "BMA-OIT", TOTAL),
    ("OIT, resolve (ms)", "OIT", RESOLVE),
    ("BMA-OIT, resolve (ms)", "BMA-OIT", RESOLVE),
];

impl Figure for BmaTable2 {
    fn name(&self) -> &'static str {
        "bma-table-2"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Table 2"
    }

    fn needs(&self) -> &'static str {
        "OIT or BMA-OIT at an array size of BMA 2013, Table 2, on the view bma of atrium, smoke or \
         powerplant"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("bma-table-2")?;
        let named: Vec<String> =
            techniques(&published).iter().flat_map(|name| coordinates(name)).collect();
        let devices = devices(tables, |cell| named.contains(&cell.name.technique));
        if devices.is_empty() {
            return Ok(Vec::new());
        }
        let mut csv = Csv { columns: CSV_COLUMNS.to_vec(), rows: Vec::new() };
        let mut shown = Vec::new();
        for (device, groups) in &devices {
            let heading = format!("{device}, {}", conditions(groups));
            shown.push(facts(heading, groups, &published));
            shown.push(times(device, groups, &published, &mut csv));
        }
        let stamps = devices.iter().flat_map(|(_, groups)| groups.values());
        Ok(vec![Output {
            name: self.name().to_owned(),
            title: "BMA 2013, Table 2: standard OIT and BMA-OIT at two sizes of array".to_owned(),
            subtitle: format!("Published: {}, {} px", published.device, published.resolution),
            chart: Box::new(TableImage(shown.clone())),
            tables: shown,
            csv,
            stamps: stamps.map(|group| Stamp::of(group.run)).collect(),
            notes: vec![
                "Medians in ms of the whole frame, and of the resolve with the grouping of pixels. \
                 Frag. and comp.: ours in the fragment stage, as the paper's, and in compute. Wrong \
                 pixels: off by more than 1/255 because the array is too small for them."
                    .to_owned(),
                OUR_SCENES.to_owned(),
            ],
        }])
    }
}

/// Every technique of the table, of any view.
fn techniques(published: &Published) -> Vec<String> {
    let mut all = Vec::new();
    for view in &VIEWS {
        for max in ALLOCATIONS.iter().filter_map(|column| view.allocation(published, column)) {
            for (_, suffix) in STAGES {
                all.extend(["OIT", "BMA-OIT"].map(|name| format!("{name}{suffix} {max}")));
            }
        }
    }
    all
}

fn facts(heading: String, groups: &BTreeMap<&str, Group>, published: &Published) -> Table {
    let mut columns = vec![String::new()];
    for view in &VIEWS {
        columns.extend(["2013", "ours"].map(|of| format!("{}\n{of}", view.paper)));
    }
    let of = |group: &Group, fact: &str| -> Option<u64> {
        let name = group.name();
        match fact {
            "Total Polys" => group.run.triangles(&name),
            "Total Frags" => group.run.total_fragments(&name),
            _ => {
                let histogram = group.run.histogram(&name)?;
                histogram.iter().rposition(|&pixels| pixels > 0).map(|peak| peak as u64)
            }
        }
    };
    let rows = published.facts.iter().map(|fact| {
        let mut row = vec![Value::from(fact.name.as_str())];
        for view in &VIEWS {
            let paper = published.fact(&fact.name, view.paper);
            row.push(paper.map_or("–".to_owned(), |value| format!("{value}")).into());
            let own = groups.get(view.paper).and_then(|group| of(group, &fact.name));
            row.push(own.map_or("–".to_owned(), |value| value.to_string()).into());
        }
        row
    });
    Table { heading, rows: rows.collect(), columns }
}

/// The cell of a technique at an allocation of the paper.
fn cell<'a>(
    groups: &BTreeMap<&str, Group<'a>>,
    published: &Published,
    (technique, suffix): (&str, &str),
    (view, column): (&BmaView, &str),
) -> Option<&'a CellResult> {
    let max = view.allocation(published, column)?;
    charted(groups.get(view.paper)?, &format!("{technique}{suffix} {max}"))
}

const CSV_COLUMNS: [&str; 15] = [
    "device",
    "paper_view",
    "scene",
    "view",
    "width_px",
    "height_px",
    "shader_stage",
    "row",
    "max_alloc",
    "coordinate",
    "published",
    "median",
    "low",
    "high",
    "run",
];

fn times(
    device: &str,
    groups: &BTreeMap<&str, Group>,
    published: &Published,
    csv: &mut Csv,
) -> Table {
    let mut columns = vec!["Max Alloc".to_owned()];
    for view in &VIEWS {
        for column in ALLOCATIONS {
            let max = published.value("Max Alloc", view.paper, column).map_or(0.0, |max| max);
            columns.extend(
                ["2013", "frag.", "comp."].map(|of| format!("{}\n{max}\n{of}", view.paper)),
            );
        }
    }
    let mut row_of = |head: &str, own: &dyn Fn(&BmaView, &str, &str) -> Option<Entry>| {
        let mut row = vec![Value::from(head)];
        for view in &VIEWS {
            for column in ALLOCATIONS {
                let paper = published.value(head, view.paper, column);
                let mut texts = vec![paper.map_or("–".to_owned(), number)];
                for (stage, suffix) in STAGES {
                    let entry = own(view, column, suffix);
                    texts.push(entry.as_ref().map_or("–".to_owned(), |entry| entry.text.clone()));
                    let (Some(entry), Some(group)) = (entry, groups.get(view.paper)) else {
                        continue;
                    };
                    csv.rows.push(vec![
                        device.to_owned(),
                        view.paper.to_owned(),
                        group.scene.to_owned(),
                        group.view.to_owned(),
                        group.width_px.to_string(),
                        group.height_px.to_string(),
                        stage.to_owned(),
                        head.to_owned(),
                        view.allocation(published, column).unwrap_or_default(),
                        entry.coordinate,
                        paper.map_or(String::new(), |value| format!("{value}")),
                        format!("{}", entry.values[0]),
                        format!("{}", entry.values[1]),
                        format!("{}", entry.values[2]),
                        group.run.name.clone(),
                    ]);
                }
                row.extend(texts.into_iter().map(Value::from));
            }
        }
        row
    };
    let mut rows = Vec::new();
    for (head, technique, stage) in TIMES {
        rows.push(row_of(head, &|view, column, suffix| {
            let cell = cell(groups, published, (technique, suffix), (view, column))?;
            let s = cell.times.get(stage)?.summary;
            let values = [s.median, s.low, s.high].map(|ns| ns / 1e6);
            Some(Entry::of(cell, values, three_digits(values[0])))
        }));
    }
    for (head, stage) in [("Speedup", TOTAL), ("Speedup of the resolve", RESOLVE)] {
        rows.push(row_of(head, &|view, column, suffix| {
            let at = (view, column);
            let base = cell(groups, published, ("OIT", suffix), at)?;
            let bma = cell(groups, published, ("BMA-OIT", suffix), at)?;
            let ratio = analysis::compare(base, bma, stage).ok()?;
            let text = format!("{:.2}", ratio.ratio);
            Some(Entry::of(bma, [ratio.ratio, ratio.low, ratio.high], text))
        }));
    }
    rows.push(row_of("Wrong pixels (%)", &|view, column, suffix| {
        let cell = cell(groups, published, ("BMA-OIT", suffix), (view, column))?;
        let pixels = f64::from(cell.name.width_px) * f64::from(cell.name.height_px);
        let v = cell.verification.as_ref()?;
        // Of an exact picture those are wrong that have no one right answer, by depth alone.
        let wrong_px = if v.verdict == Verdict::Exact { 0 } else { v.wrong_px };
        let share = 100.0 * wrong_px as f64 / pixels;
        Some(Entry::of(cell, [share; 3], number(share)))
    }));
    Table { heading: String::new(), rows, columns }
}

/// One of our numbers: a value and the ends of its 95 % interval, as text, and whose it is.
struct Entry {
    coordinate: String,
    values: [f64; 3],
    text: String,
}

impl Entry {
    fn of(cell: &CellResult, values: [f64; 3], text: String) -> Self {
        Self { coordinate: cell.name.technique.clone(), values, text }
    }
}
