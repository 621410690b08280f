//! Every capture x schedule x sort x stage x tie rule on every device, against the oracle; the
//! order of submission shuffled; pixels deeper than the array; pools that are too small. And every method.

mod support;

use oit_capture::{Accuracy, CAPTURES, Geometry, Method, MethodRequest, WIDE};
use oit_fragments::{DepthHistogram, Lfb, Ties, oracle};
use oit_gpu::Plan;
use oit_lab::{
    CellError, Engine, FrameSize, IntervalChoice, MaxFrags, MethodChoice, Pool, Schedule, Sorted,
    Source, Stage, Technique, Verifier, ViewData, methods, open_engine, parse_method,
};
use oit_record::{Verdict, Verification};
use oit_scene::{
    Atom, Camera, Level, Mesh, Object, Projection, Scene, Spheres, SplitMix64, shuffle_triangles,
};
use oit_sort::{STRATEGIES, SortChoice, SortSpec, SortStrategy, store_name};

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

/// A cloud of spheres that overlap, are cut off by the near plane, or lie beside the picture or behind
/// the camera; no two of one colour.
fn spheres(size: FrameSize) -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let overrides = "alpha = 0.3\ncount = 1".parse::<toml::Table>().expect("TOML");
    let scene = oit_scene::load(&path.join("sphere_stack.toml"), &overrides.into_iter().collect());
    let mut scene: Scene = scene.expect("a scene of this repository");
    let mut random = SplitMix64::new(5);
    let mut cloud = Spheres::clone(scene.spheres.as_ref().expect("a scene of spheres"));
    let (object, first) = (cloud.objects[0], cloud.atoms.len() as u32);
    for atom in 0..400u32 {
        let center = [0; 3].map(|_| random.between(-2.0, 2.0));
        let radius = if atom % 9 == 0 { 0.8 } else { random.between(0.02, 0.2) };
        cloud.atoms.push(Atom { center, radius });
        cloud.atom_rgba.push([atom as u8, (atom >> 8) as u8, random.below(256) as u8, 100]);
    }
    cloud.levels = vec![Level { first_atom: first, atoms: 400, from_distance: 0.0 }];
    (cloud.kinds[0].first_level, cloud.kinds[0].levels) = (0, 1);
    cloud.objects = vec![Object { kind: 0, position: [0.0; 3], rgba: [255; 4], ..object }];
    scene.spheres = Some(cloud.into());
    let projection = Projection::Perspective { fov_y_degrees: 60.0, near: 0.5, far: 4.0 };
    scene.views[0].camera =
        Camera { eye: [0.2, 0.1, 1.8], target: [0.0; 3], up: [0.0, 1.0, 0.0], projection };
    let view = scene.views[0].name.clone();
    ViewData::new(&scene, &view, size).expect("its view")
}

/// Every sort alone, in each of its stores.
fn all_sorts() -> Vec<SortChoice> {
    let stores = STRATEGIES
        .iter()
        .flat_map(|strategy| strategy.stores().iter().map(|&store| store_name(*strategy, store)));
    stores.map(|sort| sort.parse().expect("a sort")).collect()
}

