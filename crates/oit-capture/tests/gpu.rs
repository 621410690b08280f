//! Captures on every device of this machine, against each other and against the CPU rasteriser.
//!
//! Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.

#[path = "gpu/contended.rs"]
mod contended;
#[path = "gpu/early_tests.rs"]
mod early_tests;
#[path = "gpu/readers.rs"]
mod readers;
#[path = "gpu/spheres.rs"]
mod spheres;
mod support;

use std::collections::BTreeMap;
use std::io::Write;

use glam::{DMat3, DVec3};
use oit_capture::{
    CAPTURES, Capture, CaptureRequest, Demand, Frame, Geometry, InterleavedLists, LfbReader, Usage,
    count_plan, rasterize,
};
use oit_fragments::{DepthHistogram, Fragment, Lfb};
use oit_gpu::{Device, GpuError};
use oit_scene::{Mesh, Shading, SplitMix64, Stripes, Vertex, shuffle_triangles};
use support::*;

/// Runs a test on every device that can be opened.
fn on_every_device(test: &str, mut run: impl FnMut(&mut dyn Device)) {
    let cache = tempfile::tempdir().expect("a folder for pipelines");
    let mut ran = 0;
    for listed in oit_gpu::enumerate() {
        let open = |_| oit_gpu::open(&listed.id, cache.path()).map_err(|error| error.to_string());
        match listed.info.and_then(open) {
            Ok(mut device) => {
                run(device.as_mut());
                ran += 1;
            }
            Err(reason) => say(&format!("{test}: skipped on {}: {reason}", listed.id)),
        }
    }
    if ran == 0 {
        let required = std::env::var("OIT_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "{test}: OIT_REQUIRE_GPU is set and no device can be used");
        say(&format!("{test}: SKIPPED, no device can be used"));
    }
}

/// Past the test harness, which keeps back what passing tests print.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr");
}

/// The captures that this device can run; the others are named, with the reason.
fn supported(device: &mut dyn Device) -> Vec<&'static dyn Capture> {
    let geometry = &Geometry::new(&soup(&[[[0.0; 3]; 3]]), &UNLIT, &pixel_camera(8, 8), 8, 8);
    let histogram = &DepthHistogram::default();
    let supports = |capture: &&&dyn Capture| {
        let request = request(geometry, (8, 8), histogram);
        match device.prepare(&capture_plan(**capture, &request)) {
            Ok(_) => true,
            Err(GpuError::Unsupported(reason)) => {
                let id = &device.info().id;
                say(&format!("{}: SKIPPED on {id}: {reason}", capture.name()));
                false
            }
            Err(error) => panic!("{}: {error}", capture.name()),
        }
    };
    CAPTURES.iter().filter(supports).copied().collect()
}

/// One view to capture, and what the count pass found on it.
struct View<'a> {
    geometry: &'a Geometry,
    size: (u32, u32),
    counts: Vec<u32>,
    histogram: DepthHistogram,
}

impl<'a> View<'a> {
    fn new(device: &mut dyn Device, geometry: &'a Geometry, size: (u32, u32)) -> Self {
        let id = device.prepare(&count_plan(geometry, size.0, size.1)).expect("the plan is sound");
        device.poison(id).expect("fills");
        device.run(id).expect("runs");
        let counts = words(&device.read(id, "counts").expect("reads"));
        let histogram = DepthHistogram::from_counts(counts.iter().copied());
        Self { geometry, size, counts, histogram }
    }

    fn total(&self) -> u64 {
        self.histogram.total()
    }

    /// Slots that a capture needs.
    fn slots(&self, capture: &dyn Capture) -> u64 {
        let (_, lists) = grouping(capture, self.size);
        let lists = capture.needs_lists().then_some(&lists);
        let demand = Demand { counts: &self.counts, histogram: &self.histogram, lists };
        capture.slots(&demand)
    }
}

/// Whether a pool of this size is what a capture needed: all of it, and little more.
fn needs(slots: u64, used: u64) -> bool {
    used <= slots && slots - used <= used / 32
}

/// What a run of a capture left.
struct Ran {
    lfb: Lfb,
    usage: Usage,
    /// The counts as a schedule reads them.
    counted: Vec<u32>,
}

