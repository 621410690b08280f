//! What captures that keep each pixel's nearest fragments have in common.

use oit_fragments::{Fragment, Lfb, LfbError};

/// WGSL that defines `keep_nearest`.
pub(super) const NEAREST: &str = include_str!("nearest.wgsl");

pub(super) const CITATION: &str =
    "Kubisch, Order Independent Transparency in OpenGL 4.x, GTC 2014 (Loop64)";

/// Sorts each pixel's fragments by their keys: the order in which they are stored.
pub(super) fn sort(lfb: &mut Lfb) {
    let offsets = lfb.offsets().to_vec();
    let mut fragments = lfb.fragments().to_vec();
    for pixel in offsets.windows(2) {
        fragments[pixel[0]..pixel[1]].sort_unstable_by_key(|fragment| fragment.key());
    }
    *lfb = Lfb::new(lfb.width(), lfb.height(), offsets, fragments)
        .expect("the offsets are those of a buffer");
}

/// The same sorted, as the slots hold them.
pub(super) fn stored(submitted: &Lfb) -> Lfb {
    let mut sorted = submitted.clone();
    sort(&mut sorted);
    let fragments = sorted.fragments().iter().copied().map(inverted).collect();
    Lfb::new(sorted.width(), sorted.height(), sorted.offsets().to_vec(), fragments)
        .expect("the offsets are those of a buffer")
}

/// From a fragment to what a slot holds, and back.
fn inverted(fragment: Fragment) -> Fragment {
    Fragment { rgba: !fragment.rgba, depth_key: !fragment.depth_key }
}

/// The fragments in a pixel's slots, from the first on.
///
/// # Errors
/// Where a slot is empty or nearer than the one before it.
pub(super) fn read_back(
    pixel: usize,
    slots: impl Iterator<Item = Fragment>,
    fragments: &mut Vec<Fragment>,
) -> Result<(), LfbError> {
    let mut last = 0;
    for (place, slot) in slots.enumerate() {
        if slot == Fragment::default() {
            let what = format!("its slot {place} is empty");
            return Err(LfbError::Structure { pixel, what });
        }
        let fragment = inverted(slot);
        if fragment.key() < last {
            let what = format!("its slot {place} is nearer than the one before");
            return Err(LfbError::Structure { pixel, what });
        }
        last = fragment.key();
        fragments.push(fragment);
    }
    Ok(())
}
