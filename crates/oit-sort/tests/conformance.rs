//! The twin of every strategy against the standard library, on every pattern and count.

use oit_fragments::{Fragment, Lfb, Ties, oracle};
use oit_sort::patterns::PATTERNS;
use oit_sort::{STRATEGIES, Scratch, SortSpec, SortStrategy, resolve, sorted, strategy};

/// Every count up to 257, and those about each interval's edge.
fn counts() -> Vec<usize> {
    let edges = (3..=9).flat_map(|power| [(1 << power) - 1, 1 << power, (1 << power) + 1]);
    let mut counts: Vec<usize> = (0..=257).chain(edges).collect();
    counts.sort_unstable();
    counts.dedup();
    counts
}

/// A kernel that fits exactly, the interval's, the strategy's largest, and one that is too small.
fn max_frags(n: usize, limit: Option<u32>) -> Vec<u32> {
    let n = n as u32;
    let sizes = [n.max(1), n.next_power_of_two().max(8), limit.unwrap_or(512), (n * 2 / 3).max(1)];
    let mut sizes: Vec<u32> = sizes.into_iter().map(|m| m.min(limit.unwrap_or(m))).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

#[test]
fn every_strategy_sorts_every_pattern_of_every_count() {
    let seed = 20_140_612;
    println!("seed {seed}");
    let mut scratch = Scratch::default();
    let by_key = |fragments: &[Fragment]| {
        let mut fragments = fragments.to_vec();
        fragments.sort_by_key(|f| f.key());
        fragments
    };
    for n in counts() {
        for pattern in PATTERNS {
            let fragments = pattern.fragments(n, seed + n as u64);
            for strategy in STRATEGIES {
                for ties in Ties::ALL {
                    // A twin has no store: one array stands for all.
                    for max_frags in max_frags(n, strategy.limit()) {
                        let store = strategy.stores()[0];
                        let spec = SortSpec { min_frags: 1, max_frags, ties, store };
                        let found = sorted(*strategy, &spec, &fragments, &mut scratch);
                        let case = || {
                            let (name, pattern) = (strategy.name(), pattern.name);
                            format!("{name}, {pattern}, {n} fragments, {spec:?}")
                        };
                        let taken = &fragments[..n.min(max_frags as usize)];
                        let expected = by_key(taken);
                        if !strategy.sorts() {
                            assert_eq!(found, taken, "as they came: {}", case());
                        } else if ties == Ties::Total {
                            assert_eq!(found, expected, "{}", case());
                        } else {
                            assert_eq!(by_key(found), expected, "the same fragments: {}", case());
                            assert!(
                                found.windows(2).all(|w| w[0].depth_key <= w[1].depth_key),
                                "nearest first: {}",
                                case()
                            );
                        }
                    }
                }
            }
        }
    }
}

/// The deepest pixels that techniques hold: strategies without a limit, or a higher one, sort them too.
#[test]
fn deep_pixels_are_sorted() {
    let mut scratch = Scratch::default();
    let deep = |strategy: &&&dyn SortStrategy| {
        strategy.sorts() && strategy.limit().is_none_or(|limit| limit > 512)
    };
    for strategy in STRATEGIES.iter().filter(deep) {
        for n in [513usize, 1024, 1025, 2047, 2048, 3000, 4095, 4096] {
            let max_frags = (n as u32).next_power_of_two();
            if strategy.limit().is_some_and(|limit| max_frags > limit) {
                continue;
            }
            for name in ["random", "reversed", "near_equal"] {
                let pattern = PATTERNS.iter().find(|pattern| pattern.name == name).unwrap();
                let fragments = pattern.fragments(n, n as u64);
                let (ties, store) = (Ties::Total, strategy.stores()[0]);
                let spec = SortSpec { min_frags: max_frags / 2 + 1, max_frags, ties, store };
                let found = sorted(*strategy, &spec, &fragments, &mut scratch);
                let mut expected = fragments.clone();
                expected.sort_by_key(|f| f.key());
                assert!(found == expected, "{}, {name}, {n} fragments", strategy.name());
            }
        }
    }
    for name in ["heap", "merge", "rbs_heap", "rbs_hier", "rescan"] {
        let limit = strategy(name).unwrap().limit();
        assert!(limit.is_none_or(|limit| limit >= 4096), "{name} holds 4096");
    }
}

#[test]
fn every_strategy_composites_what_the_oracle_does() {
    let mut scratch = Scratch::default();
    for pattern in PATTERNS {
        for n in [0, 1, 2, 7, 31, 32, 33, 64, 100, 257] {
            let fragments = pattern.fragments(n, 7);
            let in_order = |sorts: bool| sorts || pattern.name == "sorted";
            for strategy in STRATEGIES.iter().filter(|strategy| in_order(strategy.sorts())) {
                let max_frags = strategy.limit().unwrap_or(512).min(512);
                let (ties, store) = (Ties::Total, strategy.stores()[0]);
                let spec = SortSpec { min_frags: 1, max_frags, ties, store };
                let taken = fragments[..n.min(max_frags as usize)].to_vec();
                let exact = oracle::composite(&Lfb::from_lists(1, 1, &[taken]))[0];
                let found = resolve(*strategy, &spec, &fragments, &mut scratch);
                for (found, exact) in found.into_iter().zip(exact) {
                    let error = (f64::from(found) - exact).abs();
                    let (name, pattern) = (strategy.name(), pattern.name);
                    let bound = f64::from(strategy.error_bound().unwrap_or(0.0)) + 1e-5;
                    assert!(error < bound, "{name}, {pattern}, {n} fragments: off by {error}");
                }
            }
        }
    }
}

/// A bound that no pixel comes near would be no bound.
#[test]
fn strategies_that_stop_early_leave_something_out() {
    let mut scratch = Scratch::default();
    let grey = |i: u32| Fragment::new((i + 1) as f32 / 512.0, [255, 255, 255, 8]);
    let fragments: Vec<_> = (0..400).map(grey).collect();
    let exact = oracle::composite(&Lfb::from_lists(1, 1, std::slice::from_ref(&fragments)))[0];
    let early: Vec<_> = STRATEGIES.iter().filter(|s| s.error_bound().is_some()).collect();
    assert!(early.len() >= 2);
    for strategy in early {
        let (ties, store) = (Ties::Total, strategy.stores()[0]);
        let spec = SortSpec { min_frags: 1, max_frags: 512, ties, store };
        let found = resolve(*strategy, &spec, &fragments, &mut scratch);
        let bound = f64::from(strategy.error_bound().unwrap());
        for (found, exact) in found.into_iter().zip(exact) {
            let error = (f64::from(found) - exact).abs();
            let name = strategy.name();
            assert!(error <= bound && error > 0.9 * bound, "{name}: {error}, of {bound}");
        }
    }
}

#[test]
fn patterns_are_what_they_say() {
    let pattern = |name: &str| PATTERNS.iter().find(|p| p.name == name).unwrap();
    let keys = |name: &str| -> Vec<u32> {
        pattern(name).fragments(200, 1).iter().map(|f| f.depth_key).collect()
    };
    assert!(keys("sorted").is_sorted_by(|a, b| a < b));
    assert!(keys("reversed").is_sorted_by(|a, b| a > b));
    let organ = keys("organ_pipe");
    assert!(organ[..100].is_sorted() && organ[100..].is_sorted_by(|a, b| a > b));
    let distinct = |name: &str| keys(name).into_iter().collect::<std::collections::HashSet<_>>();
    assert_eq!(distinct("all_equal").len(), 1);
    assert_eq!(distinct("two_valued").len(), 2);
    assert!(distinct("random").len() > 190);
    assert_eq!(distinct("near_equal").len(), 7);
    let colours = |name: &str| {
        let fragments = pattern(name).fragments(200, 1);
        fragments.iter().map(|f| f.rgba).collect::<std::collections::HashSet<_>>()
    };
    assert!(colours("all_equal").len() > 190);
    assert_eq!(colours("identical").len(), 1);
    let denormal = pattern("denormal").fragments(200, 1);
    assert!(denormal.iter().all(|f| f.depth() == 0.0 || f.depth().is_subnormal()));
    assert!(denormal.iter().any(|f| f.depth() < 0.0));
    for pattern in PATTERNS {
        assert_eq!(pattern.fragments(50, 3), pattern.fragments(50, 3), "seeded: {}", pattern.name);
        assert!(pattern.fragments(257, 3).iter().all(|f| !f.depth().is_nan()));
    }
}
