//! Every method on every device of this machine, against the oracle and against its CPU twin.
//!
//! Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.

use std::io::Write;

use oit_approx::{Adaptive, METHODS, MultiLayer};
use oit_capture::{
    Accuracy, CAPTURES, CapturePasses, CaptureRequest, Geometry, LfbReader, Method, MethodRequest,
    PICTURE, rasterize,
};
use oit_fragments::{DepthHistogram, Lfb, oracle};
use oit_gpu::{Device, GpuError, Plan, PlanId};
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

/// A method's plan after its second run; `None` where the device lacks something.
fn run(
    device: &mut dyn Device,
    method: &dyn Method,
    view: &View,
    size: Option<u32>,
) -> Option<PlanId> {
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
    Some(id)
}

/// A method's picture; `None` where the device lacks something.
fn draw(
    device: &mut dyn Device,
    method: &dyn Method,
    view: &View,
    size: Option<u32>,
) -> Option<Vec<[f32; 4]>> {
    let id = run(device, method, view, size)?;
    Some(picture(device, id))
}

fn picture(device: &mut dyn Device, id: PlanId) -> Vec<[f32; 4]> {
    bytemuck::pod_collect_to_vec(&device.read(id, PICTURE).expect("a picture"))
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
    let mut fragments = capture.unpack(&mut reader).expect("fragments");
    // Into submission order, by their colours.
    let mut pixel = 0;
    fragments.reorder(|own| {
        let submitted = view.fragments.pixel(pixel);
        own.sort_by_key(|own| submitted.iter().position(|other| other.rgba == own.rgba));
        pixel += 1;
    });
    fragments
}

/// Whether the picture depends on the order in which fragments arrive: where they have to share nodes.
fn depends_on_arrival(method: &dyn Method, size: Option<u32>, view: &View) -> bool {
    let nodes = method.size().and_then(|own| size.or(own.default));
    ["multi_layer", "adaptive"].contains(&method.name())
        && nodes.is_some_and(|nodes| view.histogram().peak() > nodes)
}

/// Whether a pixel's fragments arrive in the order of submission. Vulkan promises it of blending alone;
/// llvmpipe draws the triangles of a tile one after the other.
fn arrive_in_order(device: &dyn Device) -> bool {
    device.info().name.contains("llvmpipe")
}

/// By how much kernel and twin may differ in a channel. The moments of nearly one depth make matrices
/// that are nearly singular, which magnify the rounding of sums and logarithms; half floats are 2^13
/// times as coarse as floats, and devices may round them either way. llvmpipe is off by 7e-4 and 6e-3.
fn tolerance(method: &dyn Method) -> f64 {
    match method.name() {
        name if name.starts_with("moments") && name.contains("_16") => 3e-2,
        name if name.starts_with("moments") => 5e-3,
        _ => 1e-4,
    }
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
    on_every_device("kernels and twins", |device| {
        for layers in [0, 1, 2, 5, 12, 40] {
            let view = View::new(&crossing(layers, layers as u64));
            let fragments = captured(device, &view);
            for method in METHODS {
                let smallest = method.size().map(|size| *size.range.start());
                let mut sizes = vec![None, smallest, smallest.map(|smallest| smallest + 3)];
                sizes.dedup();
                for size in sizes {
                    let Some(picture) = draw(device, *method, &view, size) else { continue };
                    let what = format!("{} {size:?} on {}", method.name(), device.info().id);
                    if depends_on_arrival(*method, size, &view) && !arrive_in_order(device) {
                        not_worse_than_in_any_order(*method, size, &view, &picture, &what);
                        continue;
                    }
                    let twin = method.twin(size, &fragments);
                    let twin: Vec<_> = twin.iter().map(|pixel| pixel.map(f64::from)).collect();
                    let error = largest_error(&picture, twin.iter(), 4);
                    assert!(error <= tolerance(*method), "{what}, {layers} layers: off by {error}");
                }
            }
        }
    });
}

