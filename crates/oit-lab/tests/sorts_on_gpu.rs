//! Every sort strategy's kernel, in every store, against its CPU twin, on every GPU there is: both tie
//! rules, every count from 0 to 257 and about each interval's edge, every pattern, pixels deeper than the array.

mod support;

use oit_fragments::Ties;
use oit_gpu::{Device, GpuError};
use oit_lab::{check_emitted, emitted, kernel_conforms};
use oit_sort::{STRATEGIES, Scratch, SortSpec, patterns, store_name, strategy};

#[test]
fn every_kernel_sorts_as_its_twin() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        for strategy in STRATEGIES {
            for &store in strategy.stores() {
                let name = store_name(*strategy, store);
                let found = kernel_conforms(&mut *device, *strategy, store, 512)
                    .unwrap_or_else(|error| panic!("{id}: {name}: {error}"));
                assert_eq!(found.wrong, None, "{id}: {name}");
                match found.lacking {
                    None => {
                        assert!(found.up_to >= 8 && found.lists > 0, "{id}: {name} ran nothing");
                        println!("{id}: {name} conforms");
                    }
                    Some(reason) => {
                        let max_frags = (2 * found.up_to).max(8);
                        let spec = SortSpec { min_frags: 1, max_frags, ties: Ties::Total, store };
                        let lacking =
                            strategy.lanes(&spec) > 1 || reason.contains("64-bit integers");
                        assert!(lacking, "{id}: {name}: {reason}");
                        println!("{id}: {name} SKIPPED {reason}");
                    }
                }
            }
        }
    }
}

/// The most fragments that a strategy can be asked for; fewer where llvmpipe is given arrays filled with
/// zeros, as wgpu gives them (filling thousands of places takes it minutes to compile), and where it
/// would end a loop too early (see `kernel_conforms`).
fn deepest_of_all(id: &str, device: &dyn Device, name: &str) -> u32 {
    let software = device.info().name.contains("llvmpipe");
    match name {
        "rescan" if software => 512,
        _ if software && id.starts_with("wgpu") => 512,
        _ => 4096,
    }
}

/// The deepest pixels, by strategies that hold so many. A driver may not compile large arrays; one
/// strategy at least sorts there.
#[test]
fn pixels_of_4096_fragments_are_sorted() {
    let mut scratch = Scratch::default();
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        let mut sorted = 0;
        for name in ["rbs_hier", "rbs_heap", "rescan"] {
            let strategy = strategy(name).expect("a strategy");
            let max_frags = deepest_of_all(&id, &*device, name);
            let (min_frags, store) = (max_frags / 2 + 1, strategy.stores()[0]);
            let spec = SortSpec { min_frags, max_frags, ties: Ties::Total, store };
            let patterns = ["random", "reversed"].map(|name| {
                patterns::PATTERNS.iter().find(|pattern| pattern.name == name).expect("a pattern")
            });
            let pixels: Vec<_> =
                [min_frags, max_frags * 3 / 4, max_frags - 1, max_frags, max_frags + 1]
                    .into_iter()
                    .map(|count| (count as usize, u64::from(count)))
                    .flat_map(|(count, seed)| {
                        patterns.map(|pattern| pattern.fragments(count, seed))
                    })
                    .collect();
            let found = match emitted(&mut *device, strategy, spec, false, &pixels) {
                Ok(found) => found,
                Err(GpuError::Unsupported(reason)) => {
                    println!("{id}: {name} SKIPPED {reason}");
                    continue;
                }
                Err(error) => panic!("{id} {name}: {error}"),
            };
            for (given, found) in pixels.iter().zip(found) {
                if let Err(text) = check_emitted(strategy, spec, given, found, &mut scratch) {
                    panic!("{id} {name} {spec:?}, {} fragments: {text}", given.len());
                }
            }
            println!("{id}: {name} sorts {max_frags}");
            sorted += 1;
            device.reset();
        }
        assert!(sorted > 0, "{id}: nothing sorts pixels so deep");
    }
}
