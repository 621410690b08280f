//! What a local array of 256 entries costs that is filled and blended from, but not sorted: the side
//! remark of the layered fragment buffer chapter, section 20.5.

use analysis::{CellResult, RESOLVE, Ratio, Tables, compare};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::{Group, by_device, groups, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::layout_colour;

/// The array remark of the layered fragment buffer chapter.
pub(super) struct LfbArray;

/// The chapter's array.
const MAX: &str = "max256";

impl Figure for LfbArray {
    fn name(&self) -> &'static str {
        "lfb-array"
    }

    fn source(&self) -> &'static str {
        "LFB 2012, section 20.5: an array of 256 elements, not sorted"
    }

    fn needs(&self) -> &'static str {
        "a view with unsorted and passthrough, both max256, all else equal"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let devices = by_device(groups(tables, wanted));
        Ok(devices.iter().filter_map(|(device, groups)| output(device, groups)).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.max == MAX
        && technique.whole_pool()
        && technique.powers_of_two()
        && ["unsorted", "passthrough"].contains(&technique.sort.as_str())
}

/// The cells with an array, each beside the same without.
fn pairs<'a>(group: &Group<'a>) -> Vec<(&'a CellResult, &'a CellResult, Ratio)> {
    let cells = || group.cells.iter().copied().filter(|cell| wanted(cell));
    let mut pairs = Vec::new();
    for with in cells().filter(|cell| cell.technique.sort == "unsorted") {
        let same = |other: &&CellResult| {
            let (own, other) = (&with.technique, &other.technique);
            other.sort == "passthrough"
                && (&other.capture, &other.schedule, &other.shader_stage, &other.ties)
                    == (&own.capture, &own.schedule, &own.shader_stage, &own.ties)
        };
        for without in cells().filter(same) {
            // One of them may be wrong or skipped: then there is nothing to compare.
            if let Ok(ratio) = compare(with, without, RESOLVE) {
                pairs.push((with, without, ratio));
            }
        }
    }
    pairs
}

fn output(device: &str, groups: &[Group]) -> Option<Output> {
    let columns = vec![
        "scene",
        "view",
        "width_px",
        "height_px",
        "fragments",
        "covered_px",
        "layout",
        "schedule",
        "shader_stage",
        "without_ms",
        "with_ms",
        "ratio",
        "low",
        "high",
        "verdict",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "view",
        "fragments of\na covered pixel",
        "technique",
        "passthrough\nms",
        "unsorted\nms",
        "ratio",
        "95 % interval",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let (mut panels, mut stamps) = (Vec::new(), Vec::new());
    for group in groups {
        let name = group.name();
        let total = group.run.total_fragments(&name).unwrap_or(0);
        let histogram = group.run.histogram(&name).unwrap_or(&[]);
        let covered = histogram.iter().skip(1).fold(0_u64, |sum, &px| sum.saturating_add(px));
        let mut bars = Vec::new();
        for (with, without, ratio) in pairs(group) {
            let t = &with.technique;
            let technique = format!("{}, {}, {} stage", t.capture, t.schedule, t.shader_stage);
            let ms = |cell: &CellResult| cell.median_ms(RESOLVE).unwrap_or(0.0);
            table.rows.push(vec![
                group.title().into(),
                format!("{:.1}", total as f64 / covered.max(1) as f64).into(),
                technique.clone().into(),
                three_digits(ms(without)).into(),
                three_digits(ms(with)).into(),
                format!("{:.2}", ratio.ratio).into(),
                format!("{:.2} to {:.2}", ratio.low, ratio.high).into(),
            ]);
            let mut row = vec![group.scene.to_owned(), group.view.to_owned()];
            row.extend([group.width_px, group.height_px].map(|px| px.to_string()));
            row.extend([total, covered].map(|count| count.to_string()));
            row.extend([t.capture.clone(), t.schedule.clone(), t.shader_stage.clone()]);
            let numbers = [ms(without), ms(with), ratio.ratio, ratio.low, ratio.high];
            row.extend(numbers.map(|value| format!("{value}")));
            row.push(ratio.word().to_owned());
            csv.rows.push(row);
            bars.push(RatioBar {
                label: technique,
                colour: layout_colour(&t.capture),
                ratio: ratio.ratio,
                low: ratio.low,
                high: ratio.high,
                annotation: format!("{:.2}  {}", ratio.ratio, ratio.word()),
            });
        }
        if !bars.is_empty() {
            panels.push(RatioPanel { title: group.title(), bars });
            stamps.push(Stamp::of(group.run));
        }
    }
    let conditions = groups.first()?.conditions();
    if panels.is_empty() {
        return None;
    }
    Some(Output {
        name: format!("lfb-array-{}", slug(device)),
        title: "LFB 2012, section 20.5: what an array of 256 costs, not sorted".to_owned(),
        subtitle: conditions,
        chart: Box::new(RatioBars {
            axis_title: "resolve time with the array over that without, log scale".to_owned(),
            sides: ("faster with the array".to_owned(), "slower with it".to_owned()),
            panels,
        }),
        tables: vec![table],
        csv,
        notes: vec![
            "Both blend at most 256 fragments of a pixel without sorting them: unsorted from a local \
             array of 256 that it fills first, passthrough from memory. The chapter has 3 to 4 times \
             the time with the array, of elements of 16 bytes; ours have 8. Whiskers: 95 % bootstrap \
             interval of the ratio of medians."
                .to_owned(),
        ],
        stamps: stamps.into_iter().collect(),
    })
}
