//! How much work a frame is and how fast it is done: invocations, primitives, bytes written, and what
//! share of the device's measured bandwidth these are. Figure 2.1 of the biomolecular visualisation
//! thesis as far as pipeline statistics and plans tell it.

use analysis::{CellResult, TOTAL, Tables, WorkSum};

use super::Figure;
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::{ShareBar, ShareBars, SharePanel};
use crate::data::{Group, groups};
use crate::mechanism::{or_dash, or_empty};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::SERIES;

/// Work and speed of light.
pub(super) struct Work;

impl Figure for Work {
    fn name(&self) -> &'static str {
        "work"
    }

    fn source(&self) -> &'static str {
        "Biomolecular visualisation 2018, Figure 2.1 (speed of light)"
    }

    fn needs(&self) -> &'static str {
        "a view with techniques whose work was counted by a device"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        Ok(groups(tables, is_counted).iter().map(output).collect())
    }
}

/// Whether the device counted something of a cell.
fn is_counted(cell: &CellResult) -> bool {
    cell.work.iter().any(|pass| pass.counted.is_some())
}

/// A stage of a technique, or all of it.
struct Row<'a> {
    technique: &'a str,
    stage: &'a str,
    /// The median.
    ns: f64,
    sum: WorkSum,
}

impl Row<'_> {
    /// Bytes written to attachments a second, at most.
    fn bytes_per_s(&self) -> Option<f64> {
        let bytes = self.sum.attachment_bytes_at_most? as f64;
        (self.ns > 0.0).then(|| bytes / (self.ns / 1e9))
    }

    /// Of the most that the device's memory was measured to move.
    fn share(&self, group: &Group) -> Option<f64> {
        let best = group.run.bandwidth.as_ref()?.best_bytes_per_s();
        (best > 0.0).then_some(self.bytes_per_s()? / best)
    }

    /// Of what drawing was measured to write to attachments: the raster units may let through a
    /// small part of what the memory takes.
    fn attachment_share(&self, group: &Group) -> Option<f64> {
        let best = group.run.bandwidth.as_ref()?.attachment?.bytes_per_s;
        (best > 0.0).then_some(self.bytes_per_s()? / best)
    }

    fn ns_per_fragment(&self) -> Option<f64> {
        let fragments = self.sum.fragment_invocations.filter(|&fragments| fragments > 0)?;
        Some(self.ns / fragments as f64)
    }

    /// Runs of the stages before the rasteriser, of the fragment stage and of compute shaders: what is
    /// not known is left out.
    fn invocations(&self) -> [u64; 3] {
        let sum = &self.sum;
        [sum.vertex_invocations, sum.fragment_invocations, sum.compute_invocations]
            .map(Option::unwrap_or_default)
    }
}

/// The stages of a cell that were timed, then the whole.
fn rows(cell: &CellResult) -> Vec<Row<'_>> {
    let technique = cell.name.technique.as_str();
    let row = |stage, sum| {
        let ns = cell.times.get(stage)?.summary.median;
        Some(Row { technique, stage, ns, sum })
    };
    let stages = WorkSum::by_stage(&cell.work).into_iter();
    let mut rows: Vec<Row> = stages.filter_map(|(stage, sum)| row(stage, sum)).collect();
    rows.extend(row(TOTAL, WorkSum::of(&cell.work)));
    rows
}

/// A number that may not be known.
fn or(known: Option<f64>, text: impl Fn(f64) -> String, unknown: &str) -> String {
    known.map_or(unknown.to_owned(), text)
}

