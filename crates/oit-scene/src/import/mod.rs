//! Importers of mesh and structure files. They trust nothing: every count is checked against the bytes that are
//! there before anything is allocated for it, and every index before it is used.

mod gltf;
mod ply;
mod structure;

use std::io::Read;
use std::path::Path;

use crate::mesh::flat_normal;
use crate::{MAX_TRIANGLES, Mesh, Vertex};

pub use structure::{Coloring, Splitting, StructureOptions, import_structure};

/// A file, and a gzipped one once unpacked, may be this large.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Why a mesh or structure file is refused.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file, or one that it names, cannot be read.
    #[error("{what}: {source}")]
    Io {
        /// What was read: "file", "gzip stream", "buffer 0".
        what: String,
        /// Why.
        source: std::io::Error,
    },
    /// The ending of the file's name says no known format.
    #[error("unknown kind of mesh file; known endings: .gltf, .glb, .ply, .ply.gz")]
    UnknownFormat,
    /// The same of a structure file.
    #[error(
        "unknown kind of structure file; known endings: .pdb, .ent, .cif, .mmcif, and each with .gz"
    )]
    UnknownStructure,
    /// More than [`MAX_FILE_BYTES`], packed or unpacked.
    #[error("{what} is larger than {MAX_FILE_BYTES} bytes")]
    TooLarge {
        /// What is too large.
        what: String,
    },
    /// More than [`MAX_TRIANGLES`], or three times as many vertices.
    #[error("{what} brings the mesh above {MAX_TRIANGLES} triangles")]
    TooManyTriangles {
        /// The element or primitive that was one too many.
        what: String,
    },
    /// A structure of too many atoms.
    #[error("more than {limit} atoms")]
    TooManyAtoms {
        /// How many there may be.
        limit: usize,
    },
    /// The contents are wrong.
    #[error("{place}: {problem}")]
    Invalid {
        /// The accessor, node, element or line.
        place: String,
        /// What is wrong there.
        problem: String,
    },
}

impl ImportError {
    fn invalid(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), problem: problem.into() }
    }
}

/// Reads a glTF (`.gltf`, `.glb`) or PLY (`.ply`, `.ply.gz`) file.
///
/// Triangles keep the order of the file. Colours are straight alpha, white where none are given.
/// Where the file gives no normals each triangle gets its own, and vertices are not shared then.
///
/// # Errors
/// [`ImportError`], which names the accessor or element.
pub fn import(path: &Path) -> Result<Mesh, ImportError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let is = |ending: &str| name.ends_with(ending);
    if is(".gltf") || is(".glb") {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        gltf::read(&read_file(path, "file")?, folder.unwrap_or(Path::new(".")))
    } else if is(".ply") {
        ply::read(&read_file(path, "file")?)
    } else if is(".ply.gz") {
        ply::read(&gunzip(&read_file(path, "file")?, MAX_FILE_BYTES)?)
    } else {
        Err(ImportError::UnknownFormat)
    }
}

/// The contents of a regular file of at most [`MAX_FILE_BYTES`].
fn read_file(path: &Path, what: &str) -> Result<Vec<u8>, ImportError> {
    let io_error = |source| ImportError::Io { what: what.to_owned(), source };
    let file = std::fs::File::open(path).map_err(io_error)?;
    if !file.metadata().map_err(io_error)?.is_file() {
        return Err(ImportError::invalid(what, "not a regular file"));
    }
    read_at_most(file, MAX_FILE_BYTES, what)
}

fn gunzip(packed: &[u8], limit: u64) -> Result<Vec<u8>, ImportError> {
    read_at_most(flate2::read::MultiGzDecoder::new(packed), limit, "gzip stream")
}

/// All there is to read, unless it is more than `limit` bytes.
fn read_at_most(reader: impl Read, limit: u64, what: &str) -> Result<Vec<u8>, ImportError> {
    let mut bytes = Vec::new();
    reader
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| ImportError::Io { what: what.to_owned(), source })?;
    if bytes.len() as u64 > limit {
        return Err(ImportError::TooLarge { what: what.to_owned() });
    }
    Ok(bytes)
}

/// Appends a part, giving it flat normals (and so a vertex of its own for each corner) when it
/// brings none. Every index must be below the number of positions.
fn push_part(
    mesh: &mut Mesh,
    what: &str,
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
    rgba: &[[u8; 4]],
    indices: &[u32],
) -> Result<(), ImportError> {
    let added = if normals.is_some() { positions.len() } else { indices.len() };
    let vertices = (mesh.vertices.len() + added) as u64;
    let corners = (mesh.indices.len() + indices.len()) as u64;
    if vertices.max(corners) > 3 * MAX_TRIANGLES {
        return Err(ImportError::TooManyTriangles { what: what.to_owned() });
    }
    let first = mesh.vertices.len() as u32;
    let vertex = |i: usize, normal| Vertex { position: positions[i], normal, rgba: rgba[i] };
    if let Some(normals) = normals {
        mesh.vertices.extend((0..positions.len()).map(|i| vertex(i, normals[i])));
        mesh.indices.extend(indices.iter().map(|index| first + index));
    } else {
        let (triangles, _) = indices.as_chunks::<3>();
        for triangle in triangles {
            let corners = triangle.map(|index| index as usize);
            let [a, b, c] = corners.map(|i| positions[i]);
            let normal = flat_normal(a, b, c);
            mesh.vertices.extend(corners.map(|i| vertex(i, normal)));
        }
        mesh.indices.extend(first..mesh.vertices.len() as u32);
    }
    Ok(())
}

/// Unit length, +z for a vector without length, nothing for one that is not finite.
fn unit_normal(normal: [f32; 3]) -> Option<[f32; 3]> {
    let normal = glam::DVec3::from(normal.map(f64::from));
    normal.is_finite().then(|| normal.normalize_or(glam::DVec3::Z).as_vec3().to_array())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_gzip_bomb_is_cut_off() {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(&vec![0; 1 << 20]).unwrap();
        let bomb = encoder.finish().unwrap();
        assert!(bomb.len() < 2000);
        assert_eq!(gunzip(&bomb, 1 << 20).unwrap().len(), 1 << 20);
        let error = gunzip(&bomb, (1 << 20) - 1).unwrap_err();
        assert!(matches!(error, ImportError::TooLarge { .. }), "{error}");
        let error = gunzip(&bomb[..bomb.len() / 2], 1 << 20).unwrap_err();
        assert!(error.to_string().starts_with("gzip stream: "), "{error}");
    }

    #[test]
    fn an_unknown_ending_is_refused() {
        let error = import(Path::new("mesh.obj")).unwrap_err();
        assert!(matches!(error, ImportError::UnknownFormat));
    }

    #[test]
    fn a_missing_file_and_a_folder_are_errors() {
        let error = import(Path::new("no/such/mesh.ply")).unwrap_err();
        assert!(matches!(error, ImportError::Io { .. }), "{error}");
        let folder = tempfile::tempdir().unwrap().path().join("folder.ply");
        std::fs::create_dir_all(&folder).unwrap();
        assert!(import(&folder).unwrap_err().to_string().contains("regular file"));
    }
}
