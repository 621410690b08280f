//! Register sort: insertion sort, fully unrolled, in registers.

use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::{Fragment, Ties};

/// Reads fragments into registers by nested conditionals (Listing 3) and sorts them by an insertion
/// sort of swaps whose two loops are unrolled, so that no register is indexed at run time; each
/// insertion stops when the fragment is in place (Listing 5).
///
/// The kernel looks whether it is in place after every fourth swap, not after each; the swaps
/// between are selects, which leave what is in order as it is. A branch after each of the 496 swaps
/// takes software Vulkan (Mesa 22.3.6) ten times as long to compile, and the papers' own code
/// (pknowles/oit) also stops only at every few swaps where registers are many.
pub(crate) struct Rs;

/// Registers of fragments: the papers' `MAX_REGISTERS`.
pub(super) const REGISTERS: u32 = 32;

impl SortStrategy for Rs {
    fn name(&self) -> &'static str {
        "rs"
    }

    fn summary(&self) -> &'static str {
        "Register sort: insertion sort in registers, fully unrolled, with early exits."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 3, Listings 3 and 5 (RS)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Registers]
    }

    fn limit(&self) -> Option<u32> {
        Some(REGISTERS)
    }

    fn sorts_wide(&self) -> bool {
        true
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("rs.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("rs.cu.j2"))
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => register_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => register_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Listing 5: each fragment is swapped towards the front until it is in place.
pub(super) fn register_sort(f: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    for j in 1..f.len() {
        let key = f[j];
        let mut i = j;
        while i > 0 && behind(f[i - 1], key) {
            f[i] = f[i - 1];
            f[i - 1] = key;
            i -= 1;
        }
    }
}