fn output(group: &Group) -> Output {
    let pixels = (u64::from(group.width_px) * u64::from(group.height_px)) as f64;
    let counted = group.cells.iter().copied().filter(|cell| is_counted(cell));
    let all: Vec<Row> = counted.flat_map(rows).collect();
    let totals: Vec<&Row> = all.iter().filter(|row| row.stage == TOTAL).collect();

    let mut csv = Csv {
        columns: vec![
            "technique",
            "stage",
            "median_ns",
            "vertex_invocations",
            "primitives",
            "fragment_invocations",
            "fragment_invocations_per_px",
            "compute_invocations",
            "attachment_bytes_at_most",
            "cleared_bytes",
            "attachment_bytes_per_s",
            "share_of_bandwidth",
            "share_of_attachment_bandwidth",
            "ns_per_fragment",
        ],
        rows: Vec::new(),
    };
    for row in &all {
        let sum = &row.sum;
        let per_px = sum.fragment_invocations.map(|fragments| fragments as f64 / pixels);
        let plain = |known| or(known, |value| format!("{value}"), "");
        csv.rows.push(vec![
            row.technique.to_owned(),
            row.stage.to_owned(),
            format!("{}", row.ns),
            or_empty(sum.vertex_invocations),
            or_empty(sum.primitives),
            or_empty(sum.fragment_invocations),
            plain(per_px),
            or_empty(sum.compute_invocations),
            or_empty(sum.attachment_bytes_at_most),
            sum.cleared_bytes.to_string(),
            plain(row.bytes_per_s()),
            plain(row.share(group)),
            plain(row.attachment_share(group)),
            plain(row.ns_per_fragment()),
        ]);
    }

    Output {
        name: format!("work-{}-{}", group.slug(), group.device_slug()),
        title: format!("Work and its speed: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(chart(group, &shown(&totals))),
        tables: vec![table(group, &all, pixels)],
        csv,
        notes: notes(group, totals.len()),
        stamps: [Stamp::of(group.run)].into(),
    }
}

/// The picture has room for so many techniques: the first, which others are compared with, and the fastest.
const MOST_BARS: usize = 30;

/// What the picture shows, in the order of the table.
fn shown<'a, 'b>(totals: &[&'a Row<'b>]) -> Vec<&'a Row<'b>> {
    let mut places: Vec<usize> = (0..totals.len()).collect();
    places.sort_by(|&a, &b| totals[a].ns.total_cmp(&totals[b].ns));
    let fastest = places.into_iter().filter(|&place| place > 0).take(MOST_BARS - 1);
    let mut shown: Vec<usize> = fastest.chain((!totals.is_empty()).then_some(0)).collect();
    shown.sort_unstable();
    shown.into_iter().map(|place| totals[place]).collect()
}

fn chart(group: &Group, totals: &[&Row]) -> ShareBars {
    let mut panels = Vec::new();
    // What all names begin with says nothing.
    let prefix = match totals.iter().all(|row| row.technique.starts_with("spheres/")) {
        true => "spheres/",
        false => "",
    };
    let label = |row: &Row| row.technique.trim_start_matches(prefix).to_owned();
    let written =
        |share: Option<f64>| or(share, |share| format!("{} %", three_digits(100.0 * share)), "–");
    if let Some(told) = group.run.bandwidth {
        let of_attachments = told.attachment.is_some();
        let bars = totals.iter().map(|row| {
            let memory = row.share(group);
            let (share, annotation) = match of_attachments {
                true => {
                    let share = row.attachment_share(group);
                    (share, format!("{}, of memory's {}", written(share), written(memory)))
                }
                false => (memory, written(memory)),
            };
            ShareBar { label: label(row), shares: vec![share.unwrap_or_default()], annotation }
        });
        let of = if of_attachments { "attachments'" } else { "memory's" };
        panels.push(SharePanel {
            title: format!("Bytes written to attachments, of the {of} bandwidth measured"),
            parts: vec![("share, at most".to_owned(), SERIES[2])],
            bars: bars.collect(),
        });
    }
    let bars = totals.iter().map(|row| {
        let invocations = row.invocations();
        let all = invocations.iter().fold(0_u64, |all, &some| all.saturating_add(some)).max(1);
        let unknown = row.sum.compute_invocations.is_none();
        ShareBar {
            label: label(row),
            shares: invocations.map(|some| some as f64 / all as f64).to_vec(),
            annotation: format!(
                "{:.2} million{}",
                all as f64 / 1e6,
                if unknown { " and indirect" } else { "" }
            ),
        }
    });
    let parts = ["before the rasteriser", "fragment", "compute"].into_iter().zip(SERIES);
    panels.push(SharePanel {
        title: "Invocations by kind of stage".to_owned(),
        parts: parts.map(|(part, colour)| (part.to_owned(), *colour)).collect(),
        bars: bars.collect(),
    });
    ShareBars(panels)
}

fn table(group: &Group, all: &[Row], pixels: f64) -> Table {
    let row = |row: &Row| -> Vec<Value> {
        let sum = &row.sum;
        let per_px = sum.fragment_invocations.map(|fragments| fragments as f64 / pixels);
        let written = sum.attachment_bytes_at_most.map(|bytes| bytes as f64 / 1e6);
        let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
        let short = |known| or(known, three_digits, "–");
        vec![
            row.technique.into(),
            row.stage.into(),
            three_digits(row.ns / 1e6).into(),
            or_dash(sum.vertex_invocations).into(),
            or_dash(sum.primitives).into(),
            or_dash(sum.fragment_invocations).into(),
            short(per_px).into(),
            or_dash(sum.compute_invocations).into(),
            short(written).into(),
            short(row.bytes_per_s().map(|bytes| bytes / 1e9)).into(),
            short(percent(row.share(group))).into(),
            short(percent(row.attachment_share(group))).into(),
            short(row.ns_per_fragment()).into(),
        ]
    };
    let columns = [
        "technique",
        "stage",
        "ms",
        "vertex invocations",
        "primitives",
        "fragment invocations",
        "per pixel",
        "compute invocations",
        "MB written at most",
        "GB/s",
        "% of bandwidth",
        "% of attachments'",
        "ns per fragment",
    ];
    Table {
        heading: String::new(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: all.iter().map(row).collect(),
    }
}

fn notes(group: &Group, techniques: usize) -> Vec<String> {
    let measured = group.run.bandwidth.map(|told| {
        let gb = |bytes_per_s: f64| number((bytes_per_s / 1e8).round() / 10.0);
        let attachment = told.attachment.map_or("not measured".to_owned(), |attachment| {
            format!("{} GB/s at {} bytes a pixel", gb(attachment.bytes_per_s), attachment.bytes_per_px)
        });
        format!(
            "Measured in the same run: {} GB/s copied in compute (read and written), {} GB/s filled, \
             attachments {attachment}. The bandwidth of memory is the most of these.",
            gb(told.copy_bytes_per_s),
            gb(told.fill_bytes_per_s),
        )
    });
    let counts = "Invocations and primitives are the device's own pipeline statistics, of a run that is \
                  not timed; those before the rasteriser include tessellation and geometry. Devices \
                  count them by rules of their own (Mesa 22.3's llvmpipe counts more fragments than \
                  there are). Times are medians; nanoseconds per fragment are the stage's time over its \
                  fragment invocations."
        .to_owned();
    let bytes = "Bytes written are at most: every fragment invocation writes all the attachments that its \
                 pass writes. Clears, what blending and tests read, and what shaders write to buffers \
                 (a captured fragment) are not among them, nor is a resolve in CUDA. Caches may join \
                 writes, and fragments that are discarded or fail their test write nothing, so a share \
                 can be above 100 %."
        .to_owned();
    let left_out = (techniques > MOST_BARS).then(|| {
        format!("{techniques} techniques; the picture shows the first and the fastest of the others, the table all.")
    });
    measured.into_iter().chain([counts, bytes]).chain(left_out).collect()
}
