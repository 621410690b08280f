//! No sort: the floor that sorting is measured against.

use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::Fragment;

/// Reads and blends fragments as they come, with no array. The picture is wrong wherever fragments
/// did not arrive in order; the time is what reading and blending alone cost. Of a capture that keeps
/// fragments sorted the picture is right.
///
/// It takes the first `max_frags` fragments as every strategy does, so that it is the floor of
/// exactly the work the others do.
pub(crate) struct Passthrough;

impl SortStrategy for Passthrough {
    fn name(&self) -> &'static str {
        "passthrough"
    }

    fn summary(&self) -> &'static str {
        "No sort: reads and blends fragments as they come. The floor; its picture is wrong unless the capture sorts."
    }

    fn citation(&self) -> &'static str {
        "Knowles et al. 2012, section 20.5 (blending unsorted, without a local array)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::None]
    }

    fn sorts(&self) -> bool {
        false
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("passthrough.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("passthrough.cu.j2"))
    }

    fn sort(&self, _: &SortSpec, _: &mut [Fragment], _: &mut Vec<Fragment>) {}
}
