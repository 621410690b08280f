//! Which technique a view needs, by what was measured on a device.
//!
//! Neither a GPU nor a registry of techniques is needed: what records say of techniques by their
//! names is all there is. From [`Evidence`] a [`Model`] predicts times, [`advise`] names what meets
//! [`Bounds`] from the cheapest on, and [`trials`] tells how far such choices are from the best.

mod choice;
mod evidence;
mod fit;
mod model;
mod regret;
mod technique;

pub use choice::{Advice, Bounds, Candidate, Choice, ErrorBasis, Estimate, Metric, Reason, advise};
pub use evidence::{EXACT_ERROR, Evidence, Measured, View, scene_name};
pub use model::{Basis, Model, Part, Time, Told};
pub use regret::{LEAST_TECHNIQUES, Regret, Trial, Tried, regret, trials};
pub use technique::is_candidate;
