//! The CPU rasteriser against the rules and against direct computation.

mod support;

use glam::{DMat3, DVec3, DVec4, Vec3};
use oit_capture::{Frame, rasterize, rasterize_counts};
use oit_scene::{Camera, Mesh, Projection, Shading, SplitMix64, Stripes, shuffle_triangles};
use proptest::prelude::*;
use support::*;

fn covered(mesh: &Mesh, width: u32, height: u32) -> Vec<(u32, u32)> {
    let counts = rasterize_counts(mesh, &pixel_camera(width, height), width, height);
    let pixels = counts.iter().enumerate().flat_map(|(pixel, &count)| {
        let pixel = pixel as u32;
        std::iter::repeat_n((pixel % width, pixel / width), count as usize)
    });
    pixels.collect()
}

proptest! {
    #[test]
    fn a_tessellated_square_covers_each_pixel_once(seed: u64, n in 1u32..40, reach in 0.0f32..1e6) {
        let mesh = jittered_square(seed, n, -reach, 64.0 + reach, -0.5);
        let camera = pixel_camera(64, 64);
        let counts = rasterize_counts(&mesh, &camera, 64, 64);
        prop_assert_eq!(counts.iter().find(|&&count| count != 1), None);
    }

    #[test]
    fn so_does_one_seen_in_perspective(seed: u64, n in 1u32..40, tilt in -0.25f32..0.25) {
        // The square reaches behind the eye, so it is clipped at the near plane; in the picture it
        // lies between the planes everywhere.
        let mut mesh = jittered_square(seed, n, -50.0, 50.0, 0.0);
        for vertex in &mut mesh.vertices {
            vertex.position[2] = vertex.position[0] * tilt;
        }
        let counts = rasterize_counts(&mesh, &perspective_camera(), 90, 70);
        prop_assert_eq!(counts.iter().find(|&&count| count != 1), None);
    }

    #[test]
    fn nothing_hostile_panics(
        positions in prop::collection::vec(any::<[f32; 3]>(), 3..40),
        indices in prop::collection::vec(0u32..50, 0..60),
        width in 0u32..40,
        height in 0u32..40,
    ) {
        let mesh = Mesh { vertices: positions.into_iter().map(vertex).collect(), indices };
        for camera in [pixel_camera(40, 40), perspective_camera()] {
            let lfb = rasterize(&mesh, &UNLIT, &camera, width, height);
            prop_assert_eq!(lfb.pixels(), width as usize * height as usize);
            for fragment in lfb.fragments() {
                prop_assert!((0.0..=1.0).contains(&fragment.depth()));
            }
        }
    }
}

#[test]
fn a_centre_on_an_edge_belongs_to_the_top_or_left() {
    // Corners on pixel centres; world y is upwards. The upper and the left edge are in, the lower
    // and the right are out; of the two triangles of a square, one has each pixel of the diagonal.
    let square = [[1.5, 1.5], [4.5, 1.5], [4.5, 4.5], [1.5, 4.5]].map(|[x, y]| [x, y, -0.5]);
    let [a, b, c, d] = square;
    let once: Vec<_> = (3..6).flat_map(|y| (1..4).map(move |x| (x, y))).collect();
    for triangles in [[[a, b, c], [a, c, d]], [[b, a, d], [d, c, b]], [[c, b, a], [d, a, c]]] {
        assert_eq!(covered(&soup(&triangles), 8, 8), once, "{triangles:?}");
    }
    // Alone: hypotenuse from the lower left to the upper right, a left edge of the lower triangle.
    assert_eq!(covered(&soup(&[[a, b, c]]), 8, 8), [(3, 4), (2, 5), (3, 5)]);
    assert_eq!(
        covered(&soup(&[[a, c, d]]), 8, 8),
        [(1, 3), (2, 3), (3, 3), (1, 4), (2, 4), (1, 5)]
    );
}

#[test]
fn positions_are_snapped_to_a_256th_of_a_pixel() {
    // The right edge a little right of a centre takes the pixel in, less than half a 256th does not.
    let strip = |right: f32| {
        let z = -0.5;
        let [a, b] = [[0.0, 0.0, z], [right, 0.0, z]];
        let [c, d] = [[right, 8.0, z], [0.0, 8.0, z]];
        soup(&[[a, b, c], [a, c, d]])
    };
    assert_eq!(covered(&strip(2.5 + 0.6 / 256.0), 8, 8).len(), 24);
    assert_eq!(covered(&strip(2.5 + 0.4 / 256.0), 8, 8).len(), 16);
}

