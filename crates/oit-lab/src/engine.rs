//! What runs cells: a GPU through its plans, or the CPU through the twins.

use std::path::Path;
use std::sync::Arc;

use oit_capture::{Geometry, TooManySpheres};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{GpuError, Timing};
use oit_image::Image;
use oit_record::{Bandwidth, DeviceInfo, PassWork, Program};
use oit_scene::{Camera, Mesh, Scene, Shading, Spheres};
use oit_spheres::{SphereBytes, SphereRequest, Variation};

use crate::cpu_engine::CpuEngine;
use crate::gpu_engine::GpuEngine;
use crate::method::MethodChoice;
use crate::technique::Technique;

/// Why a cell has no result.
#[derive(Debug, thiserror::Error)]
pub enum CellError {
    /// The device or the technique cannot do it: the cell is skipped with this reason.
    #[error("{0}")]
    Unsupported(String),
    /// It was tried and broke.
    #[error("{0}")]
    Failed(String),
}

impl From<GpuError> for CellError {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Unsupported(reason) => Self::Unsupported(reason),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<oit_capture::CaptureError> for CellError {
    fn from(error: oit_capture::CaptureError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// The size of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct FrameSize {
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

impl FrameSize {
    /// Pixels in all.
    #[must_use]
    pub fn pixels(self) -> u64 {
        u64::from(self.width_px) * u64::from(self.height_px)
    }
}

/// Why there is no such view.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The scene has none of that name.
    #[error(transparent)]
    Scene(#[from] oit_scene::SceneError),
    /// It has more spheres than are drawn transparent.
    #[error(transparent)]
    Spheres(#[from] TooManySpheres),
}

/// One view at one resolution: what cells of a group share.
#[derive(Clone, Debug)]
pub struct ViewData {
    /// Where its fragments come from.
    pub source: Source,
    /// The frame's size.
    pub size: FrameSize,
    /// Whether its fragments are counted when it is opened, and can be captured. A hundred million
    /// spheres have more than a device has room for, and ways of drawing them need none.
    pub counted: bool,
}

/// Where a view's fragments come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// They are drawn.
    Scene(Box<SceneView>),
    /// They were captured before, and are resolved again without drawing; in submission order.
    Stored(Arc<Lfb>),
}

/// A mesh or spheres as one camera sees them.
#[derive(Clone, Debug)]
pub struct SceneView {
    /// The mesh; empty where spheres are seen.
    pub mesh: Arc<Mesh>,
    /// The spheres, where it is of spheres.
    pub spheres: Option<Arc<Spheres>>,
    /// Its light and stripes.
    pub shading: Shading,
    /// The camera.
    pub camera: Camera,
    /// The same as bytes for a device; spheres are here alone.
    pub geometry: Geometry,
}

impl SceneView {
    /// What is asked of a way of drawing these spheres in a frame of this size.
    pub(crate) fn sphere_request<'a>(
        &'a self,
        spheres: &'a SphereBytes,
        size: FrameSize,
    ) -> SphereRequest<'a> {
        let FrameSize { width_px, height_px } = size;
        let Self { shading, camera, .. } = self;
        SphereRequest { spheres, shading, camera, width_px, height_px }
    }
}

impl ViewData {
    /// A view of a scene.
    ///
    /// # Errors
    /// Where the scene has no such view, or it has too many spheres.
    pub fn new(scene: &Scene, view: &str, size: FrameSize) -> Result<Self, ViewError> {
        let camera = scene.view(view)?.camera;
        let geometry = Geometry::of_scene(scene, &camera, size.width_px, size.height_px)?;
        Ok(Self::of(scene, camera, geometry, size, true))
    }

    /// The same without what fragments are drawn from, for ways of drawing spheres.
    ///
    /// # Errors
    /// Where the scene has no such view.
    pub fn uncounted(scene: &Scene, view: &str, size: FrameSize) -> Result<Self, ViewError> {
        let camera = scene.view(view)?.camera;
        let FrameSize { width_px, height_px } = size;
        let none = Mesh::default();
        let geometry = Geometry::new(&none, &scene.shading, &camera, width_px, height_px);
        Ok(Self::of(scene, camera, geometry, size, false))
    }

    fn of(
        scene: &Scene,
        camera: Camera,
        geometry: Geometry,
        size: FrameSize,
        counted: bool,
    ) -> Self {
        let (mesh, spheres, shading) = (scene.mesh.clone(), scene.spheres.clone(), scene.shading);
        let scene = SceneView { mesh, spheres, shading, camera, geometry };
        let source = Source::Scene(Box::new(scene));
        Self { source, size, counted }
    }

    /// Fragments that were captured before.
    #[must_use]
    pub fn stored(lfb: Lfb) -> Self {
        let size = FrameSize { width_px: lfb.width(), height_px: lfb.height() };
        Self { source: Source::Stored(Arc::new(lfb)), size, counted: true }
    }

