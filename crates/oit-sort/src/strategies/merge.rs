//! Bottom-up merge sort in an array.

use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Reads all fragments into an array and merges runs of 1, 2, 4, ... until one is left.
///
/// Each merge first copies the left run aside and merges back in place, as the papers' own code
/// (pknowles/oit) does: half the extra memory of two arrays used in turn, and local memory is what
/// occupancy hangs on. That code sets half of `max_frags` aside, which is too little where that is
/// no power of two; the left run may be as long as the largest power of two below `max_frags`.
pub(crate) struct Merge;

impl SortStrategy for Merge {
    fn name(&self) -> &'static str {
        "merge"
    }

    fn summary(&self) -> &'static str {
        "Bottom-up merge sort in an array, with a second one for left runs."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2012, section 20.5, and 2013, section 4"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local, Store::Workgroup]
    }

    fn array_frags(&self, max_frags: u32) -> u32 {
        max_frags.saturating_add(left_frags(max_frags))
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("merge.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("merge.cu.j2"))
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! { left_frags => left_frags(spec.max_frags) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => merge_sort(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => merge_sort(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// The longest left run that a sort of up to `max_frags` can have: the largest power of two below
/// it, and at least 1.
pub(super) fn left_frags(max_frags: u32) -> u32 {
    max_frags.div_ceil(2).next_power_of_two().max(1)
}

/// Sorts `frags`; `left` is memory for the left runs. Stable.
pub(super) fn merge_sort(
    frags: &mut [Fragment],
    left: &mut Vec<Fragment>,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    let n = frags.len();
    let mut run = 1;
    while run < n {
        let mut start = 0;
        while start + run < n {
            let end = (start + 2 * run).min(n);
            left.clear();
            left.extend_from_slice(&frags[start..start + run]);
            let (mut i, mut j, mut k) = (0, start + run, start);
            // Once the left run is used up, what remains of the right one is in its place.
            while i < run {
                if j < end && behind(left[i], frags[j]) {
                    frags[k] = frags[j];
                    j += 1;
                } else {
                    frags[k] = left[i];
                    i += 1;
                }
                k += 1;
            }
            start += 2 * run;
        }
        run *= 2;
    }
}
