//! A GPU as CUDA sees it: kernels compiled, buffers uploaded, runs timed.

use std::collections::HashMap;
use std::sync::Arc;

use cudarc::driver::{
    CudaContext, CudaFunction, CudaSlice, CudaStream, DriverError, LaunchArgs, LaunchConfig,
    PushKernelArg, result, sys,
};
use cudarc::nvrtc::{CompileError, CompileOptions, compile_ptx_with_opts};

use crate::imported::{Imported, SharedMemory};
use crate::{CudaError, versions};

/// The byte that the output of a run is filled with before it.
const POISON: u8 = 0xCD;

/// A GPU. All work is on its default stream, one thing after the other.
pub struct Cuda {
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    uuid: [u8; 16],
    /// `--gpu-architecture` for NVRTC.
    architecture: String,
    kernels: HashMap<String, CudaFunction>,
}

/// A compiled kernel. Its parameters are buffers, a number, and buffers again, the last of which it
/// writes.
#[derive(Clone, Debug)]
pub struct Kernel(CudaFunction);

/// Memory of the GPU: CUDA's own, or imported.
#[derive(Debug)]
pub struct DeviceBuffer(Memory);

#[derive(Debug)]
enum Memory {
    Own(CudaSlice<u8>),
    Imported(Imported),
}

impl DeviceBuffer {
    /// Its size.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        match &self.0 {
            Memory::Own(slice) => slice.len() as u64,
            Memory::Imported(imported) => imported.bytes as u64,
        }
    }

    /// Whether it is in memory that was imported.
    #[must_use]
    pub fn is_imported(&self) -> bool {
        matches!(self.0, Memory::Imported(..))
    }

    /// Passes it to a kernel.
    fn pass_to<'a>(&'a self, launch: &mut LaunchArgs<'a>) {
        match &self.0 {
            Memory::Own(slice) => launch.arg(slice),
            Memory::Imported(imported) => launch.arg(&imported.pointer),
        };
    }
}

fn failure(doing: impl Into<String>) -> impl FnOnce(DriverError) -> CudaError {
    let doing = doing.into();
    move |error| match error.0 {
        sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY => CudaError::OutOfMemory(doing),
        _ => CudaError::Driver { doing, error: format!("{error:?}") },
    }
}

