//! Every method on every device of this machine, against the oracle and against its CPU twin.
//!
//! Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.

use std::io::Write;

use oit_capture::{Accuracy, Geometry, Method, MethodRequest, PICTURE, rasterize};
use oit_fragments::{DepthHistogram, Lfb, oracle};
use oit_gpu::{Device, GpuError};
use oit_peel::METHODS;
use oit_scene::{Camera, Mesh, Projection, Shading, SplitMix64, Vertex};

const SIZE: (u32, u32) = (32, 16);

fn camera() -> Camera {
    let (x, y) = (SIZE.0 as f32 / 2.0, SIZE.1 as f32 / 2.0);
    Camera {
        eye: [x, y, 0.0],
        target: [x, y, -1.0],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Orthographic { height: SIZE.1 as f32, near: 0.0, far: 1.0 },
    }
}

const UNLIT: Shading = Shading { light: [0.0, 0.0, 1.0], ambient: 1.0, stripes: None };

/// One view, its fragments and its exact picture.
struct View {
    geometry: Geometry,
    fragments: Lfb,
    exact: Vec<[f64; 4]>,
}

impl View {
    fn new(mesh: &Mesh) -> Self {
        let (width, height) = SIZE;
        let geometry = Geometry::new(mesh, &UNLIT, &camera(), width, height);
        let fragments = rasterize(mesh, &UNLIT, &camera(), width, height);
        let exact = oracle::composite(&fragments);
        Self { geometry, fragments, exact }
    }

    fn histogram(&self) -> DepthHistogram {
        self.fragments.histogram()
    }
}

/// A rectangle of pixels at these depths of its left and right edge.
fn rectangle(mesh: &mut Mesh, [x0, x1]: [f32; 2], [z0, z1]: [f32; 2], rgba: [u8; 4]) {
    let first = mesh.vertices.len() as u32;
    let height = SIZE.1 as f32;
    for (x, z) in [(x0, z0), (x1, z1)] {
        for y in [0.0, height] {
            let position = [x, y, -z];
            mesh.vertices.push(Vertex { position, normal: [0.0, 0.0, 1.0], rgba });
        }
    }
    mesh.indices.extend([0, 1, 2, 2, 1, 3].map(|i| first + i));
}

/// Layers in random order of depth that cut through each other; no two fragments share a depth.
fn crossing(layers: usize, seed: u64) -> Mesh {
    let mut random = SplitMix64::new(seed);
    let mut mesh = Mesh::default();
    for _ in 0..layers {
        let rgba = (random.next_u64() as u32).to_le_bytes();
        let x0 = random.below(24) as f32;
        let x1 = x0 + 1.0 + random.below(31 - x0 as usize) as f32;
        let depths = [0; 2].map(|_| random.between(0.01, 0.99));
        rectangle(&mut mesh, [x0, x1], depths, rgba);
    }
    mesh
}

/// Four layers at two depths: two unlike ones in front, two equal ones behind.
fn tied() -> Mesh {
    let mut mesh = Mesh::default();
    let full = [0.0, SIZE.0 as f32];
    rectangle(&mut mesh, full, [0.25; 2], [255, 0, 0, 128]);
    rectangle(&mut mesh, full, [0.25; 2], [0, 255, 0, 128]);
    rectangle(&mut mesh, full, [0.75; 2], [0, 0, 255, 128]);
    rectangle(&mut mesh, full, [0.75; 2], [0, 0, 255, 128]);
    mesh
}

/// Past the test harness, which keeps back what passing tests print.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr");
}

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

/// A method's picture; `None` where the device lacks something.
fn draw(
    device: &mut dyn Device,
    method: &dyn Method,
    view: &View,
    size: Option<u32>,
) -> Option<Vec<[f32; 4]>> {
    let request = MethodRequest {
        geometry: &view.geometry,
        width_px: SIZE.0,
        height_px: SIZE.1,
        histogram: &view.histogram(),
        size,
    };
    let plan = method.build(&request).expect("few passes");
    let id = match device.prepare(&plan) {
        Ok(id) => id,
        Err(GpuError::Unsupported(reason)) => {
            say(&format!("{}: SKIPPED on {}: {reason}", method.name(), device.info().id));
            return None;
        }
        Err(error) => panic!("{}: {error}", method.name()),
    };
    // The second run starts with what the first left, but for buffers.
    for _ in 0..2 {
        device.poison(id).expect("poisoned");
        device.run(id).expect("ran");
    }
    let picture = device.read(id, PICTURE).expect("a picture");
    Some(bytemuck::pod_collect_to_vec(&picture))
}

