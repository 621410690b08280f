//! Batcher's odd-even merge sort, padded to a power of two, in registers.

use super::network::{PaddedNetworks, SLOTS, network_sort, padded_slots};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::Fragment;
use std::sync::OnceLock;

/// The odd-even merge sort of the next power of two, in registers, without a branch: halves are
/// sorted, then merged. [`super::network`] has as many comparators at powers of two, in another order,
/// and leaves out those that only padding could reach.
pub(crate) struct OddEven;

impl SortStrategy for OddEven {
    fn name(&self) -> &'static str {
        "odd_even"
    }

    fn summary(&self) -> &'static str {
        "Odd-even merge network of the next power of two, in registers."
    }

    fn citation(&self) -> &'static str {
        "Batcher 1968; Knowles et al. 2014, section 2.4"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Registers]
    }

    fn limit(&self) -> Option<u32> {
        Some(SLOTS as u32)
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("odd_even.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        let slots = padded_slots(spec.max_frags);
        context! { slots => slots, comparators => comparators(slots) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        network_sort(comparators(padded_slots(spec.max_frags)), spec.ties, fragments);
    }
}

/// The comparators of the network of `slots`, a power of two of at most 64.
fn comparators(slots: usize) -> &'static [(u8, u8)] {
    static NETWORKS: PaddedNetworks = [const { OnceLock::new() }; SLOTS.ilog2() as usize + 1];
    NETWORKS[slots.ilog2() as usize].get_or_init(|| odd_even(slots))
}

/// Merges of runs of 1, 2, 4, ... slots; of each, comparators at ever smaller distances.
fn odd_even(slots: usize) -> Vec<(u8, u8)> {
    let mut comparators = Vec::new();
    let mut run = 1;
    while run < slots {
        let mut distance = run;
        while distance > 0 {
            for start in (distance % run..slots - distance).step_by(2 * distance) {
                // Only within one pair of runs.
                let pair = |i: usize| i / (2 * run);
                for i in start..(start + distance).min(slots - distance) {
                    if pair(i) == pair(i + distance) {
                        comparators.push((i as u8, (i + distance) as u8));
                    }
                }
            }
            distance /= 2;
        }
        run *= 2;
    }
    comparators
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::network::testing::{keeps_all_beside_padding, sorts};

    #[test]
    fn sorts_zero_one_sequences_of_every_size() {
        for slots in [1, 2, 4, 8, 16, 32, 64] {
            sorts(comparators(slots), slots);
        }
    }

    #[test]
    fn sizes_are_known() {
        let sizes = [(1, 0), (2, 1), (4, 5), (8, 19), (16, 63), (32, 191), (64, 543)];
        for (slots, size) in sizes {
            assert_eq!(comparators(slots).len(), size, "{slots} slots");
        }
    }

    #[test]
    fn padding_never_moves_even_beside_the_greatest_key() {
        keeps_all_beside_padding(&OddEven);
    }
}
