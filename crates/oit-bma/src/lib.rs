//! Backwards memory allocation: intervals, the passes that group pixels by depth complexity, and the
//! probe of what an array costs.
//!
//! Knowles, Leach and Zambetta, "Backwards Memory Allocation and Improved OIT", Pacific Graphics
//! 2013. A sorting array sized for the deepest pixel slows every pixel; so pixels are grouped by
//! how many fragments they have, and each group is resolved by a program with an array of its size.

mod cost;
mod intervals;
mod list;
mod optimum;
mod probe;
mod stencil;

pub use cost::{ArrayCost, BadCost, CostModel, CostPoint};
pub use intervals::{BadIntervals, Interval, Intervals, MOST_INTERVALS};
pub use list::{ListGrouping, list_grouping};
pub use optimum::{NoOptimum, optimal_intervals};
pub use probe::{ArrayProbe, ProbeAccess, ProbePlace};
pub use stencil::{MOST_COUNTED, count_drawn, counted, mark, mask_pass, masked, stencil_target};

/// What is grouped.
#[derive(Clone, Copy, Debug)]
pub struct GroupRequest<'a> {
    /// WGSL that declares what it needs at bindings below 16 and defines
    /// `fn pixel_count(pixel: u32) -> u32`.
    pub count_wgsl: &'a str,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}
