//! How far approximate techniques are from the oracle, by every figure that is recorded: a table a view.

use analysis::{CellResult, TOTAL, Tables};
use oit_record::{Verdict, Verification};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::TableImage;
use crate::claims::ErrorOf;
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::technique_names::label;

/// Errors of approximate techniques.
pub(super) struct ApproxAccuracy;

/// Fewer approximate methods than this are no comparison.
const LEAST: usize = 4;

/// The errors in the order of the columns, with the head of each. Alpha is apart, and last.
const ERRORS: [(&str, &str, ErrorOf); 7] = [
    ("wrong_percent", "colour\nwrong\npixels %", ErrorOf::WrongPercent),
    ("max_error", "colour\nlargest\nerror", ErrorOf::MaxError),
    ("rmse", "colour\nRMSE\n", ErrorOf::Rmse),
    ("psnr_db", "colour\nPSNR\ndB", ErrorOf::PsnrDb),
    ("ssim", "over black\nSSIM\n", ErrorOf::Ssim),
    ("flip", "over black\nFLIP\n", ErrorOf::Flip),
    ("max_alpha_error", "alpha\nlargest\nerror", ErrorOf::MaxAlphaError),
];

impl Figure for ApproxAccuracy {
    fn name(&self) -> &'static str {
        "approx-accuracy"
    }

    fn source(&self) -> &'static str {
        "errors of approximate techniques against the oracle"
    }

    fn needs(&self) -> &'static str {
        "four approximate methods, or more, on one view"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let enough = |group: &Group| {
            let approximate = |cell: &&&CellResult| {
                cell.technique.is_method()
                    && timed(cell).is_some_and(|said| said.verdict == Verdict::Approximate)
            };
            group.cells.iter().filter(|cell| wanted(cell)).filter(approximate).count() >= LEAST
        };
        Ok(groups_with(tables, wanted, enough).iter().map(output).collect())
    }
}

/// Methods that do not peel, arrays that may be too small, and what they are measured against.
pub(super) fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    let method = technique.is_method() && !technique.method.contains("peel");
    (method || (technique.whole_pool() && technique.powers_of_two()))
        && cell.verification.as_ref().is_some_and(|said| said.rmse.is_finite())
}

/// What was found of a cell that has times.
fn timed(cell: &CellResult) -> Option<&Verification> {
    cell.verification.as_ref().filter(|_| !cell.times.is_empty())
}

/// A figure as short as it can be said without losing its first digits.
fn short(value: f64) -> String {
    match value.abs() {
        size if !size.is_finite() => "–".to_owned(),
        0.0 => "0".to_owned(),
        size if size < 1e-4 => format!("{value:.0e}"),
        _ => three_digits(value),
    }
}

fn output(group: &Group) -> Output {
    let names = ERRORS.iter().map(|(name, ..)| *name);
    let columns: Vec<&str> = ["technique", "verdict"]
        .into_iter()
        .chain(names)
        .chain(["total_ms", "memory_bytes"])
        .collect();
    let mut csv = Csv { columns, rows: Vec::new() };
    let heads = ERRORS.iter().map(|(_, head, _)| *head);
    let heads = ["technique"].into_iter().chain(heads).chain(["total\nms", "memory\nMiB"]);
    let mut table = Table { columns: heads.map(str::to_owned).collect(), ..Table::default() };
    let pixels = f64::from(group.width_px) * f64::from(group.height_px);
    for cell in group.cells.iter().filter(|cell| wanted(cell)) {
        let Some(said) = timed(cell) else { continue };
        let exact = said.verdict == Verdict::Exact;
        let errors = ERRORS.map(|(_, _, of)| of.of(said, pixels));
        let ms = cell.median_ms(TOTAL);
        let verdict = if exact { "exact" } else { "approximate" };
        let mut row = vec![cell.name.technique.clone(), verdict.to_owned()];
        // An exact picture's ratio of signal to noise is without bound.
        let known = |value: Option<f64>| value.filter(|value| value.is_finite());
        row.extend(errors.map(|e| known(e).map_or(String::new(), |value| format!("{value}"))));
        row.push(ms.map_or(String::new(), |ms| format!("{ms}")));
        row.push(said.memory_bytes.to_string());
        csv.rows.push(row);
        let mut row: Vec<Value> = vec![label(&cell.name.technique).into()];
        let text = |error: Option<f64>| match error {
            Some(value) if !exact => short(value),
            _ => "–".to_owned(),
        };
        row.extend(errors.map(|error| Value::from(text(error))));
        row.push(ms.map_or("–".to_owned(), three_digits).into());
        row.push(match said.memory_bytes {
            0 => "–".into(),
            bytes => format!("{:.1}", bytes as f64 / f64::from(1 << 20)).into(),
        });
        table.rows.push(row);
    }
    Output {
        name: format!("approx-accuracy-{}-{}", group.slug(), group.device_slug()),
        title: format!("Errors against the oracle: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(TableImage(vec![table.clone()])),
        tables: vec![table],
        csv,
        notes: vec![
            "Colours are linear, premultiplied floats, compared before any rounding; alpha is apart. A \
             pixel is wrong if a colour channel is off by more than 1/255. PSNR is of a peak of 1. SSIM \
             (windows of 8 × 8) and FLIP are of the picture over black in eight bits. Lines without \
             errors are of pictures found exact, to within 1e-5. Times are medians."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_keep_their_first_digits() {
        let values = [0.0, 4.3e-4, 7.4e-8, 0.9853, 35.27, f64::INFINITY];
        let texts = ["0", "0.000430", "7e-8", "0.985", "35.3", "–"];
        assert_eq!(values.map(short), texts);
    }
}
