//! Approximate techniques, most of them with memory that does not grow with depth complexity. What
//! they get wrong is measured against the oracle.

mod draw;
mod k_buffer;
mod stochastic;
mod twin;
mod weighted;

use oit_capture::Method;

pub use k_buffer::{KBuffer, Tail};
pub use stochastic::Stochastic;
pub use weighted::Weighted;

/// Every approximate method, in the order they are listed.
pub const METHODS: &[&dyn Method] =
    &[&Weighted, &Stochastic, &KBuffer { tail: Tail::Dropped }, &KBuffer { tail: Tail::Merged }];