/// Runs a capture with this many slots.
fn run(device: &mut dyn Device, capture: &dyn Capture, view: &View, pool_slots: u64) -> Ran {
    let request = &CaptureRequest {
        pool_slots: pool_slots.max(1),
        ..request(view.geometry, view.size, &view.histogram)
    };
    let mut plan = capture_plan(capture, request);
    let pixels = view.size.0 * view.size.1;
    let wgsl = format!(
        "{}
        @group(0) @binding(16) var<storage, read_write> pixel_counts: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let pixel = id.y * 32768u * 64u + id.x;
            if (pixel < {pixels}u) {{ pixel_counts[pixel] = pixel_count(pixel); }}
        }}",
        capture.count_wgsl()
    );
    plan.buffers.push(oit_gpu::Buffer::new("pixel_counts", 4 * u64::from(pixels)));
    let groups = pixels.div_ceil(64);
    let dispatch = oit_gpu::Dispatch::Workgroups([groups.min(32768), groups.div_ceil(32768), 1]);
    let shader = oit_gpu::Shader::new("copy counts", wgsl);
    plan.passes.push(oit_gpu::Pass::compute("group", shader, dispatch));

    let id = device.prepare(&plan).expect("the plan is sound");
    // Twice, so that what a run leaves behind is seen not to matter.
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    device.run(id).expect("runs");
    let counted = words(&device.read(id, "pixel_counts").expect("reads"));
    let mut read = |name: &str| device.read(id, name);
    let mut reader = LfbReader {
        width_px: request.width_px,
        height_px: request.height_px,
        pool_slots: request.pool_slots,
        read: &mut read,
    };
    let usage = capture.usage(&mut reader).expect("reads");
    Ran { lfb: capture.unpack(&mut reader).expect("undamaged"), usage, counted }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
}

/// Of a million fragments, how many may be the device's or the CPU's alone: those on edges that
/// clipping moves (see [`coverage_and_depth_are_the_cpus`]).
const MOVED_PER_MILLION: u64 = 200;

/// The same for triangles that are not clipped. Lavapipe has none at all.
const MOVED_IN_VIEW_PER_MILLION: u64 = 20;

/// How far apart depths may be where fragments are paired: some of the triangles are steep.
const DEPTH: f32 = 5e-3;

/// Fragments of a pixel that one of the two lacks, once each is paired with one of almost the same
/// depth and a colour that differs by 1 of 255 at most.
fn unpaired(gpu: &[Fragment], cpu: &[Fragment]) -> u64 {
    let alike = |a: Fragment, b: Fragment| {
        let channels = a.rgba8().into_iter().zip(b.rgba8());
        (a.depth() - b.depth()).abs() <= DEPTH
            && channels.fold(true, |ok, (a, b)| ok && a.abs_diff(b) <= 1)
    };
    let mut left = cpu.to_vec();
    let mut unpaired = 0;
    for &fragment in gpu {
        match left.iter().position(|&other| alike(fragment, other)) {
            Some(found) => drop(left.swap_remove(found)),
            None => unpaired += 1,
        }
    }
    unpaired.max(left.len() as u64)
}

fn shading() -> Shading {
    Shading { light: [0.6, 0.0, 0.8], ambient: 0.2, stripes: None }
}

#[test]
fn captures_agree_with_each_other_and_with_the_cpu() {
    on_every_device("captures agree", |device| {
        let (mut total, mut counted_apart, mut apart) = (0, 0, 0);
        for (seed, size) in [(64, 64), (61, 47), (128, 8), (320, 200)].into_iter().enumerate() {
            let mesh = random_mesh(seed as u64, 200);
            let shuffled = shuffle_triangles(&mesh, 9);
            let camera = perspective_camera();
            let cpu = rasterize(&mesh, &shading(), &camera, size.0, size.1);
            let mut first: Option<Lfb> = None;
            for mesh in [&mesh, &shuffled] {
                let geometry = Geometry::new(mesh, &shading(), &camera, size.0, size.1);
                let view = View::new(device, &geometry, size);
                for capture in supported(device) {
                    let name = capture.name();
                    let slots = view.slots(capture);
                    let Ran { lfb, usage, counted } = run(device, capture, &view, slots);
                    assert_eq!(usage.fragments, view.total(), "{name}");
                    // Lists are in another order each time, and the demand is for the worst.
                    let enough = if capture.needs_lists() {
                        usage.slots <= slots
                    } else {
                        needs(slots, usage.slots)
                    };
                    assert!(enough, "{name}: {slots} for {}", usage.slots);
                    assert!(counted == view.counts, "{name}: counts differ from the count pass's");
                    assert!(lfb.counts().eq(counted), "{name}: unpacked counts");
                    let first = first.get_or_insert_with(|| lfb.clone());
                    let difference = first.multiset_difference(&lfb);
                    assert!(difference.is_none(), "{name}, seed {seed}: {difference:?}");
                }
            }
            let gpu = first.expect("there are captures");
            for pixel in 0..gpu.pixels() {
                let (gpu, cpu) = (gpu.pixel(pixel), cpu.pixel(pixel));
                counted_apart += gpu.len().abs_diff(cpu.len()) as u64;
                apart += unpaired(gpu, cpu);
                total += gpu.len() as u64;
            }
        }
        say(&format!(
            "{}: of {total} fragments {apart} differ from the CPU's, {counted_apart} in number",
            device.info().id
        ));
        assert!(apart * 1_000_000 <= MOVED_PER_MILLION * total, "{apart} of {total}");
    });
}