/// Every technique with the first capture, and every capture with a few sorts: what a capture leaves
/// is compared fragment by fragment, so that a sort need not meet them all.
fn all_techniques() -> Vec<Sorted> {
    let few: Vec<SortChoice> = ["insertion", "passthrough", "network+rbs"]
        .map(|sort| sort.parse().expect("a sort"))
        .into();
    let mut techniques = Vec::new();
    for (place, &capture) in CAPTURES.iter().enumerate() {
        let sorts = if place == 0 { all_sorts() } else { few.clone() };
        let all_ties = if place == 0 { &Ties::ALL[..] } else { &[Ties::Total] };
        for (schedule, ..) in Schedule::ALL {
            for sort in &sorts {
                for stage in Stage::ALL {
                    for &ties in all_ties {
                        techniques.push(Sorted {
                            capture,
                            schedule,
                            sort: sort.clone(),
                            stage,
                            max_frags: MaxFrags::Peak,
                            ties,
                            pool: Pool::WHOLE,
                            intervals: IntervalChoice::PowersOfTwo,
                        });
                    }
                }
            }
        }
    }
    // In compute there is no stencil, in CUDA no schedule but one.
    techniques.retain(|t| t.stage.has(t.schedule));
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
            for technique in all_techniques() {
                let Some(result) = verify(&mut *engine, &mut verifier, &technique.clone().into())
                else {
                    continue;
                };
                let sorted = technique.capture.delivers_sorted();
                let inexact = technique.sort.parts().iter().any(|part| {
                    !(part.strategy.sorts() || sorted) || part.strategy.error_bound().is_some()
                });
                let expected = if inexact { Verdict::Approximate } else { Verdict::Exact };
                assert_eq!(result.verdict, expected, "{id} {technique}: {:?}", result.note);
                ran += 1;
            }
        }
        println!("{id}: {ran} cells");
        assert!(ran > 40, "{id} ran {ran} cells");
    }
}

/// Spheres in place of triangles: every capture under every schedule, every sort, and every method.
#[test]
fn spheres_go_through_every_technique() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let histogram = engine.open_view(spheres(SIZE)).expect("the view opens");
        assert!(histogram.peak() > 8, "{histogram:?}");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let techniques = all_techniques().into_iter().filter(|technique| {
            let sort = technique.sort.to_string();
            technique.ties == Ties::Total
                && (sort == "insertion" || technique.schedule == Schedule::Base)
        });
        let mut captures = Vec::new();
        for technique in techniques {
            let named = technique.clone().into();
            let Some(result) = verify(&mut *engine, &mut verifier, &named) else { continue };
            let inexact = technique.sort.parts().iter().any(|part| {
                let unsorted = !part.strategy.sorts() && !technique.capture.delivers_sorted();
                unsorted || part.strategy.error_bound().is_some()
            });
            let expected = if inexact { Verdict::Approximate } else { Verdict::Exact };
            assert_eq!(result.verdict, expected, "{id} {technique}: {:?}", result.note);
            captures.push((technique.capture.name(), technique.schedule));
        }
        captures.dedup();
        assert!(
            captures
                .iter()
                .any(|(_, schedule)| id == "cpu" || *schedule == Schedule::BmaStencilCount)
        );
        let mut exact = 0;
        for choice in all_methods() {
            let technique = choice.into();
            let Some(result) = verify(&mut *engine, &mut verifier, &technique) else { continue };
            let expected = match choice.accuracy(&histogram) {
                Accuracy::Exact | Accuracy::ExactWithoutTies => Verdict::Exact,
                Accuracy::Approximate(_) => Verdict::Approximate,
            };
            assert_eq!(result.verdict, expected, "{id} {choice}: {result:?}");
            exact += u32::from(result.verdict == Verdict::Exact);
        }
        println!("{id}: {} captures and schedules, {exact} methods exact", captures.len());
        assert!(captures.len() > 5 && exact > 3, "{id}: {} {exact}", captures.len());
    }
}

/// Sorting where the fragments were captured (RBS-G) leaves the same fragments in another order.
#[test]
fn fragments_are_sorted_where_they_were_captured() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let histogram = engine.open_view(stack(40, SIZE)).expect("the view opens");
        assert_eq!(histogram.peak(), 40);
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let mut ran = Vec::new();
        for capture in CAPTURES {
            for coordinate in [
                "base/rbs16-global/compute",
                "bma-list/rbs8-global/compute",
                "bma-stencil/rbs8-global/fragment",
            ] {
                let name = format!("{}/{coordinate}/peak", capture.name());
                let technique: Technique = name.parse().expect("a technique");
                match engine.prepare(&technique) {
                    Ok((ready, preparation)) => {
                        let result = verifier.verify(&mut *engine, &technique, ready, &preparation);
                        let result = result.unwrap_or_else(|error| panic!("{id} {name}: {error}"));
                        assert_eq!(
                            result.verdict,
                            Verdict::Exact,
                            "{id} {name}: {:?}",
                            result.note
                        );
                        ran.push(capture.name());
                    }
                    Err(CellError::Unsupported(reason)) => println!("{id} {name}: {reason}"),
                    Err(CellError::Failed(reason)) => panic!("{id} {name}: {reason}"),
                }
            }
        }
        for capture in CAPTURES.iter().filter(|capture| capture.rewrite_wgsl().is_some()) {
            assert!(ran.contains(&capture.name()), "{id}: {}", capture.name());
        }
        let stored = ViewData::stored(verifier.reference().clone());
        engine.open_view(stored).expect("it opens");
        let technique = "linked_list/base/rbs8-global/compute/peak".parse().expect("a technique");
        let refused = engine.prepare(&technique).expect_err("it would spoil what is uploaded");
        assert!(matches!(refused, CellError::Unsupported(_)), "{refused}");
    }
}

