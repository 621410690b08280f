//! The twins: sort and composite of one pixel, in fragments a second on one core.

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use oit_fragments::Ties;
use oit_sort::patterns::PATTERNS;
use oit_sort::{STRATEGIES, Scratch, SortSpec, resolve};
use std::hint::black_box;

/// Pixels of one measurement: enough that no branch predictor learns them.
const PIXELS: u64 = 512;

fn twins(criterion: &mut Criterion) {
    let random = PATTERNS.iter().find(|pattern| pattern.name == "random").expect("a pattern");
    for ties in Ties::ALL {
        let mut group = criterion.benchmark_group(format!("resolve/{}", ties.name()));
        for per_pixel in [8u32, 16, 32, 64, 128] {
            let pixels: Vec<_> =
                (0..PIXELS).map(|seed| random.fragments(per_pixel as usize, seed)).collect();
            group.throughput(Throughput::Elements(PIXELS * u64::from(per_pixel)));
            for strategy in STRATEGIES {
                if strategy.limit().is_some_and(|limit| per_pixel > limit) {
                    continue;
                }
                let store = strategy.stores()[0];
                let spec = SortSpec { min_frags: 1, max_frags: per_pixel, ties, store };
                let id = BenchmarkId::new(strategy.name(), per_pixel);
                group.bench_function(id, |bencher| {
                    bencher.iter_batched_ref(
                        Scratch::default,
                        |scratch| {
                            for pixel in &pixels {
                                black_box(resolve(*strategy, &spec, pixel, scratch));
                            }
                        },
                        BatchSize::LargeInput,
                    );
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, twins);
criterion_main!(benches);
