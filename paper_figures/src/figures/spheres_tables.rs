//! The tables of times of the thesis on biomolecular scenes, as published and as measured.

use analysis::{CellResult, TOTAL, Tables, scene_name, scene_parameters};
use oit_record::Verdict;

use super::Figure;
use super::bma_views::charted;
use super::spheres_views::{DRAW, PREPROCESS, SphereTable, TABLES};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::TableImage;
use crate::data::{Group, by_device, groups};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::published::{self, Published};

/// Tables 3.1 to 3.5 and 4.1 of the thesis.
pub(super) struct SpheresTables;

impl Figure for SpheresTables {
    fn name(&self) -> &'static str {
        "spheres-tables"
    }

    fn source(&self) -> &'static str {
        "Biomolecular scenes 2018, Tables 3.1 to 3.5 and 4.1"
    }

    fn needs(&self) -> &'static str {
        "a way of drawing spheres of one of the thesis's tables on sphere_stack front or virus hiv"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for table in &TABLES {
            let published = published::table(table.published)?;
            let named = table.techniques();
            let wanted = |cell: &CellResult| {
                table.is_on(scene_name(&cell.name.scene), &cell.name.view)
                    && named.contains(&cell.name.technique)
            };
            let charted = |group: &Group| {
                let cells = group.cells.iter();
                cells.filter(|cell| !cell.times.is_empty() && wanted(cell)).count()
            };
            for (_, found) in by_device(groups(tables, wanted)) {
                // The scene may have been drawn in several sizes; the table has one.
                let best = found.iter().max_by_key(|group| {
                    let of_scene_file = scene_parameters(group.scene).is_empty();
                    (group.run.run.profile == "full", charted(group), of_scene_file)
                });
                outputs.extend(best.map(|group| output(table, &published, group)));
            }
        }
        Ok(outputs)
    }
}

fn output(table: &SphereTable, published: &Published, group: &Group) -> Output {
    let mut csv = Csv { columns: CSV_COLUMNS.to_vec(), rows: Vec::new() };
    let shown = vec![times(table, published, group, &mut csv)];
    Output {
        name: format!("spheres-table-{}-{}", table.number.replace('.', "-"), group.device_slug()),
        title: format!("Biomolecular scenes 2018, Table {}: {}", table.number, table.title),
        subtitle: format!(
            "{}. Published: {}, {} px",
            group.conditions(),
            published.device,
            published.resolution
        ),
        chart: Box::new(TableImage(shown.clone())),
        tables: shown,
        csv,
        notes: [
            "Medians in ms. Of first: the time over that of the first row, the thesis's and ours. \
             Shading, in a full-screen pass of its own, and all in all are ours alone."
                .to_owned(),
            "Our scenes are generated and not the thesis's data: compare ratios, not times."
                .to_owned(),
        ]
        .into_iter()
        .chain(table.note.map(str::to_owned))
        .collect(),
        stamps: [Stamp::of(group.run)].into(),
    }
}

const CSV_COLUMNS: [&str; 13] = [
    "device",
    "scene",
    "view",
    "width_px",
    "height_px",
    "row",
    "column",
    "technique",
    "published",
    "median",
    "low",
    "high",
    "verdict",
];

/// The stages that the thesis does not tell apart.
const OURS: [(&str, &str); 2] = [("shading", "shade"), ("all in all", TOTAL)];

fn times(table: &SphereTable, published: &Published, group: &Group, csv: &mut Csv) -> Table {
    let mut columns = vec![String::new()];
    for (head, ..) in table.columns {
        let parts = ["2018", "of first", "ours", "of first"];
        // Equal neighbours are joined: the second pair is told apart by what stands above it.
        columns.extend(parts.map(|part| format!("{head}\n{part}")));
    }
    for (_, suffix, _) in distinct(table) {
        let of = suffix.trim_start_matches('/');
        columns.extend(OURS.map(|(head, _)| format!("{head}\n{of}").trim().to_owned()));
    }
    columns.push("picture".to_owned());
    let first = table.rows[0].1;
    let mut rows = Vec::new();
    for (head, technique) in table.rows.iter().chain(table.beyond) {
        let mut row = vec![Value::from(*head)];
        let mut any = false;
        for (column, suffix, stage) in table.columns {
            let paper = |of: &str| table.value(published, &format!("{of}{suffix}"), stage);
            let cell = |of: &str| charted(group, &format!("{of}{suffix}"));
            let ratio = |own: Option<f64>, base: Option<f64>| {
                let text = |ratio: f64| match ratio < 0.095 {
                    // Two decimals would leave one digit.
                    true => three_digits(ratio),
                    false => format!("{ratio:.2}"),
                };
                own.zip(base).map_or("–".to_owned(), |(own, base)| text(own / base))
            };
            let (own, base) = (paper(technique), paper(first));
            row.push(own.map_or("–".to_owned(), number).into());
            row.push(ratio(own, base).into());
            let measured =
                cell(technique).and_then(|cell| Some((cell, cell.times.get(*stage)?.summary)));
            let median_of_first =
                cell(first).and_then(|cell| Some(cell.times.get(*stage)?.summary.median));
            let median = measured.map(|(_, summary)| summary.median);
            row.push(median.map_or("–".to_owned(), |ns| three_digits(ns / 1e6)).into());
            row.push(ratio(median, median_of_first).into());
            if let Some((cell, summary)) = measured {
                any = true;
                csv.rows.push(vec![
                    group.run.device(),
                    group.scene.to_owned(),
                    group.view.to_owned(),
                    group.width_px.to_string(),
                    group.height_px.to_string(),
                    (*head).to_owned(),
                    (*column).to_owned(),
                    cell.name.technique.clone(),
                    own.map_or(String::new(), |value| format!("{value}")),
                    format!("{}", summary.median / 1e6),
                    format!("{}", summary.low / 1e6),
                    format!("{}", summary.high / 1e6),
                    verdict(cell).to_owned(),
                ]);
            }
        }
        let mut pictures = Vec::new();
        for (_, suffix, _) in distinct(table) {
            let cell = charted(group, &format!("{technique}{suffix}"));
            for (_, stage) in OURS {
                let ms = cell.and_then(|cell| Some(cell.times.get(stage)?.summary.median / 1e6));
                row.push(ms.map_or("–".to_owned(), three_digits).into());
            }
            pictures.extend(cell.map(verdict));
        }
        pictures.dedup();
        row.push(pictures.join(", ").into());
        // A row of ours without measurements says nothing; the thesis's stay.
        if any || table.rows.iter().any(|(known, _)| known == head) {
            rows.push(row);
        }
    }
    Table { heading: String::new(), columns, rows }
}

/// The columns that stand for different programs, and not for stages of one.
fn distinct(
    table: &SphereTable,
) -> impl Iterator<Item = &(&'static str, &'static str, &'static str)> {
    table.columns.iter().filter(|(_, _, stage)| {
        *stage == DRAW || table.columns.iter().all(|(.., s)| *s == PREPROCESS)
    })
}

fn verdict(cell: &CellResult) -> &'static str {
    match cell.verification.as_ref().map(|v| v.verdict) {
        Some(Verdict::Exact) => "exact",
        Some(Verdict::Approximate) => "approximate",
        Some(Verdict::Wrong) => "wrong",
        None => "",
    }
}
