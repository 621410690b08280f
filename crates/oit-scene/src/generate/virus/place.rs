//! Where molecules lie, and how they are turned.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Quat, Vec3};

use crate::SplitMix64;

/// The golden angle, radians: turned by it again and again, no direction is met twice.
pub(super) const GOLDEN: f32 = 2.399_963_2;

/// A place and what points out of the surface there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
}

/// A unit vector, all alike likely.
pub(super) fn unit(random: &mut SplitMix64) -> Vec3 {
    let z = random.between(-1.0, 1.0);
    let (sin, cos) = random.between(0.0, TAU).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

/// A rotation, all alike likely.
pub(super) fn any_rotation(random: &mut SplitMix64) -> Quat {
    // Shoemake, Uniform Random Rotations, Graphics Gems III (1992).
    let (u, a, b) = (random.unit(), random.between(0.0, TAU), random.between(0.0, TAU));
    let (first, second) = ((1.0 - u).sqrt(), u.sqrt());
    Quat::from_xyzw(first * a.sin(), first * a.cos(), second * b.sin(), second * b.cos())
        .normalize()
}

/// A rotation that turns z to the normal, and about it by chance.
pub(super) fn upright(normal: Vec3, random: &mut SplitMix64) -> Quat {
    Quat::from_rotation_arc(Vec3::Z, normal) * Quat::from_rotation_z(random.between(0.0, TAU))
}

/// So many places spread evenly over a sphere about the origin, in a spiral.
pub(super) fn on_sphere(count: u64, radius: f32) -> impl Iterator<Item = Place> {
    (0..count).map(move |i| {
        // In f64: half a million and more turns leave little of an f32's fraction.
        let y = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
        let ring = (1.0 - y * y).sqrt();
        let (sin, cos) = (i as f64 * f64::from(GOLDEN)).sin_cos();
        let normal = glam::DVec3::new(ring * cos, y, ring * sin).as_vec3();
        Place { position: radius * normal, normal }
    })
}

/// A cone with round ends about an axis through the origin: the hull of two balls.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cone {
    /// Unit length, towards the wide end.
    pub(super) axis: Vec3,
    /// Where on the axis each ball's middle lies, the narrow one's first.
    pub(super) middles: [f32; 2],
    /// Of each ball.
    pub(super) radii: [f32; 2],
}

/// Which part of a cone's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    NarrowEnd,
    Side,
    WideEnd,
}

impl Cone {
    /// How deep a point lies within: 0 on the surface, less outside. To a few percent.
    pub(super) fn depth(&self, point: Vec3) -> f32 {
        const STEPS: u32 = 24;
        let depth = |step: u32| {
            let t = step as f32 / STEPS as f32;
            let [middle, radius] =
                [self.middles, self.radii].map(|[narrow, wide]| narrow + (wide - narrow) * t);
            radius - point.distance(self.axis * middle)
        };
        (0..=STEPS).map(depth).fold(f32::NEG_INFINITY, f32::max)
    }

    /// So many places spread evenly over the surface, in a spiral from the narrow end to the wide one.
    pub(super) fn surface(&self, count: u64) -> Vec<(Place, Part)> {
        const SAMPLES: usize = 256;
        let across = self.axis.any_orthonormal_vector();
        let other = self.axis.cross(across);
        // The outline's normal leans back by this angle on the side.
        let slope = (self.radii[1] - self.radii[0]) / (self.middles[1] - self.middles[0]);
        let seam = FRAC_PI_2 - slope.asin();
        // Outline: for each sample the angle of its normal from the narrow pole, and its ball (0 to 1).
        let steps = |samples: usize| (0..samples).map(move |i| i as f32 / samples as f32);
        let narrow = steps(SAMPLES).map(|t| (seam * t, 0.0, Part::NarrowEnd));
        let side = steps(SAMPLES).map(|t| (seam, t, Part::Side));
        let wide = steps(SAMPLES).map(|t| (seam + (PI - seam) * t, 1.0, Part::WideEnd));
        let outline: Vec<_> = narrow
            .chain(side)
            .chain(wide)
            .chain([(PI, 1.0, Part::WideEnd)])
            .map(|(angle, t, part)| {
                let [middle, radius] =
                    [self.middles, self.radii].map(|[narrow, wide]| narrow + (wide - narrow) * t);
                let normal = [-angle.cos(), angle.sin()];
                ([middle + radius * normal[0], radius * normal[1]], normal, part)
            })
            .collect();
        let mut areas = vec![0.0];
        for pair in outline.windows(2) {
            let ([a, b], [c, d]) = (pair[0].0, pair[1].0);
            areas.push(areas[areas.len() - 1] + (b + d) / 2.0 * (c - a).hypot(d - b));
        }
        let all = areas[areas.len() - 1];
        let place = |i: u64| {
            let wanted = all * (i as f32 + 0.5) / count as f32;
            let after = areas.partition_point(|area| *area < wanted).clamp(1, areas.len() - 1);
            let t = (wanted - areas[after - 1])
                / (areas[after] - areas[after - 1]).max(f32::MIN_POSITIVE);
            let (from, normal, part) = outline[after - 1];
            let [along, out] =
                std::array::from_fn(|k| from[k] + t * (outline[after].0[k] - from[k]));
            let (sin, cos) = ((i as f64 * f64::from(GOLDEN)) % f64::from(TAU)).sin_cos();
            let outward = across * cos as f32 + other * sin as f32;
            let position = self.axis * along + outward * out;
            (Place { position, normal: self.axis * normal[0] + outward * normal[1] }, part)
        };
        (0..count).map(place).collect()
    }

