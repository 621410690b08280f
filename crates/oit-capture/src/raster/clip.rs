//! From clip space to the screen, and what of a triangle gets there.

use glam::{DVec3, DVec4, Vec3, Vec4};

use super::triangle::Corner;
use crate::Frame;

/// A position that is not finite.
const NOT_FINITE: u8 = 1;
const BEFORE_NEAR: u8 = 2;
const BEHIND_FAR: u8 = 4;
/// Beyond the guard band, which is far beyond the picture.
const OUT_OF_GUARD: u8 = 8;
const LEFT: u8 = 16;
const RIGHT: u8 = 32;
const BELOW: u8 = 64;
const ABOVE: u8 = 128;

/// If all corners share one of these, nothing of the triangle is seen.
pub(super) const ALL_OUT: u8 = BEFORE_NEAR | BEHIND_FAR | LEFT | RIGHT | BELOW | ABOVE;

/// If any corner has one of these, the triangle cannot be drawn as it is.
pub(super) const NEEDS_CLIP: u8 = NOT_FINITE | BEFORE_NEAR | BEHIND_FAR | OUT_OF_GUARD;

/// Half the width of the guard band, in pixels from the middle of the picture. Triangles are
/// clipped at its edges and not at those of the picture, since clipping moves edges a little; but
/// they are clipped, so that coordinates fit the integers.
const GUARD_PX: f32 = 65536.0;

/// The way from clip space to pixels.
pub(super) struct View {
    /// Half the picture, in pixels.
    half: [f32; 2],
    /// The guard band's edges: x and y over w.
    guard: [f32; 2],
}

impl View {
    pub(super) fn new(frame: &Frame) -> Self {
        let half = [frame.width_px, frame.height_px].map(|size| size as f32 / 2.0);
        Self { half, guard: half.map(|half| GUARD_PX / half.max(0.5)) }
    }

    /// Where a point of clip space lies outside.
    pub(super) fn outcode(&self, p: Vec4) -> u8 {
        if !p.is_finite() {
            return NOT_FINITE;
        }
        // A point of no or hardly any w has no place on the screen.
        let guard = p.x.abs() > self.guard[0] * p.w
            || p.y.abs() > self.guard[1] * p.w
            || p.w < f32::MIN_POSITIVE;
        let bit = |out: bool, bit: u8| if out { bit } else { 0 };
        bit(p.z < 0.0, BEFORE_NEAR)
            | bit(p.z > p.w, BEHIND_FAR)
            | bit(guard, OUT_OF_GUARD)
            | bit(p.x < -p.w, LEFT)
            | bit(p.x > p.w, RIGHT)
            | bit(p.y < -p.w, BELOW)
            | bit(p.y > p.w, ABOVE)
    }

    /// A point of clip space on the screen. Means nothing for a point that is to be clipped.
    pub(super) fn corner(&self, p: Vec4) -> Corner {
        let inv_w = 1.0 / p.w;
        // One rounding for product and sum, as devices do.
        let to_px =
            |ndc: f32, half: f32| (f64::from(ndc) * f64::from(half) + f64::from(half.abs())) as f32;
        let snap = |px: f32| (px * 256.0).round_ties_even() as i32;
        Corner {
            x: snap(to_px(p.x * inv_w, self.half[0])),
            y: snap(to_px(p.y * inv_w, -self.half[1])),
            depth: p.z * inv_w,
            inv_w,
        }
    }

    /// Clips a triangle and gives what is left as triangles, in double precision (Sutherland and
    /// Hodgman). With each come its corners as weights of the triangle's own.
    pub(super) fn clip(&self, corners: [Vec4; 3], mut put: impl FnMut([Corner; 3], [Vec3; 3])) {
        let out = corners.iter().fold(0, |out, &corner| out | self.outcode(corner));
        if out & NOT_FINITE != 0 {
            return;
        }
        let [a, b, c] = corners.map(|corner| corner.as_dvec4());
        let mut polygon = vec![(a, DVec3::X), (b, DVec3::Y), (c, DVec3::Z)];
        let [x, y] = self.guard.map(f64::from);
        // A point is inside where its product with the plane is not negative.
        let planes = [
            (BEFORE_NEAR, DVec4::new(0.0, 0.0, 1.0, 0.0)),
            (BEHIND_FAR, DVec4::new(0.0, 0.0, -1.0, 1.0)),
            (OUT_OF_GUARD, DVec4::new(1.0, 0.0, 0.0, x)),
            (OUT_OF_GUARD, DVec4::new(-1.0, 0.0, 0.0, x)),
            (OUT_OF_GUARD, DVec4::new(0.0, 1.0, 0.0, y)),
            (OUT_OF_GUARD, DVec4::new(0.0, -1.0, 0.0, y)),
        ];
        for (_, plane) in planes.into_iter().filter(|(bit, _)| out & bit != 0) {
            polygon = cut(&polygon, plane);
        }
        let on_screen: Vec<_> = polygon
            .iter()
            .map(|(p, weights)| (self.corner(p.as_vec4()), weights.as_vec3()))
            .collect();
        if on_screen.iter().any(|(corner, _)| !corner.inv_w.is_finite()) {
            // Only a triangle through the eye itself, with the near plane there too.
            return;
        }
        for i in 2..on_screen.len() {
            let fan = [on_screen[0], on_screen[i - 1], on_screen[i]];
            put(fan.map(|(corner, _)| corner), fan.map(|(_, weights)| weights));
        }
    }
}

/// The part of a convex polygon inside a plane.
fn cut(polygon: &[(DVec4, DVec3)], plane: DVec4) -> Vec<(DVec4, DVec3)> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &(to, to_weights)) in polygon.iter().enumerate() {
        let (from, from_weights) = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (d_from, d_to) = (plane.dot(from), plane.dot(to));
        if (d_from < 0.0) != (d_to < 0.0) {
            // From the inside outwards, so that both triangles of an edge get the same point.
            let along = |inside: f64, outside: f64| inside / (inside - outside);
            kept.push(if d_from < 0.0 {
                let t = along(d_to, d_from);
                (to + (from - to) * t, to_weights + (from_weights - to_weights) * t)
            } else {
                let t = along(d_from, d_to);
                (from + (to - from) * t, from_weights + (to_weights - from_weights) * t)
            });
        }
        if d_to >= 0.0 {
            kept.push((to, to_weights));
        }
    }
    kept
}
