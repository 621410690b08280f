//! Every capture x schedule x sort x stage x tie rule on every device, against the oracle; the
//! order of submission shuffled; pixels deeper than the array; pools that are too small.

mod support;

use oit_capture::CAPTURES;
use oit_fragments::Ties;
use oit_lab::ViewData;
use oit_lab::{
    CellError, Engine, FrameSize, MaxFrags, Schedule, Stage, Technique, Verifier, open_engine,
};
use oit_record::{Verdict, Verification};
use oit_scene::{Camera, Projection, Scene, shuffle_triangles};
use oit_sort::SortChoice;

/// Small, and no multiple of a workgroup or a tile.
const SIZE: FrameSize = FrameSize { width_px: 61, height_px: 37 };

/// The same, and the CPU.
fn devices() -> Vec<String> {
    let mut devices = support::gpus();
    devices.push("cpu".into());
    devices
}

/// A small soup of intersecting triangles, its triangles in an order of this seed.
fn soup(seed: u64, size: FrameSize) -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let scene = oit_scene::load(&path.join("random_triangles.toml"), &Default::default());
    let mut scene: Scene = scene.expect("a scene of this repository");
    if seed > 0 {
        scene.mesh = shuffle_triangles(&scene.mesh, seed).into();
    }
    ViewData::new(&scene, "front", size).expect("one of its views")
}

/// `count` squares that fill the view, as deep as wanted.
fn stack(count: u32, size: FrameSize) -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let text = format!("count = {count}\norder = \"random\"\nsize = 1.2");
    let overrides = text.parse::<toml::Table>().expect("TOML").into_iter().collect();
    let scene = oit_scene::load(&path.join("stack.toml"), &overrides);
    let mut scene = scene.expect("a scene of this repository");
    let projection = Projection::Orthographic { height: 2.0, near: 0.0, far: 8.0 };
    let camera = Camera { projection, ..scene.views[0].camera };
    scene.views[0].camera = camera;
    let view = scene.views[0].name.clone();
    ViewData::new(&scene, &view, size).expect("its view")
}

fn all_techniques(max_frags: MaxFrags) -> Vec<Technique> {
    let mut techniques = Vec::new();
    for &capture in CAPTURES {
        for (schedule, ..) in Schedule::ALL {
            for sort in SortChoice::all() {
                for stage in Stage::ALL {
                    for ties in Ties::ALL {
                        techniques.push(Technique {
                            capture,
                            schedule,
                            sort: sort.clone(),
                            stage,
                            max_frags,
                            ties,
                            pool_percent: 100,
                        });
                    }
                }
            }
        }
    }
    techniques
}

/// Verifies a technique; `None` where the device cannot run it.
fn verify(
    engine: &mut dyn Engine,
    verifier: &mut Verifier,
    technique: &Technique,
) -> Option<Verification> {
    match engine.prepare(technique) {
        Ok((ready, preparation)) => {
            let result = verifier.verify(engine, technique, ready, &preparation);
            Some(result.unwrap_or_else(|error| panic!("{technique}: {error}")))
        }
        Err(CellError::Unsupported(_)) => None,
        Err(CellError::Failed(reason)) => panic!("{technique}: {reason}"),
    }
}

#[test]
fn every_technique_is_exact_whatever_the_order_of_submission() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let mut ran = 0;
        for seed in [0, 1] {
            engine.open_view(soup(seed, SIZE)).expect("the view opens");
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            for technique in all_techniques(MaxFrags::Peak) {
                let Some(result) = verify(&mut *engine, &mut verifier, &technique) else {
                    continue;
                };
                let expected = if technique.sort.to_string() == "passthrough" {
                    Verdict::Approximate
                } else {
                    Verdict::Exact
                };
                assert_eq!(result.verdict, expected, "{id} {technique}: {:?}", result.note);
                ran += 1;
            }
        }
        println!("{id}: {ran} cells");
        assert!(ran > 40, "{id} ran {ran} cells");
    }
}

#[test]
fn a_deeper_pixel_than_the_array_is_an_error_that_is_measured() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let histogram = engine.open_view(stack(40, SIZE)).expect("the view opens");
        assert_eq!(histogram.peak(), 40);
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        for name in [
            "linked_list/base/insertion/compute/max12",
            "linked_list/bma-list/rbs/compute/max12",
            "linearized/bma-list/network/compute/max12",
        ] {
            let technique: Technique = name.parse().expect("a technique");
            let result = verify(&mut *engine, &mut verifier, &technique).expect("it is supported");
            assert_eq!(result.verdict, Verdict::Approximate, "{id} {name}");
            assert!(result.wrong_px > 0 && result.max_error > 1.0 / 255.0, "{id} {name}");
            assert_eq!(result.max_frags, 12);
        }
    }
}

#[test]
fn a_pool_that_is_too_small_grows_to_the_counted_size() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let histogram = engine.open_view(soup(0, SIZE)).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        for name in [
            "linked_list/bma-list/insertion/compute/peak/pool25",
            "linearized/bma-list/insertion/compute/peak/pool25",
        ] {
            let technique: Technique = name.parse().expect("a technique");
            let result = verify(&mut *engine, &mut verifier, &technique).expect("it is supported");
            assert_eq!(result.verdict, Verdict::Exact, "{id} {name}: {:?}", result.note);
            assert_eq!(result.pool_grown, 1);
            assert_eq!(result.pool_initial, histogram.total().div_ceil(4));
            assert_eq!(result.pool_final, histogram.total());
        }
    }
}

#[test]
fn a_sort_that_cannot_hold_a_view_says_so() {
    let cache = support::cache();
    let mut engine = open_engine("cpu", cache.path()).expect("the CPU");
    engine.open_view(stack(80, SIZE)).expect("the view opens");
    let technique = "linked_list/bma-list/network/compute/peak".parse().expect("a technique");
    let Err(CellError::Unsupported(reason)) = engine.prepare(&technique) else {
        panic!("80 fragments are too many for a network of 64");
    };
    assert!(reason.contains("network holds 64"), "{reason}");
}
