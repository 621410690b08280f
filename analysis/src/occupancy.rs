//! A model of what a resolve program's array costs: how many invocations a processor can hold, and
//! how many bytes each moves. It predicts the time of a program relative to another's on the same
//! fragments. It is there to be compared with what was measured, and is used for nothing else.
//!
//! # Formula
//!
//! ```text
//! registers of a warp  = registers of an invocation * 32, rounded up to the allocation unit
//! warps by registers   = partitions * floor(registers of a partition / registers of a warp)
//! workgroups           = min(floor(warps by registers / warps of a workgroup),
//!                            floor(threads of an SM / 32 / warps of a workgroup),
//!                            workgroups of an SM,
//!                            floor(shared bytes of an SM / (bytes of a workgroup + reserved,
//!                                                           rounded up to their allocation unit)))
//! warps                = workgroups * warps of a workgroup
//! bytes of a pixel     = fragments * (8 read + 4 link) + 16 written
//!                        + 2 * local bytes touched * device bandwidth / L1 bandwidth
//! local bytes touched  = min(local bytes of an invocation, fragments * 8)
//! time                 ~ bytes of a pixel / warps
//! ```
//!
//! The first part is NVIDIA's occupancy calculation (`cuda_occupancy.h` of CUDA 12 and 13,
//! `cudaOccMaxBlocksPerSMRegsLimit`: registers are given to warps in units of 256, out of four partitions).
//! How much of the L1 cache is set apart as shared memory (the carve-out) is the driver's choice; what is
//! counted is the most there can be. In the fragment stage a warp counts as a workgroup, and
//! neither limits of workgroups nor shared memory count. The last line is Little's law where latency
//! bounds: with twice as many warps in flight, twice as many bytes arrive in the same time (Volkov,
//! *Understanding Latency Hiding on GPUs*, 2016). Where the memory's bandwidth or
//! instructions bound, it predicts too large a difference. Local memory lies in device memory behind
//! the L1 cache, so that unlike in BMA 2013, section 3, its size does not limit the warps: only what is
//! touched of it counts, an array's elements once written and once read. What is touched soon again is
//! found in the L1 cache, whose bandwidth is several times that of device memory: a local byte counts
//! for as much less. That all of it stays there is the best case. To count local bytes as bytes of
//! device memory, as this model once did, predicts far too much: docs/METHODOLOGY.md has both errors.

use oit_record::{DeviceInfo, Program};

use crate::programs::ProgramFigures;

/// What a streaming multiprocessor holds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SmLimits {
    /// The compute capability, `9.0`.
    pub capability: &'static str,
    /// Registers, of 32 bits.
    pub registers: u64,
    /// Invocations.
    pub threads: u64,
    /// Workgroups.
    pub workgroups: u64,
    /// Workgroup memory, in bytes.
    pub shared_bytes: u64,
    /// Bandwidth of the device's memory, in GB/s.
    pub device_gb_s: u32,
    /// Bandwidth of the L1 caches of all multiprocessors, in GB/s.
    pub l1_gb_s: u32,
}

/// Limits by words of a device's name. Source: CUDA C++ Programming Guide 12, section "Compute
/// Capabilities", table "Technical Specifications per Compute Capability", and for 9.0 the Hopper Tuning
/// Guide (docs.nvidia.com/cuda/hopper-tuning-guide), "Occupancy"; which device has which capability:
/// developer.nvidia.com/cuda-gpus. Bandwidths of memory are those of NVIDIA's product pages, of the SXM
/// boards; those of L1 are 128 bytes a clock of each multiprocessor (132 at 1.755 GHz, 108 at 1.410), as
/// doi.org/10.1016/j.ultsonch.2023.106546, Table 3, has them for whole chips.
const LIMITS: &[(&[&str], SmLimits)] = &[
    (
        &["NVIDIA H200"],
        SmLimits {
            capability: "9.0",
            registers: 65_536,
            threads: 2048,
            workgroups: 32,
            shared_bytes: 228 << 10,
            device_gb_s: 4800,
            l1_gb_s: 29_652,
        },
    ),
    (
        &["NVIDIA H100"],
        SmLimits {
            capability: "9.0",
            registers: 65_536,
            threads: 2048,
            workgroups: 32,
            shared_bytes: 228 << 10,
            device_gb_s: 3350,
            l1_gb_s: 29_652,
        },
    ),
    (
        &["NVIDIA GH200"],
        SmLimits {
            capability: "9.0",
            registers: 65_536,
            threads: 2048,
            workgroups: 32,
            shared_bytes: 228 << 10,
            device_gb_s: 4000,
            l1_gb_s: 29_652,
        },
    ),
    (
        &["NVIDIA A100"],
        SmLimits {
            capability: "8.0",
            registers: 65_536,
            threads: 2048,
            workgroups: 32,
            shared_bytes: 164 << 10,
            device_gb_s: 1555,
            l1_gb_s: 19_492,
        },
    ),
];

