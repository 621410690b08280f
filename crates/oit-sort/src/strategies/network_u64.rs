//! Batcher's odd-even merge network on 64-bit integers.

use super::network::{Network, SLOTS, comparators};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::Fragment;

/// The network of `network` where a slot is one 64-bit integer and a comparator one compare of two
/// of them, for devices that have such. Of a list each slot is filled under a condition of its own,
/// where `network` nests a condition for each slot in those before it.
///
/// So on layouts with random access the two differ by their integers alone, and on lists with
/// `ties-depth` hardly by more than by how they are filled.
pub(crate) struct NetworkU64;

impl SortStrategy for NetworkU64 {
    fn name(&self) -> &'static str {
        "network_u64"
    }

    fn summary(&self) -> &'static str {
        "Odd-even merge network on 64-bit integers in registers, filled without nested conditions."
    }

    fn citation(&self) -> &'static str {
        Network.citation()
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
        include_str!("network_u64.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        context! { comparators => comparators(spec.max_frags as usize) }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        Network.sort(spec, fragments, scratch);
    }
}
