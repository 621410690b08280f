//! What each layout takes of memory, as recorded, and what it would take with fragments of 16 bytes
//! as in the layered fragment buffer chapter.

use analysis::{CellResult, Tables};
use oit_record::Verification;

use super::Figure;
use super::layout_views::{LayoutView, REFERENCE, Resolve, views};
use crate::FigureError;
use crate::chart::TableImage;
use crate::data::slug;
use crate::output::{Csv, Output, Stamp, Table, Value};

/// Memory by layout.
pub(super) struct LfbMemory;

/// What a fragment of the chapter has more than one of ours.
const MORE_BYTES: u64 = 8;

/// The buffer that a resolve reads if fragments had 16 bytes: derived, not measured.
pub(crate) fn lfb_bytes_at_16(verification: &Verification) -> Option<u64> {
    let more = verification.pool_final.checked_mul(MORE_BYTES)?;
    verification.lfb_bytes?.checked_add(more)
}

impl Figure for LfbMemory {
    fn name(&self) -> &'static str {
        "lfb-memory"
    }

    fn source(&self) -> &'static str {
        "memory of all layouts, after LFB 2012, section 20.5"
    }

    fn needs(&self) -> &'static str {
        "a view as lfb-layouts needs it, with three layouts that say how large their buffer is"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs: Vec<Output> = Vec::new();
        let views = views(tables);
        let mut rest = views.as_slice();
        // Views come sorted by device.
        while let Some(first) = rest.first() {
            let device = first.group.run.device();
            let same = rest.iter().take_while(|view| view.group.run.device() == device).count();
            outputs.extend(output(&device, &rest[..same]));
            rest = &rest[same..];
        }
        Ok(outputs)
    }
}

/// The resolve with the most layouts that say how large their buffer is.
fn fullest<'a, 'b>(view: &'b LayoutView<'a>) -> Option<(&'b Resolve<'a>, Vec<&'a CellResult>)> {
    let said =
        |cell: &&CellResult| cell.verification.as_ref().is_some_and(|v| v.lfb_bytes.is_some());
    let all = view.resolves.iter().map(|resolve| {
        (resolve, resolve.cells.iter().copied().filter(said).collect::<Vec<&CellResult>>())
    });
    // The first of those with as many.
    all.rev().max_by_key(|(_, cells)| cells.len()).filter(|(_, cells)| cells.len() >= 3)
}

fn output(device: &str, views: &[LayoutView]) -> Option<Output> {
    let mut csv = Csv {
        columns: vec![
            "device",
            "scene",
            "view",
            "width_px",
            "height_px",
            "technique",
            "layout",
            "fragments",
            "pool_slots",
            "lfb_bytes",
            "memory_bytes",
            "peak_bytes",
            "lfb_bytes_per_fragment",
            "lfb_over_linearized",
            "derived_lfb_bytes_at_16",
            "derived_over_linearized_at_16",
        ],
        rows: Vec::new(),
    };
    let (mut tables, mut stamps) = (Vec::new(), Vec::new());
    for view in views {
        let Some((resolve, cells)) = fullest(view) else { continue };
        tables.push(block(view, resolve, &cells, &mut csv));
        stamps.push(Stamp::of(view.group.run));
    }
    if tables.is_empty() {
        return None;
    }
    Some(Output {
        name: format!("lfb-memory-{}", slug(device)),
        title: "Memory of each layout".to_owned(),
        subtitle: format!("{device}; MiB"),
        chart: Box::new(TableImage(tables.clone())),
        tables,
        csv,
        notes: vec![
            "Buffer: what a resolve reads, the pool and its tables. All: with every other buffer \
             and target of the plan. Most at once: where a pool grew, with the pool before it."
                .to_owned(),
            "Derived: 8 bytes more for each slot of the pool, as the chapter's fragments have 16 \
             bytes and ours 8. Not measured."
                .to_owned(),
        ],
        stamps: stamps.into_iter().collect(),
    })
}

fn block(view: &LayoutView, resolve: &Resolve, cells: &[&CellResult], csv: &mut Csv) -> Table {
    let group = &view.group;
    let total = group.run.total_fragments(&group.name());
    let columns = [
        "layout",
        "slots\nM",
        "buffer\nMiB",
        "buffer\nbytes a fragment",
        "buffer\nover linearized",
        "all\nMiB",
        "most at once\nMiB",
        "derived: buffer at 16 bytes\nMiB",
        "derived: buffer at 16 bytes\nover linearized",
    ];
    let fragments = total.map_or(String::new(), |n| format!(", {:.2} M fragments", n as f64 / 1e6));
    let mut table = Table {
        heading: format!("{}{fragments}; {}", group.title(), resolve.name),
        columns: columns.map(str::to_owned).to_vec(),
        rows: Vec::new(),
    };
    let of = |layout: &str| {
        let cell = cells.iter().find(|cell| cell.technique.capture == layout);
        cell.and_then(|cell| cell.verification.as_ref())
    };
    let reference = of(REFERENCE);
    let least = cells.iter().filter_map(|cell| cell.verification.as_ref()?.lfb_bytes).min();
    for cell in cells {
        let Some(own) = &cell.verification else { continue };
        let ratio = |bytes: fn(&Verification) -> Option<u64>| {
            Some(bytes(own)? as f64 / bytes(reference?)? as f64)
        };
        let per_fragment =
            own.lfb_bytes.zip(total).map(|(bytes, total)| bytes as f64 / total.max(1) as f64);
        let ratios = [ratio(|v| v.lfb_bytes), ratio(lfb_bytes_at_16)];
        let all = Some(own.memory_bytes).filter(|&bytes| bytes > 0);
        let mib = |bytes: Option<u64>| {
            bytes.map_or("–".to_owned(), |bytes| {
                format!("{:.1}", bytes as f64 / f64::from(1 << 20))
            })
        };
        let two =
            |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.2}"));
        table.rows.push(vec![
            cell.technique.capture.as_str().into(),
            format!("{:.2}", own.pool_final as f64 / 1e6).into(),
            Value { text: mib(own.lfb_bytes), marked: own.lfb_bytes == least },
            two(per_fragment).into(),
            two(ratios[0]).into(),
            mib(all).into(),
            mib(own.peak_bytes).into(),
            mib(lfb_bytes_at_16(own)).into(),
            two(ratios[1]).into(),
        ]);
        let whole = |value: Option<u64>| value.map_or(String::new(), |value| value.to_string());
        let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
        csv.rows.push(vec![
            group.run.device(),
            group.scene.to_owned(),
            group.view.to_owned(),
            group.width_px.to_string(),
            group.height_px.to_string(),
            cell.name.technique.clone(),
            cell.technique.capture.clone(),
            whole(total),
            own.pool_final.to_string(),
            whole(own.lfb_bytes),
            whole(all),
            whole(own.peak_bytes),
            say(per_fragment),
            say(ratios[0]),
            whole(lfb_bytes_at_16(own)),
            say(ratios[1]),
        ]);
    }
    table
}