#[test]
fn slivers_without_area_and_bad_corners_give_nothing() {
    let z = -0.5;
    let line = [[0.0, 0.0, z], [4.0, 4.0, z], [8.0, 8.0, z]];
    let point = [[3.5, 3.5, z]; 3];
    let nan = [[0.0, 0.0, z], [8.0, 0.0, z], [f32::NAN, 8.0, z]];
    let infinite = [[0.0, 0.0, z], [f32::INFINITY, 0.0, z], [0.0, 8.0, z]];
    assert_eq!(covered(&soup(&[line, point, nan, infinite]), 8, 8), []);
    let mut beyond = soup(&[[[0.0, 0.0, z], [8.0, 0.0, z], [0.0, 8.0, z]]]);
    beyond.indices[1] = 3;
    assert_eq!(covered(&beyond, 8, 8), []);
    let huge = 1e12;
    let all = [[-huge, -huge, z], [huge, -huge, z], [0.0, huge, z]];
    assert_eq!(covered(&soup(&[all]), 8, 8).len(), 64);
}

#[test]
fn what_lies_before_near_or_behind_far_is_cut_off() {
    // A ramp along x from z = 1 (before the near plane) to z = -2 (behind the far plane) over 96
    // pixels: depth 0 to 1 is seen from pixel 32 to pixel 64, on whole columns.
    let corners = [[0.0, 0.0, 1.0], [96.0, 0.0, -2.0], [96.0, 32.0, -2.0], [0.0, 32.0, 1.0]];
    let [a, b, c, d] = corners;
    let camera = pixel_camera(128, 32);
    let mesh = soup(&[[a, b, c], [a, c, d]]);
    let lfb = rasterize(&mesh, &UNLIT, &camera, 128, 32);
    let counts = rasterize_counts(&mesh, &camera, 128, 32);
    assert!(lfb.counts().eq(counts.iter().copied()), "both passes see the same fragments");
    for (pixel, &count) in counts.iter().enumerate() {
        let x = pixel % 128;
        assert_eq!(count, u32::from((32..64).contains(&x)), "column {x}");
        for fragment in lfb.pixel(pixel) {
            let exact = (x as f32 + 0.5 - 32.0) / 32.0;
            assert!((fragment.depth() - exact).abs() < 1e-6, "{} for {exact}", fragment.depth());
        }
    }
}

#[test]
fn both_passes_agree_on_anything() {
    for seed in 0..20 {
        let mesh = random_mesh(seed, 60);
        let camera = perspective_camera();
        let lfb = rasterize(&mesh, &UNLIT, &camera, 61, 47);
        assert!(lfb.counts().eq(rasterize_counts(&mesh, &camera, 61, 47)), "seed {seed}");
        let other = rasterize(&shuffle_triangles(&mesh, 1), &UNLIT, &camera, 61, 47);
        assert!(lfb.multiset_difference(&other).is_none(), "seed {seed}");
        assert!(lfb.histogram().peak() > 3, "seed {seed}: a scene to speak of");
    }
}

#[test]
fn fragments_are_in_submission_order() {
    let z = [-0.9, -0.1, -0.5];
    let square = |z: f32| [[0.0, 0.0, z], [16.0, 0.0, z], [0.0, 16.0, z]];
    let lfb = rasterize(&soup(&z.map(square)), &UNLIT, &pixel_camera(8, 8), 8, 8);
    for pixel in 0..lfb.pixels() {
        let depths: Vec<_> = lfb.pixel(pixel).iter().map(|f| f.depth()).collect();
        assert_eq!(depths, [0.9, 0.1, 0.5]);
    }
}

#[test]
fn threads_change_nothing() {
    let mesh = random_mesh(7, 20_000);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| rasterize(&mesh, &UNLIT, &perspective_camera(), 123, 97))
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

