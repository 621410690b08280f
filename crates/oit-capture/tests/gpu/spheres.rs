//! Spheres: every capture has the same fragments, those of the CPU.

use oit_capture::{LinearizedUnclipped, PlacedSpheres, rasterize_spheres};
use oit_scene::{Camera, Projection, Spheres};

use super::*;

const SIZE: (u32, u32) = (61, 47);

/// The two kinds of camera.
fn cameras() -> [Camera; 2] {
    let perspective = perspective_camera();
    let projection = Projection::Orthographic { height: 2.5, near: 0.5, far: 4.0 };
    [perspective, Camera { projection, ..perspective }]
}

fn place(spheres: &Spheres, camera: &Camera) -> PlacedSpheres {
    let stripes = Stripes { direction: [0.3, 1.0, 0.2], period: 0.3, rgba: [9, 80, 250, 7] };
    let shading = Shading { stripes: Some(stripes), ..shading() };
    PlacedSpheres::new(spheres, &shading, camera, SIZE.0, SIZE.1).expect("few spheres")
}

/// Fragments of a pixel that one of the two lacks. Paired are those of a depth that is the same but for
/// rounding, and a colour that differs by 1 of 255 at most; unless they lie on the edge of a stripe.
fn unlike(gpu: &[Fragment], cpu: &[Fragment]) -> u64 {
    let alike = |a: Fragment, b: Fragment| {
        let channels = a.rgba8().into_iter().zip(b.rgba8());
        (a.depth() - b.depth()).abs() <= 2e-6
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

/// Of a million fragments, how many may be unlike: those where a stripe ends.
const STRIPES_PER_MILLION: u64 = 500;

#[test]
fn every_capture_has_the_same_spheres_and_the_cpus() {
    on_every_device("spheres", |device| {
        let captures = supported(device);
        let (mut total, mut apart, mut counted_apart) = (0u64, 0u64, 0u64);
        for (seed, camera) in (0..6).zip(cameras().into_iter().cycle()) {
            let spheres = random_spheres(seed, 300, 3);
            let mut turned = spheres.clone();
            turned.objects.reverse();
            let cpu = rasterize_spheres(&place(&spheres, &camera));
            let mut first: Option<Lfb> = None;
            for spheres in [&spheres, &turned] {
                let geometry = Geometry::of_spheres(place(spheres, &camera));
                let view = View::new(device, &geometry, SIZE);
                for &capture in &captures {
                    let name = capture.name();
                    let Ran { lfb, usage, counted } =
                        run(device, capture, &view, view.slots(capture));
                    assert_eq!(usage.fragments, view.total(), "{name}");
                    assert!(counted == view.counts, "{name}: counts differ from the count pass's");
                    let first = first.get_or_insert_with(|| lfb.clone());
                    let difference = first.multiset_difference(&lfb);
                    assert!(difference.is_none(), "{name}, seed {seed}: {difference:?}");
                }
            }
            let gpu = first.expect("there are captures");
            assert!(gpu.histogram().peak() > 8, "{:?}", gpu.histogram());
            for pixel in 0..gpu.pixels() {
                let (gpu, cpu) = (gpu.pixel(pixel), cpu.pixel(pixel));
                counted_apart += gpu.len().abs_diff(cpu.len()) as u64;
                apart += unlike(gpu, cpu);
                total += gpu.len() as u64;
            }
        }
        let id = &device.info().id;
        say(&format!(
            "{id}: of {total} fragments of spheres {apart} differ from the CPU's, {counted_apart} in \
             number"
        ));
        assert!(total > 50_000, "{total} fragments");
        assert!(apart * 1_000_000 <= STRIPES_PER_MILLION * total, "{apart} of {total}");
        // Coverage is exact where sums and products stay what they are.
        if id.starts_with("vulkan") {
            assert_eq!(counted_apart, 0, "{id}");
        }
    });
}

/// Captures that draw past the planes have nothing to clip, and leave out nothing else.
#[test]
fn spheres_are_the_same_without_clipping() {
    on_every_device("unclipped spheres", |device| {
        for camera in cameras() {
            let geometry = Geometry::of_spheres(place(&random_spheres(3, 300, 3), &camera));
            let view = View::new(device, &geometry, SIZE);
            let slots = view.total();
            let first = run(device, CAPTURES[0], &view, slots);
            for late in [false, true] {
                let capture = LinearizedUnclipped { late };
                let request = request(&geometry, SIZE, &view.histogram);
                if let Err(GpuError::Unsupported(reason)) =
                    device.prepare(&capture_plan(&capture, &request))
                {
                    say(&format!("{}: SKIPPED: {reason}", capture.name()));
                    continue;
                }
                let ran = run(device, &capture, &view, slots);
                let difference = first.lfb.multiset_difference(&ran.lfb);
                assert!(difference.is_none(), "{}: {difference:?}", capture.name());
            }
        }
    });
}

#[test]
fn no_spheres_are_no_fragments() {
    on_every_device("no spheres", |device| {
        let mut behind = random_spheres(1, 5, 1);
        behind.atoms.iter_mut().for_each(|atom| {
            atom.center = [0.3, 0.2, 30.0];
        });
        behind.objects[0].rotation = [0.0, 0.0, 0.0, 1.0];
        for spheres in [Spheres::default(), behind] {
            let geometry = Geometry::of_spheres(place(&spheres, &perspective_camera()));
            let view = View::new(device, &geometry, SIZE);
            for capture in supported(device) {
                let ran = run(device, capture, &view, 1);
                assert_eq!((ran.usage.fragments, view.total()), (0, 0), "{}", capture.name());
            }
        }
    });
}
