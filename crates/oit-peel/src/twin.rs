//! What the CPU twins have in common.

use oit_fragments::{Fragment, Lfb};
use rayon::prelude::*;

/// The picture, pixel by pixel; `resolve` uses its scratch again from pixel to pixel.
pub(crate) fn pixels<S: Default>(
    submitted: &Lfb,
    resolve: impl Fn(&[Fragment], &mut S) -> [f32; 4] + Sync,
) -> Vec<[f32; 4]> {
    (0..submitted.pixels())
        .into_par_iter()
        .with_min_len(256)
        .map_init(S::default, |scratch, pixel| resolve(submitted.pixel(pixel), scratch))
        .collect()
}

/// Red, green, blue, premultiplied, and alpha.
pub(crate) fn premultiplied(fragment: Fragment) -> [f32; 4] {
    let [r, g, b, a] = fragment.rgba8().map(|channel| f32::from(channel) / 255.0);
    [r * a, g * a, b * a, a]
}

/// Channel by channel.
pub(crate) fn max(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|channel| a[channel].max(b[channel]))
}

/// A premultiplied colour over another.
pub(crate) fn over(front: [f32; 4], back: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|channel| front[channel] + (1.0 - front[3]) * back[channel])
}