/// Each fragment of random triangles against the ray through its pixel, in double precision.
#[test]
fn depth_and_colour_are_those_of_the_ray() {
    let (width, height) = (120u32, 80u32);
    let shading = Shading {
        light: Vec3::new(1.0, 2.0, 3.0).normalize().to_array(),
        ambient: 0.25,
        stripes: Some(Stripes { direction: [0.0, 0.6, 0.8], period: 0.3, rgba: [250, 100, 0, 77] }),
    };
    let orthographic = Camera {
        projection: Projection::Orthographic { height: 3.0, near: 0.5, far: 4.0 },
        ..perspective_camera()
    };
    let mut random = SplitMix64::new(3);
    let (mut compared, mut striped) = (0, 0);
    for camera in [perspective_camera(), orthographic] {
        let frame = Frame::new(&shading, &camera, width, height);
        let inverse = frame.view_projection.as_dmat4().inverse();
        for _ in 0..100 {
            let corners = [0; 3].map(|_| random_vertex(&mut random, 2.0));
            let mesh = Mesh { vertices: corners.to_vec(), indices: vec![0, 1, 2] };
            let [a, b, c] = corners.map(|v| DVec3::from(v.position.map(f64::from)));
            let lfb = rasterize(&mesh, &shading, &camera, width, height);
            for pixel in 0..lfb.pixels() {
                let [fragment] = *lfb.pixel(pixel) else { continue };
                let x = (pixel as f64 % f64::from(width)).floor() + 0.5;
                let y = (pixel as f64 / f64::from(width)).floor() + 0.5;
                let ndc = |z: f64| {
                    let (x, y) =
                        (2.0 * x / f64::from(width) - 1.0, 1.0 - 2.0 * y / f64::from(height));
                    let point = inverse * DVec4::new(x, y, z, 1.0);
                    point.truncate() / point.w
                };
                let (near, far) = (ndc(0.0), ndc(1.0));
                // a u + b v + c w = near + (far - near) t with u + v + w = 1.
                let system = DMat3::from_cols(b - a, c - a, near - far);
                if system.determinant().abs() < 0.3 {
                    continue; // Seen nearly edge on: a 256th of a pixel is a long way there.
                }
                let solved = system.inverse() * (near - a);
                let weights = DVec3::new(1.0 - solved.x - solved.y, solved.x, solved.y);
                let mix = |of: &dyn Fn(usize) -> DVec3| {
                    of(0) * weights.x + of(1) * weights.y + of(2) * weights.z
                };
                let world = mix(&|i| DVec3::from(corners[i].position.map(f64::from)));
                let clip = frame.view_projection.as_dmat4() * world.extend(1.0);
                let depth = clip.z / clip.w;
                assert!((f64::from(fragment.depth()) - depth).abs() < 2e-3, "{fragment:?} {depth}");

                let along = world.dot(DVec3::new(0.0, 0.6, 0.8)) / 0.3;
                let band = along - along.floor();
                if band.min((band - 0.5).abs()).min(1.0 - band) < 0.05 {
                    continue;
                }
                let normal = mix(&|i| DVec3::from(corners[i].normal.map(f64::from)));
                if normal.length() < 0.2 {
                    continue; // Its direction changes fast.
                }
                let light = DVec3::new(1.0, 2.0, 3.0).normalize();
                let lit = 0.25 + 0.75 * normal.normalize().dot(light).abs();
                let own = mix(&|i| {
                    let [r, g, b, _] = corners[i].rgba;
                    DVec3::new(f64::from(r), f64::from(g), f64::from(b))
                });
                let alpha = mix(&|i| DVec3::splat(f64::from(corners[i].rgba[3]))).x;
                let (own, alpha) =
                    if band < 0.5 { (DVec3::new(250.0, 100.0, 0.0), 77.0) } else { (own, alpha) };
                let exact = [own.x * lit, own.y * lit, own.z * lit, alpha];
                for (&got, exact) in fragment.rgba8().iter().zip(exact) {
                    assert!((f64::from(got) - exact).abs() < 1.5, "{fragment:?} for {exact}");
                }
                compared += 1;
                striped += usize::from(band < 0.5);
            }
        }
    }
    assert!(compared > 20_000 && striped > 5_000, "{compared} compared, {striped} in stripes");
}