    /// The scene, and its spheres, for a way of drawing them.
    ///
    /// # Errors
    /// Where there are none.
    pub(crate) fn sphere_scene(
        &self,
        variation: &Variation,
    ) -> Result<(&SceneView, &Arc<Spheres>), CellError> {
        let scene = match &self.source {
            Source::Scene(scene) => Some(scene),
            Source::Stored(_) => None,
        };
        let found = scene.and_then(|scene| Some((&**scene, scene.spheres.as_ref()?)));
        found.ok_or_else(|| {
            let what = format!("{variation} draws spheres, and this scene has none");
            CellError::Unsupported(what)
        })
    }

    /// Spheres there are, every object in full detail; `None` where it is not of spheres.
    #[must_use]
    pub fn spheres(&self) -> Option<u64> {
        match &self.source {
            Source::Scene(scene) => scene.spheres.as_ref().map(|spheres| spheres.total()),
            Source::Stored(_) => None,
        }
    }

    /// Triangles that are drawn; of a sphere two.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        match &self.source {
            Source::Scene(scene) => scene.geometry.triangles(),
            Source::Stored(_) => 0,
        }
    }
}

/// A technique made ready on the open view.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Ready(pub usize);

/// What making it ready came to.
#[derive(Clone, PartialEq, Debug)]
pub struct Preparation {
    /// The array size of its deepest program; 0 for methods, which have no pool either.
    pub max_frags: u32,
    /// Room in the pool at first, in slots.
    pub pool_initial: u64,
    /// Room in the pool in the end.
    pub pool_final: u64,
    /// How often the pool was too small, grew to what was counted, and the frame was run again.
    pub pool_grown: u32,
    /// Device memory of its buffers and targets; `None` on the CPU.
    pub memory: Option<Memory>,
    /// Milliseconds until its pipelines were ready.
    pub prepare_ms: f64,
    /// Its resolve programs, one an interval from the shallowest; empty on the CPU and for methods.
    pub programs: Vec<Program>,
    /// What else is to be told of it, in words: in the stage `cuda`, which memory it reads and why.
    pub note: Option<String>,
}

/// Device memory of a technique, as allocated, in bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Memory {
    /// Of all its buffers and targets.
    pub all_bytes: u64,
    /// Of the buffers that hold the layered fragment buffer: what a resolve reads. `None` for methods,
    /// which have none.
    pub lfb_bytes: Option<u64>,
    /// The most at once: with the first pool, where a second took its place.
    pub peak_bytes: u64,
}

/// Why a method cannot go by fragments that were captured before.
pub(crate) fn draws_itself(choice: &MethodChoice) -> CellError {
    CellError::Unsupported(format!("{choice} draws the scene itself; stored fragments have none"))
}

/// An engine that runs no passes.
fn no_passes() -> CellError {
    CellError::Unsupported("it runs no passes whose work could be counted".into())
}

/// Runs techniques on one view at a time.
pub trait Engine {
    /// The device.
    fn info(&self) -> &DeviceInfo;

    /// Opens a view, forgetting the one before it, and counts its fragments.
    ///
    /// # Errors
    /// Where the device cannot do it.
    fn open_view(&mut self, view: ViewData) -> Result<DepthHistogram, CellError>;

    /// The reference capture of the open view, and per-pixel counts made without it.
    ///
    /// # Errors
    /// Where the device cannot do it.
    fn reference(&mut self) -> Result<(Lfb, Vec<u32>), CellError>;

    /// Makes a technique ready on the open view and runs it once, over poisoned buffers.
    ///
    /// # Errors
    /// Where the device cannot do it.
    fn prepare(&mut self, technique: &Technique) -> Result<(Ready, Preparation), CellError>;

    /// Runs it once more.
    ///
    /// # Errors
    /// Where the device fails.
    fn run(&mut self, ready: Ready) -> Result<Timing, CellError>;

    /// The picture of its last run.
    ///
    /// # Errors
    /// Where the device fails.
    fn picture(&mut self, ready: Ready) -> Result<Image, CellError>;

    /// The fragments its last run captured, in the order its resolve meets them.
    ///
    /// # Errors
    /// Where it is a method, which captures none, or the device fails, or what it captured is damaged.
    fn captured(&mut self, ready: Ready) -> Result<Lfb, CellError>;

    /// How much work its passes are. Runs it once more, to count, and not to time.
    ///
    /// # Errors
    /// Where it has no passes, as on the CPU, or the device fails. What a device does not count is no
    /// error, and `None`.
    fn work(&mut self, ready: Ready) -> Result<Vec<PassWork>, CellError> {
        let _ = ready;
        Err(no_passes())
    }

    /// What the device's memory moves. Forgets the open view.
    ///
    /// # Errors
    /// Where the device cannot do it, or is none that runs passes.
    fn bandwidth(&mut self) -> Result<Bandwidth, CellError> {
        Err(no_passes())
    }
}

/// Opens a device by its id (`cpu`, `vulkan:0`, `wgpu:0`). Pipelines are kept in `cache`.
///
/// # Errors
/// Where there is no such device, or it does not start.
pub fn open_engine(id: &str, cache: &Path) -> Result<Box<dyn Engine>, GpuError> {
    if id == "cpu" {
        return Ok(Box::new(CpuEngine::new()));
    }
    Ok(Box::new(GpuEngine::new(oit_gpu::open(id, cache)?)))
}
