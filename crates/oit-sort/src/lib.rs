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

pub use choice::{ChoiceError, SortChoice, SortLimit};
pub use cuda::{CUDA_KERNEL, CUDA_THREADS, CudaLayout, CudaProgram};
pub use program::{
    Entry, INVOCATIONS, Layout, MAX_WORKGROUPS_X, Output, Program, ProgramError, workgroups,
};
pub use resolve::{Scratch, composite, resolve, sorted};
pub use strategies::{STRATEGIES, UnknownStrategy, strategy};
pub use strategy::{End, SortSpec, SortStrategy, Store};
