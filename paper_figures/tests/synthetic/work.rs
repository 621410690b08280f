//! A test fixture: methods whose passes are counted, on a device that does not exist, with counts,
//! bandwidth and times made up so that it is known what the figure on work must show. Nothing here was
//! measured.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{
    AttachmentBandwidth, Bandwidth, Cell, Event, PassKind, PassWork, RasterCounts, RunWriter,
    Verdict, Verification,
};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// Methods, each with the runs of its fragment stage, in one stage of drawing.
pub(crate) const METHODS: &[(&str, u64)] = &[("weighted", 20_000), ("dual_peel", 60_000)];

/// What is measured at best, in bytes a second.
pub(crate) const BEST_BYTES_PER_S: f64 = 4e9;
/// Nanoseconds of drawing.
pub(crate) const DRAW_NS: u64 = 1_000_000;
/// Bytes that a fragment writes.
pub(crate) const BYTES_PER_FRAGMENT: u64 = 20;

fn pass(stage: &str, kind: PassKind) -> PassWork {
    PassWork {
        stage: stage.to_owned(),
        label: "made up".to_owned(),
        kind,
        cleared_bytes: 0,
        color_bytes_per_fragment: 0,
        depth_stencil_bytes_per_fragment: 0,
        compute_invocations: None,
        counted: None,
    }
}

fn passes(fragments: u64) -> Vec<PassWork> {
    let counts = RasterCounts {
        vertex_invocations: 300,
        clipping_invocations: 100,
        clipping_primitives: 100,
        fragment_invocations: fragments,
        ..RasterCounts::default()
    };
    vec![
        PassWork {
            cleared_bytes: 64,
            color_bytes_per_fragment: 16,
            depth_stencil_bytes_per_fragment: BYTES_PER_FRAGMENT - 16,
            counted: Some(counts),
            ..pass("draw", PassKind::Raster)
        },
        PassWork { compute_invocations: Some(512), ..pass("resolve", PassKind::Compute) },
    ]
}

/// Writes the run folder, with the bandwidth if it `is_measured`.
pub(crate) fn write_run(folder: &Path, device: &str, is_measured: bool) {
    let cells = METHODS.iter().map(|(method, _)| Cell {
        technique: (*method).to_owned(),
        scene: "shells".to_owned(),
        view: "inside".to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    });
    let cells: Vec<Cell> = cells.collect();
    let mut writer = RunWriter::create(folder, &run_of(device, cells.clone())).unwrap();
    if is_measured {
        let measured = Bandwidth {
            buffer_bytes: 1 << 28,
            copy_bytes_per_s: BEST_BYTES_PER_S,
            fill_bytes_per_s: 3e9,
            attachment: Some(AttachmentBandwidth {
                bytes_per_px: 64,
                pixels: 1 << 22,
                bytes_per_s: 2e9,
            }),
            repeats: 20,
        };
        writer.append(&Event::Bandwidth { measured }).unwrap();
    }
    let histogram = vec![0, 0, 0, u64::from(WIDTH_PX * HEIGHT_PX)];
    writer
        .append(&Event::Counted {
            group: cells[0].group(),
            triangles: 100,
            spheres: None,
            histogram,
        })
        .unwrap();
    for (cell, (_, fragments)) in METHODS.iter().enumerate() {
        let result = Verification {
            verdict: Verdict::Approximate,
            fragments_compared: false,
            max_frags: 0,
            ..verification("linked_list/base/insertion/compute/peak", 3)
        };
        writer.append(&Event::Verified { cell, result }).unwrap();
        writer.append(&Event::Work { cell, passes: passes(*fragments) }).unwrap();
        for sample in 0..5 {
            let stages = [("draw".to_owned(), DRAW_NS), ("resolve".to_owned(), 200_000)];
            let stages_ns = BTreeMap::from(stages);
            let (parts_ns, total_ns) = (BTreeMap::new(), DRAW_NS + 200_000);
            let event = Event::Sample { cell, sample, stages_ns, parts_ns, total_ns };
            writer.append(&event).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
