//! A pixel sorted by several lanes of a subgroup, in their registers.

use super::network::{Comparator, comparators};
use crate::{End, SortSpec, SortStrategy, Store};
use minijinja::{Value, context};
use oit_fragments::{Fragment, Ties};

/// Some lanes of a subgroup sort a pixel together: each sorts a few fragments in registers, and
/// sorted runs of 1, 2, 4, ... lanes are merged by shuffles between lanes.
///
/// A lane holds neighbours of the order. So of a merge only the distances of a lane and more are
/// between lanes, and the many that are shorter, and the whole first sort, cost no shuffle. Fewer
/// lanes with more slots each need fewer shuffles and comparators a fragment, but more registers.
///
/// All comparators leave what is nearer in the lower slot: a merge begins with slots compared with
/// those of the other run in reverse. So padding, the greatest of all keys, ends up last.
///
/// To composite, each lane blends its own, and lanes are put together two by two: blending is
/// associative. The sum is taken in another order than one after the other, which rounds
/// differently.
pub(crate) struct Cooperative {
    name: &'static str,
    summary: &'static str,
    /// The fewest lanes that share a pixel, and the most: powers of two. A subgroup holds as many
    /// pixels as that goes into it.
    fewest: u32,
    most: u32,
}

/// As many lanes as give each no more than [`AIM`] slots, and no fewer than 4.
pub(crate) const COOPERATIVE: Cooperative = Cooperative {
    name: "cooperative",
    summary: "4 to 32 lanes of a subgroup, of 16 fragments each, sort a pixel in registers.",
    fewest: 4,
    most: 32,
};

/// With 2 lanes, up to 64 fragments: half of a network's registers.
pub(crate) const COOPERATIVE_2: Cooperative = Cooperative {
    name: "cooperative2",
    summary: "2 lanes of a subgroup sort a pixel in registers and merge by shuffles.",
    fewest: 2,
    most: 2,
};

/// With 4 lanes, up to 128 fragments.
pub(crate) const COOPERATIVE_4: Cooperative = Cooperative {
    name: "cooperative4",
    summary: "4 lanes of a subgroup sort a pixel in registers and merge by shuffles.",
    fewest: 4,
    most: 4,
};

/// With 8 lanes, up to 256 fragments.
pub(crate) const COOPERATIVE_8: Cooperative = Cooperative {
    name: "cooperative8",
    summary: "8 lanes of a subgroup sort a pixel in registers and merge by shuffles.",
    fewest: 8,
    most: 8,
};

/// With 16 lanes, up to 512 fragments.
pub(crate) const COOPERATIVE_16: Cooperative = Cooperative {
    name: "cooperative16",
    summary: "16 lanes of a subgroup sort a pixel in registers and merge by shuffles.",
    fewest: 16,
    most: 16,
};

/// With 32 lanes, up to 1024 fragments.
pub(crate) const COOPERATIVE_32: Cooperative = Cooperative {
    name: "cooperative32",
    summary: "32 lanes of a subgroup sort a pixel in registers and merge by shuffles.",
    fewest: 32,
    most: 32,
};

/// Slots of a lane where there are lanes enough: the registers of more cost occupancy.
const AIM: u32 = 16;

/// The most slots of a lane: two 32-bit registers each.
const SLOTS: u32 = 32;

impl Cooperative {
    /// Slots of each lane: a power of two, for the last merges.
    fn slots(&self, spec: &SortSpec) -> u32 {
        spec.max_frags.div_ceil(self.lanes(spec)).next_power_of_two().min(SLOTS)
    }

    /// How runs of one lane become one run of all.
    fn merges(&self, spec: &SortSpec) -> impl Iterator<Item = Merge> {
        (0..self.lanes(spec).ilog2()).map(|power| Merge { run: 1 << power })
    }
}

/// Two sorted runs of as many lanes become one, but for the order inside each lane.
#[derive(Clone, Copy)]
struct Merge {
    run: u32,
}

impl Merge {
    /// By what a lane of one run differs from the lane of the other that it is first compared with,
    /// slots in reverse.
    fn flip(self) -> u32 {
        2 * self.run - 1
    }

