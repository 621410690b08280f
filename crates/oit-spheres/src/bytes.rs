//! What a device keeps of spheres.

use std::sync::Arc;

use oit_scene::{Level, Spheres};

/// The bytes that a device reads of spheres: made once, shared by all views and variations. A clone
/// shares them.
#[derive(Clone, Debug)]
pub struct SphereBytes {
    /// The spheres.
    pub spheres: Arc<Spheres>,
    /// 16 bytes an atom: its centre and radius.
    pub(crate) atoms: Arc<[u8]>,
    /// 4 bytes an atom.
    pub(crate) atom_rgba: Arc<[u8]>,
    /// 12 bytes a level.
    pub(crate) levels: Arc<[u8]>,
    /// 12 bytes a kind: its first level, how many, its radius.
    pub(crate) kinds: Arc<[u8]>,
    /// 32 bytes an object: its position and kind, its rotation.
    pub(crate) places: Arc<[u8]>,
    /// 4 bytes an object.
    pub(crate) object_rgba: Arc<[u8]>,
}

impl SphereBytes {
    /// Spheres as a device reads them.
    #[must_use]
    pub fn new(spheres: &Arc<Spheres>) -> Self {
        let kinds: Vec<[u32; 3]> = spheres
            .kinds
            .iter()
            .map(|kind| [kind.first_level, kind.levels, kind.radius.to_bits()])
            .collect();
        let places: Vec<[u32; 8]> = spheres
            .objects
            .iter()
            .map(|object| {
                let [x, y, z] = object.position.map(f32::to_bits);
                let [a, b, c, d] = object.rotation.map(f32::to_bits);
                [x, y, z, object.kind, a, b, c, d]
            })
            .collect();
        let object_rgba: Vec<[u8; 4]> = spheres.objects.iter().map(|object| object.rgba).collect();
        Self {
            atoms: bytemuck::cast_slice(&spheres.atoms).into(),
            atom_rgba: bytemuck::cast_slice(&spheres.atom_rgba).into(),
            levels: bytemuck::cast_slice::<Level, u8>(&spheres.levels).into(),
            kinds: bytemuck::cast_slice(&kinds).into(),
            places: bytemuck::cast_slice(&places).into(),
            object_rgba: bytemuck::cast_slice(&object_rgba).into(),
            spheres: spheres.clone(),
        }
    }

    /// Of all objects, the places they take at most in a list with a place for each so many atoms.
    pub(crate) fn places_of(&self, atoms_a_place: u32) -> u64 {
        let spheres = &self.spheres;
        let most: Vec<u64> = spheres
            .kinds
            .iter()
            .map(|kind| {
                let levels = &spheres.levels[kind.first_level as usize..][..kind.levels as usize];
                levels.iter().map(|level| level.atoms.div_ceil(atoms_a_place)).max().unwrap_or(0)
            })
            .map(u64::from)
            .collect();
        spheres.objects.iter().map(|object| most[object.kind as usize]).sum()
    }
}
