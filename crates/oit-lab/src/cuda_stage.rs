//! The stage `cuda`: every run resolves what its capture leaves, where Vulkan has it. Where memory is
//! not shared, what a capture left is copied to CUDA once a view, and every run resolves that copy.

use std::collections::HashMap;

use oit_cuda::{Cuda, CudaError, DeviceBuffer, Kernel, SharedMemory};
use oit_fragments::Lfb;
use oit_gpu::{Device, PlanId, SharedBuffer};
use oit_sort::{CUDA_KERNEL, CUDA_THREADS, CudaLayout, CudaProgram, Output};

use crate::assemble::{intervals, sort_spec};
use crate::engine::{CellError, FrameSize};
use crate::technique::{Pool, Sorted, Stage};

/// CUDA on the engine's GPU, opened at the first technique that needs it, and what it holds of the
/// open view.
#[derive(Default)]
pub(crate) struct CudaStage {
    opened: Option<Result<Cuda, String>>,
    /// What the resolves that were made ready read.
    captured: Vec<Captured>,
    /// Of each capture that was copied, which of these it is: techniques of one capture resolve the
    /// same copy, so that it is there once.
    copies: HashMap<&'static str, usize>,
    /// The picture of the last run.
    image: Option<DeviceBuffer>,
}

/// The buffers that a capture's layout reads, in memory shared with Vulkan or as a copy.
struct Captured {
    buffers: Vec<DeviceBuffer>,
    /// Slots of `fragments`.
    room: u32,
}

/// A technique's resolve, made ready.
#[derive(Clone)]
pub(crate) struct CudaResolve {
    kernel: Kernel,
    /// What it reads, as an index into [`CudaStage::captured`].
    captured: usize,
    pixels: u32,
    /// Why it resolves a copy; `None` where it does not.
    copied_since: Option<String>,
}

impl CudaResolve {
    /// What is told of it beside its verdict: which memory it reads.
    pub(crate) fn note(&self) -> String {
        match &self.copied_since {
            None => "fragments are read from Vulkan's memory".into(),
            Some(reason) => format!("a copy of the fragments is read: {reason}"),
        }
    }
}

impl From<CudaError> for CellError {
    fn from(error: CudaError) -> Self {
        match error {
            CudaError::Missing(reason) => Self::Unsupported(reason),
            other => Self::Failed(other.to_string()),
        }
    }
}

fn unprepared() -> CellError {
    CellError::Failed("nothing was prepared in CUDA".into())
}

fn layout(technique: &Sorted) -> Result<CudaLayout<'static>, CellError> {
    let (name, random_access) = (technique.capture.name(), technique.capture.random_access());
    let source = technique.capture.layout_cuda();
    let source =
        source.ok_or_else(|| CellError::Unsupported(format!("{name} has no reader in CUDA")))?;
    Ok(CudaLayout { name, source, random_access })
}

/// The buffers of a technique's plan that the stage would share with Vulkan.
pub(crate) fn shared_buffers(technique: &Sorted) -> Result<Vec<&'static str>, CellError> {
    match technique.stage {
        Stage::Cuda => Ok(layout(technique)?.buffers()),
        Stage::Fragment | Stage::Compute => Ok(Vec::new()),
    }
}

/// The same memory, in CUDA's words.
fn shared_memory(buffer: SharedBuffer) -> SharedMemory {
    let SharedBuffer { handle, uuid, memory_bytes, dedicated, offset_bytes, bytes } = buffer;
    SharedMemory { handle, uuid, memory_bytes, dedicated, offset_bytes, bytes }
}

/// Slots of a buffer of fragments.
fn slots_of(bytes: u64) -> u32 {
    u32::try_from(bytes / 8).unwrap_or(u32::MAX)
}

/// The versions of CUDA's driver and compiler on this machine.
///
/// # Errors
/// Why it has none that can be used.
pub fn cuda_versions() -> Result<String, String> {
    match oit_cuda::versions() {
        Ok(versions) => Ok(versions.to_string()),
        Err(error) => Err(error.to_string()),
    }
}

