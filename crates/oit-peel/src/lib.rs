//! Depth peeling: layers of a scene, one or two for each time that it is drawn, composited as they
//! come. No fragment is stored, so memory does not grow with depth complexity, but time does.

mod depth_peel;
mod depth_peel_total;
mod draw;
mod dual_peel;
mod passes;
mod small_float;
mod twin;

use oit_capture::Method;

pub use depth_peel::DepthPeel;
pub use depth_peel_total::DepthPeelTotal;
pub use dual_peel::{Back, DepthBits, DualPeel};

/// Every method of peeling, in the order they are listed.
pub const METHODS: &[&dyn Method] = &[
    &DepthPeel { stops: false },
    &DepthPeel { stops: true },
    &DepthPeelTotal,
    &DualPeel { back: Back::Blended, depth: DepthBits::ThirtyTwo, stops: false },
    &DualPeel { back: Back::Blended, depth: DepthBits::ThirtyTwo, stops: true },
    &DualPeel { back: Back::Blended, depth: DepthBits::Sixteen, stops: false },
    &DualPeel { back: Back::ForwardedRgba32, depth: DepthBits::ThirtyTwo, stops: false },
    &DualPeel { back: Back::ForwardedRgba16, depth: DepthBits::ThirtyTwo, stops: false },
    &DualPeel { back: Back::ForwardedR11g11b10, depth: DepthBits::ThirtyTwo, stops: false },
];