/// Where the order of arrival is not known, the twin is asked for several.
fn not_worse_than_in_any_order(
    method: &dyn Method,
    size: Option<u32>,
    view: &View,
    picture: &[[f32; 4]],
    what: &str,
) {
    // A layer has one colour, and mostly arrives before or after another at all pixels alike: such
    // orders are worse than those in which every pixel has its own, whose errors are averaged.
    let mut worst = 0.0f64;
    for seed in 0..32 {
        let mut shuffled = view.fragments.clone();
        let mut random = SplitMix64::new(seed);
        let first = random.next_u64();
        shuffled.reorder(|fragments| match seed {
            0 => fragments.reverse(),
            1..8 => {
                for last in (1..fragments.len()).rev() {
                    fragments.swap(last, random.below(last + 1));
                }
            }
            _ => {
                fragments
                    .sort_by_key(|own| SplitMix64::new(first ^ u64::from(own.rgba)).next_u64());
            }
        });
        worst = worst.max(rmse(&method.twin(size, &shuffled), &view.exact));
    }
    let own = rmse(picture, &view.exact);
    assert!(own <= 1.25 * worst, "{what}: {own}, and {worst} in random orders");
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

/// What a listed method's twin comes to, on average of some views of forty layers.
fn twin_error(name: &str, view: impl Fn(u64) -> View) -> f64 {
    let method = METHODS.iter().find(|method| method.name() == name).expect("listed");
    let errors =
        (0..6).map(view).map(|view| rmse(&method.twin(None, &view.fragments), &view.exact));
    errors.sum::<f64>() / 6.0
}

#[test]
fn more_moments_are_nearer_to_the_oracle() {
    let error = |name: &str| twin_error(name, |seed| View::new(&crossing(40, seed)));
    let average = error("weighted");
    for kind in ["", "_16", "_bounded"] {
        let [four, six, eight] = [4, 6, 8].map(|count| error(&format!("moments{count}{kind}")));
        assert!(eight < six && six < four, "{kind}: {four} {six} {eight}");
        assert!(four < 0.7 * average, "{kind}: {four}, and {average} of weights");
    }
}

#[test]
fn bounds_help_where_depths_lie_close_together() {
    let close = |seed| {
        let mut mesh = crossing(40, seed);
        for vertex in &mut mesh.vertices {
            vertex.position[2] = vertex.position[2] * 0.015 - 0.98;
        }
        View::new(&mesh)
    };
    let wide = |seed| View::new(&crossing(40, seed));
    for count in [4, 6, 8] {
        let [plain, bounded] = ["", "_bounded"].map(|bounds| format!("moments{count}{bounds}"));
        let [apart, together] = [twin_error(&bounded, wide), twin_error(&bounded, close)];
        assert!((together / apart - 1.0).abs() < 0.02, "{bounded}: {apart}, {together}");
        let without = twin_error(&plain, close);
        assert!(without > 1.2 * together, "{plain}: {without}, {together} with bounds");
    }
}

/// Full-screen layers at these depths, in this order.
fn layers(layers: &[(f32, [u8; 4])]) -> View {
    let mut mesh = Mesh::default();
    for &(depth, rgba) in layers {
        rectangle(&mut mesh, [0.0, SIZE.0 as f32], [depth; 2], rgba);
    }
    View::new(&mesh)
}

#[test]
fn pictures_are_numbers_whatever_the_fragments() {
    let red = [255, 0, 0, 100];
    let opaque = [200, 255, 30, 255];
    let nothing = [10, 20, 30, 0];
    let views = [
        ("nothing", layers(&[])),
        ("one", layers(&[(0.5, red)])),
        ("one on the near plane", layers(&[(0.0, red)])),
        ("one on the far plane", layers(&[(1.0, red)])),
        ("alpha 0", layers(&[(0.2, nothing), (0.6, nothing), (0.3, nothing)])),
        ("alpha 1", layers(&[(0.2, opaque); 1])),
        ("alpha 0 and 1", layers(&[(0.7, opaque), (0.2, nothing), (0.5, red), (0.4, opaque)])),
        ("one depth", layers(&[(0.5, red); 20])),
        ("one depth, alpha 1", layers(&[(0.5, opaque); 20])),
        (
            "opaque all through",
            layers(&(0..20).map(|i| (i as f32 / 19.0, opaque)).collect::<Vec<_>>()),
        ),
        (
            "next to nothing",
            layers(&[(0.5, [255, 255, 255, 1]), (0.500_000_1, [255, 255, 255, 1])]),
        ),
    ];
    let numbers = |picture: &[[f32; 4]], what: &str| {
        for pixel in picture {
            let fits = pixel.iter().all(|channel| (-1e-4..=1.002).contains(channel));
            assert!(fits, "{what}: {pixel:?}");
        }
    };
    for (name, view) in &views {
        for method in METHODS {
            let what = format!("{}: {name}", method.name());
            numbers(&method.twin(None, &view.fragments), &what);
        }
    }
    on_every_device("numbers", |device| {
        for (name, view) in &views {
            for method in METHODS {
                let Some(picture) = draw(device, *method, view, None) else { continue };
                let what = format!("{} on {}: {name}", method.name(), device.info().id);
                numbers(&picture, &what);
                // One fragment is what it is in every method that does not draw lots.
                if view.fragments.histogram().peak() == 1 && method.name() != "stochastic" {
                    let error = largest_error(&picture, view.exact.iter(), 4);
                    assert!(error < 2.5e-3, "{what}: off by {error}");
                }
            }
        }
    });
}

/// Words of a buffer that a method's last run left.
fn words(device: &mut dyn Device, id: PlanId, buffer: &str) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&device.read(id, buffer).expect("a buffer"))
}

