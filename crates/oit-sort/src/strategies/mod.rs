//! The registry of sort strategies. Adding one: `docs/adding-a-sort.md`.

mod bitonic;
mod cooperative;
mod early;
mod heap;
mod insertion;
mod insertion_merge;
mod merge;
mod network;
mod network_merge;
mod network_u64;
mod odd_even;
mod passthrough;
mod rbs;
mod rbs_heap;
mod rbs_hier;
mod rescan;
mod rs;
mod rs_inner;
mod selection;
mod shell;
mod unsorted;

use crate::SortStrategy;
use crate::nearest::{did_you_mean, nearest};

/// Every sort strategy, in the order they are listed.
pub const STRATEGIES: &[&dyn SortStrategy] = &[
    &passthrough::Passthrough,
    &unsorted::Unsorted,
    &insertion::Insertion,
    &merge::Merge,
    &insertion_merge::InsertionMerge::UP_TO_32,
    &insertion_merge::InsertionMerge::UP_TO_64,
    &rs::Rs,
    &rbs::Rbs { block: 32 },
    &network::Network,
    &selection::Selection { early: false },
    &selection::Selection { early: true },
    &shell::Shell,
    &heap::Heap { early: false },
    &heap::Heap { early: true },
    &rs_inner::RsInner,
    &bitonic::Bitonic,
    &odd_even::OddEven,
    &rbs::Rbs { block: 8 },
    &rbs::Rbs { block: 16 },
    &rbs_heap::RbsHeap,
    &rbs_hier::RbsHier,
    &network_merge::NetworkMerge { block: 64 },
    &network_merge::NetworkMerge { block: 32 },
    &network_u64::NetworkU64,
    &cooperative::COOPERATIVE,
    &cooperative::COOPERATIVE_2,
    &cooperative::COOPERATIVE_4,
    &cooperative::COOPERATIVE_8,
    &cooperative::COOPERATIVE_16,
    &cooperative::COOPERATIVE_32,
    &rescan::Rescan { early: false },
    &rescan::Rescan { early: true },
];

/// No strategy has this name.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("unknown sort {name:?}{}; the sorts are {}", did_you_mean(nearest), names.join(", "))]
pub struct UnknownStrategy {
    /// The name given.
    pub name: String,
    /// The names most like it.
    pub nearest: Vec<&'static str>,
    /// All names.
    pub names: Vec<&'static str>,
}

/// The strategy of this name.
///
/// # Errors
/// Where there is none: lists the nearest names and all.
pub fn strategy(name: &str) -> Result<&'static dyn SortStrategy, UnknownStrategy> {
    STRATEGIES.iter().copied().find(|s| s.name() == name).ok_or_else(|| {
        let names: Vec<_> = STRATEGIES.iter().map(|s| s.name()).collect();
        UnknownStrategy {
            name: name.to_owned(),
            nearest: nearest(name, names.iter().copied()),
            names,
        }
    })
}
