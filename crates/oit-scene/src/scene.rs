use std::path::PathBuf;
use std::sync::Arc;

use crate::{
    Camera, CameraPath, Fault, GenerateError, ImportError, Mesh, Problem, Shading, Spheres,
};

/// A mesh or spheres, their shading and the views they are seen from.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene file's name without its ending.
    pub name: String,
    /// Prose: what the scene is and where it comes from.
    pub about: String,
    /// Shared, because one mesh serves many cells. Empty in a scene of spheres.
    pub mesh: Arc<Mesh>,
    /// What a scene of spheres has instead of a mesh.
    pub spheres: Option<Arc<Spheres>>,
    /// Light and stripes.
    pub shading: Shading,
    /// At least one; names are unique.
    pub views: Vec<View>,
    /// Camera paths by name. Each frame of one is a view as well, named `path@frame`.
    pub paths: Vec<(String, CameraPath)>,
}

/// What stands between a path's name and a frame's number.
pub(crate) const FRAME_MARK: char = '@';

/// The name of a path's frame as a view: `path@frame`.
#[must_use]
pub fn frame_view(path: &str, frame: u32) -> String {
    format!("{path}{FRAME_MARK}{frame}")
}

/// The path and the frame that a view's name means, if it names a frame.
#[must_use]
pub fn split_frame_view(view: &str) -> Option<(&str, u32)> {
    let (path, digits) = view.split_once(FRAME_MARK)?;
    let frame = digits.parse().ok()?;
    // One name a frame: neither `+7` nor `007`.
    (frame_view(path, frame) == view).then_some((path, frame))
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
    /// The view of that name, a frame of a path (`path@frame`) among them.
    ///
    /// # Errors
    /// [`SceneError::UnknownView`], with the nearest names or the path's frames.
    pub fn view(&self, name: &str) -> Result<View, SceneError> {
        if let Some(view) = self.views.iter().find(|view| view.name == name) {
            return Ok(view.clone());
        }
        let unknown = |problem| SceneError::UnknownView { scene: self.name.clone(), problem };
        let of_path = |wanted: &str| self.paths.iter().find(|(known, _)| known == wanted);
        if let Some((wanted, frame)) = split_frame_view(name)
            && let Some((_, path)) = of_path(wanted)
        {
            if frame >= path.frames() {
                return Err(unknown(no_such_frame(wanted, path.frames(), frame)));
            }
            return Ok(View { name: name.to_owned(), camera: path.camera(frame) });
        }
        let frames = self.paths.iter().map(|(path, _)| frame_view(path, 0));
        let frames: Vec<String> = frames.collect();
        let names = self.views.iter().map(|view| &view.name).chain(&frames);
        Err(unknown(Problem::unknown("view", name, names.map(String::as_str))))
    }
}

/// A frame that a path of so many does not have.
#[must_use]
pub fn no_such_frame(path: &str, frames: u32, frame: u32) -> Problem {
    Problem::Invalid(format!("path `{path}` has the frames 0 to {}, not {frame}", frames - 1))
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
    /// A mesh or structure file that is not there.
    #[error("{}: the asset {} is missing{}", scene.display(), asset.display(), hint(asset))]
    MissingAsset {
        /// The scene file.
        scene: PathBuf,
        /// The path in the scene file.
        asset: PathBuf,
    },
    /// A mesh or structure file that cannot be used.
    #[error("{}: {source}", path.display())]
    Import {
        /// The file.
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