/// Fragments sorted as they were captured need no sort: what does not sort is judged as exact, and is
/// found wrong where its order is.
#[test]
fn what_was_sorted_during_capture_is_exact_unsorted() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        engine.open_view(stack(40, SIZE)).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let mut ran = 0;
        for capture in CAPTURES.iter().filter(|capture| capture.delivers_sorted()) {
            for rest in [
                "base/passthrough/compute/peak",
                "base/unsorted/compute/peak",
                "bma-list/passthrough/compute/peak/ties-depth",
                "bma-stencil/passthrough/fragment/peak",
                "base/passthrough/compute/peak/pool40",
                "base/passthrough/compute/peak/pool40-drop",
            ] {
                let name = format!("{}/{rest}", capture.name());
                let technique: Technique = name.parse().expect("a technique");
                let Some(result) = verify(&mut *engine, &mut verifier, &technique) else {
                    continue;
                };
                let dropped = result.fragments_missing > 0;
                assert_eq!(dropped, rest.ends_with("drop"), "{id} {name}");
                let expected = if dropped { Verdict::Approximate } else { Verdict::Exact };
                assert_eq!(result.verdict, expected, "{id} {name}: {:?}", result.note);
                assert_eq!(result.pool_grown, u32::from(rest.ends_with("pool40")), "{id} {name}");
                ran += 1;
            }
            // Cut short, it is as inexact as any.
            let name = format!("{}/base/passthrough/compute/max12", capture.name());
            let technique: Technique = name.parse().expect("a technique");
            if let Some(result) = verify(&mut *engine, &mut verifier, &technique) {
                assert_eq!(result.verdict, Verdict::Approximate, "{id} {name}");
            }
        }
        println!("{id}: {ran} cells");
        assert!(ran >= 6 || id != "cpu", "{id} ran {ran}");
        let technique: Technique =
            "linked_list/base/passthrough/compute/peak".parse().expect("a technique");
        let result = verify(&mut *engine, &mut verifier, &technique).expect("it is supported");
        assert_eq!(result.verdict, Verdict::Approximate, "{id}: {:?}", result.note);
    }
}

