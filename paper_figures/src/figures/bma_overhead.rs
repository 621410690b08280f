//! What an array of twice the size costs where no pixel needs it: section 4 of the backwards memory
//! allocation paper, on the views of its Table 2.

use std::collections::BTreeMap;

use analysis::{Ratio, TOTAL, Tables, compare};

use super::Figure;
use super::bma_views::{ALLOCATIONS, BmaView, OUR_SCENES, STAGES, VIEWS, charted, devices};
use crate::FigureError;
use crate::canvas::Colour;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::{Group, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::published::{self, Published};
use crate::style::SERIES;
use crate::technique_names::coordinates;

/// The overhead of an empty interval.
pub(super) struct BmaOverhead;

/// The techniques, with their heads in Table 2 and their colours.
const TECHNIQUES: [(&str, &str, Colour); 2] =
    [("OIT", "OIT (ms)", SERIES[1]), ("BMA-OIT", "BMA-OIT (ms)", SERIES[0])];

impl Figure for BmaOverhead {
    fn name(&self) -> &'static str {
        "bma-overhead"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, section 4: an additional interval without pixels"
    }

    fn needs(&self) -> &'static str {
        "OIT or BMA-OIT at both array sizes of BMA 2013, Table 2, on a view that needs the smaller only"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("bma-table-2")?;
        let mut named = Vec::new();
        for max in VIEWS.iter().filter_map(|view| view.allocation(&published, "larger")) {
            for (_, suffix) in STAGES {
                for (technique, ..) in TECHNIQUES {
                    named.extend(coordinates(&format!("{technique}{suffix} {max}")));
                }
            }
        }
        let devices = devices(tables, |cell| named.contains(&cell.name.technique));
        Ok(devices
            .iter()
            .filter_map(|(device, groups)| output(device, groups, &published))
            .collect())
    }
}

/// Whether no pixel is deeper than the smaller array.
fn fits(group: &Group, smaller: f64) -> bool {
    let deepest = group.run.histogram(&group.name()).and_then(|h| h.iter().rposition(|&px| px > 0));
    deepest.is_some_and(|deepest| deepest as f64 <= smaller)
}

/// The time with the larger array over that with the smaller.
fn own(
    group: &Group,
    view: &BmaView,
    published: &Published,
    (technique, suffix): (&str, &str),
) -> Option<Ratio> {
    let [smaller, larger] = ALLOCATIONS.map(|column| {
        let max = view.allocation(published, column)?;
        charted(group, &format!("{technique}{suffix} {max}"))
    });
    compare(larger?, smaller?, TOTAL).ok()
}

fn output(device: &str, groups: &BTreeMap<&str, Group>, published: &Published) -> Option<Output> {
    let columns = vec![
        "paper_view",
        "scene",
        "view",
        "technique",
        "of",
        "smaller",
        "larger",
        "ratio",
        "low",
        "high",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = ["view", "technique", "of", "time over that with the smaller", "95 % interval"];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let (mut panels, mut stamps, mut conditions) = (Vec::new(), Vec::new(), None);
    for view in &VIEWS {
        let Some(group) = groups.get(view.paper) else { continue };
        let max = |column: &str| published.value("Max Alloc", view.paper, column);
        let (Some(smaller), Some(larger)) = (max("smaller"), max("larger")) else { continue };
        // An interval that has pixels is no overhead, in the paper's times as in ours.
        let paper_fits = published.fact("Peak Depth", view.paper).is_some_and(|p| p <= smaller);
        if !(paper_fits && fits(group, smaller)) {
            continue;
        }
        let mut bars = Vec::new();
        for (technique, head, colour) in TECHNIQUES {
            let mut one = |of: &str, colour: Colour, [ratio, low, high]: [f64; 3]| {
                let interval = (low < high).then(|| format!("{low:.3} to {high:.3}"));
                table.rows.push(vec![
                    group.title().into(),
                    technique.into(),
                    of.into(),
                    format!("{ratio:.3}").into(),
                    interval.unwrap_or("–".to_owned()).into(),
                ]);
                let mut row = vec![view.paper, group.scene, group.view, technique, of];
                let sizes = [smaller, larger].map(|size| format!("{size}"));
                row.extend(sizes.iter().map(String::as_str));
                let mut row: Vec<String> = row.into_iter().map(str::to_owned).collect();
                row.extend([ratio, low, high].map(|value| format!("{value}")));
                csv.rows.push(row);
                let percent = 100.0 * (ratio - 1.0);
                let label = format!("{technique}, {of}");
                let annotation = format!("{ratio:.3}  ({percent:+.1} %)");
                bars.push(RatioBar { label, colour, ratio, low, high, annotation });
            };
            let paper = published
                .value(head, view.paper, "larger")
                .zip(published.value(head, view.paper, "smaller"));
            if let Some((larger, smaller)) = paper {
                one("published, GTX 670", colour.tint(0.6), [larger / smaller; 3]);
            }
            for (stage, suffix) in STAGES {
                if let Some(r) = own(group, view, published, (technique, suffix)) {
                    one(&format!("ours, {stage}"), colour, [r.ratio, r.low, r.high]);
                }
            }
        }
        if bars.iter().any(|bar| bar.label.contains("ours")) {
            let title = format!("{}: arrays up to {larger} over {smaller}", group.title());
            panels.push(RatioPanel { title, bars });
            stamps.push(Stamp::of(group.run));
            conditions.get_or_insert_with(|| group.conditions());
        }
    }
    Some(Output {
        name: format!("bma-overhead-{}", slug(device)),
        title: "BMA 2013, section 4: what an unneeded array size costs".to_owned(),
        subtitle: conditions?,
        chart: Box::new(RatioBars {
            axis_title: "time of the frame with the larger over that with the smaller, log scale"
                .to_owned(),
            sides: ("faster with the larger".to_owned(), "slower with it".to_owned()),
            panels,
        }),
        tables: vec![table],
        csv,
        notes: vec![
            "No pixel needs the larger array: for BMA-OIT it is one interval more, which is empty. \
             The paper says: “supporting an additional Max Alloc interval (in which no pixels exist \
             so no computation is performed) adds an overhead of 0.5% and 0.1% for the Atrium and \
             Smoke scenes respectively. In contrast, standard OIT rendering increases by 151% and \
             176% for the additional and unnecessary increase.” Its Table 2, from which the bars of \
             published numbers are, gives +0.5 % and +0.2 % for BMA-OIT, and +43 % and +63 % for OIT."
                .to_owned(),
            format!("Whiskers: 95 % bootstrap interval of the ratio of medians. {OUR_SCENES}"),
        ],
        stamps: stamps.into_iter().collect(),
    })
}
