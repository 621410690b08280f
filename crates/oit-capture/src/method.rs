//! What a method without a layered fragment buffer is.

use std::ops::RangeInclusive;

use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::Plan;

use crate::Geometry;

/// A technique that is one whole: it draws the scene in passes of its own and composites as it goes,
/// without a layered fragment buffer that a resolve would read. Peeling and most approximate
/// techniques are such.
pub trait Method: Sync {
    /// The name in technique coordinates: lower case, words joined by `_`.
    fn name(&self) -> &'static str;

    /// One sentence: what it does.
    fn summary(&self) -> &'static str;

    /// Where it comes from.
    fn citation(&self) -> &'static str;

    /// What it has a number of, if it has: passes, layers, samples.
    fn size(&self) -> Option<Size> {
        None
    }

    /// What its picture must be on a view, in the size asked for.
    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy;

    /// Its plan, which leaves the picture in the target or the buffer [`PICTURE`].
    ///
    /// # Errors
    /// Why it cannot draw such a view, in words.
    fn build(&self, request: &MethodRequest) -> Result<Plan, String>;

    /// The CPU twin: the picture from the fragments in submission order, premultiplied red, green,
    /// blue and `1 - transmittance`, row by row.
    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]>;
}

/// Where a [`Method`]'s plan leaves its picture: premultiplied RGBA, four 32-bit floats a pixel.
pub const PICTURE: &str = "image";

/// What a method has a number of. In names it is `WORDn`: `dual_peel/passes4`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Size {
    /// Of what.
    pub word: &'static str,
    /// What is allowed.
    pub range: RangeInclusive<u32>,
    /// The number where none is asked for; `None`: as many as the view needs.
    pub default: Option<u32>,
}

/// What a method is asked to draw.
#[derive(Clone, Copy, Debug)]
pub struct MethodRequest<'a> {
    /// What is drawn.
    pub geometry: &'a Geometry,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// What the count pass found.
    pub histogram: &'a DepthHistogram,
    /// The number of what [`Method::size`] says, where one is asked for.
    pub size: Option<u32>,
}

/// What a method's picture must be.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Accuracy {
    /// The oracle's, on every pixel.
    Exact,
    /// The oracle's, but on pixels where fragments share a depth: of those it may lose some.
    ExactWithoutTies,
    /// Not the oracle's, and why.
    Approximate(String),
}

/// WGSL that draws the scene: the entry point `vs` and `Varyings`, and for the fragment stage
/// `shade(in: Varyings) -> u32` (RGBA8, not premultiplied), `fragment_depth(in: Varyings) -> f32`,
/// `depth_key(depth: f32) -> u32`, `pixel_index(position: vec4<f32>) -> u32`,
/// `covered(in: Varyings) -> bool` and `discard_uncovered(in: Varyings)`; and then the fragment stage.
///
/// A fragment stage may do nothing for what is not covered, and has to end it by `discard_uncovered`:
/// where spheres are drawn the rasteriser also covers what lies beside them. Of triangles everything is
/// covered, and these functions are empty.
///
/// Goes with [`Geometry::draw`] and its buffers; it takes `@group(0)`, the bindings 0 and 16 to 18.
#[must_use]
pub fn scene_wgsl(geometry: &Geometry, fragment_stage: &str) -> String {
    geometry.scene_wgsl() + fragment_stage
}
