//! Insertion sort for shallow pixels, merge sort for deep ones.

use super::insertion::insertion_sort;
use super::merge::{left_frags, merge_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Insertion sort up to some number of fragments and merge sort above. Where the interval decides,
/// only that sort is compiled (BMA-IMS); otherwise the kernel branches for each pixel (BASE-IMS).
pub(crate) struct InsertionMerge {
    name: &'static str,
    summary: &'static str,
    citation: &'static str,
    /// The most fragments that insertion sorts.
    insertion_frags: u32,
}

impl InsertionMerge {
    /// The RBS paper's bound.
    pub(crate) const UP_TO_32: Self = Self {
        name: "insertion_merge",
        summary: "Insertion sort for up to 32 fragments, merge sort above, in an array.",
        citation: "Knowles, Leach, Zambetta 2014, section 4 (IMS)",
        insertion_frags: 32,
    };

    /// The BMA paper's bound for one program that branches. Its programs for intervals have another,
    /// `insertion@16+merge`.
    pub(crate) const UP_TO_64: Self = Self {
        name: "insertion_merge64",
        summary: "Insertion sort for up to 64 fragments, merge sort above, in an array.",
        citation: "Knowles, Leach, Zambetta 2013, section 4 (standard OIT)",
        insertion_frags: 64,
    };
}

impl SortStrategy for InsertionMerge {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn citation(&self) -> &'static str {
        self.citation
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local, Store::Workgroup]
    }

    fn array_frags(&self, max_frags: u32) -> u32 {
        let left = if max_frags > self.insertion_frags { left_frags(max_frags) } else { 0 };
        max_frags.saturating_add(left)
    }

    fn sorts_wide(&self) -> bool {
        true
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
            insertion_frags => self.insertion_frags,
            left_frags => left_frags(spec.max_frags),
        }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        let insertion = fragments.len() <= self.insertion_frags as usize;
        match (spec.ties, insertion) {
            (Ties::Total, true) => insertion_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            (Ties::Depth, true) => insertion_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
            (Ties::Total, false) => merge_sort(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            (Ties::Depth, false) => merge_sort(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}