/// Fragments of 128 bits, sorted whole or by index, give the same picture; what cannot sort them is
/// refused, with the reason.
#[test]
fn fragments_of_128_bits_are_exact() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        for view in [soup(0, SIZE), stack(40, SIZE)] {
            engine.open_view(view).expect("the view opens");
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            let mut check = |name: String, refusal: Option<&str>| {
                let technique: Technique = name.parse().expect("a technique");
                match (engine.prepare(&technique), refusal) {
                    (Ok((ready, preparation)), None) => {
                        let result = verifier.verify(&mut *engine, &technique, ready, &preparation);
                        let result = result.unwrap_or_else(|error| panic!("{id} {name}: {error}"));
                        let (verdict, note) = (result.verdict, result.note);
                        assert_eq!(verdict, Verdict::Exact, "{id} {name}: {note:?}");
                        assert!(result.fragments_compared, "{id} {name}");
                    }
                    (Err(CellError::Unsupported(reason)), Some(part)) => {
                        assert!(reason.contains(part), "{id} {name}: {reason}");
                    }
                    (result, _) => panic!("{id} {name}: {:?}", result.map(|_| ())),
                }
            };
            for capture in WIDE {
                let name = capture.name();
                for rest in [
                    "base/rbs8/compute/peak/ties-depth",
                    "bma-list/insertion/compute/peak/ties-depth",
                    "bma-stencil/insertion/fragment/peak/ties-depth",
                    "base-stencil/merge/fragment/peak/ties-depth/pool30",
                ] {
                    check(format!("{name}/{rest}"), None);
                }
                let global = format!("{name}/base/rbs8-global/compute/peak/ties-depth");
                check(global, Some("cannot be written back to"));
            }
            for sort in ["insertion", "merge", "rbs8"] {
                check(format!("linked_list128/base/{sort}/compute/peak"), None);
                let indirect = format!("linked_list128_indirect/base/{sort}/compute/peak");
                check(indirect, Some("use ties-depth"));
            }
            for sort in ["network", "heap", "insertion-workgroup"] {
                let direct = format!("linked_list128/base/{sort}/compute/peak/ties-depth");
                check(direct, Some("holds fragments of 64 bits"));
            }
            for sort in ["heap", "insertion-workgroup"] {
                let indirect =
                    format!("linked_list128_indirect/base/{sort}/compute/peak/ties-depth");
                check(indirect, None);
            }
        }
    }
    let cache = support::cache();
    let mut engine = open_engine("cpu", cache.path()).expect("the CPU");
    engine.open_view(soup(0, SIZE)).expect("the view opens");
    let technique = "linked_list128/base/rbs/compute/peak".parse().expect("a technique");
    let refused = engine.prepare(&technique).expect_err("its twin has another fragment");
    assert!(matches!(refused, CellError::Unsupported(_)), "{refused}");
}

/// A kernel that ends early is off by what it says, no more, and not exact.
#[test]
fn sorts_that_end_early_keep_their_bound() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        engine.open_view(stack(60, SIZE)).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        for sort in ["selection_early", "heap_early"] {
            let name = format!("linked_list/bma-list/{sort}/compute/peak");
            let technique: Technique = name.parse().expect("a technique");
            let result = verify(&mut *engine, &mut verifier, &technique).expect("it is supported");
            assert_eq!(result.verdict, Verdict::Approximate, "{id} {name}: {:?}", result.note);
            let error = result.max_error.max(result.max_alpha_error);
            assert!(error > 1e-4 && error <= 1.0 / 512.0 + 1e-5, "{id} {name}: {error}");
        }
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
            assert!(result.peak_bytes > Some(result.memory_bytes), "both pools were there at once");
        }
    }
}

/// Left out is what has no room, and nothing else; what is left is still blended in order, though a
/// pixel then has fewer fragments than were counted for it.
#[test]
fn a_pool_that_may_not_grow_drops_what_has_no_room() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        for view in [soup(0, SIZE), stack(30, SIZE)] {
            let total = engine.open_view(view).expect("the view opens").total();
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            for (capture, percent) in CAPTURES
                .iter()
                .flat_map(|capture| [25, 60, 100, 150].map(|percent| (capture, percent)))
            {
                for rest in [
                    "base/insertion/compute/peak",
                    "base-stencil/rbs/fragment/peak",
                    "bma-list/network+rbs/compute/peak",
                    "bma-stencil/insertion_merge/fragment/peak",
                ] {
                    let name = format!("{}/{rest}/pool{percent}-drop", capture.name());
                    let technique: Technique = name.parse().expect("a technique");
                    let Some(result) = verify(&mut *engine, &mut verifier, &technique) else {
                        continue;
                    };
                    let missing = result.fragments_missing;
                    let verdict = if missing > 0 { Verdict::Approximate } else { Verdict::Exact };
                    assert_eq!(result.verdict, verdict, "{id} {name}: {:?}", result.note);
                    assert_eq!(result.fragments_extra, 0, "{id} {name}");
                    assert_eq!(result.pool_grown, 0, "{id} {name}");
                    if percent >= 100 {
                        assert_eq!(missing, 0, "{id} {name}");
                    } else if ["linked_list", "linearized"].contains(&capture.name()) {
                        let room = (total * percent).div_ceil(100);
                        assert_eq!(missing, total - room, "{id} {name}");
                        assert!(result.wrong_px > 0, "{id} {name}");
                    }
                }
            }
        }
    }
}

