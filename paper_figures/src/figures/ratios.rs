//! What the comparisons of sorts share: cells that differ in their sort only, and the chart of
//! their ratios.

use std::collections::BTreeMap;

use analysis::{CellResult, Ratio, Technique};

use crate::axis::three_digits;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::Group;
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::sort_colour;

/// Charted cells of a group by all that is no sort, and then by sort. Arrays hold the peak.
pub(super) fn families<'a>(
    group: &Group<'a>,
) -> BTreeMap<String, BTreeMap<&'a str, &'a CellResult>> {
    let mut families: BTreeMap<String, BTreeMap<&str, &CellResult>> = BTreeMap::new();
    for cell in group.cells.iter().copied().filter(|cell| wanted(cell) && !cell.times.is_empty()) {
        let technique = &cell.technique;
        families.entry(family_name(technique)).or_default().insert(&technique.sort, cell);
    }
    families
}

/// All of a technique that is no sort, in words.
pub(super) fn family_name(technique: &Technique) -> String {
    let Technique { capture, schedule, shader_stage, ties, .. } = technique;
    format!("{capture}, {schedule}, {shader_stage} stage, {ties} order")
}

/// Cells that comparisons of sorts are about.
pub(super) fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.max == "peak"
        && technique.whole_pool()
        && technique.powers_of_two()
        && !technique.sort.is_empty()
}

/// A ratio: the family, the first sort and the second, and how they compare.
pub(super) struct Compared<'a> {
    /// What the two have in common.
    pub(super) family: String,
    /// The sort whose time is above the line.
    pub(super) sort: &'a str,
    /// The sort it is compared with.
    pub(super) with: &'a str,
    /// The ratio of their times.
    pub(super) ratio: Ratio,
}

/// A chart of ratios with its tables. `named` is the sort that labels and colours a bar.
pub(super) fn output<'a>(
    group: &Group,
    (name, title): (String, String),
    (axis_title, sides): (String, (String, String)),
    compared: &[Compared<'a>],
    named: impl Fn(&Compared<'a>) -> &'a str,
) -> Output {
    let mut csv = Csv {
        columns: vec!["family", "sort", "compared_with", "ratio", "low", "high", "verdict"],
        rows: Vec::new(),
    };
    let columns = ["technique", "sort", "compared with", "ratio", "95 % interval", "verdict"];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let mut panels: Vec<RatioPanel> = Vec::new();
    for one in compared {
        let Ratio { ratio, low, high, .. } = one.ratio;
        let word = one.ratio.word();
        csv.rows.push(vec![
            one.family.clone(),
            one.sort.to_owned(),
            one.with.to_owned(),
            format!("{ratio}"),
            format!("{low}"),
            format!("{high}"),
            word.to_owned(),
        ]);
        let interval = format!("{low:.3} to {high:.3}");
        table.rows.push(vec![
            one.family.clone().into(),
            one.sort.into(),
            one.with.into(),
            format!("{ratio:.3}").into(),
            interval.into(),
            word.into(),
        ]);
        if panels.last().is_none_or(|panel| panel.title != one.family) {
            panels.push(RatioPanel { title: one.family.clone(), bars: Vec::new() });
        }
        if let Some(panel) = panels.last_mut() {
            panel.bars.push(RatioBar {
                label: named(one).to_owned(),
                colour: sort_colour(named(one)),
                ratio,
                low,
                high,
                annotation: format!("{}  {word}", three_digits(ratio)),
            });
        }
    }
    Output {
        name,
        title,
        subtitle: group.conditions(),
        chart: Box::new(RatioBars { axis_title, sides, panels }),
        tables: vec![table],
        csv,
        notes: vec![
            "Whiskers: 95 % bootstrap interval of the ratio of medians. Faster or slower where the \
             whole interval lies on one side of 1, else same. passthrough blends unsorted: it is \
             the floor, not a competitor."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    }
}
