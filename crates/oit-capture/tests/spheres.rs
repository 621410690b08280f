//! The CPU rasteriser of spheres, against rays in double precision.

mod support;

use glam::{DVec3, Vec3};
use oit_capture::{
    Frame, Geometry, MOST_SPHERES, PlacedSpheres, TooManySpheres, rasterize_sphere_counts,
    rasterize_spheres,
};
use oit_scene::{Camera, Level, Projection, Spheres};
use support::*;

const SIZE: (u32, u32) = (97, 61);

fn place(spheres: &Spheres, camera: &Camera) -> PlacedSpheres {
    PlacedSpheres::new(spheres, &UNLIT, camera, SIZE.0, SIZE.1).expect("few spheres")
}

/// Depths of a pixel's fragments, and those that a rounding error may add or take away.
fn by_rays(spheres: &Spheres, camera: &Camera, pixel: u32) -> (Vec<f64>, usize) {
    let matrix = Frame::new(&UNLIT, camera, SIZE.0, SIZE.1).view_projection.as_dmat4();
    let inverse = matrix.inverse();
    let (x, y) = (f64::from(pixel % SIZE.0) + 0.5, f64::from(pixel / SIZE.0) + 0.5);
    let at = |depth: f64| {
        let x = 2.0 * x / f64::from(SIZE.0) - 1.0;
        inverse.project_point3(DVec3::new(x, 1.0 - 2.0 * y / f64::from(SIZE.1), depth))
    };
    let (from, to) = (at(0.0), at(1.0));
    let direction = (to - from).normalize();
    let (mut depths, mut doubtful) = (Vec::new(), 0);
    for object in &spheres.objects {
        for atom in &spheres.atoms {
            let (center, radius) = spheres.placed(object, atom);
            let (center, radius) = (center.as_dvec3(), f64::from(radius));
            let along = (center - from).dot(direction);
            let beside = (center - from - direction * along).length();
            let t = along - (radius * radius - beside * beside).max(0.0).sqrt();
            let length = (to - from).length();
            let margin = 2e-6;
            let is_doubtful = (beside - radius).abs() < margin
                || (beside < radius && (t.abs() < 1e-5 || (t - length).abs() < 1e-5));
            if is_doubtful {
                doubtful += 1;
            } else if beside < radius && t > 0.0 && t < length {
                depths.push(matrix.project_point3(from + direction * t).z);
            }
        }
    }
    depths.sort_by(f64::total_cmp);
    (depths, doubtful)
}

#[test]
fn fragments_are_where_rays_first_hit() {
    let perspective = perspective_camera();
    let projection = Projection::Orthographic { height: 2.5, near: 0.5, far: 4.0 };
    let (mut total, mut doubtful, mut huge) = (0, 0, 0);
    for camera in [perspective, Camera { projection, ..perspective }] {
        for seed in 0..3 {
            let spheres = random_spheres(seed, 300, 2);
            let lfb = rasterize_spheres(&place(&spheres, &camera));
            assert!(lfb.counts().eq(rasterize_sphere_counts(&place(&spheres, &camera))));
            for pixel in 0..SIZE.0 * SIZE.1 {
                let (exact, own_doubtful) = by_rays(&spheres, &camera, pixel);
                let own = lfb.pixel(pixel as usize);
                total += own.len();
                doubtful += own_doubtful;
                if own_doubtful > 0 {
                    let count = exact.len()..=exact.len() + own_doubtful;
                    assert!(count.contains(&own.len()), "pixel {pixel}: {} {count:?}", own.len());
                    continue;
                }
                assert_eq!(own.len(), exact.len(), "pixel {pixel}, seed {seed}, {camera:?}");
                let mut depths: Vec<f64> = own.iter().map(|f| f64::from(f.depth())).collect();
                depths.sort_by(f64::total_cmp);
                huge += usize::from(depths.len() > 3);
                for (own, exact) in depths.iter().zip(&exact) {
                    assert!((own - exact).abs() < 2e-5, "pixel {pixel}: {own} and {exact}");
                }
            }
        }
    }
    assert!(total > 50_000 && huge > 5_000, "{total} fragments, {huge} deep pixels");
    assert!(doubtful * 1000 < total, "{doubtful} of {total} are too near a rim to tell");
}

