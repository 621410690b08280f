//! The stage `cuda`: what a capture left on the GPU is copied to CUDA once a view, and every run
//! resolves that copy.

use std::collections::HashMap;

use oit_cuda::{Cuda, CudaError, DeviceBuffer, Kernel};
use oit_fragments::Lfb;
use oit_gpu::{Device, PlanId};
use oit_sort::{CUDA_KERNEL, CUDA_THREADS, CudaLayout, CudaProgram, Output};

use crate::assemble::{intervals, sort_spec};
use crate::engine::{CellError, FrameSize};
use crate::technique::{Pool, Sorted};

/// CUDA on the engine's GPU, opened at the first technique that needs it, and what it holds of the
/// open view.
#[derive(Default)]
pub(crate) struct CudaStage {
    opened: Option<Result<Cuda, String>>,
    /// Of each capture the buffers that its layout reads: techniques of one capture resolve the same
    /// copy, so that it is there once.
    captured: HashMap<&'static str, Captured>,
    /// The picture of the last run.
    image: Option<DeviceBuffer>,
}

struct Captured {
    buffers: Vec<DeviceBuffer>,
    /// Slots of `fragments`.
    room: u32,
}

/// A technique's resolve, made ready.
#[derive(Clone)]
pub(crate) struct CudaResolve {
    kernel: Kernel,
    capture: &'static str,
    pixels: u32,
}

impl From<CudaError> for CellError {
    fn from(error: CudaError) -> Self {
        match error {
            CudaError::Missing(reason) => Self::Unsupported(reason),
            other => Self::Failed(other.to_string()),
        }
    }
}

fn layout(technique: &Sorted) -> Result<CudaLayout<'static>, CellError> {
    let (name, random_access) = (technique.capture.name(), technique.capture.random_access());
    let source = technique.capture.layout_cuda();
    let source =
        source.ok_or_else(|| CellError::Unsupported(format!("{name} has no reader in CUDA")))?;
    Ok(CudaLayout { name, source, random_access })
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
            let reason = "the cuda stage resolves a copy of a whole pool";
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

    /// Copies what a technique's plan left when it ran, unless one of the same capture did before.
    pub(crate) fn copy(
        &mut self,
        device: &mut dyn Device,
        plan: PlanId,
        technique: &Sorted,
        kernel: Kernel,
        size: FrameSize,
    ) -> Result<CudaResolve, CellError> {
        let layout = layout(technique)?;
        let (capture, pixels) = (layout.name, size.pixels() as u32);
        if !self.captured.contains_key(capture) {
            let (mut buffers, mut room) = (Vec::new(), 0);
            for name in layout.buffers() {
                let bytes = device.read(plan, name)?;
                if name == "fragments" {
                    room = u32::try_from(bytes.len() / 8).unwrap_or(u32::MAX);
                }
                buffers.push(self.open(device)?.upload(name, &bytes)?);
            }
            self.captured.insert(capture, Captured { buffers, room });
        }
        if self.image.is_none() {
            self.image = Some(self.open(device)?.allocate("image", 16 * size.pixels())?);
        }
        Ok(CudaResolve { kernel, capture, pixels })
    }

    fn parts(&mut self) -> Result<(&Cuda, &mut DeviceBuffer), CellError> {
        match (&self.opened, &mut self.image) {
            (Some(Ok(cuda)), Some(image)) => Ok((cuda, image)),
            _ => Err(CellError::Failed("nothing was prepared in CUDA".into())),
        }
    }

    /// Resolves; nanoseconds by CUDA's events.
    pub(crate) fn run(&mut self, resolve: &CudaResolve) -> Result<u64, CellError> {
        let captured = self.captured.remove(resolve.capture);
        let captured =
            captured.ok_or_else(|| CellError::Failed("nothing was copied to CUDA".into()))?;
        let (cuda, image) = self.parts()?;
        let blocks = (resolve.pixels.div_ceil(CUDA_THREADS), CUDA_THREADS);
        let inputs = (&*captured.buffers, captured.room, &[][..]);
        // SAFETY: the kernel is made from the layout whose buffers these are, in their order, for a
        // picture of this size; the fragments in them were counted.
        let ns = unsafe { cuda.run(&resolve.kernel, blocks, inputs, image) };
        self.captured.insert(resolve.capture, captured);
        Ok(ns?)
    }

    /// The picture of the last run, as bytes.
    pub(crate) fn picture(&mut self) -> Result<Vec<u8>, CellError> {
        let (cuda, image) = self.parts()?;
        Ok(cuda.read(image)?)
    }

    /// Bytes of the copy that a technique resolves, and of its picture.
    pub(crate) fn memory_bytes(&self, resolve: &CudaResolve) -> (u64, u64) {
        let buffers = self.captured.get(resolve.capture).map(|captured| &captured.buffers);
        let copy = buffers.into_iter().flatten().map(DeviceBuffer::bytes).sum();
        (copy, self.image.as_ref().map_or(0, DeviceBuffer::bytes))
    }
}
