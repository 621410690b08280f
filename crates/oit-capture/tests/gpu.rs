//! Captures on every device of this machine, against each other and against the CPU rasteriser.
//!
//! Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.

mod support;

use std::io::Write;

use oit_capture::{
    CAPTURES, Capture, CaptureRequest, Geometry, LfbReader, count_plan, rasterize, rasterize_counts,
};
use oit_fragments::{Fragment, Lfb};
use oit_gpu::{Device, Plan};
use oit_scene::Shading;
use support::*;

/// Runs a test on every device that can be opened.
fn on_every_device(test: &str, mut run: impl FnMut(&mut dyn Device)) {
    let cache = tempfile::tempdir().expect("a folder for pipelines");
    let mut ran = 0;
    for listed in oit_gpu::enumerate() {
        match oit_gpu::open(&listed.id, cache.path()) {
            Ok(mut device) => {
                run(device.as_mut());
                ran += 1;
            }
            Err(error) => say(&format!("{test}: skipped on {}: {error}", listed.id)),
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

fn request(geometry: &Geometry, size: (u32, u32), pool_fragments: u64) -> CaptureRequest<'_> {
    let (width_px, height_px) = size;
    CaptureRequest { geometry, width_px, height_px, pool_fragments, counts: true }
}

/// Runs a capture, and gives what it stored, what it needed, and its counts.
fn run(
    device: &mut dyn Device,
    capture: &dyn Capture,
    request: &CaptureRequest,
) -> (Lfb, u64, Vec<u32>) {
    let passes = capture.build(request);
    let mut plan = Plan {
        name: capture.name().into(),
        buffers: passes.buffers,
        targets: passes.targets,
        passes: passes.passes,
    };
    // The counts as a schedule reads them.
    let pixels = request.width_px * request.height_px;
    let wgsl = format!(
        "{}
        @group(0) @binding(16) var<storage, read_write> counted: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let pixel = id.y * 32768u * 64u + id.x;
            if (pixel < {pixels}u) {{ counted[pixel] = pixel_count(pixel); }}
        }}",
        capture.count_wgsl()
    );
    plan.buffers.push(oit_gpu::Buffer::new("counted", 4 * u64::from(pixels)));
    let groups = pixels.div_ceil(64);
    let dispatch = oit_gpu::Dispatch::Workgroups([groups.min(32768), groups.div_ceil(32768), 1]);
    let shader = oit_gpu::Shader::new("copy counts", wgsl);
    plan.passes.push(oit_gpu::Pass::compute("group", shader, dispatch));

    let id = device.prepare(&plan).expect("the plan is sound");
    // Twice, so that what a run leaves behind is seen not to matter.
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    device.run(id).expect("runs");
    let counted = words(&device.read(id, "counted").expect("reads"));
    let mut read = |name: &str| device.read(id, name);
    let mut reader = LfbReader {
        width_px: request.width_px,
        height_px: request.height_px,
        pool_fragments: request.pool_fragments,
        read: &mut read,
    };
    let needed = capture.needed(&mut reader).expect("reads");
    (capture.unpack(&mut reader).expect("undamaged"), needed, counted)
}

fn count(device: &mut dyn Device, request: &CaptureRequest) -> Vec<u32> {
    let id = device.prepare(&count_plan(request)).expect("the plan is sound");
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    words(&device.read(id, "counts").expect("reads"))
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
}

fn shading() -> Shading {
    Shading { light: [0.6, 0.0, 0.8], ambient: 0.2, stripes: None }
}

#[test]
fn captures_agree_with_each_other_and_with_the_cpu() {
    on_every_device("captures agree", |device| {
        let (mut total, mut moved, mut worst) = (0, 0u64, 0f32);
        for (seed, size) in [(64, 64), (61, 47), (128, 8), (320, 200)].into_iter().enumerate() {
            let mesh = random_mesh(seed as u64, 200);
            let camera = perspective_camera();
            let geometry = Geometry::new(&mesh, &shading(), &camera, size.0, size.1);
            let cpu = rasterize(&mesh, &shading(), &camera, size.0, size.1);
            let counts = count(device, &request(&geometry, size, 1));
            let pool = counts.iter().map(|&count| u64::from(count)).sum::<u64>();
            let mut first: Option<Lfb> = None;
            for capture in CAPTURES {
                let (lfb, needed, counted) = run(device, *capture, &request(&geometry, size, pool));
                assert_eq!(needed, pool);
                assert_eq!(counted, counts, "counts of {}", capture.name());
                assert!(lfb.counts().eq(counts.iter().copied()), "{}", capture.name());
                let first = first.get_or_insert_with(|| lfb.clone());
                assert!(first.multiset_difference(&lfb).is_none(), "{}", capture.name());
            }
            let gpu = first.expect("there are captures");
            for pixel in 0..gpu.pixels() {
                let (m, w) = compare(gpu.pixel(pixel), cpu.pixel(pixel));
                moved += m;
                worst = worst.max(w);
            }
            total += pool;
        }
        say(&format!("{}: {total} {moved} {worst}", device.info().id));
    });
}

fn compare(gpu: &[Fragment], cpu: &[Fragment]) -> (u64, f32) {
    if gpu.len() != cpu.len() {
        return (gpu.len().abs_diff(cpu.len()) as u64, 0.0);
    }
    let mut g = gpu.to_vec();
    let mut c = cpu.to_vec();
    g.sort_by_key(|f| f.key());
    c.sort_by_key(|f| f.key());
    (0, g.iter().zip(&c).map(|(g, c)| (g.depth() - c.depth()).abs()).fold(0.0, f32::max))
}
