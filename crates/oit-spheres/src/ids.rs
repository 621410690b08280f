//! Which sphere a fragment is of, in 32 bits.

use oit_scene::Spheres;

/// How the 32 bits of a fragment's id are shared between an object's number and that of the atom
/// within its level. Both have 16, as in the thesis (Table 3.4), as long as 16 suffice; else the one
/// that needs more takes them from the other.
///
/// The thesis keeps 16 bits of each, whatever their number: more than 65,536 objects wrap, and a
/// picture coloured by them is wrong. Here every fragment's colour, and with 4 bytes all of it, is
/// found by its id, so ids are exact, and a scene that needs more than 32 bits is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Ids {
    pub(crate) atom_bits: u32,
}

impl Ids {
    /// How the ids of a scene are shared out.
    ///
    /// # Errors
    /// Where 32 bits do not suffice.
    pub(crate) fn of(spheres: &Spheres) -> Result<Self, String> {
        let bits = |count: usize| count.next_power_of_two().trailing_zeros();
        let most_atoms = spheres.levels.iter().map(|level| level.atoms).max().unwrap_or(1);
        let object_bits = bits(spheres.objects.len());
        let atom_bits = bits(most_atoms as usize);
        // All ones stand for nothing, so that one id is too many.
        let full = object_bits + atom_bits == 32
            && spheres.objects.len() == 1 << object_bits
            && most_atoms == 1 << atom_bits;
        if object_bits + atom_bits > 32 || full {
            return Err(format!(
                "an id of 32 bits has {object_bits} for {} objects and {atom_bits} for the {most_atoms} \
                 atoms of one",
                spheres.objects.len()
            ));
        }
        let atom_bits = if object_bits > 16 { 32 - object_bits } else { atom_bits.max(16) };
        Ok(Self { atom_bits })
    }
}
