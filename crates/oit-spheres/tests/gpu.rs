//! Variations on every device of this machine, against the oracle.

mod support;

use oit_spheres::Variation;
use support::{View, inside, molecules, on_every_device, orthographic, outside, say};

/// Each axis's values, the others as the thesis's best, and combinations that share passes.
const EXACT: &[&str] = &[
    "per-object/pulled/per-center/sphere-depth/discard/bytes64",
    "per-object/pulled/per-center/sphere-depth/discard/bytes36",
    "per-object/pulled/per-center/sphere-depth/discard/bytes24",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4",
    "per-object/pulled/per-vertex/sphere-depth/discard/bytes4",
    "per-object/pulled/per-fragment/sphere-depth/discard/bytes4",
    "per-object/pulled/per-center/conservative-depth/discard/bytes4",
    "per-object/pulled/per-center/sphere-depth/infinite-depth/bytes4",
    "per-object/pulled/per-center/conservative-depth/infinite-depth/bytes36",
    "per-mesh/pulled/per-center/sphere-depth/discard/bytes4",
    "index-list/pulled/per-center/sphere-depth/discard/bytes4",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4/front-to-back",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4/back-to-front",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4/random",
    "index-list/pulled/per-center/sphere-depth/discard/bytes4/outside-in",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4/sorted",
    "index-list/pulled/per-center/sphere-depth/discard/bytes4/sorted/full-detail",
    "per-object/pulled/per-center/sphere-depth/discard/bytes4/frustum",
    "per-mesh/pulled/per-center/sphere-depth/discard/bytes36/frustum",
    "per-object/pulled/per-center/sphere-depth/discard/bytes64/occlusion",
    "per-mesh/pulled/per-center/sphere-depth/discard/bytes4/occlusion",
    "index-list/pulled/per-center/conservative-depth/discard/bytes4/sorted/occlusion",
    "per-object/geometry/per-center/sphere-depth/discard/bytes4",
    "per-mesh/geometry/per-vertex/sphere-depth/discard/bytes36",
    "index-list/geometry/per-fragment/conservative-depth/discard/bytes64",
    "batches/geometry/per-fragment/sphere-depth/discard/bytes64",
    "batches/geometry/per-center/sphere-depth/discard/bytes4/back-to-front",
    "batches/geometry/per-center/sphere-depth/discard/bytes4/occlusion",
    "batches/mesh-shader/per-center/sphere-depth/discard/bytes4",
    "batches/mesh-shader/per-vertex/conservative-depth/discard/bytes36/sorted/frustum",
    "compute/bytes4",
    "compute/bytes64",
    "compute/bytes24/full-detail/frustum",
    "compute/bytes4/occlusion",
];

fn variation(name: &str) -> Variation {
    format!("spheres/{name}").parse().expect("a variation")
}

fn matches_on(view: &View, what: &str) {
    on_every_device(what, |device| {
        let mut drawn = 0;
        for name in EXACT {
            let variation = variation(name);
            let id = device.info().id.clone();
            match view.compare(device, &variation) {
                Err(why) => say(&format!("{what}: {variation} SKIPPED on {id}: {why}")),
                Ok(comparison) => {
                    drawn += 1;
                    if std::env::var("OIT_SPHERES_SAY").is_ok() {
                        say(&format!("{what}: {variation} on {id}: {comparison:?}"));
                    }
                    let pixels = u64::from(view.size.0 * view.size.1);
                    assert_eq!(comparison.wrong_px, 0, "{variation} on {id}: {comparison:?}");
                    assert!(comparison.undecided_px < pixels / 4, "{variation}: {comparison:?}");
                }
            }
        }
        assert!(drawn > 5, "{what}: too few of them can be drawn: {drawn}");
    });
}

#[test]
fn from_outside() {
    matches_on(&View::new(molecules(60, 60, 1), outside(), (160, 100)), "from outside");
}

#[test]
fn from_inside() {
    matches_on(&View::new(molecules(60, 60, 2), inside(), (120, 90)), "from inside");
}

#[test]
fn in_a_box() {
    matches_on(&View::new(molecules(60, 60, 3), orthographic(), (100, 120)), "in a box");
}
