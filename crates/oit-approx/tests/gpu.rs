//! Every method on every device of this machine, against the oracle and against its CPU twin.
//!
//! Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.

use std::io::Write;

use oit_approx::METHODS;
use oit_capture::{
    Accuracy, CAPTURES, CapturePasses, CaptureRequest, Geometry, LfbReader, Method, MethodRequest,
    PICTURE, rasterize,
};
use oit_fragments::{DepthHistogram, Lfb, oracle};
use oit_gpu::{Device, GpuError, Plan};
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

/// The view's fragments as the device captures them: the CPU rasteriser's depths may be off by a bit,
/// which gives other random numbers.
fn captured(device: &mut dyn Device, view: &View) -> Lfb {
    let capture = CAPTURES[0];
    let (width_px, height_px) = SIZE;
    let histogram = &view.histogram();
    let pool_slots = histogram.total().max(1);
    let passes = capture.build(&CaptureRequest {
        geometry: &view.geometry,
        width_px,
        height_px,
        pool_slots,
        histogram,
        counts: false,
        lists: None,
        mark: None,
    });
    let CapturePasses { buffers, targets, passes, .. } = passes;
    let plan = Plan { name: capture.name().to_owned(), buffers, targets, passes };
    let id = device.prepare(&plan).expect("prepared");
    device.run(id).expect("ran");
    let read = &mut |name: &str| device.read(id, name);
    let mut reader = LfbReader { width_px, height_px, pool_slots, read };
    capture.unpack(&mut reader).expect("fragments")
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

#[test]
fn kernels_and_twins_agree() {
    for layers in [0, 1, 2, 12, 40] {
        let view = View::new(&crossing(layers, layers as u64));
        on_every_device("kernels and twins", |device| {
            let fragments = captured(device, &view);
            for method in METHODS {
                let smallest = method.size().map(|size| *size.range.start());
                for size in [None, smallest, smallest.map(|smallest| smallest + 3)] {
                    let Some(picture) = draw(device, *method, &view, size) else { continue };
                    let twin = method.twin(size, &fragments);
                    let twin: Vec<_> = twin.iter().map(|pixel| pixel.map(f64::from)).collect();
                    let error = largest_error(&picture, twin.iter(), 4);
                    let what = format!("{} {size:?} on {}", method.name(), device.info().id);
                    assert!(error <= 1e-4, "{what}, {layers} layers: off by {error}");
                }
            }
        });
    }
}

#[test]
fn exact_where_they_say_so() {
    for (layers, size) in [(1, None), (7, None), (40, None), (40, Some(40))] {
        let view = View::new(&crossing(layers, layers as u64));
        on_every_device("accuracy", |device| {
            for method in METHODS {
                let size = size.filter(|size| {
                    method.size().is_some_and(|allowed| allowed.range.contains(size))
                });
                let Some(picture) = draw(device, *method, &view, size) else { continue };
                let error = largest_error(&picture, view.exact.iter(), 4);
                let what = format!("{} {size:?} on {}", method.name(), device.info().id);
                match method.accuracy(size, &view.histogram()) {
                    Accuracy::Approximate(_) => assert!(error < 1.0, "{what}: off by {error}"),
                    _ => assert!(error < 1e-5, "{what}: off by {error}"),
                }
            }
        });
    }
}

/// The root of the mean squared error of colour.
fn rmse(picture: &[[f32; 4]], exact: &[[f64; 4]]) -> f64 {
    let square = |(own, right): (&[f32; 4], &[f64; 4])| -> f64 {
        (0..3).map(|channel| (f64::from(own[channel]) - right[channel]).powi(2)).sum()
    };
    (picture.iter().zip(exact).map(square).sum::<f64>() / picture.len() as f64).sqrt()
}

#[test]
fn more_of_what_they_have_a_number_of_is_nearer_to_the_oracle() {
    let view = View::new(&crossing(40, 9));
    for method in METHODS {
        let Some(size) = method.size() else { continue };
        let mut sizes = vec![*size.range.start(), 8, 64];
        sizes.retain(|count| size.range.contains(count));
        sizes.dedup();
        let errors: Vec<f64> = sizes
            .iter()
            .map(|&size| rmse(&method.twin(Some(size), &view.fragments), &view.exact))
            .collect();
        let falls = errors.windows(2).all(|pair| pair[1] < pair[0]);
        assert!(falls, "{}: {errors:?} for {sizes:?}", method.name());
    }
}
