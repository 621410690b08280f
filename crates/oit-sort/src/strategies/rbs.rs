//! Register-based block sort: blocks sorted in registers, merged while they are composited.

use super::rs::{REGISTERS, register_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Reads blocks of fragments into registers, sorts each with [`super::rs`] and writes it to a local
/// array. Then merges all blocks at once: the farthest fragment left of each block is a candidate
/// in a register, a linear search finds the farthest of them, and it is composited at once
/// (Listing 6). Pixels of at most one block are sorted by rs alone, without an array.
///
/// In the store `global` there is no array: a sorted block is written back to where its fragments
/// were captured (RBS-G).
pub(crate) struct Rbs {
    /// Fragments of a block, at most [`REGISTERS`]. The paper's is 32.
    pub(super) block: u32,
}

/// The mark of a block that is used up: in front of every fragment, since no depth has the key 0
/// (it would be a NaN).
const USED_UP: Fragment = Fragment { rgba: 0, depth_key: 0 };

impl SortStrategy for Rbs {
    fn name(&self) -> &'static str {
        match self.block {
            8 => "rbs8",
            16 => "rbs16",
            _ => "rbs",
        }
    }

    fn summary(&self) -> &'static str {
        match self.block {
            8 => "Register-based block sort with blocks of 8.",
            16 => "Register-based block sort with blocks of 16.",
            _ => "Register-based block sort: blocks of 32 in registers, merged while composited.",
        }
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 3, Listing 6 (RBS-L; global: RBS-G)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local, Store::Global]
    }

    /// As many blocks as there are registers for their candidates.
    fn limit(&self) -> Option<u32> {
        Some(REGISTERS * self.block)
    }

    fn sorts_wide(&self) -> bool {
        true
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
        context! { block => self.block, blocks => spec.max_frags.div_ceil(self.block) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        let block = self.block as usize;
        match spec.ties {
            Ties::Total => block_sort(fragments, block, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => block_sort(fragments, block, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Sorts blocks, then merges them from the farthest fragment to the nearest.
pub(super) fn block_sort(
    frags: &mut [Fragment],
    block: usize,
    blocks: &mut Vec<Fragment>,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    for block in frags.chunks_mut(block) {
        register_sort(block, &behind);
    }
    if frags.len() > block {
        blocks.clear();
        blocks.extend_from_slice(frags);
        merge_blocks(blocks, block, frags, behind);
    }
}

/// Merges sorted blocks (at most [`REGISTERS`], all of them full but the last) into `merged`, which
/// is as long as all of them, by a linear search of their candidates (Listing 6).
pub(super) fn merge_blocks(
    blocks: &[Fragment],
    block: usize,
    merged: &mut [Fragment],
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    let k = blocks.len().div_ceil(block);
    let mut left = [0; REGISTERS as usize];
    let mut candidates = [USED_UP; REGISTERS as usize];
    for j in 0..k {
        left[j] = (blocks.len() - j * block).min(block);
        candidates[j] = blocks[j * block + left[j] - 1];
    }
    for slot in merged.iter_mut().rev() {
        let mut from = 0;
        for j in 1..k {
            if behind(candidates[j], candidates[from]) {
                from = j;
            }
        }
        *slot = candidates[from];
        left[from] = left[from].max(1) - 1;
        candidates[from] =
            if left[from] > 0 { blocks[from * block + left[from] - 1] } else { USED_UP };
    }
}
