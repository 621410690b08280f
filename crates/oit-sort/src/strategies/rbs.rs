//! Register-based block sort: blocks sorted in registers, merged while they are composited.

use super::rs::{REGISTERS, register_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Reads blocks of 32 fragments into registers, sorts each with [`super::rs`] and writes it to a
/// local array. Then merges all blocks at once: the farthest fragment left of each block is a
/// candidate in a register, a linear search finds the farthest of them, and it is composited at
/// once (Listing 6). Pixels of at most 32 fragments are sorted by rs alone, without an array.
pub(crate) struct Rbs;

/// The mark of a block that is used up: in front of every fragment, since no depth has the key 0
/// (it would be a NaN).
const USED_UP: Fragment = Fragment { rgba: 0, depth_key: 0 };

impl SortStrategy for Rbs {
    fn name(&self) -> &'static str {
        "rbs"
    }

    fn summary(&self) -> &'static str {
        "Register-based block sort: blocks of 32 in registers, merged while composited."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 3, Listing 6 (RBS-L)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    /// As many blocks as there are registers for their candidates.
    fn limit(&self) -> Option<u32> {
        Some(REGISTERS * REGISTERS)
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("rbs.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("rbs.cu.j2"))
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! { block => REGISTERS, blocks => spec.max_frags.div_ceil(REGISTERS) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => block_sort(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => block_sort(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Sorts blocks, then merges them from the farthest fragment to the nearest.
fn block_sort(
    frags: &mut [Fragment],
    blocks: &mut Vec<Fragment>,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    const BLOCK: usize = REGISTERS as usize;
    for block in frags.chunks_mut(BLOCK) {
        register_sort(block, &behind);
    }
    if frags.len() <= BLOCK {
        return;
    }
    blocks.clear();
    blocks.extend_from_slice(frags);
    let k = blocks.len().div_ceil(BLOCK);
    let mut left = [0; BLOCK];
    let mut candidates = [USED_UP; BLOCK];
    for j in 0..k {
        left[j] = (blocks.len() - j * BLOCK).min(BLOCK);
        candidates[j] = blocks[j * BLOCK + left[j] - 1];
    }
    for slot in frags.iter_mut().rev() {
        let mut from = 0;
        for j in 1..k {
            if behind(candidates[j], candidates[from]) {
                from = j;
            }
        }
        *slot = candidates[from];
        left[from] = left[from].max(1) - 1;
        candidates[from] =
            if left[from] > 0 { blocks[from * BLOCK + left[from] - 1] } else { USED_UP };
    }
}