/// A triangle as the camera sees it.
struct OnScreen {
    /// How much its depth changes from pixel to pixel at most, along x plus along y.
    steepness: f64,
    /// Whether all of it is in the view volume.
    in_view: bool,
}

impl OnScreen {
    fn new(frame: &Frame, corners: [[f32; 3]; 3]) -> Self {
        let matrix = frame.view_projection.as_dmat4();
        let clip = corners.map(|p| matrix * DVec3::from(p.map(f64::from)).extend(1.0));
        // z over w is linear in x over w and y over w, also where a corner lies behind the eye.
        let [a, b, c] = clip.map(|p| DVec3::new(p.x, p.y, p.w));
        let plane =
            DMat3::from_cols(a, b, c).transpose().inverse() * DVec3::from(clip.map(|p| p.z));
        let (x, y) = (plane.x / f64::from(frame.width_px), plane.y / f64::from(frame.height_px));
        let in_view =
            clip.iter().all(|p| p.x.abs() <= p.w && p.y.abs() <= p.w && (0.0..=p.w).contains(&p.z));
        Self { steepness: 2.0 * (x.abs() + y.abs()), in_view }
    }
}

/// Each triangle has a colour of its own, so that its fragments are known again.
fn numbered(mesh: &Mesh) -> Mesh {
    let mut numbered = Mesh::default();
    for (triangle, corners) in mesh.indices.as_chunks::<3>().0.iter().enumerate() {
        for &corner in corners {
            let rgba = (triangle as u32).to_le_bytes();
            numbered.indices.push(numbered.vertices.len() as u32);
            numbered.vertices.push(Vertex { rgba, ..mesh.vertices[corner as usize] });
        }
    }
    numbered
}

/// Triangle by triangle: depths as near as snapping positions to 256ths allows, and the same pixels.
/// Of triangles wholly in view exactly the same, whose corners every device snaps alike but for a
/// rounding error near the middle between two 256ths. Others may be clipped, in the device's own way
/// and at planes of its choice (lavapipe clips at the picture's edges), and each point where an edge
/// is cut is snapped again, which moves the edge by up to half a 256th.
#[test]
fn coverage_and_depth_are_the_cpus() {
    on_every_device("coverage and depth", |device| {
        let size = (160, 90);
        let camera = perspective_camera();
        let frame = Frame::new(&UNLIT, &camera, size.0, size.1);
        let (mut total, mut apart, mut apart_in_view) = (0u64, 0u64, 0u64);
        for seed in 0..20 {
            let mesh = numbered(&random_mesh(100 + seed, 150));
            let triangles: Vec<_> = mesh
                .vertices
                .as_chunks::<3>()
                .0
                .iter()
                .map(|corners| OnScreen::new(&frame, corners.map(|vertex| vertex.position)))
                .collect();
            let cpu = rasterize(&mesh, &UNLIT, &camera, size.0, size.1);
            let geometry = Geometry::new(&mesh, &UNLIT, &camera, size.0, size.1);
            let pool = cpu.fragments().len() as u64 + 1000;
            let view = View::new(device, &geometry, size);
            let Ran { lfb: gpu, usage, .. } = run(device, CAPTURES[0], &view, pool);
            assert_eq!(usage.slots, gpu.fragments().len() as u64, "there was room for all");
            for pixel in 0..gpu.pixels() {
                let by_triangle = |lfb: &Lfb| -> BTreeMap<u32, f32> {
                    lfb.pixel(pixel).iter().map(|f| (f.rgba, f.depth())).collect()
                };
                let (gpu, cpu) = (by_triangle(&gpu), by_triangle(&cpu));
                total += cpu.len() as u64;
                for number in
                    gpu.keys().chain(cpu.keys().filter(|number| !gpu.contains_key(number)))
                {
                    let triangle = &triangles[*number as usize];
                    if let (Some(gpu), Some(cpu)) = (gpu.get(number), cpu.get(number)) {
                        let allowed = triangle.steepness / 256.0 + 4.0 * f64::from(f32::EPSILON);
                        let difference = f64::from((gpu - cpu).abs());
                        assert!(difference <= allowed, "{difference} where {allowed} is allowed");
                    } else {
                        apart += 1;
                        apart_in_view += u64::from(triangle.in_view);
                    }
                }
            }
        }
        let id = &device.info().id;
        say(&format!(
            "{id}: of {total} fragments {apart} differ from the CPU's, {apart_in_view} of them of \
             triangles wholly in view"
        ));
        assert!(total > 1_000_000, "scenes to speak of");
        assert!(apart_in_view * 1_000_000 <= MOVED_IN_VIEW_PER_MILLION * total);
        assert!(apart * 1_000_000 <= MOVED_PER_MILLION * total);
    });
}

