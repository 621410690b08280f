//! Register-based block sort whose candidates are in a heap.

use super::heap::sift_down;
use super::rs::{REGISTERS, register_sort};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// [`super::rbs`], its blocks merged by a heap of their candidates instead of a linear search: a step
/// takes time proportional to the logarithm of the number of blocks, of which there may be any
/// number. The heap is indexed at run time, so it is in a local array too.
pub(crate) struct RbsHeap;

impl SortStrategy for RbsHeap {
    fn name(&self) -> &'static str {
        "rbs_heap"
    }

    fn summary(&self) -> &'static str {
        "Register-based block sort with blocks of 32, merged by a heap of their candidates."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, sections 3 and 5 (a heap for large k-way merges)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("rbs_heap.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! { block => REGISTERS, blocks => spec.max_frags.div_ceil(REGISTERS) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => heap_merge(fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => heap_merge(fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// Sorts blocks, then merges them from the farthest fragment to the nearest. A candidate is a
/// fragment and its place in `blocks`.
fn heap_merge(
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
    let n = blocks.len();
    let last = |block: usize| ((block + 1) * BLOCK).min(n) - 1;
    let mut heap: Vec<(Fragment, usize)> =
        (0..n.div_ceil(BLOCK)).map(|block| (blocks[last(block)], last(block))).collect();
    // The heap is of the farthest: what belongs below is what the other is behind.
    let below = |a: (Fragment, usize), b: (Fragment, usize)| behind(b.0, a.0);
    for start in (0..heap.len() / 2).rev() {
        sift_down(&mut heap, start, below);
    }
    for slot in frags.iter_mut().rev() {
        let (farthest, at) = heap[0];
        *slot = farthest;
        if at % BLOCK > 0 {
            heap[0] = (blocks[at - 1], at - 1);
        } else {
            heap.swap_remove(0);
        }
        if !heap.is_empty() {
            sift_down(&mut heap, 0, below);
        }
    }
}