#[test]
fn lost_fragments_are_counted() {
    let view = View::new(&crossing(40, 3));
    let nodes = 4;
    let beyond = |kept: u32| -> u32 {
        view.fragments.counts().map(|count| count.saturating_sub(kept)).sum()
    };
    let seen = view.fragments.fragments().iter().filter(|own| own.rgba >> 24 != 0).count();
    let methods: [(&dyn Method, &dyn Method, u32); 2] = [
        // No turn at the last node.
        (&MultiLayer::PATIENT, &MultiLayer { tries: 0 }, beyond(nodes - 1)),
        // No turn at the lock.
        (&Adaptive::PATIENT, &Adaptive { tries: 0 }, seen as u32),
    ];
    on_every_device("lost", |device| {
        for (patient, impatient, lost) in methods {
            let what = format!("{} on {}", patient.name(), device.info().id);
            let Some(id) = run(device, patient, &view, Some(nodes)) else { continue };
            assert_eq!(words(device, id, "lost")[0], 0, "{what}");
            let Some(id) = run(device, impatient, &view, Some(nodes)) else { continue };
            assert_eq!(words(device, id, "lost")[0], lost, "{what} without patience");
            let picture = picture(device, id);
            if patient.name() == "multi_layer" {
                // What is left are the nearest, for which the last node is not needed.
                let nearest = METHODS.iter().find(|own| own.name() == "k_nearest").expect("listed");
                let right = nearest.twin(Some(nodes - 1), &view.fragments);
                let right: Vec<_> = right.iter().map(|pixel| pixel.map(f64::from)).collect();
                let error = largest_error(&picture, right.iter(), 4);
                assert!(error < 1e-5, "{what}: off by {error}");
            }
        }
    });
}

#[test]
fn curves_and_nodes_enough_for_all_are_the_oracle() {
    let view = View::new(&crossing(12, 5));
    let all = Some(view.histogram().peak().max(2));
    on_every_device("enough nodes", |device| {
        let methods: [(&dyn Method, f64); 2] =
            [(&MultiLayer::PATIENT, 1e-5), (&Adaptive::PATIENT, 2e-4)];
        for (method, most) in methods {
            let Some(picture) = draw(device, method, &view, all) else { continue };
            let error = largest_error(&picture, view.exact.iter(), 4);
            let what = format!("{} on {}", method.name(), device.info().id);
            assert!(error < most, "{what}: off by {error}");
        }
    });
}

#[test]
fn depths_within_a_step_are_one() {
    // The nearer has the larger colour word, so that one step of depth gets them the wrong way round.
    let (near, far) = ([255, 0, 255, 255], [0, 255, 0, 255]);
    for (apart, wrong) in [
        (4e-8, ["quantised_depth16", "quantised_depth24"].as_slice()),
        (4e-6, &["quantised_depth16"]),
        (4e-5, &[]),
    ] {
        let view = layers(&[(0.25, near), (0.25 + apart, far)]);
        on_every_device("steps of depth", |device| {
            for method in METHODS.iter().filter(|own| own.name().starts_with("quantised")) {
                let Some(picture) = draw(device, *method, &view, None) else { continue };
                let error = largest_error(&picture, view.exact.iter(), 4);
                let what = format!("{} at {apart} on {}", method.name(), device.info().id);
                let name = method.name().trim_end_matches("_premultiplied");
                assert_eq!(error > 0.5, wrong.contains(&name), "{what}: off by {error}");
            }
        });
    }
}

#[test]
fn premultiplied_colours_are_off_by_their_rounding() {
    let view = layers(&[(0.5, [255, 128, 3, 1]), (0.6, [77, 200, 5, 30])]);
    let twin = |name: &str| {
        let method = METHODS.iter().find(|method| method.name() == name).expect("listed");
        largest_error(&method.twin(None, &view.fragments), view.exact.iter(), 4)
    };
    let error = twin("quantised_premultiplied");
    assert!(error > 1e-4 && error < 2.0 * 0.5 / 255.0 + 1e-6, "{error}");
    assert!(twin("quantised_depth24") < 1e-6);
}
