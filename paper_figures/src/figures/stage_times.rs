//! Where the time goes: the median of each stage, technique by technique.

use analysis::{CellResult, RESOLVE, TOTAL, Tables};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{StageBar, StageBars, stage_place};
use crate::data::{Group, groups};
use crate::output::{Csv, Output, Stamp, Table};
use crate::technique_names::label;

/// Stacked stage times.
pub(super) struct StageTimes;

impl Figure for StageTimes {
    fn name(&self) -> &'static str {
        "stage-times"
    }

    fn source(&self) -> &'static str {
        "time of each stage, after LFB 2012, Table 20.1"
    }

    fn needs(&self) -> &'static str {
        "a view with a charted technique"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let groups = groups(tables, wanted);
        Ok(groups.iter().map(output).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    !cell.technique.truncated() && ["100", ""].contains(&cell.technique.pool_percent.as_str())
}

fn output(group: &Group) -> Output {
    let mut cells: Vec<&CellResult> =
        group.cells.iter().copied().filter(|cell| wanted(cell) && !cell.times.is_empty()).collect();
    let total = |cell: &CellResult| cell.median_ms(TOTAL).unwrap_or(0.0);
    cells.sort_by(|a, b| total(a).total_cmp(&total(b)).then_with(|| a.name.cmp(&b.name)));
    let mut csv = Csv {
        columns: vec![
            "technique",
            "stage",
            "n",
            "median_ns",
            "q1_ns",
            "q3_ns",
            "low_ns",
            "high_ns",
        ],
        rows: Vec::new(),
    };
    let mut names: Vec<&str> = cells
        .iter()
        .flat_map(|cell| cell.times.keys())
        .map(String::as_str)
        .filter(|stage| ![RESOLVE, TOTAL].contains(stage))
        .collect();
    names.sort_by_key(|stage| (stage_place(stage), *stage));
    names.dedup();
    let columns = ["technique"].iter().chain(&names).chain(&[TOTAL]);
    let columns = columns.map(|&name| name.to_owned()).collect();
    let mut table = Table { columns, ..Table::default() };
    let mut bars = Vec::new();
    for cell in cells {
        let median = |stage: &str| cell.median_ms(stage);
        let mut row = vec![label(&cell.name.technique).into()];
        for stage in names.iter().chain(&[TOTAL]) {
            row.push(median(stage).map_or("–".to_owned(), three_digits).into());
            let Some(timing) = cell.times.get(*stage) else { continue };
            let s = timing.summary;
            let mut line = vec![cell.name.technique.clone(), (*stage).to_owned()];
            line.push(s.samples.to_string());
            line.extend([s.median, s.q1, s.q3, s.low, s.high].map(|ns| format!("{ns}")));
            csv.rows.push(line);
        }
        table.rows.push(row);
        let stages =
            names.iter().filter_map(|stage| Some(((*stage).to_owned(), median(stage)?))).collect();
        bars.push(StageBar {
            label: label(&cell.name.technique),
            sort: cell.technique.sort.clone(),
            stages,
            total_ms: total(cell),
        });
    }
    Output {
        name: format!("stage-times-{}-{}", group.slug(), group.device_slug()),
        title: format!("Where the time goes: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(StageBars(bars)),
        tables: vec![table],
        csv,
        notes: vec![
            "Milliseconds. Resolve, and paler the grouping of pixels, in the colour of the sort. \
             Medians of stages need not add up to the median of the total, which is written beside \
             the bar and includes what lies between the stages."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    }
}
