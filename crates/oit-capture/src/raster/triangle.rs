//! One triangle on the screen: which pixels it covers, and what lies where on it.

use std::ops::Range;

use glam::Vec3;

use crate::Frame;

/// A corner on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// To the right, in 256ths of a pixel.
    pub(super) x: i32,
    /// Downwards, in 256ths of a pixel.
    pub(super) y: i32,
    /// 0 at the near plane, 1 at the far plane.
    pub(super) depth: f32,
    /// One over w.
    pub(super) inv_w: f32,
}

/// A triangle that covers some pixel's row and column.
#[derive(Debug)]
pub(super) struct Triangle {
    /// Clockwise as seen on the screen, so that inside is where all three [`edge`]s are positive.
    corners: [Corner; 3],
    /// The first and the last row, and the first and last column, with a pixel centre in the box.
    pub(super) top: u32,
    pub(super) bottom: u32,
    left: u32,
    right: u32,
    /// Which of the mesh's triangles it is, or is a part of.
    pub(super) source: u32,
    /// How the mesh's corners make up this triangle's, one row each: only for a clipped one.
    weights: Option<Box<[Vec3; 3]>>,
    /// Whether the first two corners were swapped.
    swapped: bool,
}

impl Triangle {
    /// A triangle in the picture, or none if it has no area or its box has no pixel centre.
    /// `weights` say how the corners of a clipped triangle are made up of those it came from.
    pub(super) fn new(
        mut corners: [Corner; 3],
        frame: &Frame,
        source: u32,
        weights: Option<[Vec3; 3]>,
    ) -> Option<Self> {
        let [x, y] = [corners.map(|corner| corner.x), corners.map(|corner| corner.y)];
        let (left, right) = centres(x, frame.width_px)?;
        let (top, bottom) = centres(y, frame.height_px)?;
        let area = edge(&corners[0], &corners[1], (corners[2].x, corners[2].y));
        if area == 0 {
            return None;
        }
        let swapped = area < 0;
        if swapped {
            corners.swap(0, 1);
        }
        let weights = weights.map(Box::new);
        Some(Self { corners, top, bottom, left, right, source, weights, swapped })
    }

    /// The rows it may cover of `count` from `first` on.
    pub(super) fn rows(&self, first: u32, count: u32) -> Range<u32> {
        self.top.max(first)..(self.bottom + 1).min(first + count)
    }

    /// The pixels it covers in a row: those whose centre is inside, or on a top or left edge.
    pub(super) fn span(&self, row: u32) -> Range<u32> {
        let (mut first, mut last) = (i64::from(self.left), i64::from(self.right));
        let [a, b, c] = &self.corners;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (dx, dy) = (to.x - from.x, to.y - from.y);
            // Clockwise, y downwards: a top edge runs right, a left edge runs up.
            let least = if dy < 0 || (dy == 0 && dx > 0) { 0 } else { 1 };
            // From the edge function at column 0; each column further adds -256 dy.
            let inside = edge(from, to, centre(0, row)) - least;
            let step = 256 * i64::from(dy);
            match dy.signum() {
                0 if inside < 0 => return 0..0,
                0 => {}
                1 => last = last.min(inside.div_euclid(step)),
                _ => first = first.max(-inside.div_euclid(-step)),
            }
        }
        if first <= last { first as u32..last as u32 + 1 } else { 0..0 }
    }

    /// The depth at a pixel, and how much of each of the mesh's corners is there, with perspective.
    pub(super) fn interpolate(&self, x: u32, y: u32) -> (f32, Vec3) {
        let [a, b, c] = &self.corners;
        let at = centre(x, y);
        let areas = [edge(b, c, at), edge(c, a, at), edge(a, b, at)];
        let whole = areas.iter().sum::<i64>() as f64;
        let [_, v, w] = areas.map(|area| area as f64 / whole);

        let depth = f64::from(a.depth)
            + v * (f64::from(b.depth) - f64::from(a.depth))
            + w * (f64::from(c.depth) - f64::from(a.depth));
        let depth = (depth as f32).clamp(0.0, 1.0);

        let near =
            [(1.0 - v - w) * f64::from(a.inv_w), v * f64::from(b.inv_w), w * f64::from(c.inv_w)];
        let sum = near.iter().sum::<f64>();
        let [mut u, mut v, w] = near.map(|part| (part / sum) as f32);
        if self.swapped {
            std::mem::swap(&mut u, &mut v);
        }
        let weights = match self.weights.as_deref() {
            None => Vec3::new(u, v, w),
            Some([a, b, c]) => *a * u + *b * v + *c * w,
        };
        (depth, weights)
    }
}

/// A pixel's centre, in 256ths of a pixel.
fn centre(x: u32, y: u32) -> (i32, i32) {
    (x as i32 * 256 + 128, y as i32 * 256 + 128)
}

/// Twice the area of the triangle of an edge and a point, positive if clockwise. Exact.
fn edge(from: &Corner, to: &Corner, (x, y): (i32, i32)) -> i64 {
    let [dx, dy] = [to.x - from.x, to.y - from.y].map(i64::from);
    dx * i64::from(y - from.y) - dy * i64::from(x - from.x)
}

/// The first and last pixel of a row or column of `size` whose centre lies between the least and
/// the greatest of these coordinates, if there is one.
fn centres(coordinates: [i32; 3], size: u32) -> Option<(u32, u32)> {
    let least = coordinates[0].min(coordinates[1]).min(coordinates[2]);
    let greatest = coordinates[0].max(coordinates[1]).max(coordinates[2]);
    // Shifting rounds down.
    let first = ((least + 127) >> 8).max(0);
    let last = ((greatest - 128) >> 8).min(size as i32 - 1);
    (first <= last).then_some((first as u32, last as u32))
}
