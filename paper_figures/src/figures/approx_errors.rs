//! What approximate techniques do to the picture: theirs, the right one and a map of the errors between.

use analysis::{CellResult, Tables};
use oit_record::Verdict;

use super::Figure;
use super::approx_accuracy::wanted;
use super::images;
use crate::FigureError;
use crate::axis::number;
use crate::chart::{PictureRow, Pictures};
use crate::claims::ErrorOf;
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::technique_names::label;

/// Pictures of approximate techniques with their errors.
pub(super) struct ApproxErrors;

impl Figure for ApproxErrors {
    fn name(&self) -> &'static str {
        "approx-errors"
    }

    fn source(&self) -> &'static str {
        "pictures of approximate techniques, and maps of their errors against the oracle"
    }

    fn needs(&self) -> &'static str {
        "pictures kept of an exact technique and of an approximate method, on one view"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        // The run with pictures speaks for a view, whichever other there is.
        let kept = |cell: &CellResult| {
            wanted(cell) && images::are_kept(&tables.runs[cell.run], &cell.name)
        };
        let enough = |group: &Group| {
            let kept = || group.cells.iter().filter(|cell| kept(cell));
            kept().any(|cell| verdict(cell) == Some(Verdict::Exact))
                && kept().any(|cell| {
                    cell.technique.is_method() && verdict(cell) == Some(Verdict::Approximate)
                })
        };
        let groups = groups_with(tables, kept, enough);
        let outputs = groups.iter().map(output).collect::<Result<Vec<_>, FigureError>>()?;
        Ok(outputs.into_iter().flatten().collect())
    }
}

fn verdict(cell: &CellResult) -> Option<Verdict> {
    cell.verification.as_ref().map(|said| said.verdict)
}

fn output(group: &Group) -> Result<Option<Output>, FigureError> {
    let mut right = None;
    let mut shown = Vec::new();
    for cell in group.cells.iter().copied().filter(|cell| wanted(cell)) {
        let Some(kept) = images::read(group.run, &cell.name)? else { continue };
        match verdict(cell) {
            Some(Verdict::Exact) if right.is_none() => right = Some((cell, kept.picture)),
            Some(Verdict::Approximate) => shown.push((cell, kept)),
            _ => {}
        }
    }
    let Some((exact, right)) = right else { return Ok(None) };
    let pixels = f64::from(group.width_px) * f64::from(group.height_px);
    let columns = vec!["technique", "wrong_percent", "max_error", "rmse", "max_alpha_error"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let heads = ["technique", "wrong pixels", "largest error", "RMSE", "largest error of alpha"];
    let mut table = Table { columns: heads.map(str::to_owned).to_vec(), ..Table::default() };
    let mut rows = Vec::new();
    for (cell, kept) in shown {
        let Some(said) = &cell.verification else { continue };
        let name = label(&cell.name.technique);
        let percent = ErrorOf::WrongPercent.of(said, pixels).unwrap_or(0.0);
        let errors = [percent, said.max_error, said.rmse, said.max_alpha_error];
        let row = [cell.name.technique.clone()].into_iter();
        csv.rows.push(row.chain(errors.map(|error| format!("{error}"))).collect());
        let row = [Value::from(name.clone()), format!("{} %", number(percent)).into()].into_iter();
        table.rows.push(row.chain(errors[1..].iter().map(|error| number(*error).into())).collect());
        rows.push(PictureRow {
            title: format!(
                "{name}: {} % of pixels wrong, by up to {}, RMSE {}",
                number(percent),
                number(said.max_error),
                number(said.rmse)
            ),
            pictures: vec![
                kept.picture.titled("Its picture"),
                right.clone().titled("The right one"),
                kept.error.map("Errors of colour"),
            ],
        });
    }
    if rows.is_empty() {
        return Ok(None);
    }
    Ok(Some(Output {
        name: format!("approx-errors-{}-{}", group.slug(), group.device_slug()),
        title: format!("What approximate techniques get wrong: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(Pictures { rows, scale: images::error_scale() }),
        tables: vec![table],
        csv,
        notes: vec![format!(
            "Pictures are over white. The right one is {}'s, which is the oracle's to within 1e-5. The \
             map has the largest error of a pixel's colour channels, rounded to 1/255.",
            label(&exact.name.technique)
        )],
        stamps: [Stamp::of(group.run)].into(),
    }))
}
