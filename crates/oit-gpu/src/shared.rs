//! Memory of a plan's buffer that other interfaces of the same GPU (CUDA) can import.

/// What refers to the memory of a [`SharedBuffer`]: a file descriptor, as Vulkan's `OPAQUE_FD`.
#[cfg(unix)]
pub type Handle = std::os::fd::OwnedFd;

/// Where there are no file descriptors, no memory is shared.
#[cfg(not(unix))]
pub type Handle = std::convert::Infallible;

/// The memory of one of a plan's buffers, for another interface of the same GPU to import. It outlives
/// the plan, and the device, for as long as the handle or an import of it does.
#[derive(Debug)]
pub struct SharedBuffer {
    /// Refers to the memory. Whoever imports it may have to keep it or to give it away.
    pub handle: Handle,
    /// The GPU: a handle means nothing to another.
    pub uuid: [u8; 16],
    /// Size of the allocation in bytes.
    pub memory_bytes: u64,
    /// Whether the allocation was made for this buffer alone (Vulkan's dedicated allocation), which
    /// importers want to be told.
    pub dedicated: bool,
    /// Where in the allocation the buffer begins, in bytes.
    pub offset_bytes: u64,
    /// The buffer's size in bytes, as its plan has it.
    pub bytes: u64,
}
