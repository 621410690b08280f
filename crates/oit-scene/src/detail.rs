//! Levels of detail: clouds of fewer, larger spheres, and the distances from which they are drawn.

use glam::DVec3;

use crate::{Atom, Level, SphereKind, Spheres};

/// The lines of the picture and the vertical field of view for which levels are chosen.
const LINES: f64 = 1080.0;
const FOV_Y_DEGREES: f64 = 40.0;

/// Each level has about so many times fewer spheres than the one before.
const COARSENING: usize = 4;

/// No level but the finest has fewer spheres than this: a shape should be left.
const LEAST: usize = 6;

/// How wide, in pixels, a level's spheres may appear where it begins to be drawn, if nothing else is
/// said.
pub const DETAIL_PIXELS: f64 = 6.0;

/// Pixels that a length of 1 covers at a distance of 1, in a picture of 1080 lines that sees 40 degrees
/// from top to bottom. Levels of detail are chosen for it.
///
/// A level is drawn from the distance at which its spheres, of the radius whose volume is their mean,
/// appear [`DETAIL_PIXELS`] wide or less: `2 * radius * pixels_at_one() / DETAIL_PIXELS`.
#[must_use]
pub fn pixels_at_one() -> f64 {
    LINES / (2.0 * (FOV_Y_DEGREES / 2.0).to_radians().tan())
}

/// One level while it is made.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Cloud {
    pub(crate) atoms: Vec<Atom>,
    pub(crate) rgba: Vec<[u8; 4]>,
}

impl Cloud {
    pub(crate) fn push(&mut self, center: [f32; 3], radius: f32, rgba: [u8; 4]) {
        self.atoms.push(Atom { center, radius });
        self.rgba.push(rgba);
    }

    /// Fewer spheres in the same places: one for each of so many clusters, at most one for each atom.
    ///
    /// Clusters are the cells of a k-d tree that halves the atoms across the longest side of their box,
    /// so that all hold the same number but for rounding. A cluster's sphere has the volume of its atoms
    /// together and lies at their centre of volume, and its colour is their mean by volume. What atoms
    /// overlap is counted for each: spheres that overlap as their atoms did cover the same space.
    fn merged(&self, clusters: usize) -> Self {
        let mut members: Vec<u32> = (0..self.atoms.len() as u32).collect();
        let mut merged = Self::default();
        self.split(&mut members, clusters.clamp(1, self.atoms.len()), &mut merged);
        merged
    }

    fn split(&self, members: &mut [u32], clusters: usize, merged: &mut Self) {
        if clusters == 1 {
            return self.merge(members, merged);
        }
        let center = |atom: &u32| glam::Vec3::from(self.atoms[*atom as usize].center);
        let low = members.iter().map(center).reduce(glam::Vec3::min).unwrap_or_default();
        let high = members.iter().map(center).reduce(glam::Vec3::max).unwrap_or_default();
        let axis = (high - low).max_position();
        let first = clusters / 2;
        // As many atoms for each cluster, and at least one: there are no more clusters than atoms.
        let middle = (members.len() * first / clusters).max(first);
        // Ties by index, so that the result does not depend on how selecting works.
        let key = |atom: &u32| self.atoms[*atom as usize].center[axis];
        members.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (low, high) = members.split_at_mut(middle);
        self.split(low, first, merged);
        self.split(high, clusters - first, merged);
    }

    fn merge(&self, members: &mut [u32], merged: &mut Self) {
        // Selecting leaves them in no order, and sums depend on it.
        members.sort_unstable();
        let (mut volume, mut center, mut color) = (0.0, DVec3::ZERO, [0.0; 4]);
        for &member in &*members {
            let atom = self.atoms[member as usize];
            let share = f64::from(atom.radius).powi(3);
            volume += share;
            center += share * DVec3::from(atom.center.map(f64::from));
            for (sum, channel) in color.iter_mut().zip(self.rgba[member as usize]) {
                *sum += share * f64::from(channel);
            }
        }
        merged.push(
            (center / volume).as_vec3().to_array(),
            volume.cbrt() as f32,
            color.map(|sum| (sum / volume).round() as u8),
        );
    }

