//! Memory that Vulkan allocated, as CUDA sees it: imported by a handle and mapped, never copied.

use std::sync::Arc;

use cudarc::driver::{CudaContext, DriverError, result, sys};

/// What refers to memory that is imported: a file descriptor, as Vulkan's `OPAQUE_FD`.
#[cfg(unix)]
pub type Handle = std::os::fd::OwnedFd;

/// Where there are no file descriptors, no memory is imported.
#[cfg(not(unix))]
pub type Handle = std::convert::Infallible;

/// A buffer in memory that another interface of the driver allocated.
#[derive(Debug)]
pub struct SharedMemory {
    /// Refers to the allocation.
    pub handle: Handle,
    /// The GPU on which it is.
    pub uuid: [u8; 16],
    /// Size of the allocation in bytes.
    pub memory_bytes: u64,
    /// Whether the allocation was made for one buffer alone.
    pub dedicated: bool,
    /// Where in it the buffer begins, in bytes.
    pub offset_bytes: u64,
    /// The buffer's size in bytes.
    pub bytes: u64,
}

/// An imported buffer. Dropping it ends the import; the memory goes with the last that refers to it.
#[derive(Debug)]
pub(crate) struct Imported {
    /// `None` where nothing is mapped.
    mapped: Option<sys::CUdeviceptr>,
    bytes: usize,
    memory: sys::CUexternalMemory,
    context: Arc<CudaContext>,
}

impl Imported {
    /// Imports memory of the context's GPU and maps the buffer. Zero bytes are mapped nowhere.
    ///
    /// # Errors
    /// As the driver says.
    ///
    /// # Safety
    /// The memory must be as described, and on the context's GPU.
    pub(crate) unsafe fn new(
        context: &Arc<CudaContext>,
        shared: SharedMemory,
    ) -> Result<Self, DriverError> {
        let SharedMemory { handle, memory_bytes, dedicated, offset_bytes, bytes, .. } = shared;
        context.bind_to_thread()?;
        // SAFETY: the caller answers for the description.
        let memory = unsafe { import(handle, memory_bytes, dedicated) }?;
        let mut imported =
            Self { mapped: None, bytes: bytes as usize, memory, context: context.clone() };
        if bytes > 0 {
            // SAFETY: the memory was imported above, and the buffer is inside.
            let mapped =
                unsafe { result::external_memory::get_mapped_buffer(memory, offset_bytes, bytes) };
            imported.mapped = Some(mapped?);
        }
        Ok(imported)
    }

    /// Where it is; 0 where it has no bytes.
    pub(crate) fn pointer(&self) -> sys::CUdeviceptr {
        self.mapped.unwrap_or_default()
    }

    /// Its size.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }
}

impl Drop for Imported {
    fn drop(&mut self) {
        let context = &self.context;
        context.record_err(context.bind_to_thread());
        // SAFETY: every run is waited for, so nothing uses the mapping; it is freed once, and before the
        // memory that it maps.
        unsafe {
            if let Some(mapped) = self.mapped {
                context.record_err(result::memory_free(mapped));
            }
            context.record_err(result::external_memory::destroy_external_memory(self.memory));
        }
    }
}

/// # Safety
/// The handle must refer to an allocation of this size on the current GPU.
#[cfg(unix)]
unsafe fn import(
    handle: Handle,
    memory_bytes: u64,
    dedicated: bool,
) -> Result<sys::CUexternalMemory, DriverError> {
    use std::os::fd::{AsRawFd, IntoRawFd};
    let description = sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC {
        type_: sys::CUexternalMemoryHandleType::CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD,
        handle: sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1 { fd: handle.as_raw_fd() },
        size: memory_bytes,
        flags: if dedicated { sys::CUDA_EXTERNAL_MEMORY_DEDICATED } else { 0 },
        reserved: [0; 16],
    };
    let mut memory = std::ptr::null_mut();
    // SAFETY: the caller answers for the handle. Functions of this age every driver has.
    unsafe { sys::cuImportExternalMemory(&raw mut memory, &raw const description) }.result()?;
    // From here on the file descriptor is the driver's; where it failed, dropping it closed it.
    let _ = handle.into_raw_fd();
    Ok(memory)
}

/// # Safety
/// None: there are no such handles.
#[cfg(not(unix))]
unsafe fn import(handle: Handle, _: u64, _: bool) -> Result<sys::CUexternalMemory, DriverError> {
    match handle {}
}
