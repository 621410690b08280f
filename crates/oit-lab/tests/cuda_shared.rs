//! The stage `cuda` on fragments that stay where Vulkan captured them: captures into memory that is
//! shared, on every GPU that shares memory, and what CUDA reads there, where there is CUDA. With
//! `OIT_SHARE=0` in the environment the last test is of the copy that is resolved instead.

mod support;

use oit_capture::{CAPTURES, Capture, Demand, Geometry, LfbReader, count_plan};
use oit_cuda::{Cuda, CudaError, DeviceBuffer, SharedMemory};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Device, GpuError, Plan, PlanId, SharedBuffer};
use oit_lab::{
    CellError, Engine, Fragments, FrameSize, Sorted, Source, Technique, Verifier, ViewData,
    assemble, open_engine,
};
use oit_record::Verdict;

const SIZE: FrameSize = FrameSize { width_px: 61, height_px: 37 };

fn soup() -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let scene = oit_scene::load(&path.join("random_triangles.toml"), &Default::default());
    let scene = scene.expect("a scene of this repository");
    ViewData::new(&scene, "front", SIZE).expect("one of its views")
}

fn geometry(view: &ViewData) -> &Geometry {
    match &view.source {
        Source::Scene(scene) => &scene.geometry,
        Source::Stored(_) => panic!("a view of a scene"),
    }
}

/// A technique of the stage with each capture that CUDA reads.
fn techniques() -> Vec<Sorted> {
    let read = CAPTURES.iter().filter(|capture| capture.layout_cuda().is_some());
    let technique = |capture: &&'static dyn Capture| {
        let name = format!("{}/base/insertion/cuda/peak", capture.name());
        match name.parse() {
            Ok(Technique::Sorted(sorted)) => sorted,
            other => panic!("{name}: {other:?}"),
        }
    };
    read.map(technique).collect()
}

/// The buffers that a technique's resolve reads: the pointers of its layout's `struct Lfb`.
fn read_by(technique: &Sorted) -> Vec<&'static str> {
    let layout = oit_sort::CudaLayout {
        name: technique.capture.name(),
        source: technique.capture.layout_cuda().expect("one of `techniques`"),
        random_access: technique.capture.random_access(),
    };
    layout.buffers()
}

/// What a plan that has run left, its fragments in order.
fn unpacked(device: &mut dyn Device, id: PlanId, capture: &dyn Capture, pool_slots: u64) -> Lfb {
    let FrameSize { width_px, height_px } = SIZE;
    let mut read = |name: &str| device.read(id, name);
    let mut reader = LfbReader { width_px, height_px, pool_slots, read: &mut read };
    let mut lfb = capture.unpack(&mut reader).expect("it is whole");
    lfb.reorder(|fragments| fragments.sort_by_key(|fragment| fragment.key()));
    lfb
}

/// The view's fragments counted, and each technique's plan with the slots of its pool.
fn plans(device: &mut dyn Device, view: &ViewData) -> Vec<(Sorted, Plan, u64)> {
    let counting = count_plan(geometry(view), SIZE.width_px, SIZE.height_px);
    let id = device.prepare(&counting).expect("prepared");
    device.run(id).expect("ran");
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&device.read(id, "counts").expect("read"));
    let histogram = DepthHistogram::from_counts(counts.iter().copied());
    let plan = |technique: Sorted| {
        let demand = Demand { counts: &counts, histogram: &histogram, lists: None };
        let slots = technique.capture.slots(&demand);
        let drawn = Fragments::Drawn(geometry(view));
        let plan = assemble(&technique, drawn, SIZE, &histogram, slots).expect("it assembles");
        (technique, plan, slots)
    };
    techniques().into_iter().map(plan).collect()
}

/// A plan made ready with what its resolve reads shared, and run over poisoned buffers; or why not.
fn shared(device: &mut dyn Device, technique: &Sorted, plan: &Plan) -> Result<PlanId, String> {
    let id = match device.prepare_shared(plan, &read_by(technique)) {
        Err(GpuError::Unsupported(reason)) => return Err(reason),
        prepared => prepared.expect("prepared"),
    };
    device.poison(id).expect("poisoned");
    device.run(id).expect("ran");
    Ok(id)
}

