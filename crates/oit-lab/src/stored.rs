//! Fragments that were captured before, from a file: a trace, or a deep OpenEXR image.

use std::ffi::OsStr;
use std::path::Path;

use oit_fragments::Lfb;
use oit_fragments::deep_exr::{self, DeepExrError, DeepInfo};
use oit_fragments::trace::{self, TRACE_EXTENSION, TraceError, TraceInfo};
use oit_scene::{Asset, SceneEntry};

/// The one view that a file of fragments has.
pub const STORED_VIEW: &str = "stored";

/// The ending of a deep image's name.
pub const DEEP_EXTENSION: &str = "exr";

/// What a file of fragments holds.
#[derive(Clone, PartialEq, Debug)]
pub struct Stored {
    /// The fragments.
    pub lfb: Lfb,
    /// What the file says of them.
    pub origin: Origin,
}

/// What a file of fragments says of itself.
#[derive(Clone, PartialEq, Debug)]
pub enum Origin {
    /// A trace.
    Trace(TraceInfo),
    /// A deep image, written here or elsewhere.
    DeepImage(DeepInfo),
}

/// Why a file of fragments cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// It is no trace, or a damaged one.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// It is no deep image, or a damaged one.
    #[error(transparent)]
    DeepImage(#[from] DeepExrError),
}

/// Whether the name is that of a file of fragments, and not of a scene.
#[must_use]
pub fn is_stored(path: &Path) -> bool {
    [TRACE_EXTENSION, DEEP_EXTENSION]
        .iter()
        .any(|&ending| path.extension() == Some(OsStr::new(ending)))
}

/// Reads a file of fragments: a deep image where its name ends in `.exr`, else a trace.
///
/// # Errors
/// Where the file cannot be read or is damaged.
pub fn load_stored(path: &Path) -> Result<Stored, StoredError> {
    if path.extension() == Some(OsStr::new(DEEP_EXTENSION)) {
        let (info, lfb) = deep_exr::read(path)?;
        return Ok(Stored { lfb, origin: Origin::DeepImage(info) });
    }
    let (info, lfb) = trace::load(path)?;
    Ok(Stored { lfb, origin: Origin::Trace(info) })
}

/// A file of fragments as an experiment's scene, with the one view [`STORED_VIEW`].
#[must_use]
pub fn stored_entry(path: &Path) -> SceneEntry {
    SceneEntry {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        path: path.to_owned(),
        about: "Fragments that were captured before.".into(),
        views: vec![STORED_VIEW.into()],
        paths: Vec::new(),
        asset: Asset::None,
        spheres: false,
    }
}
