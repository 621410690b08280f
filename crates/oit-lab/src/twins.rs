//! The CPU twins of sorts on captured fragments: comparisons and times by interval, without a GPU.

use std::hint::black_box;
use std::time::Instant;

use oit_bma::Intervals;
use oit_fragments::{Lfb, Ties};
use oit_fragments_counted::take_comparisons;
use oit_record::statistics::SplitMix64;
use oit_sort::{Scratch, SortChoice, SortSpec, SortStrategy, Store, resolve};
use serde::Serialize;

/// The pixels of one interval of depth complexity, and how the twins did on them.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct TwinInterval {
    /// The fewest fragments.
    pub low: u32,
    /// The most.
    pub high: u32,
    /// Pixels of the interval.
    pub pixels: u64,
    /// Of these the ones that were resolved, evenly spread.
    pub resolved_pixels: u64,
    /// Fragments of the resolved pixels.
    pub fragments: u64,
    /// One for each sort asked for, in order.
    pub twins: Vec<Twin>,
}

/// One sort's twin on the pixels of an interval.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Twin {
    /// The sort as asked for.
    pub sort: String,
    /// Comparisons of fragments to sort all the resolved pixels, padding's included, as the kernel
    /// makes them. `None` where the sort does not hold the interval.
    pub comparisons: Option<u64>,
    /// Nanoseconds to take, sort and composite all of them, on one thread, a sample each. Nothing is
    /// counted in these runs.
    pub samples_ns: Vec<u64>,
}

/// Comparisons that the twin makes on these pixels.
fn comparisons(
    lfb: &Lfb,
    pixels: &[usize],
    strategy: &dyn SortStrategy,
    spec: &SortSpec,
) -> Option<u64> {
    let counted = oit_sort_counted::strategy(strategy.name()).ok()?;
    let stores = counted.stores().iter().copied();
    let store = stores.into_iter().find(|store| store.name() == spec.store.name())?;
    let spec = oit_sort_counted::SortSpec {
        min_frags: spec.min_frags,
        max_frags: spec.max_frags,
        ties: match spec.ties {
            Ties::Total => oit_fragments_counted::Ties::Total,
            Ties::Depth => oit_fragments_counted::Ties::Depth,
        },
        store,
    };
    let mut scratch = oit_sort_counted::Scratch::default();
    let _ = take_comparisons();
    for &pixel in pixels {
        black_box(oit_sort_counted::sorted(counted, &spec, lfb.pixel(pixel), &mut scratch));
    }
    Some(take_comparisons())
}

/// Resolves captured pixels with the twins of sorts, interval by interval of the papers' powers of two,
/// at most `pixels_at_most` pixels of each, by the total order. Samples of the sorts are taken in turn,
/// in an order shuffled from the seed, after one that is dropped.
#[must_use]
pub fn time_twins(
    lfb: &Lfb,
    sorts: &[SortChoice],
    pixels_at_most: usize,
    samples: u32,
    seed: u64,
) -> Vec<TwinInterval> {
    let intervals = Intervals::powers_of_two(lfb.histogram().peak());
    let groups = intervals.group(lfb.counts());
    let mut found = Vec::new();
    for (interval, group) in intervals.iter().zip(groups) {
        let step = group.len().div_ceil(pixels_at_most.max(1)).max(1);
        let pixels: Vec<usize> = group.iter().step_by(step).map(|&pixel| pixel as usize).collect();
        if pixels.is_empty() {
            continue;
        }
        let held: Vec<Option<(&'static dyn SortStrategy, Store)>> =
            sorts.iter().map(|sort| sort.for_max_frags(interval.high).ok()).collect();
        let spec = |store| SortSpec {
            min_frags: interval.low,
            max_frags: interval.high,
            ties: Ties::Total,
            store,
        };
        let mut twins: Vec<Twin> = sorts
            .iter()
            .zip(&held)
            .map(|(sort, held)| Twin {
                sort: sort.to_string(),
                comparisons: held
                    .and_then(|(twin, store)| comparisons(lfb, &pixels, twin, &spec(store))),
                samples_ns: Vec::new(),
            })
            .collect();
        let mut scratch = Scratch::default();
        let mut order: Vec<usize> = (0..sorts.len()).collect();
        for round in 0..=samples {
            SplitMix64(seed ^ (u64::from(round) << 32)).shuffle(&mut order);
            for &place in &order {
                let Some((strategy, store)) = held[place] else { continue };
                let (spec, started) = (spec(store), Instant::now());
                for &pixel in &pixels {
                    black_box(resolve(strategy, &spec, lfb.pixel(pixel), &mut scratch));
                }
                let ns = u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX);
                if round > 0 {
                    twins[place].samples_ns.push(ns);
                }
            }
        }
        found.push(TwinInterval {
            low: interval.low,
            high: interval.high,
            pixels: group.len() as u64,
            resolved_pixels: pixels.len() as u64,
            fragments: pixels.iter().map(|&pixel| lfb.pixel(pixel).len() as u64).sum(),
            twins,
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use oit_sort::{STRATEGIES, patterns::PATTERNS};

    /// One pixel of `n` fragments in the pattern's order.
    fn one(pattern: &str, n: usize) -> Lfb {
        let pattern = PATTERNS.iter().find(|known| known.name == pattern).unwrap();
        Lfb::from_lists(1, 1, &[pattern.fragments(n, 5)])
    }

    fn counts(lfb: &Lfb, sort: &str) -> Option<u64> {
        time_twins(lfb, &[sort.parse().unwrap()], 10, 1, 1)[0].twins[0].comparisons
    }

    #[test]
    fn comparisons_are_those_of_the_algorithm() {
        // Insertion: one a fragment in order, all pairs in reverse.
        assert_eq!(counts(&one("sorted", 16), "insertion"), Some(15));
        assert_eq!(counts(&one("reversed", 16), "insertion"), Some(15 * 16 / 2));
        // A network compares the same whatever it is given: Batcher's for 16.
        assert_eq!(counts(&one("sorted", 16), "network"), Some(63));
        assert_eq!(counts(&one("random", 13), "network"), Some(63));
        assert_eq!(counts(&one("random", 16), "passthrough"), Some(0));
        assert_eq!(counts(&one("random", 100), "network"), None);
    }

    #[test]
    fn every_sort_is_counted_and_timed() {
        let lfb = one("random", 30);
        let sorts = SortChoice::all();
        let found = time_twins(&lfb, &sorts, 10, 3, 1);
        assert_eq!((found.len(), found[0].high, found[0].fragments), (1, 32, 30));
        for (twin, strategy) in found[0].twins.iter().zip(STRATEGIES) {
            // No comparison sort has fewer than n - 1.
            let least = if strategy.sorts() { 29 } else { 0 };
            assert!(twin.comparisons.unwrap() >= least, "{}", twin.sort);
            assert_eq!(twin.samples_ns.len(), 3, "{}", twin.sort);
        }
    }

    #[test]
    fn pixels_are_taken_evenly() {
        let lists: Vec<_> = (0..100).map(|i| PATTERNS[0].fragments(1 + i % 8, i as u64)).collect();
        let found =
            time_twins(&Lfb::from_lists(10, 10, &lists), &["insertion".parse().unwrap()], 30, 1, 1);
        assert_eq!((found[0].pixels, found[0].resolved_pixels), (100, 25));
    }
}