/// CUDA's own segmented sort of a captured frame: nanoseconds of each run, by CUDA's events. It sorts
/// linearized runs and composites nothing, so that it is no technique. What it makes is compared with
/// the standard library's sort.
///
/// # Errors
/// [`CellError::Unsupported`] where the toolkit is not there, and [`CellError::Failed`] where it sorts
/// wrong.
pub fn cuda_segmented_sort(lfb: &Lfb, runs: u32) -> Result<Vec<u64>, CellError> {
    let too_many = |_| CellError::Unsupported("more fragments than 32 bits count".into());
    let offsets: Result<Vec<u32>, _> =
        lfb.offsets().iter().map(|&offset| u32::try_from(offset)).collect();
    let keys: Vec<u64> = lfb.fragments().iter().map(|fragment| fragment.key()).collect();
    let sorted = oit_cuda::segmented_sort(&keys, &offsets.map_err(too_many)?, runs)?;
    let mut expected = lfb.clone();
    expected.reorder(|fragments| fragments.sort_by_key(|fragment| fragment.key()));
    let expected = expected.fragments().iter().map(|fragment| fragment.key());
    let wrong = expected.zip(&sorted.keys).filter(|(a, b)| a != *b).count();
    if wrong > 0 {
        return Err(CellError::Failed(format!("{wrong} fragments are not in their place")));
    }
    Ok(sorted.runs_ns)
}

/// What a technique's resolve in CUDA is, and its source.
///
/// # Errors
/// [`CellError::Unsupported`] where its capture or its sort is not written in CUDA, or it holds fewer
/// fragments.
pub fn cuda_source(
    technique: &Sorted,
    size: FrameSize,
    peak: u32,
) -> Result<(String, String), CellError> {
    let unsupported = |error: &dyn std::fmt::Display| CellError::Unsupported(error.to_string());
    let intervals = intervals(technique, peak)?;
    let interval = intervals.iter().next().expect("the base schedule has one interval");
    let (strategy, spec) = sort_spec(technique, interval)?;
    let pixels = u32::try_from(size.pixels()).map_err(|error| unsupported(&error))?;
    let layout = layout(technique)?;
    let program = CudaProgram { layout, strategy, spec, output: Output::Composite, pixels };
    let source = program.source().map_err(|error| unsupported(&error))?;
    Ok((format!("resolve: {} for up to {}", strategy.name(), spec.max_frags), source))
}

impl CudaStage {
    /// Forgets the view.
    pub(crate) fn reset(&mut self) {
        self.captured.clear();
        self.copies.clear();
        self.image = None;
    }

    /// Refuses what can be refused before anything is captured.
    pub(crate) fn check(
        &mut self,
        device: &dyn Device,
        technique: &Sorted,
        size: FrameSize,
        peak: u32,
    ) -> Result<(), CellError> {
        if technique.pool != Pool::WHOLE {
            let reason = "the cuda stage resolves whole pools";
            return Err(CellError::Unsupported(reason.into()));
        }
        cuda_source(technique, size, peak)?;
        self.open(device).map(drop)
    }

    fn open(&mut self, device: &dyn Device) -> Result<&mut Cuda, CellError> {
        let opened = self.opened.get_or_insert_with(|| {
            let Some(uuid) = device.uuid() else {
                let backend = &device.info().backend;
                return Err(format!("{backend} does not say which of CUDA's devices it is"));
            };
            Cuda::open(uuid).map_err(|error| error.to_string())
        });
        opened.as_mut().map_err(|reason| CellError::Unsupported(reason.clone()))
    }

    /// Compiles a technique's resolve.
    pub(crate) fn compile(
        &mut self,
        device: &dyn Device,
        technique: &Sorted,
        size: FrameSize,
        peak: u32,
    ) -> Result<Kernel, CellError> {
        let (label, source) = cuda_source(technique, size, peak)?;
        Ok(self.open(device)?.kernel(&label, &source, CUDA_KERNEL)?)
    }