    /// The radius of the sphere that has the mean volume.
    fn mean_radius(&self) -> f64 {
        let volume: f64 = self.atoms.iter().map(|atom| f64::from(atom.radius).powi(3)).sum();
        (volume / self.atoms.len() as f64).cbrt()
    }
}

impl Spheres {
    /// Adds a kind and makes its levels of detail, at most so many: each has a quarter of the spheres of
    /// the one before and is drawn from where they appear `pixels` wide. The cloud must not be empty.
    /// Returns its place in [`Spheres::kinds`].
    pub(crate) fn push_kind(
        &mut self,
        name: String,
        finest: Cloud,
        levels: u64,
        pixels: f64,
    ) -> u32 {
        let first_level = self.levels.len() as u32;
        let mut radius = 0.0f64;
        let mut cloud = finest;
        let mut from_distance = 0.0f32;
        for level in 0..levels {
            if level > 0 {
                let fewer = cloud.atoms.len() / COARSENING;
                if fewer < LEAST {
                    break;
                }
                cloud = cloud.merged(fewer);
                let distance = 2.0 * cloud.mean_radius() * pixels_at_one() / pixels;
                // Distances rise with the radii; rounding could make two of them one.
                from_distance = (distance as f32).max(from_distance.next_up());
            }
            let first_atom = self.atoms.len() as u32;
            let atoms = cloud.atoms.len() as u32;
            self.levels.push(Level { first_atom, atoms, from_distance });
            self.atoms.extend(&cloud.atoms);
            self.atom_rgba.extend(&cloud.rgba);
            let reach = |atom: &Atom| {
                DVec3::from(atom.center.map(f64::from)).length() + f64::from(atom.radius)
            };
            radius = cloud.atoms.iter().map(reach).fold(radius, f64::max);
        }
        let levels = self.levels.len() as u32 - first_level;
        // Up, so that rounding leaves nothing outside.
        let radius = (radius as f32).next_up();
        self.kinds.push(SphereKind { name, first_level, levels, radius });
        self.kinds.len() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// A ball of atoms on a jittered lattice.
    fn ball(radius: f32, step: f32) -> Cloud {
        let mut random = SplitMix64::new(1);
        let mut cloud = Cloud::default();
        let cells = (radius / step) as i32 + 1;
        for x in -cells..=cells {
            for y in -cells..=cells {
                for z in -cells..=cells {
                    let at = [x, y, z].map(|cell| step * (cell as f32 + random.between(-0.3, 0.3)));
                    if glam::Vec3::from(at).length() < radius {
                        cloud.push(at, 0.66 * step, [100, 0, 200, 255]);
                    }
                }
            }
        }
        cloud
    }

    const CELLS: i32 = 24;

    /// Which points of a grid a cloud covers; z is the last to vary.
    fn covered(cloud: &Cloud, half: f32) -> Vec<bool> {
        let mut inside = Vec::new();
        for x in 0..CELLS {
            for y in 0..CELLS {
                for z in 0..CELLS {
                    let at =
                        [x, y, z].map(|i| half * (2.0 * (i as f32 + 0.5) / CELLS as f32 - 1.0));
                    let at = glam::Vec3::from(at);
                    inside.push(cloud.atoms.iter().any(|atom| {
                        at.distance_squared(atom.center.into()) < atom.radius * atom.radius
                    }));
                }
            }
        }
        inside
    }

    #[test]
    fn merging_keeps_volume_place_and_colour() {
        let finest = ball(5.0, 0.7);
        assert!(finest.atoms.len() > 1000);
        let volume = |cloud: &Cloud| cloud.atoms.len() as f64 * cloud.mean_radius().powi(3);
        for clusters in [1, 7, 100, finest.atoms.len() / 4] {
            let merged = finest.merged(clusters);
            assert_eq!(merged.atoms.len(), clusters);
            assert!((volume(&merged) / volume(&finest) - 1.0).abs() < 1e-5, "{clusters}");
            assert!(merged.rgba.iter().all(|rgba| *rgba == [100, 0, 200, 255]));
        }
        let one = finest.merged(1).atoms[0];
        assert!(glam::Vec3::from(one.center).length() < 0.1, "{one:?}");
        // One cluster for each atom is the same cloud in another order.
        let mut same = finest.merged(finest.atoms.len()).atoms;
        assert_eq!(finest.merged(usize::MAX).atoms, same);
        let mut atoms = finest.atoms;
        for cloud in [&mut same, &mut atoms] {
            cloud.sort_by(|a, b| a.center.partial_cmp(&b.center).unwrap());
        }
        for (same, atom) in same.iter().zip(&atoms) {
            let apart = glam::Vec3::from(same.center).distance(atom.center.into());
            assert!(apart < 1e-5 && (same.radius - atom.radius).abs() < 1e-6);
        }
    }

    #[test]
    fn coarser_levels_cover_nearly_the_same_space() {
        let finest = ball(5.0, 0.7);
        let fine = covered(&finest, 6.5);
        let count = |inside: &[bool]| inside.iter().filter(|inside| **inside).count() as f64;
        // What is seen along z.
        let outline = |inside: &[bool]| -> Vec<bool> {
            inside.chunks(CELLS as usize).map(|line| line.contains(&true)).collect()
        };
        for (fewer, limit, outline_limit) in [(4, 0.1, 0.1), (16, 0.1, 0.15), (64, 0.15, 0.2)] {
            let coarse = covered(&finest.merged(finest.atoms.len() / fewer), 6.5);
            let difference = count(&coarse) / count(&fine) - 1.0;
            assert!(difference.abs() < limit, "1/{fewer}: volume {difference}");
            let (seen, coarse) = (outline(&fine), outline(&coarse));
            let apart = seen.iter().zip(&coarse).filter(|(a, b)| a != b).count() as f64;
            assert!(apart / count(&seen) < outline_limit, "1/{fewer}: outline {apart}");
        }
    }

    #[test]
    fn levels_rise_and_lie_within_the_radius() {
        let mut spheres = Spheres::default();
        let mut few = Cloud::default();
        few.push([1.0, 0.0, 0.0], 0.5, [255; 4]);
        assert_eq!(spheres.push_kind("few".into(), few, 8, 4.0), 0);
        assert_eq!(spheres.push_kind("ball".into(), ball(5.0, 0.7), 8, 4.0), 1);
        assert_eq!(spheres.kinds[0].levels, 1);
        assert!(spheres.kinds[0].radius >= 1.5 && spheres.kinds[0].radius < 1.5001);
        let kind = &spheres.kinds[1];
        let levels = &spheres.levels[kind.first_level as usize..];
        assert_eq!(levels.len(), kind.levels as usize);
        assert!(levels.len() >= 4);
        assert_eq!(levels[0].from_distance, 0.0);
        for pair in levels.windows(2) {
            assert!(pair[0].from_distance < pair[1].from_distance);
            assert_eq!(pair[1].atoms, pair[0].atoms / 4);
            assert_eq!(pair[1].first_atom, pair[0].first_atom + pair[0].atoms);
            // Four atoms in one sphere are the cube root of four as wide.
            let first = spheres.atoms[pair[1].first_atom as usize];
            let wide = 2.0 * f64::from(first.radius) * pixels_at_one() / 4.0;
            assert!((f64::from(pair[1].from_distance) / wide - 1.0).abs() < 0.2);
        }
        assert!(levels.last().unwrap().atoms >= 6);
    }
}
