//! Synthetic records of ways of drawing spheres. No number here was measured: a byte of output takes 1 us,
//! tessellation and a projection for each fragment as much again, and a million spheres 1 ms.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{
    AttachmentBandwidth, Bandwidth, Cell, Event, PassKind, PassWork, RasterCounts, RunWriter,
    Verdict, Verification,
};

use super::bma::write_images;
use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// What follows `spheres/` in names.
const DEPTHS: [&str; 3] = ["flat-depth", "sphere-depth", "conservative-depth"];
const OUTPUTS: [u64; 5] = [64, 36, 24, 12, 4];

/// Spheres of the virus in each size.
const SIZES: [(&str, u64); 3] =
    [("virus", 1_000_000), ("virus{factor=4}", 4_000_000), ("virus{factor=16}", 16_000_000)];

fn names() -> Vec<(String, u64)> {
    let mut names = Vec::new();
    for drawing in ["batches", "per-object", "per-mesh"] {
        for projection in ["per-fragment", "per-vertex", "per-center"] {
            for bytes in OUTPUTS {
                let name = format!(
                    "spheres/{drawing}/geometry/{projection}/sphere-depth/discard/bytes{bytes}"
                );
                let factor =
                    1 + u64::from(drawing == "batches") + u64::from(projection == "per-fragment");
                names.push((name, 1_000 * bytes * factor));
            }
        }
    }
    for depth in DEPTHS {
        let name = format!("spheres/batches/geometry/per-fragment/{depth}/discard/bytes64");
        if depth != "sphere-depth" {
            names.push((name, 190_000));
        }
    }
    names.push(("spheres/compute/bytes4".to_owned(), 1_000));
    names
}

/// Fragments that are shaded where none is rejected before, for each sphere.
pub(crate) const FRAGMENTS_OF_SPHERE: u64 = 50;
/// Bytes a second written to attachments.
pub(crate) const ATTACHMENT_BYTES_PER_S: f64 = 5e10;

/// What a device counts of drawing so many spheres: a tenth of the fragments where an early test sees
/// them front to back.
fn passes(technique: &str, spheres: u64) -> Vec<PassWork> {
    let early = technique.ends_with("front-to-back") && !technique.contains("sphere-depth");
    let fragments = FRAGMENTS_OF_SPHERE * spheres / if early { 10 } else { 1 };
    let bytes = technique.split("/bytes").nth(1).and_then(|bytes| bytes.split('/').next());
    let counts = RasterCounts {
        vertex_invocations: spheres / 100,
        tessellation_patches: Some(spheres / 100),
        tessellation_invocations: Some(2 * spheres),
        geometry_invocations: Some(2 * spheres),
        clipping_invocations: spheres,
        clipping_primitives: spheres,
        fragment_invocations: fragments,
        ..RasterCounts::default()
    };
    let pass = |stage: &str, kind| PassWork {
        stage: stage.to_owned(),
        label: format!("{stage}: made up"),
        kind,
        cleared_bytes: 0,
        color_bytes_per_fragment: 0,
        depth_stencil_bytes_per_fragment: 0,
        compute_invocations: (kind == PassKind::Compute).then_some(512),
        counted: None,
    };
    let raster = |stage: &str, counted, color_bytes_per_fragment| PassWork {
        color_bytes_per_fragment,
        counted: Some(counted),
        ..pass(stage, PassKind::Raster)
    };
    let full_screen = RasterCounts {
        vertex_invocations: 3,
        clipping_invocations: 1,
        clipping_primitives: 1,
        fragment_invocations: u64::from(WIDTH_PX * HEIGHT_PX),
        ..RasterCounts::default()
    };
    vec![
        pass("preprocess", PassKind::Compute),
        raster("draw", counts, bytes.unwrap().parse().unwrap()),
        raster("shade", full_screen, 16),
    ]
}

/// Writes a run of the virus in three sizes and of the stack from both sides.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let mut cells = Vec::new();
    for (scene, spheres) in SIZES {
        for (technique, ns) in names() {
            // What has no room for so many is refused.
            let refused = spheres > 4_000_000 && technique.contains("per-mesh");
            cells.push((technique, scene, "hiv", spheres, ns * spheres / 1_000_000, refused));
        }
    }
    for depth in DEPTHS {
        for (order, ns) in [("front-to-back", 5_000_000), ("back-to-front", 9_000_000)] {
            let name =
                format!("spheres/batches/geometry/per-fragment/{depth}/discard/bytes64/{order}");
            cells.push((name, "sphere_stack", "front", 10_000, ns, false));
        }
    }
    let named = cells.iter().map(|(technique, scene, view, ..)| Cell {
        technique: technique.clone(),
        scene: (*scene).to_owned(),
        view: (*view).to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    });
    let run = run_of(device, named.collect());
    let mut writer = RunWriter::create(folder, &run).unwrap();
    let attachment = Some(AttachmentBandwidth {
        bytes_per_px: 64,
        pixels: 1 << 22,
        bytes_per_s: ATTACHMENT_BYTES_PER_S,
    });
    let measured = Bandwidth {
        buffer_bytes: 1 << 28,
        copy_bytes_per_s: 4e12,
        fill_bytes_per_s: 3e12,
        attachment,
        repeats: 20,
    };
    writer.append(&Event::Bandwidth { measured }).unwrap();
    let mut counted = String::new();
    for (index, (technique, .., spheres, draw_ns, refused)) in cells.iter().enumerate() {
        let group = run.cells[index].group();
        if counted != group {
            counted.clone_from(&group);
            let spheres = Some(*spheres);
            let histogram = Vec::new();
            writer.append(&Event::Counted { group, triangles: 0, spheres, histogram }).unwrap();
        }
        if *refused {
            let reason = "its list has no room".to_owned();
            writer.append(&Event::Skipped { cell: index, reason }).unwrap();
            continue;
        }
        let approximate = technique.contains("flat-depth") || technique.contains("bytes12");
        let max_error = if approximate { 0.01 } else { 0.0 };
        let result = Verification {
            verdict: if approximate { Verdict::Approximate } else { Verdict::Exact },
            max_error,
            rmse: max_error / 2.0,
            fragments_compared: false,
            max_frags: 0,
            ..verification("linked_list/base/insertion/compute/peak", 8)
        };
        if *spheres == 10_000 && technique.contains("front-to-back") {
            write_images(folder, &run.cells[index]);
        }
        writer.append(&Event::Verified { cell: index, result }).unwrap();
        let passes = passes(technique, *spheres);
        writer.append(&Event::Work { cell: index, passes }).unwrap();
        for sample in 0..5 {
            let draw_ns = draw_ns + u64::from(sample);
            let stages = [("preprocess", 3_000), ("draw", draw_ns), ("shade", 2_000)];
            let stages_ns: BTreeMap<String, u64> =
                stages.map(|(stage, ns)| (stage.to_owned(), ns)).into();
            let total_ns = stages_ns.values().sum();
            let parts_ns = BTreeMap::new();
            writer
                .append(&Event::Sample { cell: index, sample, stages_ns, parts_ns, total_ns })
                .unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