    /// Takes what a technique's plan leaves when it runs: by sharing its memory, or else by copying
    /// what it left, unless one of the same capture was copied before.
    pub(crate) fn take(
        &mut self,
        device: &mut dyn Device,
        plan: PlanId,
        technique: &Sorted,
        kernel: Kernel,
        size: FrameSize,
    ) -> Result<CudaResolve, CellError> {
        let layout = layout(technique)?;
        let pixels = size.pixels() as u32;
        if self.image.is_none() {
            self.image = Some(self.open(device)?.allocate("image", 16 * size.pixels())?);
        }
        // What keeps it from being shared only makes it be copied, and is told.
        let (captured, copied_since) = match self.share(device, plan, &layout) {
            Ok(shared) => {
                self.captured.push(shared);
                (self.captured.len() - 1, None)
            }
            Err(reason) => (self.copy(device, plan, &layout)?, Some(reason.to_string())),
        };
        Ok(CudaResolve { kernel, captured, pixels, copied_since })
    }

    fn share(
        &mut self,
        device: &dyn Device,
        plan: PlanId,
        layout: &CudaLayout,
    ) -> Result<Captured, CellError> {
        let cuda = self.open(device)?;
        let (mut buffers, mut room) = (Vec::new(), 0);
        for name in layout.buffers() {
            let memory = shared_memory(device.export(plan, name)?);
            if name == "fragments" {
                room = slots_of(memory.bytes);
            }
            // SAFETY: the memory is as the device that allocated it says.
            buffers.push(unsafe { cuda.import(name, memory) }?);
        }
        Ok(Captured { buffers, room })
    }

    fn copy(
        &mut self,
        device: &mut dyn Device,
        plan: PlanId,
        layout: &CudaLayout<'static>,
    ) -> Result<usize, CellError> {
        if let Some(&known) = self.copies.get(layout.name) {
            return Ok(known);
        }
        let (mut buffers, mut room) = (Vec::new(), 0);
        for name in layout.buffers() {
            let bytes = device.read(plan, name)?;
            if name == "fragments" {
                room = slots_of(bytes.len() as u64);
            }
            buffers.push(self.open(device)?.upload(name, &bytes)?);
        }
        self.captured.push(Captured { buffers, room });
        self.copies.insert(layout.name, self.captured.len() - 1);
        Ok(self.captured.len() - 1)
    }

    /// Resolves; nanoseconds by CUDA's events.
    pub(crate) fn run(&mut self, resolve: &CudaResolve) -> Result<u64, CellError> {
        let (Some(Ok(cuda)), Some(image), Some(captured)) =
            (&self.opened, &mut self.image, self.captured.get(resolve.captured))
        else {
            return Err(unprepared());
        };
        let blocks = (resolve.pixels.div_ceil(CUDA_THREADS), CUDA_THREADS);
        let inputs = (&*captured.buffers, captured.room, &[][..]);
        // SAFETY: the kernel is made from the layout whose buffers these are, in their order, for a
        // picture of this size; the fragments in them were counted. The device waits for every run.
        Ok(unsafe { cuda.run(&resolve.kernel, blocks, inputs, image) }?)
    }

    /// The picture of the last run, as bytes.
    pub(crate) fn picture(&self) -> Result<Vec<u8>, CellError> {
        match (&self.opened, &self.image) {
            (Some(Ok(cuda)), Some(image)) => Ok(cuda.read(image)?),
            _ => Err(unprepared()),
        }
    }

    /// Bytes of the copy that a technique resolves, none where it shares what it reads, and of its
    /// picture.
    pub(crate) fn memory_bytes(&self, resolve: &CudaResolve) -> (u64, u64) {
        let buffers = self.captured.get(resolve.captured).map(|captured| &captured.buffers);
        let copied = buffers.into_iter().flatten().filter(|buffer| !buffer.is_imported());
        let copy = copied.map(DeviceBuffer::bytes).sum();
        (copy, self.image.as_ref().map_or(0, DeviceBuffer::bytes))
    }
}
