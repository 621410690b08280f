//! The plans and all their WGSL, without a device.

mod support;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use oit_capture::{CAPTURES, CaptureRequest, Drawn, Geometry, MeshBytes, WIDE, count_plan};
use oit_fragments::DepthHistogram;
use oit_gpu::{Contents, Plan};
use std::sync::Arc;
use support::*;

/// What resolves read is plain WGSL: a capture that needs more of its device needs it in passes of
/// its own.
fn validate(label: &str, wgsl: &str) {
    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string_with_path(wgsl, label)));
    Validator::new(ValidationFlags::all(), Capabilities::EARLY_DEPTH_TEST)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string_with_path(wgsl, label)));
}

fn geometry(width_px: u32, height_px: u32) -> Geometry {
    Geometry::new(&random_mesh(1, 10), &UNLIT, &perspective_camera(), width_px, height_px)
}

fn plans(request: &CaptureRequest) -> Vec<Plan> {
    CAPTURES
        .iter()
        .chain(WIDE)
        .map(|capture| capture_plan(*capture, request))
        .chain([count_plan(request.geometry, request.width_px, request.height_px)])
        .collect()
}

#[test]
fn every_plan_is_sound() {
    for (width_px, height_px) in [(1, 1), (64, 16), (1025, 1), (960, 540), (8192, 8192)] {
        let geometry = geometry(width_px, height_px);
        let histogram = DepthHistogram::from_counts([3, 0, 9]);
        for counts in [false, true] {
            for pool_slots in [1, 1000] {
                let request = CaptureRequest {
                    pool_slots,
                    counts,
                    ..request(&geometry, (width_px, height_px), &histogram)
                };
                for plan in plans(&request) {
                    plan.check().unwrap_or_else(|error| panic!("{width_px}x{height_px}: {error}"));
                }
            }
        }
    }
}

#[test]
fn stages_are_those_of_the_chapter() {
    let geometry = geometry(8, 8);
    let histogram = DepthHistogram::default();
    let request = request(&geometry, (8, 8), &histogram);
    let expected: &[(&str, &[&str])] = &[
        ("linked_list", &["clear", "capture"]),
        ("linearized", &["clear", "count", "scan", "capture"]),
        ("linearized_sweep", &["clear", "count", "scan", "capture"]),
        ("linearized_lookback", &["clear", "count", "scan", "capture"]),
        ("linked_list_subgroup", &["clear", "capture"]),
        ("linked_list_blend", &["clear", "capture", "count"]),
        ("linked_list_sorted", &["clear", "capture"]),
        ("linked_list128", &["clear", "capture"]),
        ("array3d", &["clear", "capture"]),
        ("array3d_nearest", &["clear", "capture"]),
        ("linearized_nearest", &["clear", "count", "scan", "capture"]),
        ("linked_pages4", &["clear", "capture"]),
        ("linked_pages6", &["clear", "capture"]),
        ("linearized_blend", &["count", "scan", "capture"]),
        ("interleaved", &["clear", "count", "scan", "capture"]),
        ("interleaved_lists", &["clear", "count", "group", "scan", "capture"]),
        ("count", &["clear", "count"]),
    ];
    let plans = plans(&request);
    for (name, stages) in expected {
        let plan = plans.iter().find(|plan| &plan.name == name).expect(name);
        assert_eq!(plan.stages(), *stages, "{name}");
    }
}

/// What each layout needs beside its pool, in bytes, for 1025 pixels.
#[test]
fn tables_have_their_size() {
    let geometry = geometry(1025, 1);
    let histogram = DepthHistogram::default();
    let plans = plans(&request(&geometry, (1025, 1), &histogram));
    let tables = [
        ("linearized", vec![("offsets", 4100), ("offsets_sums1", 8)]),
        ("linearized_sweep", vec![("offsets", 8192)]),
        ("linearized_lookback", vec![("counts", 4100), ("offsets", 4100), ("offsets_status", 12)]),
        ("linearized_blend", vec![("offsets", 4100), ("offsets_sums1", 8)]),
        ("interleaved", vec![("counts", 4100), ("rows", 4 * 33)]),
        ("interleaved_lists", vec![("bases", 4100), ("counts", 4100), ("rows", 4 * (33 + 3))]),
    ];
    let common =
        ["frame", "vertices", "indices", "total", "row_total", "fragments", "image"].as_slice();
    for (name, tables) in tables {
        let plan = plans.iter().find(|plan| plan.name == name).expect(name);
        let mut found: Vec<_> = plan.buffers.iter().map(|b| (b.name.as_str(), b.bytes)).collect();
        found.retain(|(name, _)| !common.contains(name) && !name.starts_with("group_"));
        found.sort_unstable();
        assert_eq!(found, tables, "{name}");
    }
}

#[test]
fn every_layout_keeps_its_word() {
    for capture in CAPTURES {
        let mut body = "lfb_begin(3u); while (lfb_more()) { out += lfb_next(); }".to_owned();
        if capture.random_access() {
            body += "for (var i = 0u; i < lfb_len(); i++) { out += lfb_at(i); }";
        }
        let result = "@group(0) @binding(16) var<storage, read_write> out: vec2<u32>;";
        let main = "@compute @workgroup_size(1) fn main()";
        validate(capture.name(), &format!("{}{result}{main} {{ {body} }}", capture.layout_wgsl()));
        if let Some(layout) = capture.rewrite_wgsl() {
            let body = "lfb_begin(3u); let first = lfb_cursor(); out = lfb_next(); lfb_seek(first); \
                lfb_put(out);";
            validate(capture.name(), &format!("{layout}{result}{main} {{ {body} }}"));
        }
        let body = "out.x = pixel_count(3u);";
        validate(capture.name(), &format!("{}{result}{main} {{ {body} }}", capture.count_wgsl()));
    }
}

#[test]
fn two_views_share_one_mesh() {
    let mesh = MeshBytes::new(&random_mesh(1, 100));
    let [a, b] = [(8, 8), (16, 8)]
        .map(|(width_px, height_px)| mesh.view(&UNLIT, &perspective_camera(), width_px, height_px));
    let (Drawn::Mesh(of_a), Drawn::Mesh(of_b)) = (&a.drawn, &b.drawn) else { panic!("meshes") };
    assert!(Arc::ptr_eq(&of_a.vertices, &of_b.vertices));
    assert!(Arc::ptr_eq(&of_a.indices, &of_b.indices));
    assert_ne!(a.frame, b.frame);
    let buffers = a.buffers();
    let shared = buffers.iter().any(
        |buffer| matches!(&buffer.contents, Contents::Data(data) if Arc::ptr_eq(data, &of_b.vertices)),
    );
    assert!(shared, "buffers take the bytes as they are");
}
