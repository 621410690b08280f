//! Batcher's bitonic sorting network, in registers.

use super::network::{PaddedNetworks, SLOTS, network_sort, padded_slots};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::Fragment;
use std::sync::OnceLock;

/// The bitonic sorter of the next power of two, in registers, without a branch.
///
/// In the form in which all comparators point the same way: of two sorted halves, the first step of
/// a merge compares the nearest of one with the farthest of the other, and so on inwards. Padding
/// then stays in the highest slots, as in [`super::network`].
pub(crate) struct Bitonic;

impl SortStrategy for Bitonic {
    fn name(&self) -> &'static str {
        "bitonic"
    }

    fn summary(&self) -> &'static str {
        "Bitonic network of the next power of two, in registers."
    }

    fn citation(&self) -> &'static str {
        "Batcher 1968; Knuth, The Art of Computer Programming 3, 5.3.4; Knowles et al. 2014, section 2.4"
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
        include_str!("bitonic.wgsl.j2")
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
    NETWORKS[slots.ilog2() as usize].get_or_init(|| bitonic(slots))
}

/// Merges of 2, 4, ... slots: each a step of mirrored comparators, then half-cleaners.
fn bitonic(slots: usize) -> Vec<(u8, u8)> {
    let mut comparators = Vec::new();
    let mut size = 2;
    while size <= slots {
        for start in (0..slots).step_by(size) {
            for i in 0..size / 2 {
                comparators.push(((start + i) as u8, (start + size - 1 - i) as u8));
            }
        }
        let mut distance = size / 4;
        while distance > 0 {
            for i in (0..slots).filter(|i| i & distance == 0) {
                comparators.push((i as u8, (i + distance) as u8));
            }
            distance /= 2;
        }
        size *= 2;
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
        let sizes = [(1, 0), (2, 1), (4, 6), (8, 24), (16, 80), (32, 240), (64, 672)];
        for (slots, size) in sizes {
            assert_eq!(comparators(slots).len(), size, "{slots} slots");
        }
    }

    #[test]
    fn padding_never_moves_even_beside_the_greatest_key() {
        keeps_all_beside_padding(&Bitonic);
    }
}
