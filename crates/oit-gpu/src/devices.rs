//! The GPUs of this machine, by every backend.

use crate::{Device, DeviceInfo, GpuError, Vulkan, Wgpu, vulkan, wgpu_backend};
use std::path::Path;

/// A device, or a whole backend, and whether it can be used.
#[derive(Clone, PartialEq, Debug)]
pub struct Listed {
    /// By which [`open`] opens it: `vulkan:0`, `wgpu:0`. A backend that finds no device at all has
    /// one entry, `vulkan` or `wgpu`, with the reason.
    pub id: String,
    /// What it is, or why it cannot be used.
    pub info: Result<DeviceInfo, String>,
}

/// Lists every device of every backend, the instrument's first.
#[must_use]
pub fn enumerate() -> Vec<Listed> {
    let mut listed = listing("vulkan", vulkan::enumerate());
    listed.extend(listing("wgpu", wgpu_backend::enumerate()));
    listed
}

fn listing(
    backend: &str,
    found: Result<Vec<Result<DeviceInfo, GpuError>>, GpuError>,
) -> Vec<Listed> {
    let unusable = |reason: String| vec![Listed { id: backend.to_owned(), info: Err(reason) }];
    match found {
        Err(GpuError::Unsupported(reason)) => unusable(reason),
        Err(error) => unusable(error.to_string()),
        Ok(devices) if devices.is_empty() => unusable("no device was found".to_owned()),
        Ok(devices) => devices
            .into_iter()
            .enumerate()
            .map(|(index, info)| Listed {
                id: format!("{backend}:{index}"),
                info: info.map_err(|error| error.to_string()),
            })
            .collect(),
    }
}

/// Opens a device by its id. Compiled pipelines are kept in `cache_dir`, which need not exist.
///
/// # Errors
/// [`GpuError::Unsupported`] if no device has this id, or it cannot run plans.
pub fn open(id: &str, cache_dir: &Path) -> Result<Box<dyn Device>, GpuError> {
    let parts = id
        .split_once(':')
        .and_then(|(backend, index)| Some((backend, index.parse::<usize>().ok()?)));
    match parts {
        Some(("vulkan", index)) => Ok(Box::new(Vulkan::open(index, cache_dir, false)?)),
        Some(("wgpu", index)) => Ok(Box::new(Wgpu::open(index, cache_dir)?)),
        _ => {
            let ids: Vec<_> = enumerate().into_iter().map(|listed| listed.id).collect();
            let known = ids.join(", ");
            Err(GpuError::Unsupported(format!("no device is named {id:?}; there are {known}")))
        }
    }
}
