//! What a picture of spheres must show, in double precision: for each pixel the nearest sphere that
//! its ray meets, without any code of what it judges.
//!
//! Billboards are rasterised with corners in 256ths of a pixel, and depths are rounded, so a pixel at
//! a sphere's rim, or where two spheres meet, may rightly show either side. Each pixel is therefore
//! looked at in five places a little apart. Where these do not all see the same sphere, or one so
//! near behind it that rounding decides, the pixel is undecided; elsewhere the colours there, and a
//! 255th, are what it may have.

use glam::{DQuat, DVec2, DVec3, Vec3};
use oit_scene::{Camera, Object, Projection, Shading, Spheres};
use rayon::prelude::*;

use crate::Detail;

/// How far from a pixel's middle it is looked at as well, pixels.
const OFFSET_PX: f64 = 1.0 / 64.0;

/// How much colours may differ from what is expected.
const TOLERANCE: f64 = 1.0 / 255.0;

/// Depths this close, relative to the distance from the eye, may be taken for each other.
const SAME_DEPTH: f64 = 3e-6;

/// Rows of a band.
const BAND_ROWS: u32 = 8;

/// What a picture must show.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The colour in the middle of each pixel, premultiplied, rows top to bottom.
    picture: Vec<[f32; 4]>,
    /// The least and the greatest of each channel; `None` where the pixel is undecided.
    bounds: Vec<Option<[[f32; 3]; 2]>>,
}

/// How a picture compares with what was expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Pixels with a colour that they may not have, or covered where they should not be, or not
    /// covered where they should.
    pub wrong_px: u64,
    /// Pixels that may show one of several things, and are in none of the other numbers.
    pub undecided_px: u64,
    /// The greatest difference of a channel of colour.
    pub max_error: f64,
    /// The root of the mean square of differences of channels of colour.
    pub rmse: f64,
    /// The greatest difference of alpha.
    pub max_alpha_error: f64,
}

impl Expected {
    /// The exact picture: premultiplied, alpha 1 where there is a sphere, else 0. Rows top to bottom.
    #[must_use]
    pub fn picture(&self) -> &[[f32; 4]] {
        &self.picture
    }

    /// Compares a picture with it.
    ///
    /// # Panics
    /// Where it is of another size.
    #[must_use]
    pub fn compare(&self, picture: &[[f32; 4]]) -> Comparison {
        assert_eq!(picture.len(), self.picture.len(), "pictures of one size");
        let mut comparison = Comparison {
            wrong_px: 0,
            undecided_px: 0,
            max_error: 0.0,
            rmse: 0.0,
            max_alpha_error: 0.0,
        };
        let (mut squares, mut channels) = (0.0, 0u64);
        for ((got, expected), bounds) in picture.iter().zip(&self.picture).zip(&self.bounds) {
            let Some([low, high]) = bounds else {
                comparison.undecided_px += 1;
                continue;
            };
            let alpha_error = f64::from((got[3] - expected[3]).abs());
            let mut wrong = alpha_error.is_nan() || alpha_error >= 0.5;
            comparison.max_alpha_error = comparison.max_alpha_error.max(alpha_error);
            for channel in 0..3 {
                let value = f64::from(got[channel]);
                let error = (value - f64::from(expected[channel])).abs();
                comparison.max_error = comparison.max_error.max(error);
                squares += error * error;
                channels += 1;
                let (low, high) = (f64::from(low[channel]), f64::from(high[channel]));
                wrong |= !(low - TOLERANCE..=high + TOLERANCE).contains(&value);
            }
            comparison.wrong_px += u64::from(wrong);
        }
        comparison.rmse = if channels == 0 { 0.0 } else { (squares / channels as f64).sqrt() };
        comparison
    }
}

/// The picture of spheres at a level of detail.
#[must_use]
pub fn expected(
    spheres: &Spheres,
    detail: Detail,
    shading: &Shading,
    camera: &Camera,
    width_px: u32,
    height_px: u32,
) -> Expected {
    let eye = Eye::new(camera, width_px, height_px);
    let bands = height_px.div_ceil(BAND_ROWS);
    let mut lists = vec![Vec::new(); bands as usize];
    for (number, object) in spheres.objects.iter().enumerate() {
        let center = point(object.position);
        let radius = f64::from(spheres.kinds[object.kind as usize].radius);
        if let Some([_, rows]) = eye.extent(center, radius) {
            for band in rows[0] / BAND_ROWS..=rows[1] / BAND_ROWS {
                lists[band as usize].push((eye.depth(center) - radius, number as u32));
            }
        }
    }
    type Pixels = Vec<([f32; 4], Option<[[f32; 3]; 2]>)>;
    let band = |(band, list): (usize, &mut Vec<(f64, u32)>)| -> Pixels {
        // The nearest first, so that most of what is behind is soon seen to be.
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first_row = band as u32 * BAND_ROWS;
        let rows = BAND_ROWS.min(height_px - first_row);
        let mut pixels = vec![[Sample::EMPTY; 5]; (rows * width_px) as usize];
        for &(_, number) in list.iter() {
            let object = &spheres.objects[number as usize];
            draw(&eye, spheres, detail, number, object, first_row..first_row + rows, &mut pixels);
        }
        let color = |(at, samples): (usize, &[Sample; 5])| {
            let (x, y) = (at as u32 % width_px, first_row + at as u32 / width_px);
            settle(&eye, spheres, shading, x, y, samples)
        };
        pixels.iter().enumerate().map(color).collect()
    };
    let pixels: Vec<Pixels> = lists.par_iter_mut().enumerate().map(band).collect();
    let (picture, bounds) = pixels.into_iter().flatten().unzip();
    Expected { picture, bounds }
}