/// Invocations of a warp.
const WARP: u64 = 32;
/// Registers are given to warps in units of so many, and shared memory in units of so many bytes
/// (`cuda_occupancy.h`, for capabilities 8.x and 9.x).
const REGISTER_UNIT: u64 = 256;
const SHARED_UNIT_BYTES: u64 = 128;
/// Parts of a multiprocessor with registers of their own (`cuda_occupancy.h`).
const PARTITIONS: u64 = 4;
/// Shared memory that the system takes of each workgroup (CUDA C++ Programming Guide, "Shared
/// Memory" of capabilities 8.x and 9.0).
const RESERVED_BYTES: u64 = 1024;

impl SmLimits {
    /// The limits of a device; `None` where they are not known here.
    #[must_use]
    pub fn of(device: &DeviceInfo) -> Option<Self> {
        let known = |(names, _): &&(&[&str], Self)| names.iter().any(|n| device.name.contains(n));
        LIMITS.iter().find(known).map(|(_, limits)| *limits)
    }
}

/// Warps of a program that a multiprocessor can hold at once; `None` where its registers are not
/// told, or where not even one workgroup fits.
#[must_use]
pub fn warps(limits: &SmLimits, program: &Program, figures: &ProgramFigures) -> Option<u64> {
    let registers = figures.registers.filter(|&registers| registers > 0)?;
    let of_warp = registers.checked_mul(WARP)?.next_multiple_of(REGISTER_UNIT);
    let by_registers = PARTITIONS * (limits.registers / PARTITIONS / of_warp);
    let by_threads = limits.threads / WARP;
    let warps = by_registers.min(by_threads);
    let warps = match program.invocations {
        None => warps,
        Some(invocations) => {
            let of_group = u64::from(invocations).div_ceil(WARP).max(1);
            let declared = figures.workgroup_bytes.or(program.declared_workgroup_bytes);
            let groups = (warps / of_group).min(limits.workgroups);
            let groups = match declared.unwrap_or(0) {
                0 => groups,
                bytes => {
                    let taken = bytes.checked_add(RESERVED_BYTES)?;
                    groups.min(limits.shared_bytes / taken.next_multiple_of(SHARED_UNIT_BYTES))
                }
            };
            groups * of_group
        }
    };
    (warps > 0).then_some(warps)
}

/// What the resolve of a pixel of so many fragments moves, in bytes of device memory: those of local
/// memory, which the L1 cache serves, count for as much less as that is faster. Local memory that is not
/// told is left out.
#[must_use]
pub fn pixel_bytes(limits: &SmLimits, fragments: f64, local_bytes: Option<u64>) -> f64 {
    let touched = local_bytes.map_or(0.0, |bytes| (bytes as f64).min(fragments * 8.0));
    let local = f64::from(limits.device_gb_s) / f64::from(limits.l1_gb_s);
    fragments * 12.0 + 16.0 + 2.0 * touched * local
}

