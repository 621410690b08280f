//! Why both passes of a capture must test early where a test rejects at all (LFB chapter, section
//! 20.4.1): triangles that cross the far plane, drawn whole.

use oit_capture::{CaptureError, LinearizedUnclipped};
use oit_gpu::Work;

use super::*;

const EARLY: LinearizedUnclipped = LinearizedUnclipped { late: false };
const LATE: LinearizedUnclipped = LinearizedUnclipped { late: true };

/// Runs one of them with room for all that is in view; `None` where the device clips always.
fn run_unclipped(
    device: &mut dyn Device,
    capture: &dyn Capture,
    view: &View,
    pool_slots: u64,
) -> Option<Result<(Usage, Lfb), CaptureError>> {
    let request =
        &CaptureRequest { pool_slots, ..request(view.geometry, view.size, &view.histogram) };
    let id = match device.prepare(&capture_plan(capture, request)) {
        Err(GpuError::Unsupported(reason)) => {
            let (name, id) = (capture.name(), &device.info().id);
            say(&format!("{name}: SKIPPED on {id}: {reason}"));
            return None;
        }
        prepared => prepared.expect("the plan is sound"),
    };
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    let mut read = |name: &str| device.read(id, name);
    let mut reader =
        LfbReader { width_px: view.size.0, height_px: view.size.1, pool_slots, read: &mut read };
    let usage = capture.usage(&mut reader);
    let lfb = capture.unpack(&mut reader);
    assert_eq!(usage.is_ok(), lfb.is_ok(), "both tell");
    Some(usage.and_then(|usage| Ok((usage, lfb?))))
}

/// A square, tilted so that depth runs from -1 at its left to 2 at its right.
fn through_both_planes(width: f32, height: f32) -> Mesh {
    let [a, b, c, d] =
        [[0.0, 0.0, 1.0], [width, 0.0, -2.0], [width, height, -2.0], [0.0, height, 1.0]];
    soup(&[[a, b, c], [a, c, d]])
}

#[test]
fn late_writes_are_more_than_were_counted() {
    on_every_device("early tests", |device| {
        let size = (64, 8);
        let mesh = through_both_planes(64.0, 8.0);
        let geometry = Geometry::new(&mesh, &UNLIT, &pixel_camera(64, 8), size.0, size.1);
        let view = View::new(device, &geometry, size);
        // Depth is (x + 1/2) * 3/64 - 1: of 64 columns 22 lie between the planes, 21 beyond the far.
        assert_eq!(view.total(), 22 * 8);
        // The pool has room for all, or for little: the counters go on.
        for pool in [1000, 3] {
            let Some(early) = run_unclipped(device, &EARLY, &view, pool) else { return };
            let (usage, lfb) = early.expect("both passes meet the same");
            assert_eq!(usage, Usage { fragments: 22 * 8, slots: 22 * 8 });
            if pool > 3 {
                assert!(lfb.counts().eq(view.counts.iter().copied()));
            }
            assert!(lfb.fragments().iter().all(|f| 0.0 < f.depth() && f.depth() < 1.0));
            let late = run_unclipped(device, &LATE, &view, pool).expect("as the other");
            let error = late.expect_err("more are captured than were counted");
            assert_eq!(error.to_string(), "176 fragments were counted and 344 captured");
            assert!(matches!(error, CaptureError::Disagree { counted: 176, captured: 344 }));
        }
    });
}

/// Clipping cuts triangles and snaps the corners it makes, so what is drawn whole differs by
/// rounding from what is clipped, and seldom by a fragment: that is why these are not among
/// [`CAPTURES`].
#[test]
fn early_tests_keep_to_the_view_volume() {
    on_every_device("early tests and clipping", |device| {
        let (mut total, mut apart) = (0, 0);
        for (seed, size) in [(64, 64), (61, 47), (128, 8), (160, 90)].into_iter().enumerate() {
            let mesh = random_mesh(seed as u64, 200);
            let camera = perspective_camera();
            let geometry = Geometry::new(&mesh, &shading(), &camera, size.0, size.1);
            let view = View::new(device, &geometry, size);
            let clipped = run(device, CAPTURES[0], &view, view.total()).lfb;
            let room = view.total() + 1000;
            let Some(early) = run_unclipped(device, &EARLY, &view, room) else { return };
            let (_, lfb) = early.expect("both passes meet the same");
            total += view.total();
            for pixel in 0..lfb.pixels() {
                apart += unpaired(lfb.pixel(pixel), clipped.pixel(pixel));
            }
        }
        let id = &device.info().id;
        say(&format!("{id}: of {total} fragments {apart} are clipped or not"));
        assert!(apart * 1_000_000 <= MOVED_PER_MILLION * total, "{apart} of {total}");
    });
}

#[test]
fn late_writes_are_refused_where_they_are_not_meant() {
    let geometry = Geometry::new(&Mesh::default(), &UNLIT, &pixel_camera(8, 8), 8, 8);
    let histogram = DepthHistogram::default();
    for capture in oit_capture::FAULTY {
        let mut plan = capture_plan(*capture, &request(&geometry, (8, 8), &histogram));
        plan.check().expect("it is meant");
        for pass in &mut plan.passes {
            if let Work::Raster(raster) = &mut pass.work {
                raster.late_writes = false;
            }
        }
        let checked = plan.check().map_err(|error| error.to_string());
        if capture.name() == "linearized_late" {
            let message = checked.expect_err("a rejected fragment would write");
            assert!(message.contains("@early_depth_test(force)"), "{message}");
        } else {
            checked.expect("it tests early");
        }
    }
}
