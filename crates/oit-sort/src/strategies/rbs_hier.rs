//! Register-based block sort that merges twice.

use super::rbs::{block_sort, merge_blocks};
use super::rs::{REGISTERS, register_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// [`super::rbs`] for pixels of many blocks: blocks are merged in groups to longer runs, and these
/// while they are composited. With about as many groups as blocks in a group, a fragment passes two
/// short searches instead of a long one. Up to 8 blocks it is rbs.
///
/// Only one group's blocks are held beside the runs.
pub(crate) struct RbsHier;

/// The most blocks that are merged at once.
const MERGED_AT_ONCE: u32 = 8;

impl SortStrategy for RbsHier {
    fn name(&self) -> &'static str {
        "rbs_hier"
    }

    fn summary(&self) -> &'static str {
        "Register-based block sort with blocks of 32, merged in groups, then the groups."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, sections 3 and 5 (hierarchical merge passes)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    /// As many groups, of as many blocks, as there are registers for their candidates.
    fn limit(&self) -> Option<u32> {
        Some(REGISTERS * REGISTERS * REGISTERS)
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("rbs_hier.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        let blocks = spec.max_frags.div_ceil(REGISTERS);
        let group_blocks = group_blocks(spec.max_frags);
        context! { block => REGISTERS, blocks, group_blocks, groups => blocks.div_ceil(group_blocks) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        let group = (group_blocks(spec.max_frags) * REGISTERS) as usize;
        match spec.ties {
            Ties::Total => group_sort(fragments, group, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => group_sort(fragments, group, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Blocks of a group: all of them where they are few, else the power of two from the square root on.
fn group_blocks(max_frags: u32) -> u32 {
    let blocks = max_frags.div_ceil(REGISTERS);
    if blocks <= MERGED_AT_ONCE {
        return blocks.max(1);
    }
    let doubling = std::iter::successors(Some(1u32), |&size| Some(2 * size));
    doubling
        .take_while(|&size| size <= REGISTERS)
        .find(|&size| size * size >= blocks)
        .unwrap_or(REGISTERS)
}

/// Sorts the blocks of each group and merges them to a run, then merges the runs.
fn group_sort(
    frags: &mut [Fragment],
    group: usize,
    runs: &mut Vec<Fragment>,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    const BLOCK: usize = REGISTERS as usize;
    if frags.len() <= group {
        block_sort(frags, BLOCK, runs, behind);
        return;
    }
    runs.clear();
    runs.resize(frags.len(), Fragment { rgba: 0, depth_key: 0 });
    for (group, run) in frags.chunks_mut(group).zip(runs.chunks_mut(group)) {
        for block in group.chunks_mut(BLOCK) {
            register_sort(block, &behind);
        }
        merge_blocks(group, BLOCK, run, &behind);
    }
    merge_blocks(runs, group, frags, behind);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_merge_has_more_candidates_than_registers() {
        for max_frags in 1..=REGISTERS * REGISTERS * REGISTERS {
            let blocks = max_frags.div_ceil(REGISTERS);
            let group_blocks = group_blocks(max_frags);
            assert!(group_blocks <= REGISTERS && blocks.div_ceil(group_blocks) <= REGISTERS);
        }
        assert_eq!([256, 257, 512, 1024, 2048, 4096].map(group_blocks), [8, 4, 4, 8, 8, 16]);
    }
}