/// The predicted time of a program over that of another, on pixels of so many fragments.
///
/// `None` where the registers of one are not told, or the local memory of one of the two alone.
#[must_use]
pub fn predicted_ratio(
    limits: &SmLimits,
    fragments: f64,
    (program, figures): (&Program, &ProgramFigures),
    (base, base_figures): (&Program, &ProgramFigures),
) -> Option<f64> {
    if figures.local_bytes.is_some() != base_figures.local_bytes.is_some() {
        return None;
    }
    let (own, other) = (warps(limits, program, figures)?, warps(limits, base, base_figures)?);
    let bytes = pixel_bytes(limits, fragments, figures.local_bytes);
    let base_bytes = pixel_bytes(limits, fragments, base_figures.local_bytes);
    // One division, so that what is equal by the formula is equal, and shares a rank.
    Some(bytes * other as f64 / (base_bytes * own as f64))
}

/// How far predictions are off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ModelError {
    /// How many predictions.
    pub count: usize,
    /// The median of |predicted / measured - 1|.
    pub median: f64,
    /// The largest of these.
    pub worst: f64,
    /// Spearman's rank correlation of predicted and measured, ties at their mean rank; `None` for
    /// fewer than three, or where one of the two is the same throughout.
    pub rank_correlation: Option<f64>,
}

impl ModelError {
    /// The error of pairs of predicted and measured; `None` for none. What is measured is above 0.
    #[must_use]
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let off: Vec<f64> =
            pairs.iter().map(|(predicted, measured)| (predicted / measured - 1.0).abs()).collect();
        let ranks = |of: fn(&(f64, f64)) -> f64| ranks(&pairs.iter().map(of).collect::<Vec<_>>());
        Some(Self {
            count: pairs.len(),
            median: oit_record::statistics::median(&off)?,
            worst: off.iter().copied().fold(0.0, f64::max),
            rank_correlation: correlation(&ranks(|pair| pair.0), &ranks(|pair| pair.1)),
        })
    }
}

/// The rank of each value, from 1; equal values share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let rank = |value: &f64| {
        let below = values.iter().filter(|other| *other < value).count() as f64;
        let same = values.iter().filter(|other| *other == value).count() as f64;
        below + f64::midpoint(1.0, same)
    };
    values.iter().map(rank).collect()
}

