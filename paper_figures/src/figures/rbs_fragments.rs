//! Fragments of 128 bits, sorted whole and by index, beside those of 64 bits: the side remark of the
//! register-based block sort paper, section 3.

use analysis::{CellResult, RESOLVE, Ratio, Tables, compare};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::{Group, by_device, groups_with, slug};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::SERIES;

/// The fragment size remark of the register-based block sort paper.
pub(super) struct RbsFragments;

/// What is compared with: fragments of 64 bits.
const NARROW: &str = "linked_list";
/// The others: their capture, and what is sorted of a fragment.
const WIDE: [(&str, &str); 2] =
    [("linked_list128", "128 bits, whole"), ("linked_list128_indirect", "128 bits, by index")];
/// The stage that captures.
const CAPTURE: &str = "capture";

impl Figure for RbsFragments {
    fn name(&self) -> &'static str {
        "rbs-fragments"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, section 3: fragments of 64 bits, and indirect sorting of larger ones"
    }

    fn needs(&self) -> &'static str {
        "a view with linked_list beside linked_list128 or linked_list128_indirect, all else equal"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let devices = by_device(groups_with(tables, wanted, |group| !rows(group).is_empty()));
        Ok(devices.iter().filter_map(|(device, groups)| output(device, groups)).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.whole_pool()
        && technique.powers_of_two()
        && (technique.capture == NARROW || WIDE.iter().any(|(name, _)| *name == technique.capture))
}

/// A technique with fragments of 64 bits, and the same with others, in the order of [`WIDE`].
struct Row<'a> {
    narrow: &'a CellResult,
    wide: [Option<(&'a CellResult, Ratio)>; 2],
}

fn rows<'a>(group: &Group<'a>) -> Vec<Row<'a>> {
    let cells = || group.cells.iter().copied().filter(|cell| wanted(cell));
    let mut rows = Vec::new();
    for narrow in cells().filter(|cell| cell.technique.capture == NARROW) {
        let of = |capture: &str| {
            let same = |other: &&CellResult| {
                let (own, other) = (&narrow.technique, &other.technique);
                other.capture == capture
                    && (&other.schedule, &other.sort, &other.shader_stage, &other.max, &other.ties)
                        == (&own.schedule, &own.sort, &own.shader_stage, &own.max, &own.ties)
            };
            // One of them may be wrong or skipped: then there is nothing to compare.
            let wide = cells().find(same)?;
            Some((wide, compare(wide, narrow, RESOLVE).ok()?))
        };
        let wide = WIDE.map(|(capture, _)| of(capture));
        if wide.iter().any(Option::is_some) {
            rows.push(Row { narrow, wide });
        }
    }
    rows
}

fn output(device: &str, groups: &[Group]) -> Option<Output> {
    let columns = vec![
        "scene",
        "view",
        "width_px",
        "height_px",
        "sort",
        "schedule",
        "shader_stage",
        "ties",
        "sorted",
        "capture_ms",
        "resolve_ms",
        "resolve_over_64_bits",
        "low",
        "high",
        "verdict",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "view",
        "technique",
        "64 bits\nresolve, ms",
        "128, whole\nresolve, ms",
        "128, by index\nresolve, ms",
        "by index\nover whole",
        "64 bits\ncapture, ms",
        "128 bits\ncapture, ms",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let (mut panels, mut stamps) = (Vec::new(), Vec::new());
    for group in groups {
        let mut bars = Vec::new();
        for Row { narrow, wide } in rows(group) {
            let t = &narrow.technique;
            let technique = format!("{}, {}, {} stage", t.sort, t.schedule, t.shader_stage);
            let ms = |cell: Option<&CellResult>, stage: &str| -> Value {
                let ms = cell.and_then(|cell| cell.median_ms(stage));
                ms.map_or_else(|| "–".to_owned(), three_digits).into()
            };
            let [whole, index] = [&wide[0], &wide[1]].map(|w| w.as_ref().map(|(cell, _)| *cell));
            let between = index.zip(whole).and_then(|(i, w)| compare(i, w, RESOLVE).ok());
            let between = between
                .map(|r| format!("{:.2} ({:.2} to {:.2})", r.ratio, r.low, r.high))
                .unwrap_or_else(|| "–".to_owned());
            table.rows.push(vec![
                group.title().into(),
                technique.clone().into(),
                ms(Some(narrow), RESOLVE),
                ms(whole, RESOLVE),
                ms(index, RESOLVE),
                between.into(),
                ms(Some(narrow), CAPTURE),
                ms(whole.or(index), CAPTURE),
            ]);
            let mut row = |cell: &CellResult, sorted: &str, ratio: Option<&Ratio>| {
                let mut row = vec![group.scene.to_owned(), group.view.to_owned()];
                row.extend([group.width_px, group.height_px].map(|px| px.to_string()));
                let words = [&t.sort, &t.schedule, &t.shader_stage, &t.ties];
                row.extend(words.map(Clone::clone));
                row.push(sorted.to_owned());
                let times = [CAPTURE, RESOLVE].map(|stage| cell.median_ms(stage));
                row.extend(times.map(|ms| ms.map(|ms| format!("{ms}")).unwrap_or_default()));
                let numbers = ratio.map(|r| [r.ratio, r.low, r.high].map(|n| format!("{n}")));
                row.extend(numbers.unwrap_or_default());
                row.push(ratio.map(|r| r.word().to_owned()).unwrap_or_default());
                csv.rows.push(row);
            };
            row(narrow, "64 bits", None);
            for ((found, (_, sorted)), colour) in wide.iter().zip(WIDE).zip(SERIES) {
                let Some((cell, ratio)) = found else { continue };
                row(cell, sorted, Some(ratio));
                bars.push(RatioBar {
                    label: format!("{technique}: {sorted}"),
                    colour: *colour,
                    ratio: ratio.ratio,
                    low: ratio.low,
                    high: ratio.high,
                    annotation: format!("{:.2}  {}", ratio.ratio, ratio.word()),
                });
            }
        }
        panels.push(RatioPanel { title: group.title(), bars });
        stamps.push(Stamp::of(group.run));
    }
    Some(Output {
        name: format!("rbs-fragments-{}", slug(device)),
        title: "RBS 2014, section 3: fragments of 128 bits, sorted whole and by index".to_owned(),
        subtitle: groups.first()?.conditions(),
        chart: Box::new(RatioBars {
            axis_title: "resolve time over that with fragments of 64 bits, log scale".to_owned(),
            sides: ("faster than with 64 bits".to_owned(), "slower".to_owned()),
            panels,
        }),
        tables: vec![table],
        csv,
        notes: vec![
            "A fragment of 64 bits is a depth and a colour of 8 bits a channel; one of 128 bits a depth, \
             and a colour and an opacity for each channel in halves. Sorted whole, all 128 bits are \
             moved; by index, the depth and where the fragment lies, and the rest is fetched when it is \
             blended. Both read the same captured fragments. The paper packs into 64 bits and calls \
             indirect sorting of larger fragments likely to be more efficient. Whiskers: 95 % bootstrap \
             interval of the ratio of medians."
                .to_owned(),
        ],
        stamps: stamps.into_iter().collect(),
    })
}
