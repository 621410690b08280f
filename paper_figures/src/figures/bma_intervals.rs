//! Other intervals of depth complexity than powers of two: section 3 of the backwards memory
//! allocation paper has an optimum for a view gain of the order of 5 %.

use analysis::{CellResult, RESOLVE, Ratio, Tables, Technique, compare};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::{Group, by_device, groups_with, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::sort_colour;

/// Intervals against powers of two.
pub(super) struct BmaIntervals;

impl Figure for BmaIntervals {
    fn name(&self) -> &'static str {
        "bma-intervals"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, section 3: intervals optimised for views"
    }

    fn needs(&self) -> &'static str {
        "a view with powers of two and other intervals, all else equal"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let devices = by_device(groups_with(tables, wanted, |group| !pairs(group).is_empty()));
        Ok(devices.iter().filter_map(|(device, groups)| output(device, groups)).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.schedule.starts_with("bma") && technique.max == "peak" && technique.whole_pool()
}

/// Cells with other intervals, each beside the same with powers of two.
fn pairs<'a>(group: &Group<'a>) -> Vec<(&'a CellResult, &'a CellResult, Ratio)> {
    let cells = || group.cells.iter().copied().filter(|cell| wanted(cell));
    let mut pairs = Vec::new();
    for own in cells().filter(|cell| !cell.technique.powers_of_two()) {
        let same = |other: &&CellResult| {
            let (a, b) = (&own.technique, &other.technique);
            b.powers_of_two()
                && (&a.capture, &a.schedule, &a.sort, &a.shader_stage, &a.ties)
                    == (&b.capture, &b.schedule, &b.sort, &b.shader_stage, &b.ties)
        };
        for usual in cells().filter(same) {
            // One of them may be wrong or skipped: then there is nothing to compare.
            if let Ok(ratio) = compare(own, usual, RESOLVE) {
                pairs.push((own, usual, ratio));
            }
        }
    }
    pairs
}

/// The intervals and the sort that were run, where the coordinate leaves them to measurements.
fn ran(cell: &CellResult) -> Technique {
    let tuned = cell.verification.as_ref().and_then(|verification| verification.tuned.as_deref());
    tuned.map_or_else(|| cell.technique.clone(), Technique::parse)
}

/// What the device's cost model has for the time of a cell over that of another.
fn predicted(own: &CellResult, usual: &CellResult) -> Option<f64> {
    let ns = |cell: &CellResult| cell.verification.as_ref()?.predicted_ns.filter(|ns| *ns > 0.0);
    Some(ns(own)? / ns(usual)?)
}

fn output(device: &str, groups: &[Group]) -> Option<Output> {
    let columns = vec![
        "scene",
        "view",
        "width_px",
        "height_px",
        "capture",
        "schedule",
        "shader_stage",
        "sort",
        "sort_run",
        "ties",
        "intervals",
        "bounds",
        "powers_of_two_ms",
        "ms",
        "ratio",
        "low",
        "high",
        "verdict",
        "predicted_ratio",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "view",
        "stage",
        "sort",
        "intervals",
        "upper bounds",
        "powers of two\nms",
        "ms",
        "ratio",
        "95 % interval",
        "ratio by\nthe model",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let (mut panels, mut stamps) = (Vec::<RatioPanel>::new(), Vec::new());
    for group in groups {
        for (own, usual, ratio) in pairs(group) {
            let (asked, run) = (&own.technique, ran(own));
            let ms = |cell: &CellResult| cell.median_ms(RESOLVE).unwrap_or(0.0);
            let model = predicted(own, usual);
            let sort = match run.sort == asked.sort {
                true => asked.sort.clone(),
                false => format!("{} ({})", asked.sort, run.sort),
            };
            table.rows.push(vec![
                group.title().into(),
                asked.shader_stage.clone().into(),
                sort.into(),
                if asked.intervals == "optimal" { "optimal" } else { "given" }.into(),
                run.intervals.replace('-', ", ").into(),
                three_digits(ms(usual)).into(),
                three_digits(ms(own)).into(),
                format!("{:.3}", ratio.ratio).into(),
                format!("{:.3} to {:.3}", ratio.low, ratio.high).into(),
                model.map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.3}")).into(),
            ]);
            let mut row = vec![group.scene.to_owned(), group.view.to_owned()];
            row.extend([group.width_px, group.height_px].map(|px| px.to_string()));
            row.extend([&asked.capture, &asked.schedule, &asked.shader_stage].map(Clone::clone));
            row.extend([&asked.sort, &run.sort, &asked.ties].map(Clone::clone));
            row.extend([asked.intervals.clone(), run.intervals.clone()]);
            let numbers = [ms(usual), ms(own), ratio.ratio, ratio.low, ratio.high];
            row.extend(numbers.map(|value| format!("{value}")));
            row.push(ratio.word().to_owned());
            row.push(model.map(|ratio| format!("{ratio}")).unwrap_or_default());
            csv.rows.push(row);
            let title = format!("{}, {} stage", group.title(), asked.shader_stage);
            if panels.iter().all(|panel| panel.title != title) {
                panels.push(RatioPanel { title: title.clone(), bars: Vec::new() });
            }
            if let Some(panel) = panels.iter_mut().find(|panel| panel.title == title) {
                panel.bars.push(RatioBar {
                    label: format!("{}, {}", asked.sort, asked.intervals),
                    colour: sort_colour(&asked.sort),
                    ratio: ratio.ratio,
                    low: ratio.low,
                    high: ratio.high,
                    annotation: format!("{:.2}  {}", ratio.ratio, ratio.word()),
                });
            }
            stamps.push(Stamp::of(group.run));
        }
    }
    let conditions = groups.first()?.conditions();
    Some(Output {
        name: format!("bma-intervals-{}", slug(device)),
        title: "BMA 2013, section 3: other intervals than powers of two".to_owned(),
        subtitle: conditions,
        chart: Box::new(RatioBars {
            axis_title: "resolve time (with grouping) over that with powers of two, log scale"
                .to_owned(),
            sides: ("faster than powers of two".to_owned(), "slower".to_owned()),
            panels,
        }),
        tables: vec![table],
        csv,
        notes: vec![
            "The paper has an exhaustive optimum for a view gain of the order of 5 %, a ratio of 0.95. \
             Ours is exact for a cost model measured on the device, with pixels of one depth at a time; \
             the last column is what that model has for the ratio. Whiskers: 95 % bootstrap interval \
             of the ratio of medians."
                .to_owned(),
        ],
        stamps: stamps.into_iter().collect(),
    })
}