/// Light and stripes, where no position is rounded: the same fragments, colours but for rounding.
#[test]
fn light_and_stripes_are_the_cpus() {
    on_every_device("stripes", |device| {
        let size = (64, 32);
        let camera = pixel_camera(size.0, size.1);
        let stripes = Stripes { direction: [1.0, 0.0, 0.0], period: 8.0, rgba: [9, 80, 250, 7] };
        let shading = Shading { light: [0.6, 0.0, 0.8], ambient: 0.2, stripes: Some(stripes) };
        let corners = [[0.0, 0.0], [64.0, 0.0], [64.0, 32.0], [0.0, 32.0]];
        let mut mesh = Mesh { vertices: Vec::new(), indices: vec![0, 1, 2, 0, 2, 3] };
        let mut random = SplitMix64::new(1);
        for [x, y] in corners {
            let position = [x, y, -0.25 - x / 128.0];
            mesh.vertices.push(Vertex { position, ..random_vertex(&mut random, 1.0) });
        }
        let cpu = rasterize(&mesh, &shading, &camera, size.0, size.1);
        let geometry = Geometry::new(&mesh, &shading, &camera, size.0, size.1);
        let pool = cpu.fragments().len() as u64;
        assert_eq!(pool, 64 * 32);
        let view = View::new(device, &geometry, size);
        for capture in supported(device) {
            let gpu = run(device, capture, &view, view.slots(capture)).lfb;
            for (pixel, (gpu, cpu)) in gpu.fragments().iter().zip(cpu.fragments()).enumerate() {
                let channels = gpu.rgba8().into_iter().zip(cpu.rgba8());
                let alike = channels.fold(true, |alike, (a, b)| alike && a.abs_diff(b) <= 1);
                assert!(alike, "pixel {pixel}: {:?} and {:?}", gpu.rgba8(), cpu.rgba8());
                assert_eq!(gpu.rgba8()[3] == 7, pixel % 8 < 4, "pixel {pixel}: a stripe");
            }
        }
    });
}

/// A pool that is too small has the nearest of each pixel, up to one cap for all; `full` is sorted.
fn keeps_nearest(full: &Lfb, part: &Ran) {
    let cap = part.lfb.histogram().peak() as usize;
    for pixel in 0..full.pixels() {
        let all = full.pixel(pixel);
        assert!(all.is_sorted_by_key(|fragment| fragment.key()), "pixel {pixel}");
        assert_eq!(part.lfb.pixel(pixel), &all[..cap.min(all.len())], "pixel {pixel}");
    }
    assert!(part.lfb.counts().eq(part.counted.iter().copied()), "the counts of what is kept");
}

/// A pool that is too small says what was needed, and nothing is written or read beyond it.
#[test]
fn a_full_pool_says_what_was_needed() {
    on_every_device("full pool", |device| {
        let size = (50, 30);
        let mesh = random_mesh(5, 100);
        let camera = perspective_camera();
        let geometry = Geometry::new(&mesh, &shading(), &camera, size.0, size.1);
        let view = View::new(device, &geometry, size);
        for capture in supported(device) {
            let name = capture.name();
            let slots = view.slots(capture);
            let full = run(device, capture, &view, slots);
            assert_eq!(full.lfb.fragments().len() as u64, view.total(), "{name}");
            for pool in [1, slots / 3, full.usage.slots - 1] {
                let part = run(device, capture, &view, pool);
                if capture.needs_lists() {
                    assert_eq!(part.usage.fragments, view.total(), "{name}");
                    assert!((1..=slots).contains(&part.usage.slots), "{name}: {:?}", part.usage);
                } else {
                    assert_eq!(part.usage, full.usage, "{name}");
                }
                if capture.keeps_nearest() {
                    keeps_nearest(&full.lfb, &part);
                } else {
                    assert!(part.counted == full.counted, "{name}: the counts of a large pool");
                }
                let stored = part.lfb.fragments().len() as u64;
                // Shaders take the room from the binding, which has two slots at least.
                assert!(stored <= pool.max(2), "{name}: {stored} stored in {pool}");
                if slots == view.total() && !capture.keeps_nearest() {
                    assert_eq!(stored, pool.max(2), "{name}: it fills its pool");
                }
                let difference = full.lfb.multiset_difference(&part.lfb);
                let missing = view.total() - stored;
                assert_eq!((difference.missing, difference.extra), (missing, 0), "{name}");
            }
        }
    });
}

