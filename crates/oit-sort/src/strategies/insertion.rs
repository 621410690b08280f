//! Insertion sort in an array: the baseline of the papers.

use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::{Fragment, Ties};

/// Reads all fragments into an array and sorts it by insertion.
///
/// The array is one of the function, or one in workgroup memory, where the papers' local memory lay.
/// There is no store `registers`: an insertion into registers is unrolled for every place, and that is
/// [`super::rs`].
pub(crate) struct Insertion;

impl SortStrategy for Insertion {
    fn name(&self) -> &'static str {
        "insertion"
    }

    fn summary(&self) -> &'static str {
        "Insertion sort in an array: the baseline."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 2.1, Listing 1 (IS)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local, Store::Workgroup]
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("insertion.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("insertion.cu.j2"))
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => insertion_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => insertion_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Listing 1: shifts the fragments behind `key` one up and puts `key` into the gap. Stable.
pub(super) fn insertion_sort(frags: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    for j in 1..frags.len() {
        let key = frags[j];
        let mut i = j;
        while i > 0 && behind(frags[i - 1], key) {
            frags[i] = frags[i - 1];
            i -= 1;
        }
        frags[i] = key;
    }
}
