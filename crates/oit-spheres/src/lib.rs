//! Biomolecular scenes as spheres: Kugler, Profiling and Optimization of Large Biomolecular Scenes,
//! TU Wien 2018. Each variation that the thesis times, and what goes past it, is a [`Variation`].

mod accuracy;
mod billboard;
mod bytes;
mod context;
mod drawing;
mod ids;
mod named;
mod occlusion;
mod oracle;
mod order;
mod output;
mod plan;
mod scan;
mod text;
mod twin;
mod variation;
mod view;

pub use bytes::SphereBytes;
pub use named::{VARIATIONS, cross_product};
pub use oracle::{Comparison, Expected, expected};
pub use plan::{PICTURE, SphereRequest};
pub use twin::twin;
pub use variation::{
    Billboard, Cover, Culling, Depth, Detail, Drawing, Order, Output, PREFIX, Projection, Raster,
    Variation, VariationError,
};
