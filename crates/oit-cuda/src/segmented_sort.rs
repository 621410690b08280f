//! CUDA's own segmented sort, as a row to compare with: it sorts, and composites nothing.
//!
//! CUB is made of templates of host code, which NVRTC does not compile. Where the machine has `nvcc`, a
//! small library is compiled with it when it is needed.

use std::ffi::{CStr, c_char, c_int};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::CudaError;
use crate::libraries::toolkits;

/// What it made of the keys, and how long each run took.
#[derive(Clone, PartialEq, Debug)]
pub struct Sorted {
    /// The keys, in ascending order in each segment.
    pub keys: Vec<u64>,
    /// Nanoseconds of each run, by CUDA's events. The first run is not among them.
    pub runs_ns: Vec<u64>,
}

type SegmentedSort = unsafe extern "C" fn(
    *const u64,
    *mut u64,
    c_int,
    *const c_int,
    c_int,
    *mut f32,
    c_int,
) -> c_int;

/// Sorts the keys of each segment by CUB's `DeviceSegmentedSort::SortKeys` on CUDA's first device;
/// segment `i` is `offsets[i]..offsets[i + 1]`.
///
/// # Errors
/// [`CudaError::Missing`] where there is no `nvcc`, or there are more keys or segments than it counts
/// (2^31); else as CUDA says.
///
/// # Panics
/// Where the offsets fall, or do not end where the keys do.
pub fn segmented_sort(keys: &[u64], offsets: &[u32], runs: u32) -> Result<Sorted, CudaError> {
    assert!(offsets.is_sorted() && offsets.first() == Some(&0), "offsets rise from 0");
    assert_eq!(offsets.last().map(|&end| end as usize), Some(keys.len()), "they end with the keys");
    let count = |n: usize| {
        let too_many =
            |_| CudaError::Missing(format!("{n} are more than CUB's sort is given here"));
        c_int::try_from(n).map_err(too_many)
    };
    let (items, segments) = (count(keys.len())?, count(offsets.len() - 1)?);
    let runs = count(runs as usize)?;
    let nvcc = nvcc()?;
    let folder = std::env::temp_dir().join(format!("oit-segmented-sort-{}", std::process::id()));
    let compiled = compile(&nvcc, &folder);
    let sorted = compiled.and_then(|library| sort(&library, keys, items, offsets, segments, runs));
    // Nothing is lost where it stays.
    let _ = std::fs::remove_dir_all(&folder);
    sorted
}

/// The toolkit's compiler: a toolkit's that is named or in its usual place, or that on the path.
fn nvcc() -> Result<PathBuf, CudaError> {
    let named = toolkits().into_iter().map(|toolkit| toolkit.join("bin/nvcc"));
    let all = named.chain([PathBuf::from("nvcc")]);
    let works = |nvcc: &PathBuf| {
        Command::new(nvcc).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    let mut found = all.filter(works);
    found.next().ok_or_else(|| {
        let reason = "no nvcc found: CUB's sort is host code of the CUDA toolkit, which NVRTC does \
                      not compile";
        CudaError::Missing(reason.to_owned())
    })
}

fn compile(nvcc: &Path, folder: &Path) -> Result<libloading::Library, CudaError> {
    let failed = |error: &dyn std::fmt::Display| CudaError::Driver {
        doing: "compiling CUB's sort".into(),
        error: error.to_string(),
    };
    std::fs::create_dir_all(folder).map_err(|error| failed(&error))?;
    let (source, library) = (folder.join("segmented_sort.cu"), folder.join("segmented_sort.so"));
    let text = include_str!("segmented_sort.cu");
    std::fs::write(&source, text).map_err(|error| failed(&error))?;
    let output = Command::new(nvcc)
        .args(["-shared", "-Xcompiler", "-fPIC", "-O3", "-arch=native", "-std=c++17", "-o"])
        .args([&library, &source])
        .output()
        .map_err(|error| failed(&error))?;
    if !output.status.success() {
        let log = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(CudaError::Compile { label: "CUB's segmented sort".into(), log });
    }
    // SAFETY: it is the library of the source above, and has no initialisers but CUDA's.
    unsafe { libloading::Library::new(&library) }.map_err(|error| failed(&error))
}

fn sort(
    library: &libloading::Library,
    keys: &[u64],
    items: c_int,
    offsets: &[u32],
    segments: c_int,
    runs: c_int,
) -> Result<Sorted, CudaError> {
    let failed = |error: String| CudaError::Driver { doing: "CUB's segmented sort".into(), error };
    let mut sorted = vec![0u64; keys.len()];
    let mut milliseconds = vec![0f32; runs as usize];
    // SAFETY: the functions are of these types in the source that was compiled. The offsets are below
    // 2^31, as the number of keys is.
    unsafe {
        let function = library.get::<SegmentedSort>(b"oit_segmented_sort\0");
        let function = function.map_err(|error| failed(error.to_string()))?;
        let status = function(
            keys.as_ptr(),
            sorted.as_mut_ptr(),
            items,
            offsets.as_ptr().cast(),
            segments,
            milliseconds.as_mut_ptr(),
            runs,
        );
        if status != 0 {
            type Text = unsafe extern "C" fn(c_int) -> *const c_char;
            let text = library.get::<Text>(b"oit_error\0");
            let text = text.map_err(|error| failed(error.to_string()))?;
            return Err(failed(CStr::from_ptr(text(status)).to_string_lossy().into_owned()));
        }
    }
    let ns = |ms: &f32| (f64::from(*ms) * 1e6).round() as u64;
    Ok(Sorted { keys: sorted, runs_ns: milliseconds.iter().map(ns).collect() })
}