fn point(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// The camera in double precision.
struct Eye {
    at: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    perspective: bool,
    /// Half the image's width and height at depth 1, or at any.
    half: DVec2,
    near: f64,
    far: f64,
    size: [u32; 2],
}

impl Eye {
    fn new(camera: &Camera, width_px: u32, height_px: u32) -> Self {
        let at = point(camera.eye);
        let forward = (point(camera.target) - at).normalize();
        let right = forward.cross(point(camera.up)).normalize();
        let (perspective, half, near, far) = match camera.projection {
            Projection::Perspective { fov_y_degrees, near, far } => {
                (true, (f64::from(fov_y_degrees).to_radians() * 0.5).tan(), near, far)
            }
            Projection::Orthographic { height, near, far } => {
                (false, f64::from(height) * 0.5, near, far)
            }
        };
        let aspect = f64::from(width_px) / f64::from(height_px);
        Self {
            at,
            right,
            up: right.cross(forward),
            forward,
            perspective,
            half: DVec2::new(half * aspect, half),
            near: f64::from(near),
            far: f64::from(far),
            size: [width_px, height_px],
        }
    }

    fn depth(&self, p: DVec3) -> f64 {
        (p - self.at).dot(self.forward)
    }

    /// A ray's origin and direction, whose depth grows by 1 with the ray's parameter.
    fn ray(&self, x_px: f64, y_px: f64) -> (DVec3, DVec3) {
        let x = (2.0 * x_px / f64::from(self.size[0]) - 1.0) * self.half.x;
        let y = (1.0 - 2.0 * y_px / f64::from(self.size[1])) * self.half.y;
        let aside = self.right * x + self.up * y;
        match self.perspective {
            true => (self.at, self.forward + aside),
            false => (self.at + aside, self.forward),
        }
    }

    /// The pixels, first and last of x and of y, that a sphere may touch.
    fn extent(&self, center: DVec3, radius: f64) -> Option<[[u32; 2]; 2]> {
        let depth = self.depth(center);
        if depth + radius < self.near || depth - radius > self.far {
            return None;
        }
        let aside = center - self.at;
        let aside = [aside.dot(self.right), -aside.dot(self.up)];
        let mut extent = [[0; 2]; 2];
        for axis in 0..2 {
            let (low, high) = match self.perspective {
                false => (aside[axis] - radius, aside[axis] + radius),
                // All of it, unless it is wholly before the camera; then the angles of the tangents.
                true if depth <= radius => (f64::NEG_INFINITY, f64::INFINITY),
                true => {
                    let distance = aside[axis].hypot(depth);
                    let middle = aside[axis].atan2(depth);
                    let half = (radius / distance).min(1.0).asin();
                    let edge = |angle: f64| match angle.abs() < std::f64::consts::FRAC_PI_2 {
                        true => angle.tan(),
                        false => angle.signum() * f64::INFINITY,
                    };
                    (edge(middle - half), edge(middle + half))
                }
            };
            let size = f64::from(self.size[axis]);
            let pixel = |value: f64| (value / self.half[axis] + 1.0) * 0.5 * size;
            // A pixel more on either side.
            let first = (pixel(low) - 1.5).floor();
            let last = (pixel(high) + 0.5).ceil();
            if last < 0.0 || first > size - 1.0 {
                return None;
            }
            extent[axis] = [first.max(0.0) as u32, last.min(size - 1.0) as u32];
        }
        Some(extent)
    }
}

/// What one place of a pixel sees.
#[derive(Clone, Copy)]
struct Sample {
    depth: f64,
    /// Of the next sphere behind.
    next_depth: f64,
    object: u32,
    atom: u32,
}

impl Sample {
    const EMPTY: Self =
        Self { depth: f64::INFINITY, next_depth: f64::INFINITY, object: u32::MAX, atom: u32::MAX };
}

/// A pixel's middle, and four places about it.
const PLACES: [[f64; 2]; 5] = [
    [0.0, 0.0],
    [-OFFSET_PX, -OFFSET_PX],
    [OFFSET_PX, -OFFSET_PX],
    [-OFFSET_PX, OFFSET_PX],
    [OFFSET_PX, OFFSET_PX],
];

/// A sphere's middle in the world.
fn center_of(spheres: &Spheres, object: &Object, atom: u32) -> DVec3 {
    let [x, y, z, w] = object.rotation.map(f64::from);
    let turn = DQuat::from_xyzw(x, y, z, w).normalize();
    point(object.position) + turn * point(spheres.atoms[atom as usize].center)
}

fn draw(
    eye: &Eye,
    spheres: &Spheres,
    detail: Detail,
    number: u32,
    object: &Object,
    band: std::ops::Range<u32>,
    pixels: &mut [[Sample; 5]],
) {
    let kind = &spheres.kinds[object.kind as usize];
    let distance = Vec3::from(object.position).distance(eye.at.as_vec3());
    let level = match detail {
        Detail::ByDistance => spheres.level_at(kind, distance),
        Detail::Full => &spheres.levels[kind.first_level as usize],
    };
    for atom in level.first_atom..level.first_atom + level.atoms {
        let center = center_of(spheres, object, atom);
        let radius = f64::from(spheres.atoms[atom as usize].radius);
        let Some([columns, rows]) = eye.extent(center, radius) else { continue };
        let front = eye.depth(center) - radius;
        for y in rows[0].max(band.start)..(rows[1] + 1).min(band.end) {
            for x in columns[0]..=columns[1] {
                let at = ((y - band.start) * eye.size[0] + x) as usize;
                for (sample, [dx, dy]) in pixels[at].iter_mut().zip(PLACES) {
                    if front > sample.next_depth {
                        continue;
                    }
                    let (origin, direction) =
                        eye.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
                    let Some(depth) = meet(origin, direction, center, radius) else { continue };
                    if depth < eye.near || depth >= eye.far {
                        continue;
                    }
                    if depth < sample.depth {
                        let next_depth = sample.depth;
                        *sample = Sample { depth, next_depth, object: number, atom };
                    } else if depth < sample.next_depth {
                        sample.next_depth = depth;
                    }
                }
            }
        }
    }
}

/// Where a ray first meets a sphere.
fn meet(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let from = origin - center;
    let a = direction.length_squared();
    let b = from.dot(direction);
    let c = from.length_squared() - radius * radius;
    let discriminant = b * b - a * c;
    (discriminant >= 0.0).then(|| (-b - discriminant.sqrt()) / a)
}

/// A pixel's colour, and what it may be.
fn settle(
    eye: &Eye,
    spheres: &Spheres,
    shading: &Shading,
    x: u32,
    y: u32,
    samples: &[Sample; 5],
) -> ([f32; 4], Option<[[f32; 3]; 2]>) {
    let mut decided = true;
    let mut colors = [[0.0; 3]; 5];
    let mut first_stripe = None;
    for (i, (sample, [dx, dy])) in samples.iter().zip(PLACES).enumerate() {
        decided &= (sample.object, sample.atom) == (samples[0].object, samples[0].atom);
        if sample.object == u32::MAX {
            continue;
        }
        let (origin, direction) = eye.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
        let at = origin + direction * sample.depth;
        let scale = SAME_DEPTH * (at - eye.at).length();
        decided &= sample.next_depth - sample.depth > scale;
        // The planes cut a sphere as others do.
        decided &= sample.depth - eye.near > scale && eye.far - sample.depth > scale;
        let object = &spheres.objects[sample.object as usize];
        let normal = (at - center_of(spheres, object, sample.atom)).normalize();
        let mut rgba = Spheres::color(object, spheres.atom_rgba[sample.atom as usize]);
        if let Some(stripes) = &shading.stripes {
            let along = at.dot(point(stripes.direction)) / f64::from(stripes.period);
            let striped = along - along.floor() < 0.5;
            decided &= *first_stripe.get_or_insert(striped) == striped;
            if striped {
                rgba = stripes.rgba;
            }
        }
        let ambient = f64::from(shading.ambient);
        let light = point(shading.light).normalize_or_zero();
        let lit = ambient + (1.0 - ambient) * normal.dot(light).abs();
        for channel in 0..3 {
            colors[i][channel] = (f64::from(rgba[channel]) / 255.0 * lit) as f32;
        }
    }
    let [r, g, b] = colors[0];
    let alpha = if samples[0].object == u32::MAX { 0.0 } else { 1.0 };
    let bound = |pick: fn(f32, f32) -> f32| {
        std::array::from_fn(|channel| {
            colors.map(|color| color[channel]).into_iter().fold(colors[0][channel], pick)
        })
    };
    ([r, g, b, alpha], decided.then(|| [bound(f32::min), bound(f32::max)]))
}
