//! Captures where many invocations store to few pixels at once, lanes of one subgroup among them: a
//! software device draws each pixel on one thread, so there no drawing brings this about. The same
//! WGSL is run as a compute shader instead.

use std::collections::BTreeSet;

use oit_capture::{Array3dNearest, LinkedListSorted, LinkedPages};
use oit_gpu::{Dispatch, Pass, Shader, Work};

use super::*;

const SIZE: (u32, u32) = (5, 1);
const INVOCATIONS: u32 = 64 * 256;

/// The pixel that an invocation stores to: all of them, by neighbours, and one of them twice.
fn pixel(invocation: u32) -> u32 {
    [0, 1, 2, 3, 4, 4][invocation as usize % 6]
}

/// How far an invocation's fragment is: all at different depths, and in no order.
fn depth_key(invocation: u32) -> u32 {
    0x8000_0000 | (invocation * 7919 % INVOCATIONS)
}

/// Runs what a capture does with each fragment in this many invocations, each of which stores its
/// number as a colour.
fn store(
    device: &mut dyn Device,
    capture: &dyn Capture,
    histogram: &DepthHistogram,
    pool: u64,
    invocations: u32,
) -> Ran {
    let geometry = &Geometry::new(&Mesh::default(), &UNLIT, &pixel_camera(8, 8), SIZE.0, SIZE.1);
    let request = &CaptureRequest { pool_slots: pool, ..request(geometry, SIZE, histogram) };
    let mut plan = capture_plan(capture, request);
    let capturing = plan.passes.last_mut().expect("a pass that captures");
    let Work::Raster(raster) = &capturing.work else { panic!("it draws") };
    let (before, _) = raster.shader.wgsl.split_once("@fragment").expect("a fragment shader");
    let wgsl = format!(
        "{before}
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let pixel = min(id.x % 6u, 4u);
            let depth_key = 0x80000000u | (id.x * 7919u % {INVOCATIONS}u);
            store_fragment(pixel, vec2<u32>(id.x, depth_key));
        }}"
    );
    let dispatch = Dispatch::Workgroups([invocations / 64, 1, 1]);
    *capturing = Pass::compute("capture", Shader::new("stores", wgsl), dispatch);
    let id = device.prepare(&plan).expect("the plan is sound");
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    let counted = words(&device.read(id, "counts").expect("reads"));
    let mut read = |name: &str| device.read(id, name);
    let mut reader =
        LfbReader { width_px: SIZE.0, height_px: SIZE.1, pool_slots: pool, read: &mut read };
    let usage = capture.usage(&mut reader).expect("reads");
    Ran { lfb: capture.unpack(&mut reader).expect("undamaged"), usage, counted }
}

/// The counts that so many invocations together come to.
fn all_counts(invocations: u32) -> Vec<u32> {
    let mut counts = vec![0; 5];
    (0..invocations).for_each(|i| counts[pixel(i) as usize] += 1);
    counts
}

/// Each fragment stored is an invocation's own, on its own pixel, once.
fn stored_once(lfb: &Lfb) -> usize {
    let mut seen = BTreeSet::new();
    for at in 0..lfb.pixels() {
        for fragment in lfb.pixel(at) {
            assert!(fragment.rgba < INVOCATIONS, "{fragment:?}");
            assert_eq!(pixel(fragment.rgba) as usize, at, "{fragment:?}");
            assert!(seen.insert(fragment.rgba), "{fragment:?} twice");
        }
    }
    seen.len()
}

