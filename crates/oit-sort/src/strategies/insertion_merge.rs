//! Insertion sort for shallow pixels, merge sort for deep ones.

use super::insertion::insertion_sort;
use super::merge::{left_frags, merge_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Insertion sort for up to 32 fragments and merge sort above. Where the interval decides, only
/// that sort is compiled (BMA-IMS); otherwise the kernel branches for each pixel (BASE-IMS).
pub(crate) struct InsertionMerge;

/// The most fragments that insertion sorts.
const INSERTION_FRAGS: u32 = 32;

impl SortStrategy for InsertionMerge {
    fn name(&self) -> &'static str {
        "insertion_merge"
    }

    fn summary(&self) -> &'static str {
        "Insertion sort for up to 32 fragments, merge sort above, in a local array."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 4 (IMS)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("insertion_merge.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("insertion_merge.cu.j2"))
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! {
            insertion_frags => INSERTION_FRAGS,
            left_frags => left_frags(spec.max_frags),
        }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        let insertion = fragments.len() <= INSERTION_FRAGS as usize;
        match (spec.ties, insertion) {
            (Ties::Total, true) => insertion_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            (Ties::Depth, true) => insertion_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
            (Ties::Total, false) => merge_sort(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            (Ties::Depth, false) => merge_sort(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}
