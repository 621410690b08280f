//! The work of passes and the bandwidth, on every GPU there is.

mod support;

use oit_lab::{CellError, FrameSize, ViewData, measure_bandwidth, open_engine};
use oit_record::PassKind;

/// Small, and no multiple of a workgroup or a tile.
const SIZE: FrameSize = FrameSize { width_px: 61, height_px: 37 };

#[test]
fn bandwidth_is_measured_with_the_first_size_that_is_allowed() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        // No device runs two million workgroups of one side.
        let measured = measure_bandwidth(&mut *device, &[1 << 35, 1 << 20]);
        let measured = match measured {
            Err(oit_gpu::GpuError::Unsupported(reason)) => {
                assert!(reason.contains("does not time"), "{id}: {reason}");
                continue;
            }
            measured => measured.expect("it is measured"),
        };
        assert_eq!(measured.buffer_bytes, 1 << 20, "{id}");
        // What moves a megabyte in more than a second, or in less than a nanosecond, is no memory.
        let plausible = |bytes_per_s: f64| (1e6..1e15).contains(&bytes_per_s);
        assert!(plausible(measured.copy_bytes_per_s), "{id}: {measured:?}");
        assert!(plausible(measured.fill_bytes_per_s), "{id}: {measured:?}");
        if let Some(told) = measured.attachment {
            assert!(plausible(told.bytes_per_s), "{id}: {measured:?}");
            let bytes = told.pixels * told.bytes_per_px;
            assert!(bytes <= 1 << 20 && bytes > 1 << 19, "{id}: {measured:?}");
        }
        let refused = measure_bandwidth(&mut *device, &[1 << 35]);
        assert!(matches!(refused, Err(oit_gpu::GpuError::Unsupported(_))), "{id}: {refused:?}");
    }
}

#[test]
fn passes_are_counted_and_the_picture_stays() {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let scene = oit_scene::load(&path.join("random_triangles.toml"), &Default::default());
    let view = ViewData::new(&scene.expect("a scene of this repository"), "front", SIZE);
    let view = view.expect("one of its views");
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let counts = engine.info().unsupported.iter();
        let counts = counts.filter(|lacking| lacking.feature == "pipeline statistics").count() == 0;
        let histogram = engine.open_view(view.clone()).expect("it is counted");
        for name in ["linked_list/base/insertion/fragment/peak", "weighted"] {
            let technique = name.parse().expect("a technique");
            let ready = match engine.prepare(&technique) {
                Ok((ready, _)) => ready,
                Err(CellError::Unsupported(_)) => continue,
                Err(error) => panic!("{id} {name}: {error}"),
            };
            let picture = engine.picture(ready).expect("a picture");
            let passes = engine.work(ready).expect("its work");
            assert_eq!(engine.picture(ready).expect("a picture"), picture, "{id} {name}");
            let raster = passes.iter().filter(|pass| pass.kind == PassKind::Raster);
            assert!(raster.clone().all(|pass| pass.counted.is_some() == counts), "{id} {name}");
            if !counts {
                continue;
            }
            // Each of the view's fragments was run for, and more: quads are run whole, and llvmpipe of
            // Mesa 22.3 counts fragments that are in no triangle.
            let fragments = |counted: oit_record::RasterCounts| counted.fragment_invocations;
            let all: u64 = raster.clone().filter_map(|pass| pass.counted.map(fragments)).sum();
            assert!(all >= histogram.total(), "{id} {name}: {all} < {}", histogram.total());
            let written: u64 =
                raster.clone().filter_map(oit_record::PassWork::attachment_bytes_at_most).sum();
            // The picture at least: 16 bytes a pixel that has fragments.
            let covered = SIZE.pixels() - histogram.pixels[0];
            assert!(written >= 16 * covered, "{id} {name}: {written}");
            let triangles = |counted: oit_record::RasterCounts| counted.clipping_invocations;
            let drawn = raster.filter_map(|pass| pass.counted.map(triangles)).max();
            assert!(drawn >= Some(view.triangles()), "{id} {name}: {drawn:?}");
        }
    }
}

#[test]
fn the_cpu_has_no_passes() {
    let cache = support::cache();
    let mut engine = open_engine("cpu", cache.path()).expect("there is a processor");
    assert!(matches!(engine.bandwidth(), Err(CellError::Unsupported(_))));
}
