//! Which sphere a fragment is of, in 32 bits.

use oit_gpu::Buffer;
use oit_scene::Spheres;

use crate::text::word;

/// How 32 bits say which sphere a fragment is of.
///
/// The thesis keeps 16 bits of an atom and 16 of its object, whatever their number (Table 3.4): with
/// more than 65,536 objects they wrap, and a picture coloured by them is wrong. Here every
/// fragment's colour, and with 4 bytes all of it, is found by its id, so ids are exact, and a scene
/// that has more spheres than 32 bits count is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Ids {
    /// An object's number, and in so many bits that of the atom within its level: 16, as in the
    /// thesis, as long as that is enough for both; else the one that needs more takes bits from the
    /// other.
    Split {
        /// Bits of the atom.
        atom_bits: u32,
    },
    /// Where they do not share 32 bits: the number among all atoms of all objects. The object is
    /// found again by a binary search, for each pixel that is shaded.
    Numbered,
}

impl Ids {
    /// How the ids of a scene are made.
    ///
    /// # Errors
    /// Where 32 bits do not suffice.
    pub(crate) fn of(spheres: &Spheres) -> Result<Self, String> {
        let bits = |count: usize| count.next_power_of_two().trailing_zeros();
        let most_atoms = spheres.levels.iter().map(|level| level.atoms).max().unwrap_or(1);
        let (object_bits, atom_bits) = (bits(spheres.objects.len()), bits(most_atoms as usize));
        // All ones stand for nothing, so that one id fewer than there are words can be had.
        if object_bits + atom_bits < 32
            || (object_bits, atom_bits) == (16, 16) && spheres.objects.len() < 1 << 16
        {
            let atom_bits = if object_bits > 16 { 32 - object_bits } else { atom_bits.max(16) };
            return Ok(Self::Split { atom_bits });
        }
        let total: u64 = most(spheres).iter().map(|&atoms| u64::from(atoms)).sum();
        if total >= u64::from(u32::MAX) {
            return Err(format!("{total} spheres are more than ids of 32 bits count"));
        }
        Ok(Self::Numbered)
    }

    /// WGSL: `id_of` and `of_id`.
    pub(crate) fn wgsl(self) -> String {
        match self {
            Self::Split { atom_bits } => {
                word("ATOM_BITS", atom_bits) + include_str!("wgsl/ids_split.wgsl")
            }
            Self::Numbered => include_str!("wgsl/ids_numbered.wgsl").to_owned(),
        }
    }

    /// The buffer that they take, if they take one.
    pub(crate) fn buffer(self, spheres: &Spheres) -> Option<Buffer> {
        if self != Self::Numbered {
            return None;
        }
        let mut next = 0;
        let first: Vec<u32> = most(spheres)
            .into_iter()
            .map(|atoms| {
                next += atoms;
                next - atoms
            })
            .collect();
        Some(Buffer::data("first_ids", bytemuck::cast_slice(&first).into()))
    }
}

/// The most atoms of each object in any of its levels.
fn most(spheres: &Spheres) -> Vec<u32> {
    let of_kind = |kind: &oit_scene::SphereKind| {
        let levels = &spheres.levels[kind.first_level as usize..][..kind.levels as usize];
        levels.iter().map(|level| level.atoms).max().unwrap_or(0)
    };
    let of_kinds: Vec<u32> = spheres.kinds.iter().map(of_kind).collect();
    spheres.objects.iter().map(|object| of_kinds[object.kind as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use oit_scene::{Level, Object, SphereKind};

    fn spheres(objects: usize, atoms: u32) -> Spheres {
        let object = Object { position: [0.0; 3], rotation: [0.0; 4], kind: 0, rgba: [0; 4] };
        Spheres {
            levels: vec![Level { first_atom: 0, atoms, from_distance: 0.0 }],
            kinds: vec![SphereKind { name: "k".into(), first_level: 0, levels: 1, radius: 1.0 }],
            objects: vec![object; objects],
            ..Spheres::default()
        }
    }

    #[test]
    fn ids_are_sixteen_bits_each_as_long_as_that_is_enough() {
        let of = |objects, atoms| Ids::of(&spheres(objects, atoms));
        assert_eq!(of(1, 1), Ok(Ids::Split { atom_bits: 16 }));
        assert_eq!(of(35_000, 65_536), Ok(Ids::Split { atom_bits: 16 }));
        assert_eq!(
            of(65_536, 65_536),
            Err("4294967296 spheres are more than ids of 32 bits count".into())
        );
        assert_eq!(of(65_537, 10_000), Ok(Ids::Split { atom_bits: 15 }));
        assert_eq!(of(1_200_000, 1000), Ok(Ids::Split { atom_bits: 11 }));
        assert_eq!(of(1_200_000, 3000), Ok(Ids::Numbered));
        assert!(of(1_200_000, 4000).is_err_and(|why| why.contains("4800000000")));
    }
}
