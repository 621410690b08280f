//! Buffers whose memory another interface of the driver can import, by `VK_KHR_external_memory_fd`.
//!
//! Only buffers that are asked for are made so. Vulkan has memory change hands by a barrier to
//! `VK_QUEUE_FAMILY_EXTERNAL` and one back. CUDA has no counterpart, and as in NVIDIA's own samples (see
//! issue 64 of NVIDIA/cuda-samples) none is recorded: each run is waited for by its fence, which makes
//! what was written available, and importers only read.

use super::failure;
use super::gpu::{Buffer, Gpu};
use crate::device::no_sharing;
use crate::{GpuError, Handle};
use ash::{khr, vk};
use std::collections::HashSet;
use std::ffi::CString;

/// The kind of handle that is given away.
pub(super) const HANDLE: vk::ExternalMemoryHandleTypeFlags =
    vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;

/// The extension's functions, on a device that has it enabled.
pub(super) type Functions = khr::external_memory_fd::Device;

/// How a device shares the memory of buffers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sharing {
    /// Whether such memory is one buffer's alone, always.
    pub(super) dedicated_only: bool,
}

/// Whether the environment asks for copies: `OIT_SHARE=0`.
fn is_refused() -> bool {
    std::env::var_os("OIT_SHARE").is_some_and(|value| value == "0")
}

/// How a device shares the memory of buffers of this usage, or why it does not.
pub(super) fn ask(
    vulkan: &ash::Instance,
    raw: vk::PhysicalDevice,
    extensions: &HashSet<CString>,
    usage: vk::BufferUsageFlags,
) -> Result<Sharing, String> {
    if is_refused() {
        return Err("the environment has OIT_SHARE=0".to_owned());
    }
    if !extensions.contains(khr::external_memory_fd::NAME) {
        let name = khr::external_memory_fd::NAME.to_string_lossy();
        return Err(format!("the driver lacks {name}"));
    }
    let info = vk::PhysicalDeviceExternalBufferInfo::default().usage(usage).handle_type(HANDLE);
    let mut properties = vk::ExternalBufferProperties::default();
    // SAFETY: the physical device is of this instance, which is of Vulkan 1.3.
    unsafe {
        vulkan.get_physical_device_external_buffer_properties(raw, &info, &mut properties);
    }
    let features = properties.external_memory_properties.external_memory_features;
    if !features.contains(vk::ExternalMemoryFeatureFlags::EXPORTABLE) {
        return Err("the driver does not export the memory of buffers".to_owned());
    }
    let dedicated_only = features.contains(vk::ExternalMemoryFeatureFlags::DEDICATED_ONLY);
    Ok(Sharing { dedicated_only })
}

/// A new handle of a buffer's memory.
///
/// # Errors
/// [`GpuError::Unsupported`] where the buffer is not made for it.
#[cfg(unix)]
pub(super) fn handle(gpu: &Gpu, name: &str, buffer: &Buffer) -> Result<Handle, GpuError> {
    use std::os::fd::FromRawFd;
    let (Some(functions), Some(_)) = (&gpu.sharing, buffer.shared) else {
        return Err(not_asked_for(gpu, name));
    };
    let info = vk::MemoryGetFdInfoKHR::default().memory(buffer.memory).handle_type(HANDLE);
    // SAFETY: the memory is alive and was allocated to be exported by this kind of handle. The file
    // descriptor is new and the caller's.
    unsafe {
        let fd = functions
            .get_memory_fd(&info)
            .map_err(|error| failure(&format!("exporting buffer {name:?}"), error))?;
        Ok(Handle::from_raw_fd(fd))
    }
}

/// Without file descriptors no device has the extension.
#[cfg(not(unix))]
pub(super) fn handle(gpu: &Gpu, name: &str, _buffer: &Buffer) -> Result<Handle, GpuError> {
    Err(not_asked_for(gpu, name))
}

fn not_asked_for(gpu: &Gpu, name: &str) -> GpuError {
    match &gpu.physical.sharing {
        Ok(_) => no_sharing(&format!("buffer {name:?} was not asked for")),
        Err(reason) => no_sharing(reason),
    }
}
