//! Importers of structures: PDB and mmCIF.

use std::path::Path;

use serde::Deserialize;

use super::ImportError;
use crate::Spheres;

/// What an imported structure becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StructureOptions {
    /// What decides an atom's colour.
    pub colors: Coloring,
    /// What becomes an object.
    pub objects: Splitting,
    /// Multiplies every colour: straight alpha, linear values.
    pub rgba: [u8; 4],
}

/// What decides an atom's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coloring {
    /// Its element, in the colours of Corey, Pauling and Koltun.
    #[default]
    Element,
    /// Its chain, by a palette of twelve colours in turn.
    Chain,
}

/// What becomes an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Splitting {
    /// All atoms together.
    #[default]
    Whole,
    /// The atoms of each chain.
    Chain,
}

pub(crate) fn import_structure(
    _path: &Path,
    _options: &StructureOptions,
) -> Result<Spheres, ImportError> {
    Err(ImportError::UnknownStructure)
}