fn largest_error<'a>(
    picture: &[[f32; 4]],
    right: impl Iterator<Item = &'a [f64; 4]>,
    channels: usize,
) -> f64 {
    let errors = picture.iter().zip(right).flat_map(|(own, right)| {
        (0..channels).map(move |channel| (f64::from(own[channel]) - right[channel]).abs())
    });
    errors.fold(0.0, f64::max)
}

/// Pixels of which a channel differs by more.
fn off_by_more_than(allowed: f64, picture: &[[f32; 4]], right: &[[f64; 4]]) -> usize {
    let is_off = |(own, right): &(&[f32; 4], &[f64; 4])| {
        (0..4).any(|channel| (f64::from(own[channel]) - right[channel]).abs() > allowed)
    };
    picture.iter().zip(right).filter(is_off).count()
}

#[test]
fn complete_pictures_are_the_oracles() {
    for layers in [0, 1, 2, 3, 17, 40] {
        let view = View::new(&crossing(layers, layers as u64));
        on_every_device("complete pictures", |device| {
            for method in METHODS {
                let accuracy = method.accuracy(None, &view.histogram());
                let Some(picture) = draw(device, *method, &view, None) else { continue };
                let error = largest_error(&picture, view.exact.iter(), 4);
                let what = format!("{} on {}, {layers} layers", method.name(), device.info().id);
                match accuracy {
                    Accuracy::Exact | Accuracy::ExactWithoutTies => {
                        assert!(error < 1e-5, "{what}: off by {error}");
                    }
                    Accuracy::Approximate(_) => assert!(error.is_finite(), "{what}"),
                }
            }
        });
    }
}

#[test]
fn kernels_and_twins_agree() {
    let views = [crossing(17, 3), crossing(30, 4), tied()].map(|mesh| View::new(&mesh));
    for view in &views {
        on_every_device("kernels and twins", |device| {
            for method in METHODS {
                for size in [None, Some(1), Some(2), Some(5)] {
                    let Some(picture) = draw(device, *method, view, size) else { continue };
                    let twin = method.twin(size, &view.fragments);
                    let twin: Vec<_> = twin.iter().map(|pixel| pixel.map(f64::from)).collect();
                    let what = format!("{} {size:?} on {}", method.name(), device.info().id);
                    // A device may round small floats to either side, in every pass anew; these are
                    // one step of their largest values, below 32.
                    let allowed = match method.name() {
                        "dual_peel_forward11" => 0.25,
                        "dual_peel_forward16" => 1.0 / 64.0,
                        _ => 1e-5,
                    };
                    let off = off_by_more_than(allowed, &picture, &twin);
                    // A device whose depths differ in the last of 24 bits has, once in thousands of
                    // fragments, another in 11: then two are at one depth that were not, or the reverse.
                    let may_be = match method.name() {
                        "dual_peel_depth16" if !device.info().name.contains("llvmpipe") => 5,
                        _ => 0,
                    };
                    let pixels = picture.len();
                    assert!(
                        off <= may_be,
                        "{what}: {off} of {pixels} pixels off by over {allowed}"
                    );
                }
            }
        });
    }
}

#[test]
fn fragments_at_one_depth_are_lost_but_by_the_total_order() {
    let view = View::new(&tied());
    on_every_device("ties", |device| {
        for method in METHODS {
            let Some(picture) = draw(device, *method, &view, None) else { continue };
            let error = largest_error(&picture, view.exact.iter(), 4);
            let what = format!("{} on {}", method.name(), device.info().id);
            match method.accuracy(None, &view.histogram()) {
                Accuracy::Exact => assert!(error < 1e-5, "{what}: off by {error}"),
                _ => assert!(error > 0.1, "{what}: off by {error} only"),
            }
        }
    });
}

#[test]
fn too_few_passes_are_said_to_be_too_few() {
    let view = View::new(&crossing(30, 5));
    let histogram = view.histogram();
    assert!(histogram.peak() > 8);
    for method in METHODS {
        let few = method.accuracy(Some(2), &histogram);
        assert!(matches!(few, Accuracy::Approximate(_)), "{}", method.name());
        let request = MethodRequest {
            geometry: &view.geometry,
            width_px: SIZE.0,
            height_px: SIZE.1,
            histogram: &histogram,
            size: Some(4096),
        };
        let error = method.build(&request).expect_err("too many passes");
        assert!(error.contains("4096"), "{error}");
    }
}