/// The same fragments from a buffer that was captured before, on every layout.
#[test]
fn stored_fragments_are_resolved_as_drawn_ones() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        engine.open_view(soup(0, SIZE)).expect("the view opens");
        let drawn = Verifier::new(&mut *engine).expect("the reference is captured");
        let stored = ViewData::stored(drawn.reference().clone());
        let histogram = engine.open_view(stored).expect("the view opens");
        assert_eq!(histogram, drawn.reference().histogram());
        let mut verifier = Verifier::new(&mut *engine).expect("it is its own reference");
        assert_eq!(verifier.picture(), drawn.picture());
        let mut ran = 0;
        for technique in all_techniques() {
            if technique.sort.to_string() != "insertion" || technique.ties == Ties::Depth {
                continue;
            }
            let technique = technique.into();
            let Some(result) = verify(&mut *engine, &mut verifier, &technique) else { continue };
            assert_eq!(result.verdict, Verdict::Exact, "{id} {technique}: {:?}", result.note);
            ran += 1;
        }
        let every = if id == "cpu" { 2 } else { 5 };
        assert!(ran >= every * 2, "{id} ran {ran} cells");
    }
}

/// Every method in its default size, and in one that is mostly too small.
fn all_methods() -> Vec<MethodChoice> {
    let sizes = |method: &'static dyn Method| {
        [None, method.size().map(|_| 2)].map(|size| MethodChoice { method, size })
    };
    let mut choices: Vec<MethodChoice> = methods().flat_map(sizes).collect();
    choices.dedup_by_key(|choice| choice.to_string());
    choices
}

/// The soup, and a part of its triangles once more, so that some of its fragments share their depths.
fn half_tied() -> ViewData {
    let mut view = soup(0, SIZE);
    let Source::Scene(scene) = &mut view.source else { panic!("it is drawn") };
    let mut mesh: Mesh = (*scene.mesh).clone();
    let again = mesh.indices[..mesh.indices.len() / 24 * 3].to_vec();
    mesh.indices.extend(again);
    scene.geometry =
        Geometry::new(&mesh, &scene.shading, &scene.camera, SIZE.width_px, SIZE.height_px);
    scene.mesh = mesh.into();
    view
}

#[test]
fn every_method_is_as_accurate_as_it_says() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        for (view, is_tied) in [(soup(0, SIZE), false), (half_tied(), true)] {
            let histogram = engine.open_view(view).expect("the view opens");
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            let shared_px = {
                let shared = oracle::depth_shared_pixels(verifier.reference());
                shared.iter().filter(|shared| **shared).count() as u64
            };
            assert_eq!(shared_px > 0, is_tied);
            assert!(shared_px < histogram.covered() / 2, "{shared_px} of {}", histogram.covered());
            let (mut ran, mut exact, mut lost) = (0, 0, 0);
            for choice in all_methods() {
                let technique = choice.into();
                let Some(result) = verify(&mut *engine, &mut verifier, &technique) else {
                    continue;
                };
                let what = format!("{id} {choice}: {result:?}");
                let accuracy = choice.accuracy(&histogram);
                let (verdict, tied_px) = match accuracy {
                    Accuracy::Exact => (Verdict::Exact, 0),
                    Accuracy::ExactWithoutTies => (Verdict::Exact, shared_px),
                    Accuracy::Approximate(_) => (Verdict::Approximate, 0),
                };
                assert_eq!((result.verdict, result.tied_px), (verdict, tied_px), "{what}");
                assert!(!result.fragments_compared && result.max_frags == 0, "{what}");
                assert!(result.repeat_differs_px.is_some(), "{what}");
                assert_eq!(result.memory_bytes > 0, id != "cpu", "{what}");
                assert_eq!(result.lfb_bytes, None, "{what}");
                exact += u32::from(verdict == Verdict::Exact);
                lost += u32::from(tied_px > 0 && result.wrong_px > 0);
                ran += 1;
            }
            println!("{id}: {ran} methods, {exact} exact, {lost} lose fragments at one depth");
            assert!(ran > 10 && exact > 3, "{id} ran {ran}");
            assert_eq!(lost > 0, is_tied, "{id}");
            if id == "cpu" {
                assert_eq!(ran, all_methods().len());
            }
        }
        let verifier = {
            engine.open_view(soup(0, SIZE)).expect("the view opens");
            Verifier::new(&mut *engine).expect("the reference is captured")
        };
        engine.open_view(ViewData::stored(verifier.reference().clone())).expect("it opens");
        for choice in all_methods() {
            let refused = engine.prepare(&choice.into()).expect_err("there is nothing to draw");
            let CellError::Unsupported(reason) = refused else { panic!("{refused}") };
            assert!(reason.contains("draws the scene itself"), "{reason}");
        }
    }
}