#[test]
fn what_is_captured_in_shared_memory_is_what_is_captured_elsewhere() {
    let (view, cache) = (soup(), support::cache());
    for id in support::gpus() {
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        for (technique, plan, slots) in plans(&mut *device, &view) {
            let capture = technique.capture;
            let in_shared = match shared(&mut *device, &technique, &plan) {
                Ok(in_shared) => in_shared,
                Err(reason) => {
                    let listed = device.info().unsupported.iter();
                    let mut listed = listed.filter(|lacking| reason.contains(&lacking.reason));
                    assert!(listed.next().is_some(), "{id}: {reason}");
                    eprintln!("SKIPPED: {id}: {reason}");
                    break;
                }
            };
            let elsewhere = device.prepare(&plan).expect("prepared");
            device.poison(elsewhere).expect("poisoned");
            device.run(elsewhere).expect("ran");
            let expected = unpacked(&mut *device, elsewhere, capture, slots);
            assert!(expected.fragments().len() > 1000, "{technique}: hardly any fragments");
            let found = unpacked(&mut *device, in_shared, capture, slots);
            assert!(found == expected, "{id} {technique}: other fragments");
            for name in read_by(&technique) {
                let exported = device.export(in_shared, name).expect("it was asked for");
                assert_eq!(Some(exported.uuid), device.uuid(), "{id} {technique}");
                assert!(device.export(elsewhere, name).is_err(), "{id} {technique}: {name}");
            }
        }
    }
}

/// CUDA on a device, or `None` and a word on why not.
fn cuda(device: &dyn Device) -> Option<Cuda> {
    let id = &device.info().id;
    match Cuda::open(device.uuid()?) {
        Ok(cuda) => Some(cuda),
        Err(CudaError::Missing(reason)) => {
            eprintln!("SKIPPED: {id}: {reason}");
            None
        }
        Err(error) => panic!("{id}: {error}"),
    }
}

fn shared_memory(device: &dyn Device, id: PlanId, name: &str) -> SharedMemory {
    let exported = device.export(id, name).expect("it was asked for");
    let SharedBuffer { handle, uuid, memory_bytes, dedicated, offset_bytes, bytes } = exported;
    SharedMemory { handle, uuid, memory_bytes, dedicated, offset_bytes, bytes }
}

/// Files that this process has open.
fn open_files() -> usize {
    std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count)
}

#[test]
fn cuda_reads_what_vulkan_captured_where_it_is() {
    let (view, cache) = (soup(), support::cache());
    for id in support::gpus() {
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        let Some(cuda) = cuda(&*device) else { continue };
        for (technique, plan, _) in plans(&mut *device, &view) {
            let drawn = match shared(&mut *device, &technique, &plan) {
                Ok(drawn) => drawn,
                Err(reason) => {
                    eprintln!("SKIPPED: {id}: {reason}");
                    break;
                }
            };
            let imported: Vec<(&str, DeviceBuffer)> = read_by(&technique)
                .into_iter()
                .map(|name| {
                    let memory = shared_memory(&*device, drawn, name);
                    // SAFETY: the memory is as the device says, here and below.
                    let buffer = unsafe { cuda.import(name, memory) };
                    (name, buffer.unwrap_or_else(|error| panic!("{id} {technique}: {error}")))
                })
                .collect();
            let as_on_device = |device: &mut dyn Device, when: &str| {
                for (name, buffer) in &imported {
                    let expected = device.read(drawn, name).expect("read");
                    let found = cuda.read(buffer).expect("read");
                    assert!(found == expected, "{id} {technique}: {name} {when}");
                }
            };
            as_on_device(&mut *device, "as captured");
            let captured = cuda.read(&imported[0].1).expect("read");
            // No copy: what the device does next shows at once.
            device.poison(drawn).expect("poisoned");
            for (name, buffer) in &imported {
                let poisoned = cuda.read(buffer).expect("read");
                assert!(poisoned.iter().all(|&byte| byte == 0xCD), "{id} {technique}: {name}");
            }
            assert!(captured.iter().any(|&byte| byte != 0xCD), "{id} {technique}");
            device.run(drawn).expect("ran");
            as_on_device(&mut *device, "captured again");
        }
    }
}

