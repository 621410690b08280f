//! Blocks sorted by a network in registers, merged while they are composited.

use super::network::{comparators, network_sort};
use super::rs::REGISTERS;
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Sorts blocks with [`super::network`], writes them to a local array, and merges all of them at once
/// as [`super::rbs`] does, but from the nearest fragment on.
///
/// A fragment is loaded, sorted and stored without a branch: where a layout has random access, no
/// load waits for another, and a block that is not full is padded. Padding also stands after each
/// block, so that one which is used up needs no asking. The merge costs a comparison for each block
/// and fragment, so blocks are large: 64, as many as the network holds, or 32 for fewer registers.
/// Pixels of at most one block are sorted by the network alone.
pub(crate) struct NetworkMerge {
    /// Fragments of a block, a power of two of at most 64.
    pub(super) block: u32,
}

/// What stands after a block, and in place of what it lacks: behind every fragment.
const PADDING: Fragment = Fragment { rgba: u32::MAX, depth_key: u32::MAX };

impl SortStrategy for NetworkMerge {
    fn name(&self) -> &'static str {
        if self.block == 32 { "network_merge32" } else { "network_merge" }
    }

    fn summary(&self) -> &'static str {
        if self.block == 32 {
            "Blocks of 32 sorted by a network in registers, merged while composited."
        } else {
            "Blocks of 64 sorted by a network in registers, merged while composited."
        }
    }

    fn citation(&self) -> &'static str {
        "Batcher 1968; Knowles, Leach, Zambetta 2014, sections 2.4 and 3"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    /// As many blocks as there are registers for their candidates.
    fn limit(&self) -> Option<u32> {
        Some(REGISTERS * self.block)
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("network_merge.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        let blocks = spec.max_frags.div_ceil(self.block);
        context! {
            block => self.block,
            blocks,
            words => blocks.div_ceil(4),
            comparators => comparators(self.slots(spec)),
        }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        let block = self.block as usize;
        let comparators = comparators(self.slots(spec));
        for block in fragments.chunks_mut(block) {
            network_sort(comparators, spec.ties, block);
        }
        if fragments.len() <= block {
            return;
        }
        scratch.clear();
        scratch.extend_from_slice(fragments);
        match spec.ties {
            Ties::Total => merge(scratch, block, fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => merge(scratch, block, fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

impl NetworkMerge {
    /// Slots of its network: all of one block, or what is asked for if that is less.
    fn slots(&self, spec: &SortSpec) -> usize {
        spec.max_frags.min(self.block) as usize
    }
}

/// Merges sorted blocks, all of them full but the last, from the nearest fragment to the farthest.
fn merge(
    blocks: &[Fragment],
    block: usize,
    merged: &mut [Fragment],
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    let k = blocks.len().div_ceil(block);
    let mut heads = [0; REGISTERS as usize];
    let mut candidates = [PADDING; REGISTERS as usize];
    for (candidate, block) in candidates.iter_mut().zip(blocks.chunks(block)) {
        *candidate = block[0];
    }
    for slot in merged {
        let mut from = 0;
        for j in 1..k {
            if behind(candidates[from], candidates[j]) {
                from = j;
            }
        }
        *slot = candidates[from];
        heads[from] = (heads[from] + 1).min(block);
        let place = from * block + heads[from];
        let next = if heads[from] < block { blocks.get(place) } else { None };
        candidates[from] = next.copied().unwrap_or(PADDING);
    }
}
