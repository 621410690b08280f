//! What a backend is to the rest of the project: it describes itself, runs plans, gives bytes back.

use crate::{Main, Plan, SharedBuffer};
use oit_record::{DeviceInfo, Executable};

/// A plan made ready on a device: its pipelines are compiled and its data uploaded.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct PlanId(pub usize);

/// A stage, and which of its parts ([`crate::Pass::part`]).
pub type Part = (&'static str, u32);

/// What one run of a plan took, from the device's own timestamps.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Timing {
    /// Nanoseconds of each stage, in the order of [`Plan::stages`]. Consecutive passes of a stage
    /// are one interval; the intervals of a stage that recurs are added up. Empty where the device
    /// has no timestamps.
    pub stages: Vec<(&'static str, u64)>,
    /// Nanoseconds of each part of a stage that has parts, in the order in which they are first run.
    /// They are contained in their stage's.
    pub parts: Vec<(Part, u64)>,
    /// Nanoseconds from before the first pass to after the last; zero where the device has no
    /// timestamps.
    pub total_ns: u64,
}

/// What the device's pipeline statistics count of a raster pass. They tell how much work it was, not
/// how long: drivers may run a shader more often than there are vertices or pixels (whole quads of
/// fragments) or less (vertices used again, fragments that are rejected early).
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct PassStatistics {
    /// The pass, as an index into [`Plan::passes`].
    pub pass: usize,
    /// Vertices that were put together; `None` on wgpu, which does not tell.
    pub input_vertices: Option<u64>,
    /// Primitives that they made, before tessellation and geometry; `None` on wgpu.
    pub input_primitives: Option<u64>,
    /// Runs of the vertex stage.
    pub vertex_invocations: u64,
    /// Patches that the tessellation control stage ran for; `None` where there are no such stages.
    pub tessellation_patches: Option<u64>,
    /// Runs of the tessellation evaluation stage; `None` where there are no such stages.
    pub tessellation_invocations: Option<u64>,
    /// Runs of the geometry stage; `None` where there is no such stage.
    pub geometry_invocations: Option<u64>,
    /// Primitives that the geometry stage made; `None` where there is no such stage.
    pub geometry_primitives: Option<u64>,
    /// Primitives that came to be clipped.
    pub clipping_invocations: u64,
    /// Primitives that clipping left, which it may cut into several.
    pub clipping_primitives: u64,
    /// Runs of the fragment stage.
    pub fragment_invocations: u64,
}

/// What became of the shader of a pass.
#[derive(Clone, PartialEq, Debug)]
pub struct Compiled {
    /// The shader's label.
    pub shader: String,
    /// Its compute entry point; `None` in a raster pass.
    pub main: Option<Main>,
    /// Nanoseconds that the driver took to make its pipeline, by the host's clock, at its first use
    /// in this process.
    pub compile_ns: Option<u64>,
    /// Whether the driver found it in the cache that is kept on disk between processes. Caches that
    /// drivers keep of their own do not show here.
    pub from_cache: Option<bool>,
    /// What it was compiled to; `None` where the driver does not tell, or is not asked.
    pub executables: Option<Vec<Executable>>,
}

/// What kept a backend from doing as told.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The device lacks something the plan needs: the cell is skipped, with this reason.
    #[error("not supported on this device: {0}")]
    Unsupported(String),
    /// The plan is at fault: a name without a resource, a shader that does not compile.
    #[error("plan {plan:?}: {what}")]
    Plan {
        /// The plan's name.
        plan: String,
        /// What is wrong with it.
        what: String,
    },
    /// There is not enough memory.
    #[error("out of device memory: {0}")]
    OutOfMemory(String),
    /// The device was lost, or the driver failed.
    #[error("the device failed: {0}")]
    Device(String),
}

/// A GPU that runs plans.
pub trait Device {
    /// What it is and what it can do.
    fn info(&self) -> &DeviceInfo;

    /// The identifier by which other interfaces of the driver (CUDA) know the same GPU, where the
    /// backend tells it.
    fn uuid(&self) -> Option<[u8; 16]> {
        None
    }

    /// Makes a plan ready: checks it, compiles its pipelines (each once a process, and kept on
    /// disk between processes), allocates what it names and uploads its data.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device lacks something; otherwise as it says.
    fn prepare(&mut self, plan: &Plan) -> Result<PlanId, GpuError>;

    /// Makes a plan ready as [`Self::prepare`] does, with its buffers of these names in memory that
    /// [`Self::export`] gives away. No plan that does not ask for it comes to use that memory.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device shares no memory ([`DeviceInfo::unsupported`] lists
    /// "memory shared with CUDA" then); where the plan has no buffer of a name; as `prepare` has them.
    fn prepare_shared(&mut self, plan: &Plan, shared: &[&str]) -> Result<PlanId, GpuError> {
        match shared {
            [] => self.prepare(plan),
            [..] => Err(no_sharing(&format!("{} does not offer it", self.info().backend))),
        }
    }

