//! Pipes along a path with elbows, what is turned about an axis, flanges with their bolts.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::generate::solids::Solids;

/// Length of a straight piece between two rings of a pipe at full detail.
const RING_STEP: f32 = 0.54;
/// Sectors of a pipe and rings of an elbow at full detail, and the fewest that keep the shape.
const SECTORS: [u32; 2] = [22, 5];
const ELBOW_RINGS: [u32; 2] = [12, 2];

/// A pipe: corners that it goes by, with elbows of radius `bend`, or less where there is no room.
#[derive(Clone, Copy)]
pub(super) struct Pipe<'a> {
    pub(super) path: &'a [Vec3],
    pub(super) radius: f32,
    pub(super) bend: f32,
    pub(super) rgba: [u8; 4],
}

/// A place along a pipe: its middle, and two directions across it.
#[derive(Clone, Copy)]
struct Ring {
    middle: Vec3,
    across: [Vec3; 2],
}

impl Pipe<'_> {
    pub(super) fn draw(&self, solids: &mut Solids) {
        let sectors = solids.cells(SECTORS[0], SECTORS[1]);
        let radius = self.radius * widened(sectors);
        let rings = self.rings(solids);
        let last = rings.len() - 1;
        solids.patch([sectors, last as u32], self.rgba, |u, v| {
            let along = v * last as f32;
            let i = (along as usize).min(last - 1);
            let t = along - i as f32;
            // Both sides of the seam are the same numbers, so that no pixel falls between them.
            let (sin, cos) = (TAU * u.fract()).sin_cos();
            let point =
                |ring: Ring| ring.middle + radius * (cos * ring.across[0] + sin * ring.across[1]);
            point(rings[i]).lerp(point(rings[i + 1]), t)
        });
    }

    fn rings(&self, solids: &Solids) -> Vec<Ring> {
        let path = self.path;
        let mut tangent = (path[1] - path[0]).normalize();
        let mut ring = Ring { middle: path[0], across: tangent.any_orthonormal_pair().into() };
        let mut rings = vec![ring];
        let mut add = |middle: Vec3, tangent: Vec3| {
            // The directions across are carried along, turned no more than the pipe turns.
            let side = ring.across[0].reject_from_normalized(tangent).normalize();
            ring = Ring { middle, across: [side, tangent.cross(side)] };
            rings.push(ring);
        };
        let mut from = path[0];
        for corner in path.windows(3) {
            let next = (corner[2] - corner[1]).normalize();
            let room = (corner[1] - corner[0]).length().min((corner[2] - corner[1]).length());
            let cut = self.bend.min(0.45 * room);
            let (start, end) = (corner[1] - cut * tangent, corner[1] + cut * next);
            straight(solids, from, start, |middle| add(middle, tangent));
            let count = solids.cells(ELBOW_RINGS[0], ELBOW_RINGS[1]);
            for i in 1..=count {
                let t = i as f32 / count as f32;
                let middle = start.lerp(corner[1], t).lerp(corner[1].lerp(end, t), t);
                add(middle, tangent.lerp(next, t).normalize());
            }
            (from, tangent) = (end, next);
        }
        straight(solids, from, path[path.len() - 1], |middle| add(middle, tangent));
        rings
    }
}

fn straight(solids: &Solids, from: Vec3, to: Vec3, mut add: impl FnMut(Vec3)) {
    let count = solids.cells(((to - from).length() / RING_STEP).ceil() as u32, 1);
    (1..=count).for_each(|i| add(from.lerp(to, i as f32 / count as f32)));
}

/// How much wider a prism must be than the cylinder it stands for to be as wide on average from all
/// sides, so that coarse pipes have as many fragments as fine ones.
fn widened(sectors: u32) -> f32 {
    let half = PI / sectors as f32;
    half / half.sin()
}

/// What a profile of (radius, distance along the axis) gives when turned about an axis. `sectors`
/// are those at full detail, `rows` the rows of each segment of the profile.
pub(super) fn turned(
    solids: &mut Solids,
    [origin, axis]: [Vec3; 2],
    profile: &[[f32; 2]],
    [sectors, rows]: [u32; 2],
    rgba: [u8; 4],
) {
    let (a, b) = axis.any_orthonormal_pair();
    let sectors = solids.cells(sectors, (sectors / 6).clamp(5, 12));
    let segments = profile.len() - 1;
    let cells = [sectors, solids.cells(rows, 1) * segments as u32];
    solids.patch(cells, rgba, |u, v| {
        let along = v * segments as f32;
        let i = (along as usize).min(segments - 1);
        let at =
            |k: usize| profile[i][k] + (profile[i + 1][k] - profile[i][k]) * (along - i as f32);
        let (sin, cos) = (TAU * u.fract()).sin_cos();
        origin + axis * at(1) + widened(sectors) * at(0) * (cos * a + sin * b)
    });
}

/// A pair of discs about a pipe, and the bolts through them: more bolts the more detail.
pub(super) fn flange(solids: &mut Solids, middle: Vec3, axis: Vec3, radius: f32, rgba: [u8; 4]) {
    let (inner, outer) = (1.05 * radius, 1.6 * radius);
    let half = 0.25 * radius;
    let profile = [[inner, -half], [outer, -half], [outer, half], [inner, half]];
    turned(solids, [middle, axis], &profile, [32, 1], rgba);
    let (a, b) = axis.any_orthonormal_pair();
    let bolts = solids.cells(12, 0);
    for i in 0..bolts {
        let (sin, cos) = (TAU * i as f32 / bolts as f32).sin_cos();
        let at = middle + 1.35 * radius * (cos * a + sin * b);
        let thick = 0.1 * radius;
        let profile =
            [[0.0, -1.8 * half], [thick, -1.8 * half], [thick, 1.8 * half], [0.0, 1.8 * half]];
        turned(solids, [at, axis], &profile, [12, 1], rgba);
    }
}
