//! Batcher's odd-even merge network, in registers.

use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};
use std::sync::OnceLock;

/// A whole sorting network in registers, without a branch: every pixel runs every comparator.
///
/// Slots that no fragment was read into hold the padding, the greatest of all keys. A comparator
/// exchanges only if its first slot is strictly behind its second, and always leaves the nearer in
/// the lower slot, so padding, which starts in the highest slots, never moves: the first `n` slots
/// hold the pixel's `n` fragments before, during and after the sort, whatever their keys.
pub(crate) struct Network;

/// Two slots, the lower first.
pub(super) type Comparator = (u8, u8);

/// The most slots: two 32-bit registers each.
pub(super) const SLOTS: usize = 64;

impl SortStrategy for Network {
    fn name(&self) -> &'static str {
        "network"
    }

    fn summary(&self) -> &'static str {
        "Odd-even merge network in registers: no branch, every comparator always runs."
    }

    fn citation(&self) -> &'static str {
        "Batcher 1968; Knuth, The Art of Computer Programming 3, 5.2.2, algorithm M; Knowles et al. \
         2014, section 2.4"
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
        include_str!("network.wgsl.j2")
    }

    fn cuda_template(&self) -> Option<&'static str> {
        Some(include_str!("network.cu.j2"))
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! { comparators => comparators(spec.max_frags as usize) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        network_sort(comparators(spec.max_frags as usize), spec.ties, fragments);
    }
}

/// The twin of every network: runs the comparators over at most [`SLOTS`] fragments.
pub(super) fn network_sort(comparators: &[(u8, u8)], ties: Ties, fragments: &mut [Fragment]) {
    ties.compared_otherwise(comparators.len());
    match ties {
        Ties::Total => run(comparators, fragments, |a, b| (a.min(b), a.max(b))),
        Ties::Depth => {
            let nearer_first = |a, b| if a >> 32 > b >> 32 { (b, a) } else { (a, b) };
            run(comparators, fragments, nearer_first);
        }
    }
}

/// Runs the comparators over the fragments' 64-bit keys, padded as in the kernel.
fn run(
    comparators: &[(u8, u8)],
    fragments: &mut [Fragment],
    compare_exchange: impl Fn(u64, u64) -> (u64, u64),
) {
    let mut slots = [u64::MAX; SLOTS];
    for (slot, fragment) in slots.iter_mut().zip(fragments.iter()) {
        *slot = fragment.key();
    }
    for &(i, j) in comparators {
        // Masked, an index needs no bounds check.
        let (i, j) = (usize::from(i) % SLOTS, usize::from(j) % SLOTS);
        (slots[i], slots[j]) = compare_exchange(slots[i], slots[j]);
    }
    for (fragment, slot) in fragments.iter_mut().zip(slots) {
        *fragment = Fragment { rgba: slot as u32, depth_key: (slot >> 32) as u32 };
    }
}

/// The slots of a network that is padded to a power of two, for up to `max_frags` fragments.
pub(super) fn padded_slots(max_frags: u32) -> usize {
    (max_frags as usize).next_power_of_two().min(SLOTS)
}

/// The networks of one wiring, for 1, 2, 4, ... 64 slots, each made when it is first used.
pub(super) type PaddedNetworks = [OnceLock<Vec<(u8, u8)>>; SLOTS.ilog2() as usize + 1];

/// The comparators of the network of `n` slots (0 to 64), in order: the lower slot first.
pub(super) fn comparators(n: usize) -> &'static [Comparator] {
    static NETWORKS: [OnceLock<Vec<(u8, u8)>>; SLOTS + 1] = [const { OnceLock::new() }; SLOTS + 1];
    let n = n.min(SLOTS);
    NETWORKS[n].get_or_init(|| merge_exchange(n))
}

