//! Variations on every device of this machine, against the oracle.

mod support;

use oit_gpu::Device;
use oit_scene::Stripes;
use oit_spheres::{Detail, Variation, twin};
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
    "compute/direct",
    "compute/direct/full-detail/occlusion",
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

/// Lists of more than one block, sorts of more than one workgroup, patches that are split.
#[test]
fn many_objects_and_large_ones() {
    const NAMES: &[&str] = &[
        "per-object/pulled/per-center/sphere-depth/discard/bytes4/sorted",
        "index-list/pulled/per-center/conservative-depth/discard/bytes4/sorted/occlusion",
        "per-mesh/pulled/per-center/sphere-depth/discard/bytes4/frustum",
        "batches/geometry/per-center/sphere-depth/discard/bytes4",
        "batches/geometry/per-center/sphere-depth/discard/bytes4/outside-in/full-detail",
        "compute/bytes4/full-detail",
    ];
    for (objects, atoms) in [(5000, 9), (4, 9001)] {
        let view = View::new(molecules(objects, atoms, 4), outside(), (64, 64));
        on_every_device("many objects", |device| {
            for name in NAMES {
                let variation = variation(name);
                match view.compare(device, &variation) {
                    Err(why) => say(&format!("{objects} objects: {variation} SKIPPED: {why}")),
                    Ok(comparison) => {
                        assert_eq!(comparison.wrong_px, 0, "{objects} {variation}: {comparison:?}");
                    }
                }
            }
        });
    }
}

/// What is sorted on the device is what is sorted before a frame.
#[test]
fn a_sort_on_the_device_sorts() {
    let view = View::new(molecules(5000, 3, 5), outside(), (16, 16));
    let name = "per-object/pulled/per-center/sphere-depth/discard/bytes4/sorted";
    let plan = variation(name).plan(&view.request()).expect("a plan");
    let eye = glam::Vec3::from(view.camera.eye);
    on_every_device("sort", |device| {
        let id = device.prepare(&plan).expect("prepared");
        device.poison(id).expect("poisoned");
        device.run(id).expect("ran");
        let bytes = device.read(id, "sorted").expect("read");
        let words: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
            .collect();
        let objects: Vec<u32> = words.chunks_exact(2).take(5000).map(|pair| pair[1]).collect();
        let mut once = objects.clone();
        once.sort_unstable();
        assert!(once.iter().copied().eq(0..5000), "each object once");
        let distance = |object: u32| {
            glam::Vec3::from(view.spheres.objects[object as usize].position).distance(eye)
        };
        for pair in objects.windows(2) {
            assert!(distance(pair[0]) <= distance(pair[1]) + 1e-4, "{pair:?}");
        }
    });
}

/// What each approximation costs, and that it does cost: an exact one would be misnamed.
#[test]
fn approximations_are_as_far_off_as_said() {
    // The name, and the least and most of the pixels that may be wrong, in hundredths.
    const NAMES: &[(&str, u64, u64)] = &[
        ("per-object/pulled/per-center/sphere-depth/discard/bytes12", 0, 20),
        ("per-object/pulled/per-center/sphere-depth/discard/bytes8", 1, 60),
        ("per-object/pulled/per-center/flat-depth/discard/bytes4", 1, 40),
        ("per-object/pulled/per-center/flat-depth/no-discard/bytes4", 5, 90),
        ("per-object/pulled/per-center/sphere-depth/no-discard/bytes4", 5, 90),
        ("compute/bytes12", 0, 20),
    ];
    let view = View::new(molecules(60, 60, 6), outside(), (160, 160));
    on_every_device("approximations", |device| {
        for &(name, least, most) in NAMES {
            let variation = variation(name);
            assert!(variation.accuracy().is_err(), "{name}");
            let comparison = match view.compare(device, &variation) {
                Ok(comparison) => comparison,
                Err(why) => {
                    say(&format!("{variation} SKIPPED: {why}"));
                    continue;
                }
            };
            say(&format!("{variation}: {comparison:?}"));
            let hundredths = comparison.wrong_px * 100 / (160 * 160);
            assert!((least..=most).contains(&hundredths), "{variation}: {comparison:?}");
            assert!(comparison.max_error > 1.0 / 255.0, "{variation}: {comparison:?}");
        }
        for name in EXACT {
            assert!(variation(name).accuracy().is_ok(), "{name}");
        }
    });
}

