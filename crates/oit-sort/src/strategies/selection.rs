//! Selection sort in a local array, to the end or until nothing more shows.

use super::early;
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Finds the nearest fragment of those left and blends it, until none is left.
pub(crate) struct Selection {
    /// Whether it ends where what is left can hardly be seen.
    pub(super) early: bool,
}

impl SortStrategy for Selection {
    fn name(&self) -> &'static str {
        if self.early { "selection_early" } else { "selection" }
    }

    fn summary(&self) -> &'static str {
        if self.early {
            "Selection sort that ends where less than 1/512 shows through: off by at most that."
        } else {
            "Selection sort in a local array, composited while it selects."
        }
    }

    fn citation(&self) -> &'static str {
        if self.early {
            "Knuth, The Art of Computer Programming 3, 5.2.3, algorithm S, ended as ray casting is \
             (Levoy 1990)"
        } else {
            "Knuth, The Art of Computer Programming 3, 5.2.3, algorithm S"
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
        include_str!("selection.wgsl.j2")
    }

    fn values(&self, _: &SortSpec) -> Value {
        context! { stop_below => self.early.then_some(early::BOUND_WGSL) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => selection_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => selection_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }

    fn composite(&self, sorted: &[Fragment]) -> [f32; 4] {
        early::composite_front(sorted, self.error_bound())
    }
}

fn selection_sort(frags: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    for first in 0..frags.len() {
        let mut nearest = first;
        for i in first + 1..frags.len() {
            if behind(frags[nearest], frags[i]) {
                nearest = i;
            }
        }
        frags.swap(first, nearest);
    }
}