/// Each pixel's fragments are those of the spheres one after the other.
#[test]
fn fragments_are_in_the_order_of_submission() {
    let mut spheres = random_spheres(4, 200, 2);
    for (atom, rgba) in (0u32..).zip(&mut spheres.atom_rgba) {
        *rgba = [atom as u8, 0, 0, 255];
    }
    for (object, own) in (1u8..).zip(&mut spheres.objects) {
        own.rgba = [255, 255, 255, object];
    }
    let lfb = rasterize_spheres(&place(&spheres, &perspective_camera()));
    let place = |rgba: [u8; 4]| (rgba[3], rgba[0]);
    for pixel in 0..lfb.pixels() {
        assert!(lfb.pixel(pixel).is_sorted_by_key(|fragment| place(fragment.rgba8())));
    }
    assert!(lfb.histogram().peak() > 4);
}

/// An object's level is that for its distance, and its colour multiplies its atoms'.
#[test]
fn far_objects_are_drawn_coarser() {
    let mut spheres = random_spheres(1, 30, 1);
    spheres.objects[0].position = [0.0; 3];
    spheres.levels.push(Level { first_atom: 7, atoms: 2, from_distance: 3.0 });
    spheres.kinds[0].levels = 2;
    let near = perspective_camera();
    let far = Camera { eye: near.eye.map(|e| 10.0 * e), ..near };
    let (near, far) = (place(&spheres, &near), place(&spheres, &far));
    assert_eq!((near.count(), far.count()), (30, 2));
    let (sphere, rgba) = far.sphere(1);
    assert_eq!(sphere.radius, spheres.atoms[8].radius);
    assert_eq!(rgba, Spheres::color(&spheres.objects[0], spheres.atom_rgba[8]));
    let distance = Vec3::from(sphere.center).length();
    let (center, _) = spheres.placed(&spheres.objects[0], &spheres.atoms[8]);
    let eye = Vec3::from(perspective_camera().eye) * 10.0;
    assert!((distance - center.distance(eye)).abs() < 1e-4);
}

#[test]
fn spheres_that_are_none_are_left_out() {
    let mut spheres = random_spheres(1, 6, 1);
    spheres.atoms[0].radius = 0.0;
    spheres.atoms[1].radius = -1.0;
    spheres.atoms[2].radius = f32::NAN;
    spheres.atoms[3].center[1] = f32::INFINITY;
    assert_eq!(place(&spheres, &perspective_camera()).count(), 2);
}

#[test]
fn too_many_spheres_are_refused_before_they_are_placed() {
    let mut spheres = random_spheres(1, 1, 65);
    spheres.levels[0].atoms = 1 << 20;
    let refused = PlacedSpheres::new(&spheres, &UNLIT, &perspective_camera(), 8, 8);
    let wanted = TooManySpheres { spheres: 65 << 20 };
    assert_eq!(refused.map(|placed| placed.count()), Err(wanted));
    assert!(wanted.spheres > MOST_SPHERES && wanted.to_string().contains("68157440"));
}

#[test]
fn a_sphere_is_two_triangles_without_vertices() {
    let geometry = Geometry::of_spheres(place(&random_spheres(1, 9, 2), &perspective_camera()));
    assert_eq!(geometry.triangles(), 2 * 18);
    let names: Vec<_> = geometry.buffers().into_iter().map(|buffer| buffer.name).collect();
    assert_eq!(names, ["frame", "sphere_view", "spheres", "sphere_rgba"]);
    assert_eq!(geometry.draw(), oit_gpu::Draw::Vertices { count: 6 * 18, instances: 1 });
}
