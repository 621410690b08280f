//! Small scenes for the tests.
#![allow(dead_code, reason = "each test binary uses a part")]

use oit_bma::{GroupRequest, Intervals, ListGrouping, list_grouping};
use oit_capture::{Capture, CaptureRequest, Geometry, Lists};
use oit_fragments::DepthHistogram;
use oit_gpu::{Buffer, Plan};
use oit_scene::{
    Atom, Camera, Level, Mesh, Object, Projection, Shading, SphereKind, Spheres, SplitMix64, Vertex,
};

pub(crate) const UNLIT: Shading = Shading { light: [0.0, 0.0, 1.0], ambient: 1.0, stripes: None };

/// A camera under which world x and y are pixels, y upwards, and z from 0 to -1 is depth 0 to 1.
/// Exact where width and height are powers of two.
pub(crate) fn pixel_camera(width: u32, height: u32) -> Camera {
    let (x, y) = (width as f32 / 2.0, height as f32 / 2.0);
    Camera {
        eye: [x, y, 0.0],
        target: [x, y, -1.0],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Orthographic { height: height as f32, near: 0.0, far: 1.0 },
    }
}

pub(crate) fn perspective_camera() -> Camera {
    Camera {
        eye: [0.3, 0.2, 2.0],
        target: [0.0; 3],
        up: [0.1, 1.0, 0.0],
        projection: Projection::Perspective { fov_y_degrees: 60.0, near: 0.5, far: 4.0 },
    }
}

pub(crate) fn vertex(position: [f32; 3]) -> Vertex {
    Vertex { position, normal: [0.0, 0.0, 1.0], rgba: [255; 4] }
}

/// Triangles that share no vertex.
pub(crate) fn soup(triangles: &[[[f32; 3]; 3]]) -> Mesh {
    let vertices: Vec<_> = triangles.as_flattened().iter().map(|&p| vertex(p)).collect();
    let indices = (0..vertices.len() as u32).collect();
    Mesh { vertices, indices }
}

pub(crate) fn random_vertex(random: &mut SplitMix64, reach: f32) -> Vertex {
    let mut vector = |reach: f32| [0; 3].map(|_| random.between(-reach, reach));
    let (position, normal) = (vector(reach), vector(1.0));
    let rgba = (random.next_u64() as u32).to_le_bytes();
    Vertex { position, normal, rgba }
}

/// Random triangles: large ones that intersect and cross the near and the far plane, small ones, and
/// fans of shared edges.
pub(crate) fn random_mesh(seed: u64, triangles: usize) -> Mesh {
    let mut random = SplitMix64::new(seed);
    let mut mesh = Mesh::default();
    while mesh.triangle_count() < triangles {
        let first = mesh.vertices.len() as u32;
        match random.below(3) {
            0 => {
                mesh.vertices.extend([0; 3].map(|_| random_vertex(&mut random, 2.5)));
                mesh.indices.extend([first, first + 1, first + 2]);
            }
            1 => {
                let hub = random_vertex(&mut random, 1.0);
                mesh.vertices.push(hub);
                for _ in 0..2 {
                    let mut corner = random_vertex(&mut random, 0.2);
                    for (own, hub) in corner.position.iter_mut().zip(hub.position) {
                        *own += hub;
                    }
                    mesh.vertices.push(corner);
                }
                mesh.indices.extend([first, first + 2, first + 1]);
            }
            _ => {
                let hub = random_vertex(&mut random, 1.0);
                mesh.vertices.push(hub);
                let sides = 3 + random.below(6) as u32;
                for side in 0..sides {
                    let angle = side as f32 / sides as f32 * std::f32::consts::TAU;
                    let mut corner = random_vertex(&mut random, 1.0);
                    corner.position = [
                        hub.position[0] + angle.cos(),
                        hub.position[1] + angle.sin(),
                        corner.position[2],
                    ];
                    mesh.vertices.push(corner);
                    mesh.indices.extend([first, first + 1 + side, first + 1 + (side + 1) % sides]);
                }
            }
        }
    }
    mesh
}

