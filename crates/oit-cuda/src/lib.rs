//! Kernels in CUDA C++ on an NVIDIA GPU: what a resolve in CUDA needs, and no more.
//!
//! Nothing of CUDA is needed to build. The driver and NVRTC, its compiler, are looked for when a
//! device is opened; a machine without them gets [`CudaError::Missing`] with the reason.

mod device;
mod imported;
mod libraries;
mod segmented_sort;

pub use device::{Cuda, DeviceBuffer, Kernel};
pub use imported::{Handle, SharedMemory};
pub use libraries::{Versions, versions};
pub use segmented_sort::{Sorted, segmented_sort};

/// What kept CUDA from doing as told.
#[derive(Debug, thiserror::Error)]
pub enum CudaError {
    /// This machine has no CUDA, or not on this GPU, or not of the version needed.
    #[error("{0}")]
    Missing(String),
    /// NVRTC refuses a kernel.
    #[error("{label} does not compile:\n{log}")]
    Compile {
        /// What the kernel is.
        label: String,
        /// What NVRTC says.
        log: String,
    },
    /// There is not enough memory.
    #[error("out of device memory: {0}")]
    OutOfMemory(String),
    /// The driver fails.
    #[error("{doing}: {error}")]
    Driver {
        /// What was tried.
        doing: String,
        /// What the driver says.
        error: String,
    },
}
