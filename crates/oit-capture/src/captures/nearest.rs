//! What captures that keep each pixel's nearest fragments have in common.

use oit_fragments::{Fragment, Lfb, LfbError};

/// WGSL that defines `keep_nearest`.
pub(super) const NEAREST: &str = include_str!("nearest.wgsl");

pub(super) const CITATION: &str =
    "Kubisch, Order Independent Transparency in OpenGL 4.x, GTC 2014 (Loop64)";

/// Sorts each pixel's fragments by their keys: the order in which they are stored.
pub(super) fn sort(lfb: &mut Lfb) {
    lfb.reorder(|pixel| pixel.sort_unstable_by_key(|fragment| fragment.key()));
}

/// The same sorted, as the slots hold them.
pub(super) fn stored(submitted: &Lfb) -> Lfb {
    let mut stored = submitted.clone();
    sort(&mut stored);
    stored.reorder(|pixel| pixel.iter_mut().for_each(|fragment| *fragment = inverted(*fragment)));
    stored
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
