//! Molecules as spheres: objects that share clouds of atoms, in several levels of detail.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

/// No generator or importer makes more atoms than this, all levels together (2 GiB, colours 512 MiB).
pub const MAX_ATOMS: u64 = 1 << 27;

/// No generator or importer makes more objects than this (576 MiB).
pub const MAX_OBJECTS: u64 = 1 << 24;

/// A scene of spheres. Objects (say, protein instances) share kinds (protein types); a kind has a
/// cloud of atoms for each of its levels of detail. Objects, and atoms within a level, are kept in
/// the order in which they are to be submitted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spheres {
    /// The atoms of all levels of all kinds.
    pub atoms: Vec<Atom>,
    /// The colour of each atom: straight alpha, linear values, 255 is 1.
    pub atom_rgba: Vec<[u8; 4]>,
    /// The levels of all kinds.
    pub levels: Vec<Level>,
    /// What objects can be.
    pub kinds: Vec<Kind>,
    /// What is drawn.
    pub objects: Vec<Object>,
}

/// One sphere of a cloud: 16 bytes, without padding.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Atom {
    /// Its centre, in its object's space.
    pub center: [f32; 3],
    /// Above 0, world units: objects are turned and moved, not scaled.
    pub radius: f32,
}

/// One level of detail of a kind: 12 bytes, without padding.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Level {
    /// Its first atom in [`Spheres::atoms`].
    pub first_atom: u32,
    /// How many atoms it has, at least 1.
    pub atoms: u32,
    /// It is drawn where the camera's distance from the object's position is this much or more,
    /// unless the next level is. 0 for a kind's first level, and rising.
    pub from_distance: f32,
}

/// What an object can be: a protein type.
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// What it stands for.
    pub name: String,
    /// Its finest level in [`Spheres::levels`]; coarser ones follow.
    pub first_level: u32,
    /// How many levels it has, at least 1.
    pub levels: u32,
    /// The radius of a sphere about the object's position that holds all its levels.
    pub radius: f32,
}

/// One object: 36 bytes, without padding.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Object {
    /// Where its space's origin lies, world space.
    pub position: [f32; 3],
    /// How it is turned: a unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
    /// Its kind in [`Spheres::kinds`].
    pub kind: u32,
    /// Multiplies its atoms' colours.
    pub rgba: [u8; 4],
}

impl Spheres {
    /// Spheres that are drawn where every object is in full detail.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.objects.iter().map(|object| self.level_atoms(object, 0)).sum()
    }

    /// The atoms of the level of a kind that is drawn at this distance from the camera.
    #[must_use]
    pub fn level_at(&self, kind: &Kind, distance: f32) -> &Level {
        let levels = &self.levels[kind.first_level as usize..][..kind.levels as usize];
        levels.iter().rev().find(|level| distance >= level.from_distance).unwrap_or(&levels[0])
    }

    /// A sphere of an object in world space: its centre and radius.
    #[must_use]
    pub fn placed(&self, object: &Object, atom: &Atom) -> (Vec3, f32) {
        let rotation = Quat::from_array(object.rotation);
        (Vec3::from(object.position) + rotation * Vec3::from(atom.center), atom.radius)
    }

    /// The colour of an object's atom: both multiplied, rounded.
    #[must_use]
    pub fn color(object: &Object, atom: [u8; 4]) -> [u8; 4] {
        let product = |(a, b): (u8, u8)| ((u32::from(a) * u32::from(b) + 127) / 255) as u8;
        std::array::from_fn(|channel| product((atom[channel], object.rgba[channel])))
    }

    fn level_atoms(&self, object: &Object, level: u32) -> u64 {
        let kind = &self.kinds[object.kind as usize];
        u64::from(self.levels[(kind.first_level + level) as usize].atoms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_follows_the_distance() {
        let level = |first_atom, from_distance| Level { first_atom, atoms: 1, from_distance };
        let spheres = Spheres {
            levels: vec![level(7, 0.0), level(0, 0.0), level(1, 10.0), level(2, 20.0)],
            ..Spheres::default()
        };
        let kind = Kind { name: "k".into(), first_level: 1, levels: 3, radius: 1.0 };
        for (distance, atom) in [(0.0, 0), (9.9, 0), (10.0, 1), (19.0, 1), (20.0, 2), (1e9, 2)] {
            assert_eq!(spheres.level_at(&kind, distance).first_atom, atom, "{distance}");
        }
    }

    #[test]
    fn sizes_are_the_shaders() {
        assert_eq!((size_of::<Atom>(), size_of::<Level>(), size_of::<Object>()), (16, 12, 36));
    }
}
