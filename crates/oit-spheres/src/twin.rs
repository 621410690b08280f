//! The compute rasteriser on the CPU, in single precision: the twin of `choose.wgsl`,
//! `rasterise.wgsl`, `write_out.wgsl` and `shade.wgsl`.

use glam::{Quat, Vec2, Vec3};
use oit_scene::Spheres;
use rayon::prelude::*;

use crate::ids::Ids;
use crate::view::{View, is_perspective};
use crate::{Culling, Detail, Output, Raster, SphereRequest, Variation};

/// Rows of a band. Bands are drawn in parallel, each by one thread.
const BAND_ROWS: u32 = 8;

/// The picture of a variation's rule, drawn on the CPU: premultiplied, rows top to bottom.
///
/// # Errors
/// Where the CPU cannot say it: it rasterises no billboards, has no pyramid, and rebuilds nothing from
/// neighbours; and where [`Variation::plan`] refuses.
pub fn twin(variation: &Variation, request: &SphereRequest) -> Result<Vec<[f32; 4]>, String> {
    variation.refuse()?;
    if variation.raster != Raster::Compute {
        return Err("the CPU has no raster units: it draws as the compute rasteriser does".into());
    }
    if variation.culling == Culling::Occlusion {
        return Err("the CPU culls by the frustum alone".into());
    }
    if variation.output == Output::Bytes8 {
        return Err("the CPU rebuilds no normals from neighbouring depths".into());
    }
    let spheres = &*request.spheres.spheres;
    Ids::of(spheres)?;
    let (width, height) = (request.width_px, request.height_px);
    let objects = spheres.objects.len() as u32;
    let view = View::new(request.shading, request.camera, width, height, objects);
    let eye = Eye { view, perspective: is_perspective(request.camera) };
    let placed: Vec<Option<Placed>> = (0..spheres.objects.len())
        .into_par_iter()
        .map(|object| eye.choose(variation, spheres, object))
        .collect();
    let mut lists = vec![Vec::new(); height.div_ceil(BAND_ROWS) as usize];
    for (object, placed) in placed.iter().enumerate() {
        let Some(placed) = placed else { continue };
        let radius = spheres.kinds[spheres.objects[object].kind as usize].radius;
        let Some([_, rows]) = eye.extent(placed.position, radius) else { continue };
        for band in rows[0] / BAND_ROWS..=rows[1] / BAND_ROWS {
            lists[band as usize].push(object as u32);
        }
    }
    let band = |(band, list): (usize, &Vec<u32>)| {
        let first_row = band as u32 * BAND_ROWS;
        let rows = BAND_ROWS.min(height - first_row);
        let mut nearest = vec![(0.0f32, 0u32, 0u32); (rows * width) as usize];
        for &object in list {
            let Some(placed) = &placed[object as usize] else { continue };
            for atom in placed.first_atom..placed.first_atom + placed.atoms {
                let (center, radius) = placed.sphere(spheres, atom);
                let Some([columns, own_rows]) = eye.extent(center, radius) else { continue };
                for y in own_rows[0].max(first_row)..(own_rows[1] + 1).min(first_row + rows) {
                    for x in columns[0]..=columns[1] {
                        let Some(hit) = eye.meet(center, radius, x, y) else { continue };
                        let depth = eye.depth_of(hit.position.z);
                        let at = &mut nearest[((y - first_row) * width + x) as usize];
                        // Of equally near ones the last id, as the greatest word is kept.
                        if depth > 0.0 && (depth, object, atom) > *at {
                            *at = (depth, object, atom);
                        }
                    }
                }
            }
        }
        let color = |(at, &(depth, object, atom)): (usize, &(f32, u32, u32))| {
            let (x, y) = (at as u32 % width, first_row + at as u32 / width);
            let Some(placed) = placed[object as usize].as_ref().filter(|_| depth > 0.0) else {
                return [0.0; 4];
            };
            let (center, radius) = placed.sphere(spheres, atom);
            let hit = eye.meet(center, radius, x, y).expect("it was met before");
            let hit = eye.packed(variation.output, hit, x, y);
            eye.shade(spheres, object, atom, &hit)
        };
        nearest.iter().enumerate().map(color).collect::<Vec<_>>()
    };
    let bands: Vec<Vec<[f32; 4]>> = lists.par_iter().enumerate().map(band).collect();
    Ok(bands.concat())
}

/// An object in view space.
struct Placed {
    position: Vec3,
    turn: Quat,
    first_atom: u32,
    atoms: u32,
}

impl Placed {
    fn sphere(&self, spheres: &Spheres, atom: u32) -> (Vec3, f32) {
        let sphere = &spheres.atoms[atom as usize];
        (self.position + self.turn * Vec3::from(sphere.center), sphere.radius)
    }
}

struct Hit {
    position: Vec3,
    normal: Vec3,
}

struct Eye {
    view: View,
    perspective: bool,
}

impl Eye {
    fn choose(&self, variation: &Variation, spheres: &Spheres, object: usize) -> Option<Placed> {
        let object = &spheres.objects[object];
        let kind = &spheres.kinds[object.kind as usize];
        let from_eye = Vec3::from(object.position) - Vec3::from(self.view.eye);
        let level = match variation.detail {
            Detail::ByDistance => spheres.level_at(kind, from_eye.length()),
            Detail::Full => &spheres.levels[kind.first_level as usize],
        };
        let turn = Quat::from_array(self.view.turn);
        let position = turn * from_eye;
        if variation.culling == Culling::Frustum && !self.in_frustum(position, kind.radius) {
            return None;
        }
        let turn = turn * Quat::from_array(object.rotation);
        Some(Placed { position, turn, first_atom: level.first_atom, atoms: level.atoms })
    }