/// A method that says of itself what it is not.
struct Boasting(&'static dyn Method, Accuracy);

impl Method for Boasting {
    fn name(&self) -> &'static str {
        "boasting"
    }

    fn summary(&self) -> &'static str {
        self.0.summary()
    }

    fn citation(&self) -> &'static str {
        self.0.citation()
    }

    fn accuracy(&self, _: Option<u32>, _: &DepthHistogram) -> Accuracy {
        self.1.clone()
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        self.0.build(request)
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        self.0.twin(size, submitted)
    }
}

#[test]
fn a_method_that_is_less_accurate_than_it_says_is_wrong() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        engine.open_view(half_tied()).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let named = |name: &str| parse_method(name).expect("a method").method;
        for (name, accuracy, verdict) in [
            ("weighted", Accuracy::Exact, Verdict::Wrong),
            ("weighted", Accuracy::ExactWithoutTies, Verdict::Wrong),
            ("depth_peel", Accuracy::Exact, Verdict::Wrong),
            ("depth_peel", Accuracy::ExactWithoutTies, Verdict::Exact),
        ] {
            let what = format!("{id} {name} {accuracy:?}");
            let method: &'static dyn Method = Box::leak(Box::new(Boasting(named(name), accuracy)));
            let technique = MethodChoice::new(method).into();
            let result = verify(&mut *engine, &mut verifier, &technique).expect("it is supported");
            assert_eq!(result.verdict, verdict, "{what}: {:?}", result.note);
            assert!(result.wrong_px > 0 && result.note.is_some(), "{what}");
        }
    }
}

/// Deep pixels of a list and of a layout with random access, whole and cut off, where the lanes of a subgroup share them.
#[test]
fn cooperating_lanes_resolve_deep_pixels() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let subgroup = engine.info().subgroup_size.map_or(0, |(min, _)| min);
        engine.open_view(stack(100, SIZE)).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let lanes = |sort: &dyn SortStrategy| {
            let (ties, store) = (Ties::Total, sort.stores()[0]);
            sort.lanes(&SortSpec { min_frags: 1, max_frags: 128, ties, store })
        };
        let mut ran = 0;
        let holds = |sort: &dyn SortStrategy| sort.limit().is_none_or(|limit| limit >= 128);
        for sort in STRATEGIES.iter().filter(|&&sort| lanes(sort) > 1 && holds(sort)) {
            for capture in ["linked_list", "linearized"] {
                for (schedule, max_frags, verdict) in
                    [("bma-list", "peak", Verdict::Exact), ("base", "max75", Verdict::Approximate)]
                {
                    let name = format!("{capture}/{schedule}/{}/compute/{max_frags}", sort.name());
                    let technique: Technique = name.parse().expect("a technique");
                    let result = verify(&mut *engine, &mut verifier, &technique);
                    let fits = lanes(*sort) <= subgroup || id == "cpu";
                    assert_eq!(result.is_some(), fits, "{id} {name}");
                    let Some(result) = result else { continue };
                    assert_eq!(result.verdict, verdict, "{id} {name}: {:?}", result.note);
                    assert!(result.wrong_px > 0 || verdict == Verdict::Exact, "{id} {name}");
                    ran += 1;
                }
            }
        }
        println!("{id}: {ran} cells");
        assert!(ran > 0 || subgroup < 4, "{id}");
        let technique = "linked_list/base/cooperative4/fragment/peak".parse().expect("one");
        let Err(CellError::Unsupported(reason)) = engine.prepare(&technique) else {
            panic!("{id}: a fragment shader has one invocation to a pixel");
        };
        assert!(id == "cpu" || reason.contains("4 invocations to a pixel"), "{reason}");
    }
}