/// Knuth's algorithm M, Batcher's odd-even merge sort for any number of slots: the network of the
/// next power of two without the comparators that reach beyond `n`, where only padding could be.
fn merge_exchange(n: usize) -> Vec<(u8, u8)> {
    let mut comparators = Vec::new();
    let top = n.next_power_of_two() / 2;
    let mut p = top;
    while p > 0 {
        let (mut q, mut r, mut d) = (top, 0, p);
        loop {
            for i in (0..n.saturating_sub(d)).filter(|i| i & p == r) {
                comparators.push((i as u8, (i + d) as u8));
            }
            if q == p {
                break;
            }
            d = q - p;
            q /= 2;
            r = p;
        }
        p /= 2;
    }
    comparators
}

/// Tests that every wiring goes through.
#[cfg(test)]
pub(super) mod testing {
    use super::*;

    /// The 0-1 principle: a network that sorts every sequence of zeros and ones sorts every
    /// sequence. Bit `i` of `input` is what slot `i` holds.
    pub(in super::super) fn sorts_bits(comparators: &[(u8, u8)], n: usize, input: u64) -> bool {
        let mut bits = input;
        for &(i, j) in comparators {
            let exchange = (bits >> i) & !(bits >> j) & 1;
            bits ^= exchange << i | exchange << j;
        }
        let ones = input.count_ones() as usize;
        let expected = (0..n).rev().take(ones).fold(0u64, |bits, slot| bits | 1 << slot);
        bits == expected
    }

    /// Every sequence of zeros and ones up to 16 slots, random ones above, and that the lower slot
    /// of a comparator comes first.
    pub(in super::super) fn sorts(comparators: &[(u8, u8)], n: usize) {
        assert!(comparators.iter().all(|&(i, j)| i < j && usize::from(j) < n), "{n} slots");
        if n <= 16 {
            for input in 0..1u64 << n {
                assert!(sorts_bits(comparators, n, input), "{n} slots, input {input:b}");
            }
            return;
        }
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        for _ in 0..2000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let input = state & (u64::MAX >> (64 - n));
            assert!(sorts_bits(comparators, n, input), "{n} slots, input {input:b}");
        }
    }

    /// Padding keeps its slots, even beside fragments of the greatest key.
    pub(in super::super) fn keeps_all_beside_padding(strategy: &dyn SortStrategy) {
        let greatest = Fragment { rgba: u32::MAX, depth_key: u32::MAX };
        let below = Fragment { rgba: 7, depth_key: u32::MAX };
        for ties in Ties::ALL {
            let spec = SortSpec { min_frags: 1, max_frags: 8, ties, store: Store::Registers };
            let mut fragments =
                [greatest, below, greatest, Fragment::new(0.5, [1, 2, 3, 4]), below];
            let mut expected = fragments.to_vec();
            strategy.sort(&spec, &mut fragments, &mut Vec::new());
            expected.sort_by_key(|f| f.key());
            let mut found = fragments.to_vec();
            found.sort_by_key(|f| f.key());
            assert_eq!(found, expected, "no fragment is lost to the padding");
            assert!(fragments.windows(2).all(|w| !ties.behind(w[0], w[1])));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{keeps_all_beside_padding, sorts, sorts_bits};
    use super::*;

    #[test]
    fn sorts_zero_one_sequences_of_every_size() {
        for n in 0..=64 {
            sorts(comparators(n), n);
        }
    }

    #[test]
    fn a_missing_comparator_is_noticed() {
        for n in [2, 5, 8, 16] {
            for left_out in 0..comparators(n).len() {
                let mut broken = comparators(n).to_vec();
                broken.remove(left_out);
                let sorts = (0..1u64 << n).all(|input| sorts_bits(&broken, n, input));
                assert!(!sorts, "{n} slots sort without comparator {left_out}");
            }
        }
    }

    #[test]
    fn sizes_are_batchers() {
        let sizes = [(1, 0), (2, 1), (4, 5), (8, 19), (16, 63), (32, 191), (64, 543)];
        for (n, size) in sizes {
            assert_eq!(comparators(n).len(), size, "{n} slots");
        }
    }

    #[test]
    fn padding_never_moves_even_beside_the_greatest_key() {
        keeps_all_beside_padding(&Network);
    }
}