#[test]
fn pages_lose_nothing_to_each_other() {
    on_every_device("contended pages", |device| {
        let counts = all_counts(INVOCATIONS);
        let histogram = &DepthHistogram::from_counts(counts.iter().copied());
        let total = u64::from(INVOCATIONS);
        // Without patience every fragment that finds a full page fetches one.
        for capture in [4, 6].into_iter().flat_map(|page| {
            [0, 1, 256].map(|tries| LinkedPages { tries, ..LinkedPages::new(page) })
        }) {
            let slots = capture.slots(&Demand { counts: &counts, histogram, lists: None });
            let room = total * u64::from(capture.page);
            let full = store(device, &capture, histogram, room, INVOCATIONS);
            assert_eq!(full.usage.fragments, total, "{capture:?}");
            assert_eq!(stored_once(&full.lfb) as u64, total, "{capture:?}");
            assert_eq!(full.counted, counts, "{capture:?}");
            say(&format!(
                "{}: {capture:?}: {} slots used of {slots} asked for",
                device.info().id,
                full.usage.slots
            ));
            for pool in [1, u64::from(capture.page), slots / 3] {
                let part = store(device, &capture, histogram, pool, INVOCATIONS);
                assert_eq!(part.usage.fragments, total, "{capture:?} in {pool}");
                assert!(part.usage.slots >= total, "{capture:?} in {pool}");
                let stored = stored_once(&part.lfb) as u64;
                let pages = pool / u64::from(capture.page);
                assert!(stored >= pages && stored <= pool, "{capture:?} in {pool}: {stored}");
                assert_eq!(part.counted, counts, "{capture:?} in {pool}");
            }
        }
    });
}

#[test]
fn the_nearest_push_the_others_on() {
    on_every_device("contended nearest", |device| {
        let counts = all_counts(INVOCATIONS);
        let histogram = &DepthHistogram::from_counts(counts.iter().copied());
        let capture = &Array3dNearest;
        if !supported(device).iter().any(|other| other.name() == capture.name()) {
            return;
        }
        for layers in [1, 5, 32] {
            let ran = store(device, capture, histogram, 5 * layers + 3, INVOCATIONS);
            assert_eq!(ran.usage.fragments, u64::from(INVOCATIONS));
            assert_eq!(ran.counted, counts);
            for at in 0..5 {
                let own = (0..INVOCATIONS).filter(|&i| pixel(i) == at);
                let mut nearest: Vec<_> =
                    own.map(|i| Fragment { rgba: i, depth_key: depth_key(i) }).collect();
                nearest.sort_by_key(|fragment| fragment.key());
                nearest.truncate(layers as usize);
                assert_eq!(ran.lfb.pixel(at as usize), nearest, "pixel {at}");
            }
        }
    });
}

/// Few enough that every fragment has turns to pass all others of its pixel on a software device.
const INSERTED: u32 = 64 * 32;

#[test]
fn a_sorted_list_loses_nothing_untold() {
    on_every_device("contended insertion", |device| {
        let name = LinkedListSorted::PATIENT.name();
        if !supported(device).iter().any(|other| other.name() == name) {
            return;
        }
        let (counts, total) = (all_counts(INSERTED), u64::from(INSERTED));
        let histogram = &DepthHistogram::from_counts(counts.iter().copied());
        let sorted = |at: u32| {
            let own = (0..INSERTED).filter(|&i| pixel(i) == at);
            let mut own: Vec<_> =
                own.map(|i| Fragment { rgba: i, depth_key: depth_key(i) }).collect();
            own.sort_by_key(|fragment| fragment.key());
            own
        };
        for _ in 0..4 {
            let capture = &LinkedListSorted::PATIENT;
            let ran = store(device, capture, histogram, total, INSERTED);
            assert_eq!(ran.usage, Usage { fragments: total, slots: total });
            assert_eq!(ran.counted, counts);
            for at in 0..5 {
                assert_eq!(ran.lfb.pixel(at as usize), sorted(at), "pixel {at}");
            }
            let part = store(device, capture, histogram, total / 3, INSERTED);
            assert_eq!(part.usage, Usage { fragments: total, slots: total });
            assert_eq!((stored_once(&part.lfb) as u64, part.counted), (total / 3, counts.clone()));
        }
        // Whoever runs out of turns is told of, and is in no list and no count.
        for turns in [0, 1, 40] {
            let room = 2 * total;
            let ran = store(device, &LinkedListSorted { turns }, histogram, room, INSERTED);
            let stored = stored_once(&ran.lfb) as u64;
            let lost = total - stored;
            assert!(lost > 0 && (stored > 0) == (turns > 0), "{turns} turns: {stored} stored");
            assert_eq!(ran.usage, Usage { fragments: total, slots: room + lost });
            assert!(ran.lfb.counts().eq(ran.counted), "{turns} turns");
        }
    });
}
