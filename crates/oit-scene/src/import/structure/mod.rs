//! Importers of structures: the atoms of the first model of a PDB or mmCIF file.
//!
//! They read atom records alone, and every mistake in one is named with its line and field. Crates that
//! read whole files (pdbtbx among them) name a row but no line in mmCIF, and stop the program where a
//! field is `?`.

mod element;
mod mmcif;
mod pdb;

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use self::element::Element;
use super::{ImportError, MAX_FILE_BYTES, gunzip, read_file};
use crate::detail::Cloud;
use crate::{DETAIL_PIXELS, MAX_ATOMS, Object, Spheres};

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
    /// Its chain, by a palette of seven colours in turn.
    Chain,
}

/// What becomes an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Splitting {
    /// All atoms together.
    #[default]
    Whole,
    /// The atoms of each chain, in the order in which chains begin.
    Chain,
}

/// The colours of Okabe and Ito (Color Universal Design, 2008) without black, linear values.
const PALETTE: [[u8; 4]; 7] = [
    [24, 116, 208, 255],
    [202, 88, 0, 255],
    [0, 87, 44, 255],
    [222, 198, 14, 255],
    [0, 43, 114, 255],
    [170, 29, 0, 255],
    [154, 49, 99, 255],
];

/// A coordinate lies between this and its negative, ångström. The PDB format has room for a hundredth.
const MAX_COORDINATE: f64 = 1e6;

/// So many atoms leave room for their coarser levels.
const MAX_STRUCTURE_ATOMS: usize = (MAX_ATOMS / 2) as usize;

/// More than any structure has; each is a name and may be an object.
const MAX_CHAINS: usize = 1 << 16;

/// At most so many levels of detail.
const LEVELS: u64 = 8;

/// Reads a PDB (`.pdb`, `.ent`) or mmCIF (`.cif`, `.mmcif`) file, or one of them gzipped (`.gz`).
///
/// Atoms of the first model alone are read, waters and ligands among them; of alternate locations the
/// first that a residue has. Radii are van der Waals radii. World units are ångström, places as in the
/// file; an object's position is the middle of the box about its atoms' centres.
///
/// # Errors
/// [`ImportError`], which names the line and the field.
pub fn import_structure(path: &Path, options: &StructureOptions) -> Result<Spheres, ImportError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let (plain, packed) = name.strip_suffix(".gz").map_or((&*name, false), |plain| (plain, true));
    let is = |endings: [&str; 2]| endings.iter().any(|ending| plain.ends_with(ending));
    let read: fn(&[u8], &mut Structure) -> Result<(), ImportError> = if is([".pdb", ".ent"]) {
        pdb::read
    } else if is([".cif", ".mmcif"]) {
        mmcif::read
    } else {
        return Err(ImportError::UnknownStructure);
    };
    let mut bytes = read_file(path, "file")?;
    if packed {
        bytes = gunzip(&bytes, MAX_FILE_BYTES)?;
    }
    let mut structure = Structure::new(MAX_STRUCTURE_ATOMS);
    read(&bytes, &mut structure)?;
    structure.into_spheres(&path.file_stem().unwrap_or_default().to_string_lossy(), options)
}

/// What has been read so far.
#[derive(Debug)]
struct Structure {
    atoms: Vec<Record>,
    limit: usize,
    /// Chains by name, in the order in which they begin.
    chains: Vec<String>,
    chain_numbers: HashMap<String, u32>,
    /// The residue of the last atom that had an alternate location, and which one is kept of it.
    alternate: (String, String),
}

/// An atom of the first model.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Record {
    center: [f64; 3],
    element: Element,
    /// Its place in [`Structure::chains`].
    chain: u32,
}

impl Structure {
    fn new(limit: usize) -> Self {
        Self {
            atoms: Vec::new(),
            limit,
            chains: Vec::new(),
            chain_numbers: HashMap::new(),
            alternate: Default::default(),
        }
    }

    /// Whether an atom at an alternate location is of the first that its residue has.
    fn keeps(&mut self, residue: &str, alternate: &str) -> bool {
        if self.alternate.0 != residue {
            self.alternate = (residue.to_owned(), alternate.to_owned());
        }
        self.alternate.1 == alternate
    }

    fn push(&mut self, center: [f64; 3], element: Element, chain: &str) -> Result<(), ImportError> {
        if self.atoms.len() >= self.limit {
            return Err(ImportError::TooManyAtoms { limit: self.limit });
        }
        let chain = match self.chain_numbers.get(chain) {
            Some(number) => *number,
            None => {
                if self.chains.len() >= MAX_CHAINS {
                    return Err(ImportError::invalid(
                        "file",
                        format!("more than {MAX_CHAINS} chains"),
                    ));
                }
                let number = self.chains.len() as u32;
                self.chains.push(chain.to_owned());
                self.chain_numbers.insert(chain.to_owned(), number);
                number
            }
        };
        self.atoms.push(Record { center, element, chain });
        Ok(())
    }

    fn into_spheres(self, name: &str, options: &StructureOptions) -> Result<Spheres, ImportError> {
        if self.atoms.is_empty() {
            return Err(ImportError::invalid("file", "no atoms"));
        }
        let mut parts = vec![(name.to_owned(), self.atoms)];
        if options.objects == Splitting::Chain {
            let named = self.chains.iter().map(|chain| (format!("chain {chain}"), Vec::new()));
            let (_, atoms) = std::mem::replace(&mut parts, named.collect()).remove(0);
            for atom in atoms {
                parts[atom.chain as usize].1.push(atom);
            }
        }
        let mut spheres = Spheres::default();
        for (name, atoms) in parts {
            let centers = || atoms.iter().map(|atom| DVec3::from(atom.center));
            let low = centers().reduce(DVec3::min).unwrap_or_default();
            let high = centers().reduce(DVec3::max).unwrap_or_default();
            let middle = ((low + high) / 2.0).as_vec3();
            let mut cloud = Cloud::default();
            for atom in &atoms {
                let center = (DVec3::from(atom.center) - middle.as_dvec3()).as_vec3();
                let rgba = match options.colors {
                    Coloring::Element => atom.element.rgba(),
                    Coloring::Chain => PALETTE[atom.chain as usize % PALETTE.len()],
                };
                cloud.push(center.to_array(), atom.element.radius(), rgba);
            }
            let kind = spheres.push_kind(name, cloud, LEVELS, DETAIL_PIXELS);
            spheres.objects.push(Object {
                position: middle.to_array(),
                rotation: [0.0, 0.0, 0.0, 1.0],
                kind,
                rgba: options.rgba,
            });
        }
        Ok(spheres)
    }
}

/// A coordinate, or what is wrong with it.
fn coordinate(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if value.abs() <= MAX_COORDINATE {
        Ok(value)
    } else {
        Err(format!("must be from -{MAX_COORDINATE} to {MAX_COORDINATE}, not {text}"))
    }
}
