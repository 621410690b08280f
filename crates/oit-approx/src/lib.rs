//! Approximate techniques, most of them with memory that does not grow with depth complexity. What
//! they get wrong is measured against the oracle.

mod adaptive;
mod draw;
mod hamburger;
mod k_buffer;
mod moments;
mod multi_layer;
mod quantised;
mod stochastic;
mod twin;
mod weighted;

use oit_capture::Method;

pub use adaptive::Adaptive;
pub use k_buffer::{KBuffer, Tail};
pub use moments::{Moments, Sums};
pub use multi_layer::MultiLayer;
pub use quantised::Quantised;
pub use stochastic::Stochastic;
pub use weighted::Weighted;

/// Every approximate method, in the order they are listed.
pub const METHODS: &[&dyn Method] = &[
    &Weighted,
    &Stochastic,
    &KBuffer { tail: Tail::Dropped },
    &KBuffer { tail: Tail::Merged },
    &MultiLayer::PATIENT,
    &Adaptive::PATIENT,
    &Moments { count: 4, sums: Sums::Floats },
    &Moments { count: 6, sums: Sums::Floats },
    &Moments { count: 8, sums: Sums::Floats },
    &Moments { count: 4, sums: Sums::Halves },
    &Moments { count: 6, sums: Sums::Halves },
    &Moments { count: 8, sums: Sums::Halves },
    &Moments { count: 4, sums: Sums::Bounded },
    &Moments { count: 6, sums: Sums::Bounded },
    &Moments { count: 8, sums: Sums::Bounded },
    &Quantised { depth_bits: Some(24), premultiplied: false },
    &Quantised { depth_bits: Some(16), premultiplied: false },
    &Quantised { depth_bits: None, premultiplied: true },
    &Quantised { depth_bits: Some(24), premultiplied: true },
    &Quantised { depth_bits: Some(16), premultiplied: true },
];
