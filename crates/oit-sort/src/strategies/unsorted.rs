//! No sort, but the array of one: what declaring and filling it costs.

use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::Fragment;

/// Reads all fragments into a local array and blends them from there, unsorted. Its picture is as
/// wrong as `passthrough`'s; its time over that one's is the price of the array, and that of
/// `insertion` over its own the price of sorting.
pub(crate) struct Unsorted;

impl SortStrategy for Unsorted {
    fn name(&self) -> &'static str {
        "unsorted"
    }

    fn summary(&self) -> &'static str {
        "No sort: fills the local array and blends from it. What the array alone costs."
    }

    fn citation(&self) -> &'static str {
        "Knowles et al. 2012, section 20.5 (declaring and populating the sorting array, no sorting)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    fn sorts(&self) -> bool {
        false
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("unsorted.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("unsorted.cu.j2"))
    }

    fn sort(&self, _: &SortSpec, _: &mut [Fragment], _: &mut Vec<Fragment>) {}
}
