//! Fragments, the total order on them, the layered fragment buffer as data and as files, and the
//! oracle.

mod atomic;
pub mod deep_exr;
mod deflate;
mod element;
mod fragment;
mod lfb;
pub mod oracle;
pub mod trace;

pub use element::Element;
pub use fragment::{Fragment, Ties, depth_from_key, depth_key};
pub use lfb::{DepthHistogram, Lfb, LfbError, MultisetDifference};
