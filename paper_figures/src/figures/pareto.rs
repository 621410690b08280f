//! Time against error: exact techniques and those that leave something out, in one chart a view, with
//! the memory that each takes.

use analysis::{CellResult, RESOLVE, TOTAL, Tables};

use super::Figure;
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::{ErrorScatter, ScatterPanel, ScatterPoint};
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::technique_names::{is_floor, label};

/// Time against error.
pub(super) struct Pareto;

/// The scale of errors.
const ERRORS: &str = "root mean square error of the picture (0 to 1, log scale right of the break)";

impl Figure for Pareto {
    fn name(&self) -> &'static str {
        "pareto"
    }

    fn source(&self) -> &'static str {
        "time against error, after BMA 2013, Figure 6 (what a too small array costs)"
    }

    fn needs(&self) -> &'static str {
        "a view with an exact technique and one that is off"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let groups = groups_with(tables, wanted, |group| trades(&charted(group)));
        Ok(groups.iter().map(|group| output(group, &charted(group))).collect())
    }
}

/// The cells of a group that have an error and times.
pub(super) fn charted<'a>(group: &Group<'a>) -> Vec<&'a CellResult> {
    let cells = group.cells.iter().copied();
    cells.filter(|cell| wanted(cell) && !cell.times.is_empty()).collect()
}

/// Whether there is an exact technique and one that leaves fragments out. Blending unsorted is the
/// floor of times, not a choice between time and error.
pub(super) fn trades(cells: &[&CellResult]) -> bool {
    let exact = cells.iter().any(|cell| cell.rmse() == Some(0.0));
    let mut off = cells.iter().filter(|cell| !is_floor(&cell.technique.sort));
    exact && off.any(|cell| cell.rmse().is_some_and(|rmse| rmse > 0.0))
}

pub(super) fn wanted(cell: &CellResult) -> bool {
    let usual = cell.technique.whole_pool() && cell.technique.powers_of_two();
    (usual || cell.technique.is_method()) && cell.rmse().is_some_and(f64::is_finite)
}

/// Peak signal-to-noise ratio in decibels; `None` of an exact picture, which has no noise.
fn psnr_db(rmse: f64) -> Option<f64> {
    (rmse > 0.0).then(|| -20.0 * rmse.log10())
}

/// Marks the points that no other beats in one of time and error without losing in the other.
pub(super) fn mark_front(points: &mut [ScatterPoint]) {
    let all: Vec<(f64, f64)> = points.iter().map(|point| (point.rmse, point.time)).collect();
    for point in points {
        let beaten = all.iter().any(|&(rmse, ms)| {
            rmse <= point.rmse && ms <= point.time && (rmse < point.rmse || ms < point.time)
        });
        point.front = !beaten;
    }
}

fn panel(title: &str, stage: &str, cells: &[&CellResult]) -> ScatterPanel {
    let points = cells.iter().filter_map(|cell| {
        Some(ScatterPoint {
            technique: cell.technique.clone(),
            label: label(&cell.name.technique),
            rmse: cell.rmse()?,
            time: cell.median_ms(stage).filter(|&ms| ms > 0.0)?,
            memory_bytes: cell.verification.as_ref()?.memory_bytes,
            front: false,
        })
    });
    let mut points: Vec<ScatterPoint> = points.collect();
    mark_front(&mut points);
    ScatterPanel { title: title.to_owned(), unit: " ms", errors: ERRORS, points }
}

