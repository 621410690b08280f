//! The driver and NVRTC: whether they are there, and of which version.

use std::ffi::c_int;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use cudarc::{driver, nvrtc};

use crate::CudaError;

/// The versions of CUDA that driver and compiler are of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Versions {
    /// The newest CUDA that the driver knows, major and minor.
    pub driver: (u32, u32),
    /// NVRTC's.
    pub nvrtc: (u32, u32),
}

impl fmt::Display for Versions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { driver, nvrtc } = self;
        write!(f, "driver for CUDA {}.{}, NVRTC {}.{}", driver.0, driver.1, nvrtc.0, nvrtc.1)
    }
}

/// The first CUDA whose driver has every function that is called.
const NEEDED: (u32, u32) = (13, 0);

/// Looks for the driver and NVRTC, once a process, and asks for their versions.
///
/// # Errors
/// [`CudaError::Missing`] where one of them is not there or too old.
pub fn versions() -> Result<Versions, CudaError> {
    static FOUND: OnceLock<Result<Versions, String>> = OnceLock::new();
    FOUND.get_or_init(find).clone().map_err(CudaError::Missing)
}

fn find() -> Result<Versions, String> {
    // A call into a library that is not there would panic: these come first.
    // SAFETY: loading the driver runs its initialisers, which is what it is for.
    if !unsafe { driver::sys::is_culib_present() } {
        return Err("no CUDA driver found".to_owned());
    }
    let mut version: c_int = 0;
    // SAFETY: the library is there, and has this function since CUDA 2.2.
    let answer = unsafe { driver::sys::cuDriverGetVersion(&raw mut version) };
    if answer != driver::sys::CUresult::CUDA_SUCCESS {
        return Err(format!("the CUDA driver does not say its version: {answer:?}"));
    }
    let version = u32::try_from(version).unwrap_or_default();
    let driver = (version / 1000, version % 1000 / 10);
    if driver < NEEDED {
        let ((major, minor), needed) = (driver, NEEDED);
        return Err(format!(
            "the driver is for CUDA {major}.{minor}, and {}.{} is needed",
            needed.0, needed.1
        ));
    }
    load_nvrtc_of_a_toolkit();
    // SAFETY: as with the driver.
    if !unsafe { nvrtc::sys::is_culib_present() } {
        return Err("no NVRTC found (libnvrtc, CUDA's compiler): LD_LIBRARY_PATH or CUDA_PATH \
                    can say where it is"
            .to_owned());
    }
    let (mut major, mut minor): (c_int, c_int) = (0, 0);
    // SAFETY: the library is there, and has this function since its first version.
    let answer = unsafe { nvrtc::sys::nvrtcVersion(&raw mut major, &raw mut minor) };
    if answer != nvrtc::sys::nvrtcResult::NVRTC_SUCCESS {
        return Err(format!("NVRTC does not say its version: {answer:?}"));
    }
    let nvrtc = [major, minor].map(|number| u32::try_from(number).unwrap_or_default());
    let nvrtc = (nvrtc[0], nvrtc[1]);
    if nvrtc.0 > driver.0 {
        return Err(format!(
            "NVRTC {}.{} makes code that a driver for CUDA {}.{} does not know",
            nvrtc.0, nvrtc.1, driver.0, driver.1
        ));
    }
    Ok(Versions { driver, nvrtc })
}

/// The folders in which a toolkit may be.
pub(crate) fn toolkits() -> Vec<PathBuf> {
    let named = ["CUDA_PATH", "CUDA_HOME"].into_iter().filter_map(std::env::var_os);
    named.map(PathBuf::from).chain([PathBuf::from("/usr/local/cuda")]).collect()
}

/// NVRTC is part of the toolkit, whose libraries the loader need not know. Loaded by its path, it is
/// found by its name from then on.
fn load_nvrtc_of_a_toolkit() {
    for toolkit in toolkits() {
        for folder in ["lib64", "targets/x86_64-linux/lib", "targets/sbsa-linux/lib"] {
            if load_all(&toolkit.join(folder)) {
                return;
            }
        }
    }
}

/// Loads NVRTC and what it will look for from a folder, for good. Whether NVRTC was among it.
fn load_all(folder: &Path) -> bool {
    let Ok(entries) = std::fs::read_dir(folder) else { return false };
    let mut names: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    // `libnvrtc-builtins` before `libnvrtc`, which looks for it.
    names.sort();
    let mut found = false;
    for path in names {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_library = name.contains(".so") && !name.contains(".alt");
        if !is_library || !name.starts_with("libnvrtc") {
            continue;
        }
        // SAFETY: a toolkit's library, whose initialisers are what it is for.
        if let Ok(library) = unsafe { libloading::Library::new(&path) } {
            found |= name.starts_with("libnvrtc.so");
            // It stays: what was compiled with it does too.
            std::mem::forget(library);
        }
    }
    found
}