#[test]
fn an_import_keeps_its_memory_and_closes_its_files() {
    let (view, cache) = (soup(), support::cache());
    for id in support::gpus() {
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        let Some(cuda) = cuda(&*device) else { continue };
        let (technique, plan, _) = plans(&mut *device, &view).swap_remove(0);
        let drawn = match shared(&mut *device, &technique, &plan) {
            Ok(drawn) => drawn,
            Err(reason) => {
                eprintln!("SKIPPED: {id}: {reason}");
                continue;
            }
        };
        let memory = |device: &dyn Device| shared_memory(device, drawn, "fragments");
        // SAFETY: the memory is as the device says, or refused for what is wrong with it.
        let import = |memory| unsafe { cuda.import("fragments", memory) };
        let before = open_files();
        for _ in 0..200 {
            drop(import(memory(&*device)).expect("imported"));
            let mut elsewhere = memory(&*device);
            elsewhere.uuid[0] ^= 1;
            let refused = import(elsewhere);
            assert!(matches!(refused, Err(CudaError::Missing(_))), "{id}: {refused:?}");
            let mut outside = memory(&*device);
            outside.offset_bytes = outside.memory_bytes;
            let refused = import(outside);
            assert!(matches!(refused, Err(CudaError::Driver { .. })), "{id}: {refused:?}");
        }
        // Other tests open files of their own meanwhile.
        assert!(open_files() < before + 100, "{id}: {before}, then {}", open_files());
        let kept = import(memory(&*device)).expect("imported");
        let expected = device.read(drawn, "fragments").expect("read");
        device.reset();
        drop(device);
        assert!(cuda.read(&kept).expect("read") == expected, "{id}: freed too early");
    }
}

/// Whether the note of a technique of the stage says what the device lets one expect.
fn tells(engine: &dyn Engine, note: Option<&str>) {
    let lacking = engine.info().unsupported.iter();
    let mut lacking = lacking.filter(|lacking| lacking.feature == "memory shared with CUDA");
    let note = note.expect("the stage tells which memory it reads");
    match lacking.next() {
        Some(lacking) => {
            assert!(note.contains("a copy") && note.contains(&lacking.reason), "{note}");
        }
        None => assert_eq!(note, "fragments are read from Vulkan's memory"),
    }
}

#[test]
fn techniques_are_exact_whatever_memory_they_read_and_say_which() {
    let (view, cache) = (soup(), support::cache());
    for id in support::gpus() {
        let mut engine = open_engine(&id, cache.path()).expect("a listed device opens");
        if engine.info().cuda.is_none() {
            eprintln!("SKIPPED: {id}: it has no CUDA");
            continue;
        }
        engine.open_view(view.clone()).expect("the view opens");
        let mut verifier = Verifier::new(&mut *engine).expect("the reference is captured");
        let stored = ViewData::stored(verifier.reference().clone());
        for view in [view.clone(), stored] {
            engine.open_view(view).expect("the view opens");
            let mut prepared = Vec::new();
            for technique in techniques() {
                let technique = Technique::Sorted(technique);
                match engine.prepare(&technique) {
                    Ok((ready, preparation)) => prepared.push((technique, ready, preparation)),
                    Err(CellError::Unsupported(reason)) => {
                        eprintln!("SKIPPED: {id} {technique}: {reason}");
                    }
                    Err(CellError::Failed(reason)) => panic!("{id} {technique}: {reason}"),
                }
            }
            assert!(!prepared.is_empty(), "{id}: nothing was resolved");
            // One after the other, as samples are taken: each resolves what its own capture left.
            for _ in 0..2 {
                for (technique, ready, preparation) in &prepared {
                    engine.run(*ready).expect("it runs");
                    let result = verifier
                        .verify(&mut *engine, technique, *ready, preparation)
                        .unwrap_or_else(|error| panic!("{id} {technique}: {error}"));
                    let note = result.note.as_deref();
                    assert_eq!(result.verdict, Verdict::Exact, "{id} {technique}: {note:?}");
                    tells(&*engine, note);
                }
            }
        }
    }
}