    /// By what lanes differ that are compared from then on, slot by slot.
    fn distances(self) -> impl Iterator<Item = u32> {
        (0..self.run.ilog2()).rev().map(|power| 1 << power)
    }
}

/// What sorts a lane's slots after a merge: comparators over half of them, a quarter, and so on.
fn halves(slots: u32) -> Vec<Comparator> {
    let distances = (0..slots.ilog2()).rev().map(|power| 1 << power);
    let pairs = |distance: u32| {
        let lower = (0..slots).filter(move |i| i & distance == 0);
        lower.map(move |i| (i as u8, (i + distance) as u8))
    };
    distances.flat_map(pairs).collect()
}

impl SortStrategy for Cooperative {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn citation(&self) -> &'static str {
        "Batcher 1968 (bitonic merge); Porter and Duff 1984 (associativity of over)"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Registers]
    }

    fn limit(&self) -> Option<u32> {
        Some(self.most * SLOTS)
    }

    fn lanes(&self, spec: &SortSpec) -> u32 {
        spec.max_frags.div_ceil(AIM).next_power_of_two().clamp(self.fewest, self.most)
    }

    fn blends_from(&self) -> End {
        End::Front
    }

    fn template(&self) -> &'static str {
        include_str!("cooperative.wgsl.j2")
    }

    fn values(&self, spec: &SortSpec) -> Value {
        let slots = self.slots(spec);
        let merge = |merge: Merge| {
            let distances: Vec<u32> = merge.distances().collect();
            context! { run => merge.run, flip => merge.flip(), distances }
        };
        context! {
            slots,
            comparators => comparators(slots as usize),
            merges => self.merges(spec).map(merge).collect::<Vec<Value>>(),
            halves => halves(slots),
        }
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => self.run(spec, fragments, scratch, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => self.run(spec, fragments, scratch, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

impl Cooperative {
    /// The kernel's steps, one lane after the other: slot `i` of a lane is
    /// `slots[lane * slots_of_a_lane + i]`.
    fn run(
        &self,
        spec: &SortSpec,
        fragments: &mut [Fragment],
        slots: &mut Vec<Fragment>,
        behind: impl Fn(Fragment, Fragment) -> bool,
    ) {
        let (lanes, of_a_lane) = (self.lanes(spec) as usize, self.slots(spec) as usize);
        slots.clear();
        slots.resize(lanes * of_a_lane, PADDING);
        for (place, &fragment) in fragments.iter().enumerate() {
            slots[place % lanes * of_a_lane + place / lanes] = fragment;
        }
        let in_lanes = |slots: &mut [Fragment], comparators: &[Comparator]| {
            for lane in slots.chunks_exact_mut(of_a_lane) {
                for &(i, j) in comparators {
                    exchange(lane, usize::from(i), usize::from(j), &behind);
                }
            }
        };
        in_lanes(slots, comparators(of_a_lane));
        let halves = halves(of_a_lane as u32);
        for merge in self.merges(spec) {
            let (run, flip) = (merge.run as usize, merge.flip() as usize);
            for lane in (0..lanes).filter(|lane| lane & run == 0) {
                for i in 0..of_a_lane {
                    let other = (lane ^ flip) * of_a_lane + of_a_lane - 1 - i;
                    exchange(slots, lane * of_a_lane + i, other, &behind);
                }
            }
            for distance in merge.distances().map(|distance| distance as usize) {
                for lane in (0..lanes).filter(|lane| lane & distance == 0) {
                    for i in 0..of_a_lane {
                        let other = (lane ^ distance) * of_a_lane + i;
                        exchange(slots, lane * of_a_lane + i, other, &behind);
                    }
                }
            }
            in_lanes(slots, &halves);
        }
        fragments.copy_from_slice(&slots[..fragments.len()]);
    }
}

/// Behind every fragment: no depth has this key.
const PADDING: Fragment = Fragment { rgba: u32::MAX, depth_key: u32::MAX };

/// What of two slots is strictly behind goes to the second.
fn exchange(
    slots: &mut [Fragment],
    first: usize,
    second: usize,
    behind: impl Fn(Fragment, Fragment) -> bool,
) {
    if behind(slots[first], slots[second]) {
        slots.swap(first, second);
    }
}
