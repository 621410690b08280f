//! Where the time goes in each layout: the median of each stage, and the total relative to the
//! linearized buffer.

use analysis::{CellResult, RESOLVE, Ratio, TOTAL, Tables, compare};

use super::Figure;
use super::layout_views::{LayoutView, REFERENCE, Resolve, views};
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{StageBar, StageBars, StagePanel, stage_place};
use crate::output::{Csv, Output, Stamp, Table, Value};

/// Stage times by layout.
pub(super) struct LfbLayouts;

impl Figure for LfbLayouts {
    fn name(&self) -> &'static str {
        "lfb-layouts"
    }

    fn source(&self) -> &'static str {
        "stage times of all layouts, after LFB 2012, Table 20.1"
    }

    fn needs(&self) -> &'static str {
        "a view with three layouts in two of base/insertion/fragment, base/passthrough/compute and \
         bma-list/network+rbs/compute"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        Ok(views(tables).iter().map(output).collect())
    }
}

/// The stages of some cells in the order they run, without sums and parts.
fn stages<'a>(cells: &[&'a CellResult]) -> Vec<&'a str> {
    let names = cells.iter().flat_map(|cell| cell.times.keys()).map(String::as_str);
    let whole = |stage: &&str| ![RESOLVE, TOTAL].contains(stage) && !stage.contains('[');
    let mut names: Vec<&str> = names.filter(whole).collect();
    names.sort_by_key(|stage| (stage_place(stage), *stage));
    names.dedup();
    names
}

fn output(view: &LayoutView) -> Output {
    let group = &view.group;
    let mut csv = Csv {
        columns: vec![
            "resolve",
            "layout",
            "stage",
            "n",
            "median_ns",
            "q1_ns",
            "q3_ns",
            "low_ns",
            "high_ns",
            "over_linearized",
            "over_low",
            "over_high",
            "verdict",
        ],
        rows: Vec::new(),
    };
    let (mut tables, mut panels) = (Vec::new(), Vec::new());
    for resolve in &view.resolves {
        let (table, panel) = block(resolve, &mut csv);
        tables.push(table);
        panels.push(panel);
    }
    Output {
        name: format!("lfb-layouts-{}-{}", group.slug(), group.device_slug()),
        title: format!("Time of each layout: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(StageBars(panels)),
        tables,
        csv,
        notes: vec![
            "Medians in ms, each panel on a scale of its own; beside a bar the median of the total \
             and its ratio to linearized. Resolve, and paler the grouping of pixels, in the colour \
             of the sort. Medians of stages need not add up to that of the total, which includes \
             what lies between the stages."
                .to_owned(),
            "Faster or slower than linearized where the whole 95 % bootstrap interval of the ratio \
             lies on one side of 1."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    }
}

fn block(resolve: &Resolve, csv: &mut Csv) -> (Table, StagePanel) {
    let mut cells = resolve.cells.clone();
    let total = |cell: &CellResult| cell.median_ms(TOTAL).unwrap_or(0.0);
    cells.sort_by(|a, b| total(a).total_cmp(&total(b)).then_with(|| a.name.cmp(&b.name)));
    let stages = stages(&cells);
    let least = cells.first().map_or(0.0, |cell| total(cell));
    let mut columns = vec!["layout".to_owned()];
    columns.extend(stages.iter().map(|stage| (*stage).to_owned()));
    columns.extend([TOTAL, "over linearized", "95 % interval", "verdict"].map(str::to_owned));
    let mut table = Table { heading: resolve.name.clone(), columns, rows: Vec::new() };
    let mut bars = Vec::new();
    for cell in cells {
        let layout = &cell.technique.capture;
        let over = |stage: &str| -> Option<Ratio> {
            let reference = resolve.reference().filter(|_| layout != REFERENCE)?;
            compare(cell, reference, stage).ok()
        };
        for stage in stages.iter().chain(&[TOTAL]) {
            let Some(timing) = cell.times.get(*stage) else { continue };
            let (s, over) = (timing.summary, over(stage));
            let mut row = vec![resolve.name.clone(), layout.clone(), (*stage).to_owned()];
            row.push(s.samples.to_string());
            row.extend([s.median, s.q1, s.q3, s.low, s.high].map(|ns| format!("{ns}")));
            let of =
                |of: fn(&Ratio) -> f64| over.as_ref().map_or(String::new(), |r| of(r).to_string());
            row.extend([of(|r| r.ratio), of(|r| r.low), of(|r| r.high)]);
            row.push(over.map_or(String::new(), |ratio| ratio.word().to_owned()));
            csv.rows.push(row);
        }
        let time = |stage: &str| cell.median_ms(stage).map_or("–".to_owned(), three_digits);
        let ratio = over(TOTAL);
        let text = |of: &dyn Fn(&Ratio) -> String| -> Value {
            ratio.as_ref().map_or("–".to_owned(), of).into()
        };
        let mut row = vec![layout.as_str().into()];
        row.extend(stages.iter().map(|stage| time(stage).into()));
        row.push(Value { text: time(TOTAL), marked: total(cell) <= least });
        row.push(text(&|ratio| format!("{:.3}", ratio.ratio)));
        row.push(text(&|ratio| format!("{:.3} to {:.3}", ratio.low, ratio.high)));
        row.push(text(&|ratio| ratio.word().to_owned()));
        table.rows.push(row);
        let beside = ratio.map_or(String::new(), |ratio| format!("  {:.2}×", ratio.ratio));
        bars.push(StageBar {
            label: layout.clone(),
            stages: stages
                .iter()
                .filter_map(|stage| Some(((*stage).to_owned(), cell.median_ms(stage)?)))
                .collect(),
            annotation: time(TOTAL) + &beside,
        });
    }
    let (title, sort) = (resolve.name.clone(), resolve.sort.to_owned());
    (table, StagePanel { title, sort, bars })
}