/// A device's compute rasteriser gives what its twin gives.
#[test]
fn the_twin_draws_the_same() {
    for (seed, camera) in [(7, outside()), (8, inside()), (9, orthographic())] {
        let view = View::new(molecules(60, 60, seed), camera, (96, 80));
        for name in ["compute/bytes64", "compute/bytes24/frustum", "compute/bytes4/full-detail"] {
            let variation = variation(name);
            let drawn = twin(&variation, &view.request()).expect("a picture");
            let comparison = view.expected(variation.detail).compare(&drawn);
            assert_eq!(comparison.wrong_px, 0, "{variation}: {comparison:?}");
        }
        let packed = variation("compute/bytes12");
        let drawn = twin(&packed, &view.request()).expect("a picture");
        on_every_device("twin", |device| {
            let Ok(picture) = view.draw(device, &packed) else { return };
            let unlike = picture
                .iter()
                .zip(&drawn)
                .filter(|(a, b)| a.iter().zip(b.iter()).any(|(a, b)| (a - b).abs() > 0.02));
            let unlike = unlike.count();
            assert!(unlike < 96 * 80 / 50, "{unlike} pixels of {packed} differ");
        });
    }
    let view = View::new(molecules(3, 3, 1), outside(), (8, 8));
    let billboards = variation("per-object/pulled/per-center/sphere-depth/discard/bytes4");
    assert!(twin(&billboards, &view.request()).is_err_and(|why| why.contains("raster")));
}

/// The words of a buffer after a run from anything and one from what that left.
fn words(device: &mut dyn Device, view: &View, name: &str, buffer: &str) -> Vec<u32> {
    let plan = variation(name).plan(&view.request()).expect("a plan");
    let id = device.prepare(&plan).expect("prepared");
    device.poison(id).expect("poisoned");
    device.run(id).expect("ran");
    device.run(id).expect("ran");
    let bytes = device.read(id, buffer).expect("read");
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().expect("4"))).collect()
}

/// Right pictures say that no more is culled than may be; this says that something is.
#[test]
fn culling_culls() {
    let objects = 3000;
    let name = "per-object/pulled/per-center/sphere-depth/discard/bytes4";
    on_every_device("culling", |device| {
        let view = View::new(molecules(objects, 80, 10), inside(), (64, 48));
        let commands = words(device, &view, &format!("{name}/frustum"), "commands");
        let drawn = commands.chunks_exact(4).filter(|command| command[1] != 0).count();
        assert!((1..objects * 3 / 4).contains(&drawn), "{drawn} of {objects} in the frustum");

        let view = View::new(molecules(objects, 80, 10), outside(), (64, 48));
        let seen = words(device, &view, &format!("{name}/occlusion"), "seen");
        let seen = seen.iter().filter(|&&seen| seen != 0).count();
        assert!((1..objects * 3 / 4).contains(&seen), "{seen} of {objects} not hidden");
        let full = view.expected(Detail::ByDistance);
        let picture = view.draw(device, &variation(&format!("{name}/occlusion"))).expect("drawn");
        assert_eq!(full.compare(&picture).wrong_px, 0);
    });
}

/// Stripes follow positions in the world, and so show what an output makes of these.
#[test]
fn positions_show_in_stripes() {
    let mut view = View::new(molecules(60, 60, 11), outside(), (120, 90));
    view.shading.stripes =
        Some(Stripes { direction: [0.6, 0.8, 0.0], period: 1.3, rgba: [250, 240, 20, 255] });
    let plain = view.expected(Detail::ByDistance);
    on_every_device("stripes", |device| {
        for output in ["bytes64", "bytes36", "bytes24", "bytes8", "bytes4", "bytes12"] {
            let name = format!("per-object/pulled/per-center/sphere-depth/discard/{output}");
            let variation = variation(&name);
            let comparison = plain.compare(&view.draw(device, &variation).expect("drawn"));
            say(&format!("stripes: {output}: {comparison:?}"));
            if variation.accuracy().is_ok() {
                assert_eq!(comparison.wrong_px, 0, "{output}: {comparison:?}");
            }
        }
        let drawn = twin(&variation("compute/bytes4"), &view.request()).expect("a picture");
        assert_eq!(plain.compare(&drawn).wrong_px, 0);
    });
}

/// Where an object's number and an atom's do not share 32 bits.
#[test]
fn ids_of_many_objects_and_many_atoms() {
    // 17 bits of objects, most of them far away, and as many of atoms that are not drawn.
    let mut spheres = molecules(60, 60, 12);
    let far = oit_scene::Object { position: [0.0, 0.0, 1e4], ..spheres.objects[0] };
    spheres.objects.resize(66_000, far);
    spheres.objects.rotate_left(30);
    spheres.levels.push(oit_scene::Level { first_atom: 0, atoms: 70_000, from_distance: 0.0 });
    let view = View::new(spheres, outside(), (64, 48));
    on_every_device("ids", |device| {
        for name in [
            "per-mesh/pulled/per-center/sphere-depth/discard/bytes4/occlusion",
            "batches/geometry/per-center/sphere-depth/discard/bytes36/frustum",
            "compute/bytes4/frustum",
        ] {
            let plan = variation(name).plan(&view.request()).expect("a plan");
            assert!(plan.buffer("first_ids").is_some(), "{name}");
            match view.compare(device, &variation(name)) {
                Err(why) => say(&format!("{name} SKIPPED: {why}")),
                Ok(comparison) => assert_eq!(comparison.wrong_px, 0, "{name}: {comparison:?}"),
            }
        }
    });
}
