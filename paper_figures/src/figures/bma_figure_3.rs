//! Figure 3 of the backwards memory allocation paper: the time of a full-screen pass against the size
//! of an array that its program declares, in entries of four floats. One line a stage and store.

use std::collections::BTreeMap;

use analysis::{CellResult, TOTAL, Tables};

use super::Figure;
use crate::FigureError;
use crate::canvas::Colour;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::SERIES;

/// Figure 3 of the backwards memory allocation paper.
pub(super) struct BmaFigure3;

/// The two forms of the probe, by the first word of its coordinate, as panels are headed.
const FORMS: [(&str, &str); 2] = [
    ("array-probe", "Four entries written, one read"),
    ("array-probe-unset", "The paper's shader: none written, one read"),
];

/// Store and stage of each line, as in the coordinate, with its name.
const LINES: [(&str, &str, &str); 3] = [
    ("local", "fragment", "local, fragment"),
    ("local", "compute", "local, compute"),
    ("workgroup", "compute", "workgroup, compute"),
];

/// Sizes of the table, as far as they were run.
const SHOWN: [u32; 9] = [1, 8, 16, 24, 32, 64, 128, 192, 256];

impl Figure for BmaFigure3 {
    fn name(&self) -> &'static str {
        "bma-figure-3"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 3"
    }

    fn needs(&self) -> &'static str {
        "run of the array probe (`oit probe array`) with two sizes or more of a line"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let groups = groups(tables, |cell| size(cell).is_some());
        Ok(groups.iter().filter_map(output).collect())
    }
}

/// Form, store, stage and size of a probe's coordinate.
fn parts(coordinate: &str) -> Option<(&str, &str, &str, u32)> {
    let mut parts = coordinate.split('/');
    let mut next = || parts.next();
    let (form, store, stage, size) = (next()?, next()?, next()?, next()?);
    let size = size.strip_prefix("size")?.parse().ok().filter(|&size| size > 0)?;
    let known = FORMS.iter().any(|(known, _)| *known == form) && next().is_none();
    known.then_some((form, store, stage, size))
}

/// The size of a cell's array, if it is a probe.
fn size(cell: &CellResult) -> Option<u32> {
    parts(&cell.name.technique).map(|(_, _, _, size)| size)
}

/// The charted cells of a line by size, if there is one of size 1 to compare with and another.
fn line<'a>(
    group: &Group<'a>,
    form: &str,
    (store, stage): (&str, &str),
) -> Option<BTreeMap<u32, &'a CellResult>> {
    let of_line = |cell: &&CellResult| match parts(&cell.name.technique) {
        Some((f, s, t, _)) => (f, s, t) == (form, store, stage),
        None => false,
    };
    let has_time = |cell: &&CellResult| cell.median_ms(TOTAL).is_some_and(|ms| ms > 0.0);
    let cells = group.cells.iter().copied().filter(of_line).filter(has_time);
    let cells: BTreeMap<u32, &CellResult> =
        cells.filter_map(|cell| Some((size(cell)?, cell))).collect();
    (cells.len() > 1 && cells.contains_key(&1)).then_some(cells)
}

fn output(group: &Group) -> Option<Output> {
    let columns = vec![
        "form",
        "store",
        "shader_stage",
        "entries",
        "n",
        "median_ns",
        "low_ns",
        "high_ns",
        "over_size_1",
        "verdict",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut forms) = (Vec::new(), Vec::new());
    for (form, heading) in FORMS {
        let mut lines = Vec::new();
        let heads = SHOWN.iter().map(|size| format!("{size}"));
        let columns = ["store, stage".to_owned(), "size 1\nms".to_owned()];
        let columns = columns.into_iter().chain(heads).collect();
        let mut table = Table { heading: heading.to_owned(), columns, ..Table::default() };
        for (place, (store, stage, label)) in LINES.into_iter().enumerate() {
            let Some(cells) = line(group, form, (store, stage)) else { continue };
            let one = cells[&1].times[TOTAL].summary.median;
            lines.push(drawn(label, SERIES[place], &cells, one));
            let mut row = vec![label.into(), format!("{:.3}", one / 1e6).into()];
            for size in SHOWN {
                let cell = cells.get(&size);
                let over = cell.map(|cell| cell.times[TOTAL].summary.median / one);
                row.push(over.map_or("–".to_owned(), |over| format!("{over:.2}")).into());
            }
            table.rows.push(row);
            for (size, cell) in &cells {
                let s = cell.times[TOTAL].summary;
                let verdict = cell.verification.as_ref().map(|v| format!("{:?}", v.verdict));
                let mut row = [form, store, stage].map(str::to_owned).to_vec();
                row.extend([size.to_string(), s.samples.to_string()]);
                row.extend([s.median, s.low, s.high, s.median / one].map(|v| format!("{v}")));
                row.push(verdict.unwrap_or_default().to_lowercase());
                csv.rows.push(row);
            }
        }
        if !lines.is_empty() {
            tables.push(table);
            forms.push((heading, lines));
        }
    }
    if forms.is_empty() {
        return None;
    }
    // All panels on the same scales.
    let points = || forms.iter().flat_map(|(_, lines)| lines).flat_map(|line| &line.points);
    let title = "entries of the array, 16 bytes each";
    let x = Scale::from_zero(title, points().map(|point| point.x));
    let y = Scale::from_zero("time over that of one entry", points().map(|point| point.y[2]));
    let panels = forms.iter().map(|(title, lines)| LinePanel {
        title: (*title).to_owned(),
        x: x.clone(),
        y: y.clone(),
        across: Some(1.0),
        lines: lines.clone(),
    });
    Some(Output {
        name: format!("bma-figure-3-{}", group.device_slug()),
        title: "BMA 2013, Figure 3: time of a full-screen pass against the size of an array".into(),
        subtitle: group.conditions(),
        chart: Box::new(Lines(panels.collect())),
        tables,
        csv,
        notes: vec![
            "Medians of the pass with 95 % bootstrap intervals, over the median of the same with one \
             entry. The pass covers the frame as often as the probe repeats it. Work is the same for \
             every size: what is written and read are the same few entries. Workgroup memory has room \
             for 32 entries of each of 64 invocations. Entries that were never written may hold \
             anything, and a compiler may drop their array: that form's picture is not compared."
                .to_owned(),
        ],
        stamps: std::iter::once(Stamp::of(group.run)).collect(),
    })
}

fn drawn(label: &str, colour: Colour, cells: &BTreeMap<u32, &CellResult>, one: f64) -> Line {
    let points = cells.iter().map(|(size, cell)| {
        let s = cell.times[TOTAL].summary;
        let y = [s.median, s.low, s.high].map(|ns| ns / one);
        LinePoint { x: f64::from(*size), y, hollow: false }
    });
    Line { label: label.to_owned(), colour, points: points.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coordinate_says_form_store_stage_and_size() {
        let local = Some(("array-probe", "local", "fragment", 8));
        assert_eq!(parts("array-probe/local/fragment/size8"), local);
        let unset = Some(("array-probe-unset", "workgroup", "compute", 32));
        assert_eq!(parts("array-probe-unset/workgroup/compute/size32"), unset);
        for other in [
            "linked_list/base/insertion/fragment/peak",
            "array-probe/local/fragment/size0",
            "array-probe/local/fragment/8",
            "array-probe/local/fragment/size8/more",
            "array-probe/local/fragment",
        ] {
            assert_eq!(parts(other), None, "{other}");
        }
    }
}