/// Random spheres in a few turned and moved objects: tiny ones, middling ones, and huge ones that cross
/// the near or the far plane or hold the camera; some lie behind it.
pub(crate) fn random_spheres(seed: u64, atoms: u32, objects: u32) -> Spheres {
    let mut random = SplitMix64::new(seed);
    let mut spheres = Spheres {
        levels: vec![Level { first_atom: 0, atoms, from_distance: 0.0 }],
        kinds: vec![SphereKind { name: "cloud".into(), first_level: 0, levels: 1, radius: 9.0 }],
        ..Spheres::default()
    };
    for _ in 0..atoms {
        let radius = match random.below(8) {
            0..3 => random.between(0.001, 0.02),
            3..7 => random.between(0.05, 0.3),
            _ => random.between(0.5, 1.6),
        };
        let center = [0; 3].map(|_| random.between(-2.5, 2.5));
        spheres.atoms.push(Atom { center, radius });
        spheres.atom_rgba.push((random.next_u64() as u32).to_le_bytes());
    }
    for _ in 0..objects {
        let turn = glam::Vec4::from([0; 4].map(|_| random.between(-1.0, 1.0))).normalize();
        let position = [0; 3].map(|_| random.between(-0.5, 0.5));
        let rgba = [255, 255, 255, 128 + random.below(128) as u8];
        spheres.objects.push(Object { position, rotation: turn.to_array(), kind: 0, rgba });
    }
    spheres
}

/// A grid of `n` by `n` cells over a square, inner vertices moved by up to 0.2 of a cell, each cell
/// cut along a diagonal, either way round: the square is covered exactly once.
pub(crate) fn jittered_square(seed: u64, n: u32, low: f32, high: f32, z: f32) -> Mesh {
    let mut random = SplitMix64::new(seed);
    let cell = (high - low) / n as f32;
    let mut mesh = Mesh::default();
    for row in 0..=n {
        for column in 0..=n {
            let mut at = |i: u32| {
                let inner = i > 0 && i < n;
                // Little enough that every cell stays convex.
                let jitter = if inner { random.between(-0.2, 0.2) } else { 0.0 };
                if i == n { high } else { low + (i as f32 + jitter) * cell }
            };
            let (x, y) = (at(column), at(row));
            mesh.vertices.push(vertex([x, y, z]));
        }
    }
    for row in 0..n {
        for column in 0..n {
            let a = row * (n + 1) + column;
            let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
            let pair = match random.below(4) {
                0 => [[a, b, c], [a, c, d]],
                1 => [[a, c, b], [d, a, c]],
                2 => [[a, b, d], [d, b, c]],
                _ => [[b, a, d], [b, c, d]],
            };
            mesh.indices.extend(pair.as_flattened());
        }
    }
    mesh
}

/// A request with room for nothing.
pub(crate) fn request<'a>(
    geometry: &'a Geometry,
    (width_px, height_px): (u32, u32),
    histogram: &'a DepthHistogram,
) -> CaptureRequest<'a> {
    CaptureRequest {
        geometry,
        width_px,
        height_px,
        pool_slots: 1,
        histogram,
        counts: true,
        lists: None,
        mark: None,
    }
}

/// The plan of a capture alone, with lists of pixels where it needs them.
pub(crate) fn capture_plan(capture: &dyn Capture, request: &CaptureRequest) -> Plan {
    let (grouping, lists) = grouping(capture, (request.width_px, request.height_px));
    let lists = capture.needs_lists().then_some(&lists);
    let passes = capture.build(&CaptureRequest { lists, ..*request });
    let mut plan = Plan {
        name: capture.name().into(),
        buffers: passes.buffers,
        targets: passes.targets,
        passes: passes.passes,
    };
    assert_eq!(passes.lists_at.is_some(), capture.needs_lists(), "{}", capture.name());
    if let Some(at) = passes.lists_at {
        plan.passes.splice(at..at, grouping.passes);
        plan.buffers.extend(grouping.buffers);
        // Grouping sets pixels without fragments to nothing in the picture.
        let pixels = u64::from(request.width_px) * u64::from(request.height_px);
        plan.buffers.push(Buffer::new("image", 16 * pixels));
    }
    plan
}

/// How the schedule of these tests groups pixels: the last list takes most of the deep ones.
pub(crate) fn grouping(
    capture: &dyn Capture,
    (width_px, height_px): (u32, u32),
) -> (ListGrouping, Lists) {
    let uppers = vec![2, 5, 9];
    let intervals = Intervals::from_uppers(uppers.clone()).expect("rising bounds");
    let count_wgsl = &capture.count_wgsl();
    let grouping = list_grouping(
        &GroupRequest { count_wgsl, width_px, height_px },
        &intervals,
        &vec![64; intervals.len()],
    );
    let lists = Lists { firsts: grouping.firsts.clone(), uppers };
    (grouping, lists)
}
