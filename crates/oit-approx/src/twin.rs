//! What the CPU twins have in common.

use oit_fragments::{Fragment, Lfb};
use rayon::prelude::*;

/// The picture, pixel by pixel: `resolve` gets the pixel, its fragments, and scratch that is used
/// again.
pub(crate) fn pixels<S: Default>(
    submitted: &Lfb,
    resolve: impl Fn(usize, &[Fragment], &mut S) -> [f32; 4] + Sync,
) -> Vec<[f32; 4]> {
    (0..submitted.pixels())
        .into_par_iter()
        .with_min_len(256)
        .map_init(S::default, |scratch, pixel| resolve(pixel, submitted.pixel(pixel), scratch))
        .collect()
}

/// Red, green, blue and alpha, not premultiplied.
pub(crate) fn rgba(fragment: Fragment) -> [f32; 4] {
    fragment.rgba8().map(|channel| f32::from(channel) / 255.0)
}
