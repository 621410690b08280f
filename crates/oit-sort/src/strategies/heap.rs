//! A heap in a local array, composited while it is emptied.

use super::early;
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Makes a heap of all fragments, the nearest at its top, and blends the top until none is left:
/// heapsort without its last pass, since each fragment is composited when it is found.
pub(crate) struct Heap {
    /// Whether it ends where what is left can hardly be seen. Of n fragments m are then taken out of
    /// the heap, in time proportional to n + m log n.
    pub(super) early: bool,
}

impl SortStrategy for Heap {
    fn name(&self) -> &'static str {
        if self.early { "heap_early" } else { "heap" }
    }

    fn summary(&self) -> &'static str {
        if self.early {
            "A heap that is emptied until less than 1/512 shows through: off by at most that."
        } else {
            "A heap in a local array, composited while it is emptied."
        }
    }

    fn citation(&self) -> &'static str {
        if self.early {
            "Williams 1964; Floyd 1964; ended as ray casting is (Levoy 1990)"
        } else {
            "Williams 1964; Floyd 1964; Knuth, The Art of Computer Programming 3, 5.2.3"
        }
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    fn error_bound(&self) -> Option<f32> {
        self.early.then_some(early::BOUND)
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("heap.wgsl.j2")
    }

    fn values(&self, _: &SortSpec) -> Value {
        context! { stop_below => self.early.then_some(early::BOUND_WGSL) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => heap_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => heap_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }

    fn composite(&self, sorted: &[Fragment]) -> [f32; 4] {
        early::composite_front(sorted, self.error_bound())
    }
}

/// Where the kernel blends the top, the twin puts it into the place that becomes free behind the
/// heap; so the nearest comes last, and all are turned around.
fn heap_sort(frags: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    for start in (0..frags.len() / 2).rev() {
        sift_down(frags, start, &behind);
    }
    for left in (1..frags.len()).rev() {
        frags.swap(0, left);
        sift_down(&mut frags[..left], 0, &behind);
    }
    frags.reverse();
}

/// Moves the fragment at `start` down to where both below it are behind it or equal.
pub(super) fn sift_down<T: Copy>(heap: &mut [T], start: usize, behind: impl Fn(T, T) -> bool) {
    let moved = heap[start];
    let mut hole = start;
    loop {
        let mut child = 2 * hole + 1;
        if child >= heap.len() {
            break;
        }
        if child + 1 < heap.len() && behind(heap[child], heap[child + 1]) {
            child += 1;
        }
        if !behind(moved, heap[child]) {
            break;
        }
        heap[hole] = heap[child];
        hole = child;
    }
    heap[hole] = moved;
}
