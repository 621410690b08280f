//! What buildings are built of: curved patches, blocks, turned solids and arches.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::generate::shapes::push_cells;
use crate::mesh::to_byte;
use crate::{Mesh, Vertex};

/// How far the points lie, as a share of a patch, from which a normal is taken.
const NUDGE: f32 = 1e-3;

/// Where a part stands: a point, and the directions that its own x and z go; y is up.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) origin: Vec3,
    pub(super) x: Vec3,
    pub(super) z: Vec3,
}

impl Place {
    /// A point of the part in the world.
    pub(super) fn at(&self, x: f32, y: f32, z: f32) -> Vec3 {
        self.origin + self.x * x + Vec3::Y * y + self.z * z
    }

    /// The same directions from another origin, given in this place's own coordinates.
    pub(super) fn moved(&self, x: f32, y: f32, z: f32) -> Self {
        Self { origin: self.at(x, y, z), ..*self }
    }
}

/// An opening with a round head in an upright wall whose middle is x = 0.
#[derive(Clone, Copy)]
pub(super) struct Arch {
    /// Width of the wall.
    pub(super) width: f32,
    /// Where the head begins.
    pub(super) spring: f32,
    /// Where the wall ends.
    pub(super) top: f32,
    /// Half the width of the opening.
    pub(super) radius: f32,
    /// How thick the wall is, half of it on either side of z = 0.
    pub(super) thickness: f32,
}

/// A mesh that grows part by part, or only counts its triangles.
pub(super) struct Solids {
    mesh: Mesh,
    triangles: u64,
    counting: bool,
    /// Cells per cell of a full-detail part, in each direction.
    fineness: f32,
    opacity: f32,
}

impl Solids {
    /// Counts triangles and makes none.
    pub(super) fn counter(detail: f32) -> Self {
        let mesh = Mesh::default();
        Self { mesh, triangles: 0, counting: true, fineness: detail.sqrt(), opacity: 1.0 }
    }

    /// Makes triangles, of materials whose alpha is multiplied by `opacity`.
    pub(super) fn builder(detail: f32, opacity: f32) -> Self {
        Self { counting: false, opacity, ..Self::counter(detail) }
    }

    /// How many triangles there are, or would be.
    pub(super) fn triangles(&self) -> u64 {
        self.triangles
    }

    pub(super) fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// `full` cells at full detail; never fewer than `least`, which keep the shape.
    pub(super) fn cells(&self, full: u32, least: u32) -> u32 {
        ((full as f32 * self.fineness).round() as u32).max(least)
    }

