//! Every way of drawing spheres that was measured on a view, the fastest first: the thesis's Table 4.1
//! with all combinations.

use analysis::{CellResult, TOTAL, Tables};
use oit_record::Verdict;

use super::Figure;
use super::spheres_views::{BASELINE, DRAW, PREPROCESS, TABLES};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::TableImage;
use crate::data::{Group, groups};
use crate::output::{Csv, Output, Stamp, Table, Value};

/// All combinations.
pub(super) struct SpheresCross;

/// What precedes the axes in a name.
const PREFIX: &str = "spheres/";

/// The fewest ways of drawing that are worth a list beside the thesis's tables.
const FEWEST: usize = 20;

/// Rows of the picture; the tables beside it have all.
const SHOWN: usize = 40;

impl Figure for SpheresCross {
    fn name(&self) -> &'static str {
        "spheres-cross"
    }

    fn source(&self) -> &'static str {
        "Biomolecular scenes 2018, Table 4.1, with all combinations"
    }

    fn needs(&self) -> &'static str {
        "twenty ways of drawing spheres on one view"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let of_spheres = |cell: &CellResult| cell.name.technique.starts_with(PREFIX);
        let on_a_stack =
            |group: &Group| TABLES[0].is_on(analysis::scene_name(group.scene), group.view);
        let found = groups(tables, of_spheres);
        Ok(found.iter().filter(|group| !on_a_stack(group)).filter_map(output).collect())
    }
}

fn output(group: &Group) -> Option<Output> {
    let ns = |cell: &CellResult, stage: &str| Some(cell.times.get(stage)?.summary.median);
    let timed = group.cells.iter().filter(|cell| cell.name.technique.starts_with(PREFIX));
    let mut timed: Vec<(f64, &CellResult)> =
        timed.filter_map(|cell| Some((ns(cell, TOTAL)?, *cell))).collect();
    if timed.len() < FEWEST {
        return None;
    }
    timed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let base = timed.iter().find(|(_, cell)| cell.name.technique == BASELINE).map(|(ns, _)| *ns);
    let stages = [PREPROCESS, DRAW, "shade"];
    let mut columns = vec!["way of drawing".to_owned()];
    columns.extend(stages.map(|stage| format!("{stage}\nms")));
    columns.extend(
        ["all\nms", "over the\nbaseline", "picture", "largest\nerror", "memory\nMiB"]
            .map(str::to_owned),
    );
    let mut csv = Csv {
        columns: vec![
            "technique",
            "preprocess_ms",
            "draw_ms",
            "shade_ms",
            "total_ms",
            "low_ms",
            "high_ms",
            "verdict",
            "wrong_px",
            "undecided_px",
            "max_error",
            "rmse",
            "memory_bytes",
        ],
        rows: Vec::new(),
    };
    let mut rows = Vec::new();
    for (total, cell) in &timed {
        let verification = cell.verification.as_ref()?;
        let verdict = match verification.verdict {
            Verdict::Exact => "exact",
            Verdict::Approximate => "approximate",
            Verdict::Wrong => continue,
        };
        let name = cell.name.technique.trim_start_matches(PREFIX);
        let mut row = vec![Value::from(name)];
        let of_stages = stages.map(|stage| ns(cell, stage));
        row.extend(
            of_stages.map(|ns| ns.map_or("–".to_owned(), |ns| three_digits(ns / 1e6)).into()),
        );
        row.push(three_digits(total / 1e6).into());
        row.push(base.map_or("–".to_owned(), |base| format!("{:.2}", base / total)).into());
        row.push(verdict.into());
        row.push(number(verification.max_error).into());
        row.push(number(verification.memory_bytes as f64 / f64::from(1 << 20)).into());
        if cell.name.technique == BASELINE {
            row.iter_mut().for_each(|value| value.marked = true);
        }
        rows.push(row);
        let summary = cell.times.get(TOTAL)?.summary;
        let mut line = vec![cell.name.technique.clone()];
        line.extend(of_stages.map(|ns| ns.map_or(String::new(), |ns| format!("{}", ns / 1e6))));
        line.extend([*total, summary.low, summary.high].map(|ns| format!("{}", ns / 1e6)));
        line.push(verdict.to_owned());
        line.extend([verification.wrong_px, verification.tied_px].map(|px| px.to_string()));
        line.extend([verification.max_error, verification.rmse].map(|error| format!("{error}")));
        line.push(verification.memory_bytes.to_string());
        csv.rows.push(line);
    }
    let whole = Table { heading: String::new(), columns, rows };
    // The picture has the fastest and the baseline.
    let head = whole.rows.iter().enumerate();
    let head =
        head.filter(|(place, row)| *place < SHOWN || row[0].marked).map(|(_, row)| row.clone());
    let picture = Table { rows: head.collect(), ..whole.clone() };
    Some(Output {
        name: format!("spheres-cross-{}-{}", group.slug(), group.device_slug()),
        title: format!("Ways of drawing spheres, the fastest first: {}", group.title()),
        subtitle: match group.run.spheres.get(&group.name()) {
            Some(spheres) => format!("{}; {spheres} spheres in full detail", group.conditions()),
            None => group.conditions(),
        },
        chart: Box::new(TableImage(vec![picture])),
        tables: vec![whole],
        csv,
        notes: vec![format!(
            "{} ways of drawing; the picture shows the fastest {SHOWN} and the baseline, bold. Medians. \
             Over the baseline: how many times as fast as the thesis's program, the whole frame. Largest \
             error: of a colour, beside the rims of spheres, against the oracle; it is what the packing \
             of positions and normals brings.",
            timed.len()
        )],
        stamps: [Stamp::of(group.run)].into(),
    })
}