#[test]
fn a_pool_beyond_the_limits_is_not_supported() {
    on_every_device("too large a pool", |device| {
        let geometry = Geometry::new(&Mesh::default(), &UNLIT, &pixel_camera(8, 8), 8, 8);
        let histogram = &DepthHistogram::default();
        for capture in supported(device) {
            let request =
                &CaptureRequest { pool_slots: 1 << 40, ..request(&geometry, (8, 8), histogram) };
            let refused = device.prepare(&capture_plan(capture, request));
            assert!(matches!(refused, Err(GpuError::Unsupported(_))), "{}", capture.name());
        }
    });
}

/// Around one, two and three levels of prefix sums.
#[test]
fn prefix_sums_hold_at_every_size() {
    on_every_device("prefix sums", |device| {
        for size in [(1, 1), (3, 1), (1023, 1), (32, 32), (1025, 1), (2049, 3), (1024, 1025)] {
            let mesh = random_mesh(2, 20);
            let geometry = Geometry::new(&mesh, &UNLIT, &perspective_camera(), size.0, size.1);
            let view = View::new(device, &geometry, size);
            for capture in supported(device) {
                let ran = run(device, capture, &view, view.slots(capture));
                assert_eq!(ran.usage.fragments, view.total(), "{}, {size:?}", capture.name());
                let counts = view.counts.iter().copied();
                assert!(ran.lfb.counts().eq(counts), "{}, {size:?}", capture.name());
            }
        }
    });
}

#[test]
fn nothing_drawn_is_nothing_captured() {
    on_every_device("empty", |device| {
        for mesh in [Mesh::default(), soup(&[[[100.0; 3]; 3]])] {
            let geometry = Geometry::new(&mesh, &UNLIT, &perspective_camera(), 9, 9);
            let view = View::new(device, &geometry, (9, 9));
            for capture in supported(device) {
                let ran = run(device, capture, &view, 1);
                let none = Usage { fragments: 0, slots: 0 };
                assert_eq!((ran.usage, ran.lfb.fragments().len()), (none, 0), "{}", capture.name());
                assert!(ran.counted.iter().all(|&count| count == 0));
            }
        }
    });
}

/// Entries of a list that a subgroup takes together start side by side.
#[test]
fn neighbours_of_a_list_lie_side_by_side() {
    on_every_device("side by side", |device| {
        let size = (61, 47);
        let mesh = random_mesh(3, 150);
        let geometry = Geometry::new(&mesh, &UNLIT, &perspective_camera(), size.0, size.1);
        let view = View::new(device, &geometry, size);
        let slots = view.slots(&InterleavedLists);
        let request = CaptureRequest {
            pool_slots: slots,
            ..request(view.geometry, view.size, &view.histogram)
        };
        let (grouping, _) = grouping(&InterleavedLists, size);
        let id = device.prepare(&capture_plan(&InterleavedLists, &request)).expect("sound");
        device.poison(id).expect("fills");
        device.run(id).expect("runs");
        let mut read = |name| words(&device.read(id, name).expect("reads"));
        let (pixels, lengths) = (read("group_pixels"), read("group_counts"));
        let (counts, bases) = (read("counts"), read("bases"));
        assert!(lengths.iter().all(|&length| length > 64), "{lengths:?}");
        let covered = view.counts.iter().filter(|&&count| count > 0).count();
        assert_eq!(lengths.iter().sum::<u32>() as usize, covered);
        let mut row = 0;
        for (&first, &length) in grouping.firsts.iter().zip(&lengths) {
            let list = &pixels[first as usize..(first + length) as usize];
            for group in list.chunks(32) {
                for (lane, &pixel) in group.iter().enumerate() {
                    assert_eq!(bases[pixel as usize], 32 * row + lane as u32, "pixel {pixel}");
                }
                row += group.iter().map(|&pixel| counts[pixel as usize]).max().unwrap_or(0);
            }
        }
        assert_eq!(read("row_total")[0], row);
        assert!(u64::from(32 * row) <= slots, "{row} rows, {slots} slots");
    });
}