    /// A surface `at(u, v)` for u and v from 0 to 1, cut into cells of two triangles, row by row.
    pub(super) fn patch(
        &mut self,
        [columns, rows]: [u32; 2],
        rgba: [u8; 4],
        at: impl Fn(f32, f32) -> Vec3,
    ) {
        self.triangles += 2 * u64::from(columns) * u64::from(rows);
        if self.counting {
            return;
        }
        let [r, g, b, a] = rgba;
        let rgba = [r, g, b, to_byte(f32::from(a) / 255.0 * self.opacity)];
        let first = self.mesh.vertices.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
                let along_u = at((u + NUDGE).min(1.0), v) - at((u - NUDGE).max(0.0), v);
                let along_v = at(u, (v + NUDGE).min(1.0)) - at(u, (v - NUDGE).max(0.0));
                let normal = along_u.cross(along_v).normalize_or(Vec3::Y).to_array();
                let position = at(u, v).to_array();
                self.mesh.vertices.push(Vertex { position, normal, rgba });
            }
        }
        push_cells(&mut self.mesh, first, columns, rows);
    }

    /// A box between two corners.
    pub(super) fn block(&mut self, place: &Place, low: [f32; 3], high: [f32; 3], rgba: [u8; 4]) {
        self.run(place, low, high, [true; 2], rgba);
    }

    /// A box between two corners, with or without its ends towards -x and +x: where the next one
    /// goes on, two faces would lie in one another.
    pub(super) fn run(
        &mut self,
        place: &Place,
        low: [f32; 3],
        high: [f32; 3],
        ends: [bool; 2],
        rgba: [u8; 4],
    ) {
        let cells = [self.cells(1, 1); 2];
        let corner = |t: [f32; 3]| {
            let [x, y, z] = std::array::from_fn(|i| low[i] + (high[i] - low[i]) * t[i]);
            place.at(x, y, z)
        };
        for (side, end) in [0.0, 1.0].into_iter().zip(ends) {
            if end {
                self.patch(cells, rgba, |u, v| corner([side, u, v]));
            }
            self.patch(cells, rgba, |u, v| corner([u, side, v]));
            self.patch(cells, rgba, |u, v| corner([u, v, side]));
        }
    }

    /// The upper and the lower face of a floor; its x and z run from `low` to `high`.
    pub(super) fn slab(
        &mut self,
        place: &Place,
        [low, high]: [[f32; 2]; 2],
        faces: [f32; 2],
        rgba: [u8; 4],
    ) {
        let cells = [self.cells(4, 1); 2];
        for y in faces {
            self.patch(cells, rgba, |u, v| {
                let between = |i: usize, t: f32| low[i] + (high[i] - low[i]) * t;
                place.at(between(0, u), y, between(1, v))
            });
        }
    }

    /// What a profile of (radius, height) gives when it is turned about the upright through the
    /// place's origin. `rows` are the rows of each of its segments at full detail; `flutes` are hollows of a tenth
    /// of the radius.
    pub(super) fn turned(
        &mut self,
        place: &Place,
        profile: &[[f32; 2]],
        [sectors, rows]: [u32; 2],
        flutes: u32,
        rgba: [u8; 4],
    ) {
        let segments = profile.len() - 1;
        let sectors = self.cells(sectors, 4);
        // Flutes that have fewer than three cells would be noise.
        let flutes = if sectors >= 3 * flutes { flutes } else { 0 };
        let cells = [sectors, self.cells(rows * segments as u32, 2.min(segments as u32))];
        self.patch(cells, rgba, |u, v| {
            let along = v * segments as f32;
            let i = (along as usize).min(segments - 1);
            let [from, to] = [profile[i], profile[i + 1]];
            let between = |k: usize| from[k] + (to[k] - from[k]) * (along - i as f32);
            // Both sides of the seam are the same numbers, so that no pixel falls between them.
            let angle = TAU * u.fract();
            let hollow =
                if flutes > 0 { (flutes as f32 * angle / 2.0).sin().abs() - 1.0 } else { 0.0 };
            let radius = between(0) * (1.0 + 0.1 * hollow);
            place.at(radius * angle.cos(), between(1), radius * angle.sin())
        });
    }

    /// The wall around an arch from the spring upward: both faces, and the underside of the head.
    pub(super) fn arch(&mut self, place: &Place, arch: Arch, segments: u32, rgba: [u8; 4]) {
        let segments = self.cells(segments / 4, 2) * 4;
        let rows = self.cells(2, 1);
        let head = |u: f32| {
            let (sin, cos) = (PI * u).sin_cos();
            [-arch.radius * cos, arch.spring + arch.radius * sin]
        };
        for z in [-arch.thickness / 2.0, arch.thickness / 2.0] {
            self.patch([segments, rows], rgba, |u, v| {
                let (inner, outer) = (head(u), arch.outline(u));
                let between = |k: usize| inner[k] + (outer[k] - inner[k]) * v;
                place.at(between(0), between(1), z)
            });
        }
        self.patch([segments, rows], rgba, |u, v| {
            let [x, y] = head(u);
            place.at(x, y, arch.thickness * (v - 0.5))
        });
    }
}

impl Arch {
    /// The wall's outline: up the left side for a quarter of the way, across, and down the right.
    fn outline(&self, u: f32) -> [f32; 2] {
        let rise = self.top - self.spring;
        let half = self.width / 2.0;
        if u < 0.25 {
            [-half, self.spring + rise * 4.0 * u]
        } else if u < 0.75 {
            [half * (4.0 * u - 2.0), self.top]
        } else {
            [half, self.spring + rise * (4.0 - 4.0 * u)]
        }
    }
}
