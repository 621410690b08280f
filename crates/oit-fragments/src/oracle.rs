//! The oracle: the fragments actually captured, in the total order, composited in double precision.
//!
//! Exact techniques must match it. It shares no code with them: it sorts with the standard library
//! and blends in `f64`, back to front, where the kernels blend in `f32`, front to back.

use rayon::prelude::*;

use crate::Lfb;

/// The exact picture: premultiplied red, green, blue and alpha of every pixel over nothing.
#[must_use]
pub fn composite(lfb: &Lfb) -> Vec<[f64; 4]> {
    (0..lfb.pixels())
        .into_par_iter()
        .with_min_len(256)
        .map_init(Vec::new, |keys: &mut Vec<u64>, pixel| {
            keys.clear();
            keys.extend(lfb.pixel(pixel).iter().map(|fragment| fragment.key()));
            keys.sort_unstable();
            keys.iter().rev().fold([0.0; 4], |behind, &key| {
                let [r, g, b, a] = (key as u32).to_le_bytes().map(|c| f64::from(c) / 255.0);
                let under = |channel: f64, own: f64| a * own + (1.0 - a) * channel;
                [
                    under(behind[0], r),
                    under(behind[1], g),
                    under(behind[2], b),
                    a + (1.0 - a) * behind[3],
                ]
            })
        })
        .collect()
}

/// Pixels on which two fragments of different colour share a depth: there the depth-only order has
/// no single right answer.
#[must_use]
pub fn depth_tied_pixels(lfb: &Lfb) -> Vec<bool> {
    pixels_with_neighbours(lfb, |nearer, farther| {
        nearer >> 32 == farther >> 32 && nearer != farther
    })
}

/// Pixels on which two fragments share a depth, of whatever colours: there a method that tells
/// fragments apart by depth loses some.
#[must_use]
pub fn depth_shared_pixels(lfb: &Lfb) -> Vec<bool> {
    pixels_with_neighbours(lfb, |nearer, farther| nearer >> 32 == farther >> 32)
}

/// Pixels on which two fragments that follow each other in the total order are so, by their keys.
fn pixels_with_neighbours(lfb: &Lfb, are_so: impl Fn(u64, u64) -> bool + Sync) -> Vec<bool> {
    (0..lfb.pixels())
        .into_par_iter()
        .with_min_len(256)
        .map_init(Vec::new, |keys: &mut Vec<u64>, pixel| {
            keys.clear();
            keys.extend(lfb.pixel(pixel).iter().map(|fragment| fragment.key()));
            keys.sort_unstable();
            keys.windows(2).any(|pair| are_so(pair[0], pair[1]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fragment;

    #[test]
    fn near_covers_far_whatever_the_order_of_submission() {
        let near = Fragment::new(0.25, [255, 0, 0, 128]);
        let far = Fragment::new(0.75, [0, 255, 0, 255]);
        let a = 128.0 / 255.0;
        for list in [vec![near, far], vec![far, near]] {
            let pixel = composite(&Lfb::from_lists(1, 1, &[list]))[0];
            assert_eq!(pixel, [a, 1.0 - a, 0.0, 1.0]);
        }
    }

    #[test]
    fn ties_are_found_only_between_unlike_colours() {
        let a = Fragment::new(0.5, [1, 2, 3, 4]);
        let b = Fragment::new(0.5, [9, 2, 3, 4]);
        let lfb = Lfb::from_lists(3, 1, &[vec![a, a], vec![a, b], vec![]]);
        assert_eq!(depth_tied_pixels(&lfb), [false, true, false]);
        assert_eq!(depth_shared_pixels(&lfb), [true, true, false]);
        let apart = Lfb::from_lists(1, 1, &[vec![a, Fragment::new(0.75, [1, 2, 3, 4])]]);
        assert_eq!(depth_shared_pixels(&apart), [false]);
    }
}
