//! Ending a pixel where what is left can hardly be seen.

use crate::{End, composite};
use oit_fragments::Fragment;

/// The transmittance below which a kernel that ends early blends no more: what is left changes no
/// channel, alpha included, by more. Half of an 8-bit step is 1/510.
pub(super) const BOUND: f32 = 1.0 / 512.0;

/// The same in WGSL.
pub(super) const BOUND_WGSL: &str = "0.001953125";

/// Composites fragments, nearest first, down to the first after which the transmittance is below
/// `stop_below`, if there is such a bound.
pub(super) fn composite_front(sorted: &[Fragment], stop_below: Option<f32>) -> [f32; 4] {
    let mut transmittance = 1.0f32;
    let seen = sorted.iter().copied().take_while(|fragment| {
        let shows = stop_below.is_none_or(|bound| transmittance >= bound);
        transmittance *= 1.0 - f32::from(fragment.rgba8()[3]) / 255.0;
        shows
    });
    composite(seen, End::Front)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_the_same_in_wgsl() {
        assert_eq!(BOUND_WGSL.parse(), Ok(BOUND));
    }

    #[test]
    fn what_lies_behind_the_bound_is_left_out() {
        let layers = |alpha: u8, n: usize| vec![Fragment::new(0.5, [255, 255, 255, alpha]); n];
        // 128/255 shows through a layer less by half: below 1/512 after nine of them.
        let [red, .., alpha] = composite_front(&layers(128, 100), Some(BOUND));
        assert_eq!(composite_front(&layers(128, 9), None), [red, red, red, alpha]);
        assert!(alpha < 1.0 && 1.0 - alpha < BOUND);
        assert_ne!(composite_front(&layers(128, 8), None)[3], alpha);
        // An opaque layer is the last; thin ones are all blended.
        let mut fragments = layers(255, 1);
        fragments.push(Fragment::new(0.6, [0, 0, 0, 255]));
        assert_eq!(composite_front(&fragments, Some(BOUND)), [1.0; 4]);
        let thin = layers(1, 100);
        assert_eq!(composite_front(&thin, Some(BOUND)), composite_front(&thin, None));
    }
}
