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

/// Bytes that are mapped at least: no buffer is smaller.
const LEAST_BYTES: u64 = 16;

impl SharedMemory {
    /// Bytes of the allocation that are mapped; `None` where they are not inside it.
    pub(crate) fn mapped_bytes(&self) -> Option<u64> {
        let bytes = self.bytes.max(LEAST_BYTES);
        let end = self.offset_bytes.checked_add(bytes)?;
        (end <= self.memory_bytes).then_some(bytes)
    }
}

/// An imported buffer. Dropping it ends the import; the memory goes with the last that refers to it.
#[derive(Debug)]
pub(crate) struct Imported {
    /// Where it is mapped.
    pub(crate) pointer: sys::CUdeviceptr,
    /// The buffer's size.
    pub(crate) bytes: usize,
    allocation: Allocation,
}

#[derive(Debug)]
struct Allocation {
    memory: sys::CUexternalMemory,
    context: Arc<CudaContext>,
}

impl Imported {
    /// Imports memory of the context's GPU and maps this much of it from where the buffer begins.
    ///
    /// # Errors
    /// As the driver says.
    ///
    /// # Safety
    /// The memory must be as described, and on the context's GPU.
    pub(crate) unsafe fn new(
        context: &Arc<CudaContext>,
        shared: SharedMemory,
        mapped_bytes: u64,
    ) -> Result<Self, DriverError> {
        let SharedMemory { handle, memory_bytes, dedicated, offset_bytes, bytes, .. } = shared;
        context.bind_to_thread()?;
        // SAFETY: the caller answers for the description.
        let memory = unsafe { import(handle, memory_bytes, dedicated) }?;
        let allocation = Allocation { memory, context: context.clone() };
        // SAFETY: the memory was imported above.
        let pointer = unsafe {
            result::external_memory::get_mapped_buffer(memory, offset_bytes, mapped_bytes)
        }?;
        Ok(Self { pointer, bytes: bytes as usize, allocation })
    }
}

impl Drop for Imported {
    fn drop(&mut self) {
        let context = &self.allocation.context;
        context.record_err(context.bind_to_thread());
        // SAFETY: every run is waited for, so nothing uses the mapping; its memory goes after it.
        context.record_err(unsafe { result::memory_free(self.pointer) });
    }
}

impl Drop for Allocation {
    fn drop(&mut self) {
        self.context.record_err(self.context.bind_to_thread());
        // SAFETY: nothing of it is mapped any more, and it is given back once.
        let gone = unsafe { result::external_memory::destroy_external_memory(self.memory) };
        self.context.record_err(gone);
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn mapped(memory_bytes: u64, offset_bytes: u64, bytes: u64) -> Option<u64> {
        let handle = std::fs::File::open("/dev/null").expect("it is always there").into();
        let dedicated = false;
        let shared =
            SharedMemory { handle, uuid: [0; 16], memory_bytes, dedicated, offset_bytes, bytes };
        shared.mapped_bytes()
    }

    #[test]
    fn what_is_mapped_is_inside_the_allocation() {
        assert_eq!(mapped(4096, 0, 4096), Some(4096));
        assert_eq!(mapped(4096, 256, 3840), Some(3840));
        assert_eq!(mapped(4096, 0, 3), Some(16));
        assert_eq!(mapped(4096, 256, 3841), None);
        assert_eq!(mapped(4096, 4096, 1), None);
        assert_eq!(mapped(8, 0, 8), None);
        assert_eq!(mapped(4096, u64::MAX, 16), None);
        assert_eq!(mapped(4096, 16, u64::MAX), None);
    }
}
