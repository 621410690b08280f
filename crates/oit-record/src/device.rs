//! What a device says of itself, as listed by `oit devices` and kept with every run.

use serde::{Deserialize, Serialize};

/// A device and its limits. Nothing here is guessed: what a driver does not tell is `None` or empty.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct DeviceInfo {
    /// The name by which `--device` selects it: `cpu`, `vulkan:0`, `wgpu:0`.
    pub id: String,
    /// The backend: `cpu`, `vulkan`, `wgpu`.
    pub backend: String,
    /// The device's name as its driver gives it.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// The API and its version, `Vulkan 1.4.312`.
    pub api: String,
    /// `discrete-gpu`, `integrated-gpu`, `virtual-gpu`, `cpu`, `other`.
    pub kind: String,
    /// Smallest and largest subgroup, in invocations.
    pub subgroup_size: Option<(u32, u32)>,
    /// The largest range of one storage binding, in bytes.
    pub max_storage_buffer_bytes: u64,
    /// Workgroup memory of one workgroup, in bytes.
    pub max_workgroup_bytes: u64,
    /// Invocations of one workgroup.
    pub max_workgroup_invocations: u32,
    /// Nanoseconds of one timestamp tick; `None` where the device has no timestamps.
    pub timestamp_period_ns: Option<f64>,
    /// Device-local memory, in bytes.
    pub memory_bytes: Option<u64>,
    /// The versions of CUDA's driver and compiler, where the device was used by them too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cuda: Option<String>,
    /// What techniques may need and this device lacks, with the reason.
    pub unsupported: Vec<Unsupported>,
}

/// One thing a device cannot do.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Unsupported {
    /// The feature, by the project's word for it.
    pub feature: String,
    /// Why it is missing.
    pub reason: String,
}
