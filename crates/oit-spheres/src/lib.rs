//! Biomolecular scenes as spheres: Kugler, Profiling and Optimization of Large Biomolecular Scenes,
//! TU Wien 2018. Each variation that the thesis times, and what goes past it, is a [`Variation`].

mod variation;

pub use variation::{
    Billboard, Cover, Culling, Depth, Detail, Drawing, Order, Output, PREFIX, Projection, Raster,
    Variation, VariationError,
};