fn output(group: &Group, cells: &[&CellResult]) -> Output {
    let is_sorted = |cell: &&CellResult| !cell.technique.is_method();
    let sorted_cells: Vec<&CellResult> = cells.iter().copied().filter(is_sorted).collect();
    let mut panels = vec![
        panel("Total time, ms (log scale)", TOTAL, cells),
        // Methods have no resolve of their own: what a pass of that name does there is but a part.
        panel("Resolve time with grouping, ms (log scale)", RESOLVE, &sorted_cells),
    ];
    let on_front = |panel: &ScatterPanel, cell: &CellResult| {
        panel.points.iter().any(|p| p.front && p.technique.coordinate == cell.name.technique)
    };
    let mut csv = Csv {
        columns: vec![
            "technique",
            "rmse",
            "max_error",
            "psnr_db",
            "ssim",
            "flip",
            "wrong_px",
            "total_ms",
            "total_low_ms",
            "total_high_ms",
            "resolve_ms",
            "resolve_low_ms",
            "resolve_high_ms",
            "memory_bytes",
            "total_front",
            "resolve_front",
        ],
        rows: Vec::new(),
    };
    // What an eye makes of errors is recorded where an experiment asks for it.
    let perceptual =
        cells.iter().any(|cell| cell.verification.as_ref().is_some_and(|v| v.ssim.is_some()));
    let mut columns = vec!["technique", "rmse", "max error", "PSNR\ndB"];
    if perceptual {
        columns.extend(["SSIM", "FLIP"]);
    }
    columns.extend(["total\nms", "resolve\nms", "memory\nMiB"]);
    let columns = columns.into_iter().map(str::to_owned).collect();
    let mut table = Table { columns, ..Table::default() };
    let mut sorted = cells.to_vec();
    let key =
        |cell: &CellResult| (cell.rmse().unwrap_or(0.0), cell.median_ms(TOTAL).unwrap_or(0.0));
    sorted.sort_by(|a, b| {
        let ((a_rmse, a_ms), (b_rmse, b_ms)) = (key(a), key(b));
        a_rmse.total_cmp(&b_rmse).then(a_ms.total_cmp(&b_ms)).then_with(|| a.name.cmp(&b.name))
    });
    for cell in sorted {
        let Some(verification) = &cell.verification else { continue };
        let rmse = cell.rmse().unwrap_or(0.0);
        let fronts = [on_front(&panels[0], cell), on_front(&panels[1], cell)];
        let mut row = vec![
            cell.name.technique.clone(),
            format!("{rmse}"),
            format!("{}", verification.max_error),
            psnr_db(rmse).map_or(String::new(), |db| format!("{db}")),
        ];
        for value in [verification.ssim, verification.flip] {
            row.push(value.map_or(String::new(), |value| format!("{value}")));
        }
        row.push(verification.wrong_px.to_string());
        for stage in [TOTAL, RESOLVE] {
            let summary = cell.times.get(stage).map(|timing| timing.summary);
            let summary = summary.filter(|_| stage == TOTAL || is_sorted(&cell));
            for value in
                [summary.map(|s| s.median), summary.map(|s| s.low), summary.map(|s| s.high)]
            {
                row.push(value.map_or(String::new(), |ns| format!("{}", ns / 1e6)));
            }
        }
        row.push(verification.memory_bytes.to_string());
        row.extend(fronts.map(|front| front.to_string()));
        csv.rows.push(row);
        let time = |stage: &str, front: bool| match cell.median_ms(stage) {
            _ if stage == RESOLVE && !is_sorted(&cell) => Value::from("–"),
            Some(ms) => Value { text: three_digits(ms), marked: front },
            None => Value::from("–"),
        };
        let mut row: Vec<Value> = vec![
            label(&cell.name.technique).into(),
            if rmse == 0.0 { "exact".to_owned() } else { number(rmse) }.into(),
            number(verification.max_error).into(),
            psnr_db(rmse).map_or("–".to_owned(), |db| format!("{db:.1}")).into(),
        ];
        if perceptual {
            for value in [verification.ssim, verification.flip] {
                row.push(value.map_or("–".to_owned(), |value| format!("{value:.4}")).into());
            }
        }
        row.extend([
            time(TOTAL, fronts[0]),
            time(RESOLVE, fronts[1]),
            match verification.memory_bytes {
                0 => "–".to_owned(),
                bytes => format!("{:.1}", bytes as f64 / f64::from(1 << 20)),
            }
            .into(),
        ]);
        table.rows.push(row);
    }
    panels.retain(|panel| !panel.points.is_empty());
    Output {
        name: format!("pareto-{}-{}", group.slug(), group.device_slug()),
        title: format!("Time against error: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(ErrorScatter(panels)),
        tables: vec![table],
        csv,
        notes: vec![
            "Medians. A technique with max8 sorts and blends at most 8 fragments of a pixel, and so \
             on; the rest of a deeper pixel is left out. Marked times are on the front. Methods, which \
             draw the scene in passes of their own, have a total alone. PSNR is of the root mean square \
             error, against a largest value of 1. Memory is that of all buffers and targets."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    }
}

#[cfg(test)]
mod tests {
    use analysis::Technique;

    use super::*;

    #[test]
    fn noise_is_in_decibels() {
        assert_eq!((psnr_db(0.1), psnr_db(0.0)), (Some(20.0), None));
    }

    #[test]
    fn the_front_has_what_nothing_beats() {
        let point = |rmse: f64, time: f64| ScatterPoint {
            technique: Technique::default(),
            label: String::new(),
            rmse,
            time,
            memory_bytes: 0,
            front: false,
        };
        let mut points =
            [point(0.0, 4.0), point(0.0, 3.0), point(0.1, 3.0), point(0.1, 2.0), point(0.2, 1.0)];
        mark_front(&mut points);
        assert_eq!(points.map(|point| point.front), [false, true, false, true, true]);
    }
}
