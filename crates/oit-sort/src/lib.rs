//! Sort strategies: WGSL templates and their CPU twins, one file each.
//!
//! [`STRATEGIES`] lists them, [`Program`] assembles one with a capture's layout to WGSL,
//! [`CudaProgram`] to CUDA C++, and [`resolve`] is the twin of the whole program for one pixel.

mod choice;
mod cuda;
mod nearest;
pub mod patterns;
mod program;
mod resolve;
mod strategies;
mod strategy;
mod workgroup_memory;

pub use choice::{AUTO, ChoiceError, SortChoice, SortLimit, SortPart};
pub use cuda::{CUDA_KERNEL, CUDA_THREADS, CudaLayout, CudaProgram};
pub use program::{
    Entry, INVOCATIONS, Layout, MAX_WORKGROUPS_X, Output, Program, ProgramError, workgroups,
};
pub use resolve::{Scratch, composite, resolve, sorted};
pub use strategies::{STRATEGIES, UnknownStrategy, strategy};
pub use strategy::{End, SortSpec, SortStrategy, Store, store_name};
pub use workgroup_memory::{LEAST_INVOCATIONS, WORKGROUP_BYTES};
