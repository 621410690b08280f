//! Plans, without a device.

mod support;

use std::collections::HashSet;

use oit_spheres::{VARIATIONS, Variation, cross_product};
use support::{View, molecules, outside};

#[test]
fn every_named_variation_is_a_sound_plan() {
    let view = View::new(molecules(20, 20, 1), outside(), (64, 48));
    for name in VARIATIONS {
        let variation: Variation = name.parse().expect("a name");
        let plan = variation.plan(&view.request()).unwrap_or_else(|why| panic!("{name}: {why}"));
        plan.check().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(plan.stages(), ["preprocess", "draw", "shade"], "{name}");
    }
}

/// One of each few of all combinations, another few each time the list grows.
#[test]
fn combinations_are_sound_plans() {
    let view = View::new(molecules(20, 20, 2), outside(), (64, 48));
    let mut fragments = HashSet::new();
    for variation in cross_product().step_by(397) {
        let plan =
            variation.plan(&view.request()).unwrap_or_else(|why| panic!("{variation}: {why}"));
        plan.check().unwrap_or_else(|error| panic!("{error}"));
        fragments.insert(variation.output);
    }
    assert_eq!(fragments.len(), 6, "all outputs are among them");
}

/// A hundred million spheres: numbers fit, and nothing but an index list takes memory for each.
#[test]
fn a_hundred_million_spheres_can_be_said() {
    let mut spheres = molecules(1, 83, 3);
    let object = spheres.objects[0];
    spheres.objects = vec![object; 1_250_000];
    assert!(spheres.total() > 100_000_000);
    let view = View::new(spheres, outside(), (1920, 1080));
    for name in VARIATIONS {
        let variation: Variation = name.parse().expect("a name");
        let plan = variation.plan(&view.request()).unwrap_or_else(|why| panic!("{name}: {why}"));
        for pass in &plan.passes {
            if let oit_gpu::Work::Compute { dispatch, .. } = &pass.work
                && let oit_gpu::Dispatch::Workgroups(workgroups) = dispatch
            {
                assert!(workgroups.iter().all(|&side| side <= 65_535), "{name}: {workgroups:?}");
            }
            // The least that Vulkan asks of a device with mesh shaders.
            if let oit_gpu::Work::Raster(raster) = &pass.work
                && let oit_gpu::Draw::MeshIndirect { at_most, .. } = &raster.draw
            {
                assert!(at_most.iter().all(|&side| side <= 65_535), "{name}: {at_most:?}");
                let all: u32 = at_most.iter().product();
                assert!((3_750_000..=1 << 22).contains(&all), "{name}: {at_most:?}");
            }
        }
        let bytes: u64 = plan.buffers.iter().map(|buffer| buffer.bytes).sum();
        let list = if name.contains("index-list") { 8 * view.spheres.total() } else { 0 };
        assert!(bytes - list < 250_000_000, "{name}: {bytes} bytes of buffers");
    }
}

#[test]
fn what_cannot_be_said_is_refused_with_the_reason() {
    let refused = |view: &View, name: &str| {
        let variation: Variation = name.parse().expect("a name");
        variation.plan(&view.request()).expect_err(name)
    };
    let view = View::new(molecules(20, 20, 1), outside(), (64, 48));
    let why = refused(&view, "spheres/compute/bytes4/random");
    assert!(why.contains("whatever order"), "{why}");
    let why = refused(&view, "spheres/per-mesh/pulled/per-center/flat-depth/discard/bytes4/sorted");
    assert!(why.contains("by mesh"), "{why}");
    let why =
        refused(&view, "spheres/per-mesh/pulled/per-center/flat-depth/discard/bytes4/occlusion");
    assert!(why.contains("pyramid"), "{why}");

    let mut spheres = molecules(1, 100_000, 1);
    let object = spheres.objects[0];
    spheres.objects = vec![object; 70_000];
    let view = View::new(spheres, outside(), (64, 48));
    let why = refused(&view, "spheres/per-object/pulled/per-center/sphere-depth/discard/bytes4");
    assert!(why.contains("7000000000 spheres") && why.contains("32 bits"), "{why}");
    let why = refused(&view, "spheres/index-list/pulled/per-center/sphere-depth/discard/bytes64");
    assert!(why.contains("can be bound"), "{why}");

    let view = View::new(molecules(0, 20, 1), outside(), (64, 48));
    let why = refused(&view, "spheres/compute/bytes4");
    assert!(why.contains("no object"), "{why}");
}
