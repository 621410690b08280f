//! `oit-fragments`, but that comparisons of fragments are counted.
//!
//! `oit-sort-counted` is made of the sources of `oit-sort` and this crate in the place of
//! `oit-fragments`. So every CPU twin there is can be asked how often it compares, and the twins that
//! are timed have no counter in them.

use std::cell::Cell;
use std::cmp::Ordering;

pub use oit_fragments::*;

thread_local! {
    static COMPARISONS: Cell<u64> = const { Cell::new(0) };
}

fn count(more: u64) {
    COMPARISONS.with(|sum| sum.set(sum.get() + more));
}

/// The comparisons of this thread since it was last asked.
#[must_use]
pub fn take_comparisons() -> u64 {
    COMPARISONS.with(Cell::take)
}

/// [`oit_fragments::Ties`], and each comparison is counted.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Ties {
    /// Depth and colour as one 64-bit key.
    #[default]
    Total,
    /// Depth alone.
    Depth,
}

impl Ties {
    /// Both rules, in the order they are listed.
    pub const ALL: [Self; 2] = [Self::Total, Self::Depth];

    fn uncounted(self) -> oit_fragments::Ties {
        match self {
            Self::Total => oit_fragments::Ties::Total,
            Self::Depth => oit_fragments::Ties::Depth,
        }
    }

    /// The word for it in names and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.uncounted().name()
    }

    /// Compares two fragments by this rule, nearest first.
    #[must_use]
    pub fn compare(self, a: Fragment, b: Fragment) -> Ordering {
        count(1);
        self.uncounted().compare(a, b)
    }

    /// Whether `a` must come strictly behind `b`.
    #[must_use]
    pub fn behind(self, a: Fragment, b: Fragment) -> bool {
        count(1);
        self.uncounted().behind(a, b)
    }

    /// Counts what is compared by other means.
    pub fn compared_otherwise(self, comparisons: usize) {
        count(comparisons as u64);
    }
}