/// Pearson's correlation.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let count = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / count, b.iter().sum::<f64>() / count);
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| of(a - mean_a, b - mean_b)).sum()
    };
    let (aa, ab, bb) = (sum(&|a, _| a * a), sum(&|a, b| a * b), sum(&|_, b| b * b));
    (a.len() >= 3 && aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> SmLimits {
        let device = DeviceInfo { name: "NVIDIA H200".to_owned(), ..DeviceInfo::default() };
        SmLimits::of(&device).unwrap()
    }

    fn program(invocations: Option<u32>, declared_workgroup_bytes: Option<u64>) -> Program {
        Program {
            sort: "rbs".to_owned(),
            store: "local".to_owned(),
            low: 1,
            high: 8,
            invocations,
            declared_workgroup_bytes,
            compile_ns: None,
            from_cache: None,
            executables: None,
        }
    }

    fn figures(registers: u64, local_bytes: Option<u64>) -> ProgramFigures {
        ProgramFigures { registers: Some(registers), local_bytes, ..ProgramFigures::default() }
    }

    #[test]
    fn only_known_devices_have_limits() {
        assert_eq!((limits().capability, limits().shared_bytes), ("9.0", 233_472));
        let other = DeviceInfo { name: "llvmpipe".to_owned(), ..DeviceInfo::default() };
        assert_eq!(SmLimits::of(&other), None);
    }

    #[test]
    fn registers_limit_warps_as_nvidia_s_table_has_it() {
        let warps = |registers| warps(&limits(), &program(None, None), &figures(registers, None));
        // 32 * 32 = 1024 a warp: 16 in each of four partitions of 16384, all that there may be.
        assert_eq!(warps(32), Some(64));
        // 33 * 32 = 1056, rounded up to 1280: 12 in each.
        assert_eq!(warps(33), Some(48));
        // 40 * 32 = 1280.
        assert_eq!(warps(40), Some(48));
        // 128 * 32 = 4096: 4 in each.
        assert_eq!(warps(128), Some(16));
        // 255 * 32 = 8160, rounded up to 8192: 2 in each.
        assert_eq!(warps(255), Some(8));
        // One partition has not so many.
        assert_eq!(warps(600), None);
        assert_eq!(warps(u64::MAX), None);
        assert_eq!(warps(0), None);
    }

    #[test]
    fn workgroups_and_their_memory_limit_warps() {
        let of = |invocations, bytes, registers| {
            let program = program(Some(invocations), Some(bytes));
            warps(&limits(), &program, &figures(registers, None))
        };
        // Two warps a workgroup, 32 workgroups.
        assert_eq!(of(64, 0, 32), Some(64));
        // One warp a workgroup: 32 workgroups are 32 warps.
        assert_eq!(of(32, 0, 32), Some(32));
        // 64 invocations with 8 elements of 8 bytes: 4096 + 1024 of 233472 bytes, 45 times.
        assert_eq!(of(64, 4096, 32), Some(64));
        // With 32 elements: 16384 + 1024, 13 times, two warps each.
        assert_eq!(of(64, 16_384, 32), Some(26));
        // 256 invocations are 8 warps; of 48 by registers 6 workgroups.
        assert_eq!(of(256, 0, 40), Some(48));
        // No workgroup fits.
        assert_eq!(of(64, 300_000, 32), None);
        // What the driver tells comes before what the source declares.
        let told = ProgramFigures { workgroup_bytes: Some(0), ..figures(32, None) };
        assert_eq!(warps(&limits(), &program(Some(64), Some(16_384)), &told), Some(64));
    }

    #[test]
    fn time_goes_with_bytes_over_warps() {
        // 8 * 12 + 16 = 112, and an array of 8 fragments written and read: 2 * 64 more, in a cache of
        // eight times the bandwidth.
        let limits = SmLimits { device_gb_s: 1000, l1_gb_s: 8000, ..limits() };
        let bytes = |local| pixel_bytes(&limits, 8.0, local);
        assert_eq!([None, Some(0), Some(4096)].map(bytes), [112.0, 112.0, 128.0]);
        // A spill of less than the fragments.
        assert_eq!(bytes(Some(16)), 116.0);
        let program = program(None, None);
        let ratio = |a: ProgramFigures, b: ProgramFigures| {
            predicted_ratio(&limits, 8.0, (&program, &a), (&program, &b))
        };
        // 128 bytes by 48 warps over 112 by 64.
        let predicted = ratio(figures(40, Some(512)), figures(32, Some(0))).unwrap();
        assert!((predicted - (128.0 / 48.0) / (112.0 / 64.0)).abs() < 1e-12);
        assert_eq!(ratio(figures(128, None), figures(32, None)), Some(4.0));
        assert_eq!(ratio(figures(128, Some(0)), figures(32, None)), None);
        assert_eq!(ratio(ProgramFigures::default(), figures(32, None)), None);
    }

    #[test]
    fn errors_are_of_what_was_measured() {
        // Off by 0, 0.5 and 1.
        let error = ModelError::of(&[(1.0, 1.0), (3.0, 2.0), (8.0, 4.0)]).unwrap();
        assert_eq!((error.count, error.median, error.worst), (3, 0.5, 1.0));
        assert_eq!(error.rank_correlation, Some(1.0));
        // Ranks 1, 2, 3 against 3, 1, 2: 1 - 6 * (4 + 1 + 1) / (3 * 8) = -0.5.
        let error = ModelError::of(&[(1.0, 9.0), (2.0, 1.0), (3.0, 2.0)]).unwrap();
        assert!((error.rank_correlation.unwrap() + 0.5).abs() < 1e-12);
        // Ranks 1.5, 1.5, 3 against 1, 2, 3: 1.5 / sqrt(1.5 * 2).
        let error = ModelError::of(&[(1.0, 1.0), (1.0, 2.0), (2.0, 3.0)]).unwrap();
        assert!((error.rank_correlation.unwrap() - 0.75_f64.sqrt()).abs() < 1e-12);
        let flat = ModelError::of(&[(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]).unwrap();
        assert_eq!(flat.rank_correlation, None);
        assert_eq!(ModelError::of(&[]), None);
    }
}