    /// The memory of a buffer that [`Self::prepare_shared`] was asked to share. What a run of the plan
    /// leaves is there once [`Self::run`] returns, and is to be read before the next run of any plan;
    /// nobody but the device may write it.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device shares no memory, or the buffer was not asked for;
    /// where the plan has no such buffer, or the driver fails.
    fn export(&self, plan: PlanId, buffer: &str) -> Result<SharedBuffer, GpuError> {
        let _ = (plan, buffer);
        Err(no_sharing(&format!("{} does not offer it", self.info().backend)))
    }

    /// The plan, as it was given, but for the data of its buffers: the device holds that.
    ///
    /// # Errors
    /// Where it is not prepared.
    fn planned(&self, plan: PlanId) -> Result<&Plan, GpuError>;

    /// Runs a plan once and waits for it.
    ///
    /// # Errors
    /// Where the driver fails.
    fn run(&mut self, plan: PlanId) -> Result<Timing, GpuError>;

    /// Runs a plan once, waits for it, and counts instead of timing: the statistics of each raster
    /// pass, in order. To count may make a run slower. Mesh stages are not counted.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device does not count ([`DeviceInfo::unsupported`] lists
    /// "pipeline statistics" then); where the driver fails.
    fn statistics(&mut self, plan: PlanId) -> Result<Vec<PassStatistics>, GpuError> {
        let _ = plan;
        Err(no_statistics(&self.info().name))
    }

    /// Fills every buffer of the plan that has no given contents with the byte `0xCD`, so that a
    /// run cannot pass on what an earlier one left.
    ///
    /// # Errors
    /// Where the driver fails.
    fn poison(&mut self, plan: PlanId) -> Result<(), GpuError>;

    /// The bytes of one of the plan's buffers or targets (rows top to bottom, without padding), as
    /// its last run left them.
    ///
    /// # Errors
    /// Where the plan has no such resource, or the driver fails.
    fn read(&mut self, plan: PlanId, resource: &str) -> Result<Vec<u8>, GpuError>;

    /// The device memory that each of the plan's resources takes as allocated, in bytes: its buffers,
    /// then its targets, in the plan's order. What plans share is counted in each of them in full.
    /// `vulkan` tells what the driver requires of an allocation. wgpu does not tell that: there it
    /// is what wgpu asks for, with its own rounding, and of a target the bytes of its pixels.
    ///
    /// # Errors
    /// Where the plan is not prepared.
    fn resource_bytes(&self, plan: PlanId) -> Result<Vec<(String, u64)>, GpuError>;

    /// The device memory that the plan takes as allocated, in bytes: the sum of
    /// [`Self::resource_bytes`].
    ///
    /// # Errors
    /// Where the plan is not prepared.
    fn memory_bytes(&self, plan: PlanId) -> Result<u64, GpuError> {
        Ok(self.resource_bytes(plan)?.into_iter().map(|(_, bytes)| bytes).sum())
    }

    /// What became of the shader of each pass that has one, in order. Empty from a backend that
    /// cannot tell, as wgpu.
    ///
    /// # Errors
    /// Where the plan is not prepared.
    fn compiled(&self, plan: PlanId) -> Result<Vec<Compiled>, GpuError> {
        let _ = plan;
        Ok(Vec::new())
    }

    /// Forgets all plans and frees their buffers and targets; pipelines are kept.
    fn reset(&mut self);
}

/// The byte that [`Device::poison`] fills with.
pub(crate) const POISON: u8 = 0xCD;

/// A device that does not count.
pub(crate) fn no_statistics(device: &str) -> GpuError {
    GpuError::Unsupported(format!("{device} has no pipeline statistics"))
}

/// A device that gives no memory away.
pub(crate) fn no_sharing(reason: &str) -> GpuError {
    GpuError::Unsupported(format!("no memory is shared with CUDA: {reason}"))
}

/// A plan that is not, or no longer, ready on the device.
pub(crate) fn not_prepared(plan: PlanId) -> GpuError {
    GpuError::Plan {
        plan: format!("#{}", plan.0),
        what: "it is not prepared; `reset` forgets all plans".to_owned(),
    }
}

/// A name that is no buffer and no target of the plan.
pub(crate) fn no_resource(plan: &str, name: &str) -> GpuError {
    GpuError::Plan { plan: plan.to_owned(), what: format!("no buffer or target is named {name:?}") }
}