    /// A curve of so many steps of a length within the cone, at least `margin` below its surface: each
    /// step's middle and direction.
    pub(super) fn curve(
        &self,
        count: u64,
        step: f32,
        margin: f32,
        random: &mut SplitMix64,
    ) -> Vec<(Vec3, Vec3)> {
        /// How much a step turns from the one before.
        const BEND: f32 = 0.55;
        let heart = self.axis * (self.middles[0] + self.middles[1]) / 2.0;
        let mut at = heart + 5.0 * unit(random);
        let mut along = unit(random);
        let mut steps = Vec::with_capacity(count as usize);
        for _ in 0..count {
            along = (along + BEND * unit(random)).normalize_or(along);
            // Towards a place on the axis beside it, the more the closer the wall is.
            let near = self.axis * at.dot(self.axis).clamp(self.middles[0], self.middles[1]);
            let inward = (near - at).normalize_or(along);
            let mut turn = 0.25;
            while self.depth(at + step * along) < margin && turn < 4.0 {
                along = (along + turn * inward).normalize_or(inward);
                turn *= 2.0;
            }
            steps.push((at + along * step / 2.0, along));
            at += step * along;
        }
        steps
    }
}

/// So many places in a box where `free`, of which about the volume `free_volume` is free, at random: each
/// in a cell of a cubic lattice of its own.
pub(super) fn scattered(
    count: usize,
    [low, high]: [Vec3; 2],
    free_volume: f32,
    free: impl Fn(Vec3) -> bool,
    random: &mut SplitMix64,
) -> Vec<Vec3> {
    /// How far from its cell's middle at most, as a share of the cell.
    const JITTER: f32 = 0.35;
    if count == 0 {
        return Vec::new();
    }
    let mut cell = (free_volume / count as f32).cbrt();
    loop {
        let cells = ((high - low) / cell).floor().max(Vec3::ONE);
        let size = (high - low) / cells;
        let [nx, ny, nz] = cells.to_array().map(|cells| cells as u32);
        let middles = (0..nx).flat_map(|x| {
            (0..ny).flat_map(move |y| (0..nz).map(move |z| Vec3::new(x as f32, y as f32, z as f32)))
        });
        let middles = middles.map(|at| low + (at + 0.5) * size);
        let mut places: Vec<Vec3> = middles.filter(|at| free(*at)).collect();
        if places.len() < count {
            // The free volume is not quite what was said.
            cell *= 0.99;
            continue;
        }
        for i in 0..count {
            let other = i + random.below(places.len() - i);
            places.swap(i, other);
        }
        places.truncate(count);
        for place in &mut places {
            let jitter = [(); 3].map(|()| random.between(-JITTER, JITTER));
            *place += Vec3::from(jitter) * size;
        }
        return places;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONE: Cone = Cone { axis: Vec3::X, middles: [-30.0, 20.0], radii: [10.0, 25.0] };

    #[test]
    fn places_on_surfaces_are_on_them_and_even() {
        for place in on_sphere(1000, 7.0) {
            assert!((place.position.length() - 7.0).abs() < 1e-4);
            assert!((place.position / 7.0).distance(place.normal) < 1e-5);
        }
        let places = CONE.surface(2000);
        for (place, part) in &places {
            assert!(CONE.depth(place.position).abs() < 0.2, "{place:?} {part:?}");
            assert!((place.normal.length() - 1.0).abs() < 1e-4);
            assert!(CONE.depth(place.position + place.normal) < -0.8, "{place:?} {part:?}");
        }
        // Areas of the ends: of a ball beyond a plane.
        let part = |wanted| places.iter().filter(|(_, part)| *part == wanted).count() as f32;
        let sine: f32 = 15.0 / 50.0;
        let narrow = 2.0 * PI * 100.0 * (1.0 - sine);
        let wide = 2.0 * PI * 625.0 * (1.0 + sine);
        assert!((part(Part::NarrowEnd) / part(Part::WideEnd) / (narrow / wide) - 1.0).abs() < 0.03);
        assert!(places.iter().all(|(place, _)| {
            places.iter().all(|(other, _)| {
                std::ptr::eq(place, other) || place.position.distance(other.position) > 1.0
            })
        }));
    }

    #[test]
    fn a_curve_stays_within() {
        let steps = CONE.curve(5000, 1.5, 3.0, &mut SplitMix64::new(1));
        assert_eq!(steps.len(), 5000);
        let outside = steps.iter().filter(|(at, _)| CONE.depth(*at) < 1.0).count();
        assert_eq!(outside, 0);
        for pair in steps.windows(2) {
            assert!(pair[0].0.distance(pair[1].0) < 1.5001);
        }
        // It gets about.
        let least = steps.iter().map(|(at, _)| at.x).fold(f32::MAX, f32::min);
        let most = steps.iter().map(|(at, _)| at.x).fold(f32::MIN, f32::max);
        assert!(least < -20.0 && most > 30.0, "{least} {most}");
    }

    #[test]
    fn scattered_places_are_free_and_apart() {
        let low = Vec3::splat(-10.0);
        let free = |at: Vec3| at.length() > 5.0;
        let volume = 8000.0 - 4.0 / 3.0 * PI * 125.0;
        let places = scattered(500, [low, -low], volume, free, &mut SplitMix64::new(3));
        assert_eq!(places.len(), 500);
        for (i, place) in places.iter().enumerate() {
            assert!(place.length() > 4.0 && place.abs().max_element() < 10.0);
            assert!(places[..i].iter().all(|other| place.distance(*other) > 0.3));
        }
        assert!(scattered(0, [low, -low], volume, free, &mut SplitMix64::new(3)).is_empty());
    }
}
