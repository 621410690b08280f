use std::path::PathBuf;
use std::sync::Arc;

use crate::{Camera, Fault, GenerateError, ImportError, Mesh, Problem, Shading};

/// A mesh, its shading and the views it is seen from.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene file's name without its ending.
    pub name: String,
    /// Prose: what the scene is and where it comes from.
    pub about: String,
    /// Shared, because one mesh serves many cells.
    pub mesh: Arc<Mesh>,
    /// Light and stripes.
    pub shading: Shading,
    /// At least one; names are unique.
    pub views: Vec<View>,
}

/// A named camera.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// As experiments and the command line call it.
    pub name: String,
    /// Where it looks from.
    pub camera: Camera,
}

impl Scene {
    /// The view of that name.
    ///
    /// # Errors
    /// [`SceneError::UnknownView`], with the nearest names.
    pub fn view(&self, name: &str) -> Result<&View, SceneError> {
        self.views.iter().find(|view| view.name == name).ok_or_else(|| {
            let names = self.views.iter().map(|view| view.name.as_str());
            SceneError::UnknownView {
                scene: self.name.clone(),
                problem: Problem::unknown("view", name, names),
            }
        })
    }
}

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file or folder that cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A mistake in a scene file or in an override of it.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// A mesh file that is not there.
    #[error("{}: the asset {} is missing{}", scene.display(), asset.display(), hint(asset))]
    MissingAsset {
        /// The scene file.
        scene: PathBuf,
        /// The path in the scene file.
        asset: PathBuf,
    },
    /// A mesh file that cannot be used.
    #[error("{}: {source}", path.display())]
    Import {
        /// The mesh file.
        path: PathBuf,
        /// Why.
        source: ImportError,
    },
    /// Parameters that are valid one by one but not together.
    #[error("{}: {source}", path.display())]
    Generate {
        /// The scene file.
        path: PathBuf,
        /// Why.
        source: GenerateError,
    },
    /// A view that the scene does not have.
    #[error("scene `{scene}`: {problem}")]
    UnknownView {
        /// The scene.
        scene: String,
        /// The word and its neighbours.
        problem: Problem,
    },
}

/// Only what `just assets` fetches into assets/ is fetched by it.
fn hint(asset: &std::path::Path) -> &'static str {
    if asset.starts_with("assets") { ": run `just assets` to fetch it" } else { "" }
}