/// A GPU's identifier in hexadecimal digits.
fn text(uuid: [u8; 16]) -> String {
    uuid.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Cuda {
    /// Opens the GPU with this identifier, as Vulkan (`deviceUUID`) and CUDA give it.
    ///
    /// # Errors
    /// [`CudaError::Missing`] where there is no CUDA or it has no such GPU.
    pub fn open(uuid: [u8; 16]) -> Result<Self, CudaError> {
        versions()?;
        result::init().map_err(|error| {
            CudaError::Missing(format!("the CUDA driver does not start: {error:?}"))
        })?;
        let count = result::device::get_count().map_err(failure("counting CUDA's devices"))?;
        for ordinal in 0..count {
            let device = result::device::get(ordinal).map_err(failure("asking for a device"))?;
            let found = result::device::get_uuid(device).map_err(failure("asking who it is"))?;
            if found.bytes.map(|byte| byte as u8) == uuid {
                return Self::start(ordinal as usize, uuid);
            }
        }
        let uuid = text(uuid);
        Err(CudaError::Missing(format!("none of CUDA's {count} devices is this GPU ({uuid})")))
    }

    fn start(ordinal: usize, uuid: [u8; 16]) -> Result<Self, CudaError> {
        let context = CudaContext::new(ordinal).map_err(failure("starting CUDA"))?;
        let (major, minor) =
            context.compute_capability().map_err(failure("asking for the architecture"))?;
        let stream = context.default_stream();
        let architecture = format!("compute_{major}{minor}");
        Ok(Self { context, stream, uuid, architecture, kernels: HashMap::new() })
    }

    /// The kernel of this name (`extern "C"`) in a source, compiled; each source once.
    ///
    /// # Errors
    /// [`CudaError::Compile`] with NVRTC's log.
    pub fn kernel(&mut self, label: &str, source: &str, name: &str) -> Result<Kernel, CudaError> {
        if let Some(known) = self.kernels.get(source) {
            return Ok(Kernel(known.clone()));
        }
        let options = CompileOptions {
            options: vec![
                format!("--gpu-architecture={}", self.architecture),
                "--std=c++17".to_owned(),
            ],
            name: Some(format!("{}.cu", label.replace(['/', ' '], "_"))),
            ..CompileOptions::default()
        };
        let ptx = compile_ptx_with_opts(source, options).map_err(|error| {
            let log = match error {
                CompileError::CompileError { log, .. } => log.to_string_lossy().into_owned(),
                other => format!("{other:?}"),
            };
            CudaError::Compile { label: label.to_owned(), log }
        })?;
        let loading = || failure(format!("loading {label}"));
        let module = self.context.load_module(ptx).map_err(loading())?;
        let function = module.load_function(name).map_err(loading())?;
        self.kernels.insert(source.to_owned(), function.clone());
        Ok(Kernel(function))
    }

    /// Bytes of local memory of a thread, and its registers: what the compiler made of a kernel.
    ///
    /// # Errors
    /// Where the driver does not say.
    pub fn local_bytes_and_registers(&self, kernel: &Kernel) -> Result<(u32, u32), CudaError> {
        let local = kernel.0.local_size_bytes().map_err(failure("asking for local memory"))?;
        let registers = kernel.0.num_regs().map_err(failure("asking for registers"))?;
        let number = |n| u32::try_from(n).unwrap_or_default();
        Ok((number(local), number(registers)))
    }

    /// A buffer that holds these bytes (and at least 16).
    ///
    /// # Errors
    /// Where there is no room.
    pub fn upload(&self, name: &str, bytes: &[u8]) -> Result<DeviceBuffer, CudaError> {
        let mut slice = self.slice(name, bytes.len() as u64)?;
        let copying = || failure(format!("uploading {name}, {} bytes", bytes.len()));
        self.stream.memcpy_htod(bytes, &mut slice).map_err(copying())?;
        self.stream.synchronize().map_err(copying())?;
        Ok(DeviceBuffer(Memory::Own(slice)))
    }

    /// A buffer that Vulkan allocated on this GPU, mapped where it is. Kernels read what was written
    /// there before they were launched, if the host has waited for it. It is not to be written.
    ///
    /// # Errors
    /// [`CudaError::Missing`] where it is on another GPU, or this one imports no memory; else as the
    /// driver says. The handle is closed then.
    ///
    /// # Safety
    /// The memory must be as described.
    pub unsafe fn import(
        &self,
        name: &str,
        shared: SharedMemory,
    ) -> Result<DeviceBuffer, CudaError> {
        if shared.uuid != self.uuid {
            let (there, here) = (text(shared.uuid), text(self.uuid));
            return Err(CudaError::Missing(format!(
                "{name} is on GPU {there}, and CUDA on {here}"
            )));
        }
        let importing = format!("importing {name}, {} bytes", shared.bytes);
        let Some(mapped_bytes) = shared.mapped_bytes() else {
            let error =
                format!("they are not in the {} bytes of their memory", shared.memory_bytes);
            return Err(CudaError::Driver { doing: importing, error });
        };
        // SAFETY: the caller answers for the description, and the GPU was compared above.
        let imported = unsafe { Imported::new(&self.context, shared, mapped_bytes) };
        let imported = imported.map_err(|error| match error.0 {
            sys::CUresult::CUDA_ERROR_NOT_SUPPORTED => {
                CudaError::Missing("CUDA imports no memory on this GPU".to_owned())
            }
            _ => failure(importing)(error),
        })?;
        Ok(DeviceBuffer(Memory::Imported(imported)))
    }

    /// A buffer of this many bytes, at least 16, that may hold anything.
    ///
    /// # Errors
    /// Where there is no room.
    pub fn allocate(&self, name: &str, bytes: u64) -> Result<DeviceBuffer, CudaError> {
        Ok(DeviceBuffer(Memory::Own(self.slice(name, bytes)?)))
    }

    fn slice(&self, name: &str, bytes: u64) -> Result<CudaSlice<u8>, CudaError> {
        let too_large = || CudaError::OutOfMemory(format!("{name}, {bytes} bytes"));
        let bytes_here = usize::try_from(bytes.max(16)).map_err(|_| too_large())?;
        // SAFETY: bytes may hold anything, and nothing is read that a run has not written.
        let slice = unsafe { self.stream.alloc::<u8>(bytes_here) };
        slice.map_err(failure(format!("allocating {name}, {bytes} bytes")))
    }

    /// Fills the output with `0xCD`, then runs a kernel with `blocks` of `threads` in one dimension,
    /// and waits. Nanoseconds of the kernel alone, by CUDA's events. Filling comes first also so that
    /// the events and the kernel are queued while it runs: what submitting costs the host is not
    /// timed.
    ///
    /// # Errors
    /// Where the driver fails, or the kernel does, or the output is imported.
    ///
    /// # Safety
    /// The kernel must have as parameters as many pointers as there are `inputs`, a `u32`, as many
    /// pointers as there are `more`, and a pointer to what it writes; and it must access nothing
    /// outside of these buffers.
    pub unsafe fn run(
        &self,
        kernel: &Kernel,
        (blocks, threads): (u32, u32),
        (inputs, number, more): (&[DeviceBuffer], u32, &[DeviceBuffer]),
        output: &mut DeviceBuffer,
    ) -> Result<u64, CudaError> {
        let timing = || failure("timing a kernel");
        let event = || self.context.new_event(Some(sys::CUevent_flags::CU_EVENT_DEFAULT));
        let (before, after) = (event().map_err(timing())?, event().map_err(timing())?);
        let Memory::Own(output) = &mut output.0 else {
            let (doing, error) = ("running a kernel".into(), "its output is imported".into());
            return Err(CudaError::Driver { doing, error });
        };
        self.poison(output)?;
        let mut launch = self.stream.launch_builder(&kernel.0);
        for input in inputs {
            input.pass_to(&mut launch);
        }
        launch.arg(&number);
        for input in more {
            input.pass_to(&mut launch);
        }
        launch.arg(output);
        let config = LaunchConfig {
            grid_dim: (blocks, 1, 1),
            block_dim: (threads, 1, 1),
            shared_mem_bytes: 0,
        };
        before.record(&self.stream).map_err(timing())?;
        // SAFETY: the caller answers for the parameters.
        unsafe { launch.launch(config) }.map_err(failure("launching a kernel"))?;
        after.record(&self.stream).map_err(timing())?;
        self.stream.synchronize().map_err(failure("running a kernel"))?;
        let ms = before.elapsed_ms(&after).map_err(timing())?;
        Ok((f64::from(ms) * 1e6).round() as u64)
    }

    fn poison(&self, slice: &mut CudaSlice<u8>) -> Result<(), CudaError> {
        use cudarc::driver::DevicePtrMut;
        let bytes = slice.len();
        self.context.bind_to_thread().map_err(failure("choosing the GPU"))?;
        let (pointer, _written) = slice.device_ptr_mut(&self.stream);
        // SAFETY: the buffer is alive and has this many bytes.
        let filled =
            unsafe { result::memset_d8_async(pointer, POISON, bytes, self.stream.cu_stream()) };
        filled.map_err(failure("filling a buffer"))
    }

    /// What a buffer holds.
    ///
    /// # Errors
    /// Where the driver fails.
    pub fn read(&self, buffer: &DeviceBuffer) -> Result<Vec<u8>, CudaError> {
        let reading = || failure(format!("reading back {} bytes", buffer.bytes()));
        let bytes = match &buffer.0 {
            Memory::Own(slice) => self.stream.clone_dtoh(slice).map_err(reading())?,
            Memory::Imported(imported) => {
                let mut bytes = vec![0; imported.bytes];
                let stream = self.stream.cu_stream();
                self.context.bind_to_thread().map_err(reading())?;
                // SAFETY: the buffer is mapped, and both have this many bytes.
                let copied =
                    unsafe { result::memcpy_dtoh_async(&mut bytes, imported.pointer, stream) };
                copied.map_err(reading())?;
                bytes
            }
        };
        self.stream.synchronize().map_err(reading())?;
        Ok(bytes)
    }
}