    fn in_frustum(&self, center: Vec3, radius: f32) -> bool {
        -center.z + radius >= self.view.near
            && -center.z - radius <= self.view.far
            && self.between_sides(center, radius)
    }

    fn between_sides(&self, center: Vec3, radius: f32) -> bool {
        let inside = |side: &[f32; 4]| Vec3::from_slice(side).dot(center) + side[3] >= -radius;
        self.view.sides.iter().all(inside)
    }

    /// As `extent_of`: the first and last pixels of x and of y.
    fn extent(&self, center: Vec3, radius: f32) -> Option<[[u32; 2]; 2]> {
        let view = &self.view;
        let size = [view.width_px, view.height_px];
        let depth = -center.z;
        if depth + radius < view.near {
            return None;
        }
        let mut extent = [[0; 2]; 2];
        for axis in 0..2 {
            let at = center[axis];
            let (low, high) = if !self.perspective {
                (at - radius, at + radius)
            } else if depth - radius < view.near {
                if !self.between_sides(center, radius) {
                    return None;
                }
                extent[axis] = [0, size[axis] - 1];
                continue;
            } else {
                let k = 1.0 / ((depth - radius) * (depth + radius));
                let half = radius * (at * at * k * k + k).sqrt();
                (at * (depth * k) - half, at * (depth * k) + half)
            };
            let pixel = |at: f32| (at - view.pixel_offset[axis]) / view.pixel_scale[axis];
            let (a, b) = (pixel(low), pixel(high));
            let first = (a.min(b) - 0.5).ceil().max(0.0);
            let last = (a.max(b) - 0.5).floor().min(size[axis] as f32 - 1.0);
            if first > last {
                return None;
            }
            extent[axis] = [first as u32, last as u32];
        }
        Some(extent)
    }

    fn pixel_at(&self, x: u32, y: u32) -> Vec2 {
        let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        pixel * Vec2::from(self.view.pixel_scale) + Vec2::from(self.view.pixel_offset)
    }

    fn ray(&self, x: u32, y: u32) -> Vec2 {
        if self.perspective { self.pixel_at(x, y) } else { Vec2::ZERO }
    }

    fn meet(&self, center: Vec3, radius: f32, x: u32, y: u32) -> Option<Hit> {
        let ray = self.ray(x, y);
        let to_center = if self.perspective { -center.z } else { 1.0 };
        let q = center.truncate() - self.pixel_at(x, y) * to_center;
        let length2 = 1.0 + ray.length_squared();
        let along = ray.dot(q);
        let inside = along * along + length2 * (radius * radius - q.length_squared());
        let behind = (along - inside.max(0.0).sqrt()) / length2;
        let from_center = (ray * behind - q).extend(-behind);
        let covered = inside >= 0.0 && behind - center.z >= self.view.near;
        let length = from_center.length_squared().max(1e-30).sqrt();
        covered.then(|| Hit { position: center + from_center, normal: from_center / length })
    }

    /// Reversed depth of a point of this z in view space.
    fn depth_of(&self, z: f32) -> f32 {
        let [_, _, by, to] = &self.view.projection;
        ((by[2] * z + to[2]) / (by[3] * z + to[3])).min(1.0)
    }

    /// A hit as it is read back from the output's format. Positions are used for stripes alone.
    fn packed(&self, output: Output, hit: Hit, x: u32, y: u32) -> Hit {
        if !matches!(output, Output::Bytes24 | Output::Bytes12) {
            return hit;
        }
        let midway = (-self.ray(x, y)).extend(1.0).normalize() + Vec3::Z;
        let half_turned = |v: Vec3| midway * (v.dot(midway) / midway.z) - v;
        let mut xy = half_turned(hit.normal).truncate();
        let mut position = hit.position;
        if output == Output::Bytes12 {
            let byte = |value: f32| (value.clamp(-1.0, 1.0) * 127.0).round_ties_even() / 127.0;
            xy = Vec2::new(byte(xy.x), byte(xy.y));
            position = position.to_array().map(|value| half::f16::from_f32(value).to_f32()).into();
        }
        let z = (1.0 - xy.length_squared()).max(0.0).sqrt();
        Hit { position, normal: half_turned(xy.extend(z)) }
    }

    fn shade(&self, spheres: &Spheres, object: u32, atom: u32, hit: &Hit) -> [f32; 4] {
        let view = &self.view;
        let object = &spheres.objects[object as usize];
        let rgba = Spheres::color(object, spheres.atom_rgba[atom as usize]);
        let mut color = Vec3::new(rgba[0].into(), rgba[1].into(), rgba[2].into()) / 255.0;
        if view.striped != 0 {
            let world = Quat::from_array(view.turn).conjugate() * hit.position;
            let along = (Vec3::from(view.eye) + world).dot(Vec3::from(view.stripes));
            if along - along.floor() < 0.5 {
                color = Vec3::from_slice(&view.stripe_rgba);
            }
        }
        let cosine = hit.normal.dot(Vec3::from(view.light)).abs();
        (color * (view.ambient + (1.0 - view.ambient) * cosine)).extend(1.0).to_array()
    }
}