/// Up to the interval that begins at 129, which takes pixels that a stencil of 8 bits cannot tell
/// apart; not further.
#[test]
fn a_stencil_counts_as_far_as_it_goes() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let technique: Technique =
            "linked_list/bma-stencil-count/rbs/fragment/peak".parse().expect("a technique");
        for (count, supported) in [(5, true), (129, true), (256, true), (257, false)] {
            engine.open_view(stack(count, SIZE)).expect("the view opens");
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            if supported {
                let result = verify(&mut *engine, &mut verifier, &technique).expect("supported");
                assert_eq!(result.verdict, Verdict::Exact, "{id} {count}: {:?}", result.note);
            } else {
                let Err(CellError::Unsupported(reason)) = engine.prepare(&technique) else {
                    panic!("{count} fragments are more than the stencil counts");
                };
                assert!(reason.contains("255") && reason.contains("257"), "{reason}");
            }
        }
    }
}

/// Where an interval's program has another workgroup than 64 invocations, its dispatch must have so
/// many more workgroups: at 250 fragments these have 16 and 8.
#[test]
fn intervals_are_dispatched_by_the_workgroups_of_their_programs() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        engine.open_view(stack(250, SIZE)).expect("the view opens");
        for name in [
            "linked_list/bma-list/insertion-workgroup/compute/peak",
            "linked_list/base/merge-workgroup/compute/peak",
            "linearized/bma-list/insertion_merge-workgroup/compute/peak",
            "linked_list/bma-list/rs+insertion-workgroup/compute/peak",
        ] {
            let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
            let technique: Technique = name.parse().expect("a technique");
            let result = verify(&mut *engine, &mut verifier, &technique).expect("supported");
            assert_eq!(result.verdict, Verdict::Exact, "{id} {name}: {:?}", result.note);
        }
        let technique = "linked_list/base/merge-workgroup/fragment/peak".parse();
        let Err(CellError::Unsupported(reason)) = engine.prepare(&technique.expect("a technique"))
        else {
            panic!("a fragment shader has no workgroup");
        };
        assert!(id == "cpu" || reason.contains("no workgroup"), "{reason}");
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

/// Given intervals, and a sort for each: whatever they are, the picture is the same.
#[test]
fn any_intervals_with_any_sorts_are_exact() {
    for id in devices() {
        let cache = support::cache();
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        let peak = engine.open_view(soup(0, SIZE)).expect("the view opens").peak();
        assert!((5..=40).contains(&peak), "{peak}");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        for capture in ["linked_list", "linearized_blend", "interleaved_lists"] {
            for rest in [
                "bma-list/insertion@4+merge@9+rbs/compute/peak/intervals1-4-5-9",
                "bma-list/insertion/compute/peak/intervals2",
                "bma-list/network/compute/max64/intervals3-4096",
                "bma-stencil/insertion@4+merge/fragment/peak/intervals1-4-5",
                "bma-stencil-count/insertion_merge64/fragment/peak/intervals2-3",
            ] {
                let name = format!("{capture}/{rest}");
                let technique: Technique = name.parse().expect("a technique");
                let Some(result) = verify(&mut *engine, &mut verifier, &technique) else {
                    continue;
                };
                assert_eq!(result.verdict, Verdict::Exact, "{id} {name}: {:?}", result.note);
                assert!(result.max_frags >= peak, "{id} {name}");
            }
        }
    }
}
