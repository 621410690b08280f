//! Register sort with its outer loop left a loop.

use super::rs::REGISTERS;
use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::{Fragment, Ties};

/// [`super::rs`] with only the inner loop of the insertion sort unrolled (Listing 4): each fragment
/// passes all registers, and exchanges are made only up to its own. Far less code, and no early exit.
pub(crate) struct RsInner;

impl SortStrategy for RsInner {
    fn name(&self) -> &'static str {
        "rs_inner"
    }

    fn summary(&self) -> &'static str {
        "Register sort with only the inner loop unrolled: less code, no early exit."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 3, Listings 3 and 4"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Registers]
    }

    fn limit(&self) -> Option<u32> {
        Some(REGISTERS)
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("rs_inner.wgsl.j2")
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => inner_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => inner_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Listing 4. The registers above `j`, which the kernel passes without exchanging, are left out.
fn inner_sort(f: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    for j in 1..f.len() {
        for i in (1..=j).rev() {
            if behind(f[i - 1], f[i]) {
                f.swap(i - 1, i);
            }
        }
    }
}
