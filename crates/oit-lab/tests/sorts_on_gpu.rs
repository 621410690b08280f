//! Every sort strategy's kernel, in every store, against its CPU twin, on every GPU there is: both tie
//! rules, every count from 0 to 257 and about each interval's edge, every pattern, pixels deeper than the array.

mod support;

use std::sync::Arc;

use oit_bma::{Interval, Intervals};
use oit_fragments::{Fragment, Ties};
use oit_gpu::{Buffer, Device, Dispatch, GpuError, Pass, Plan, Shader};
use oit_sort::{
    End, Entry, Layout, Output, Program, STRATEGIES, Scratch, SortSpec, SortStrategy, Store,
    patterns, sorted, store_name, strategy, workgroups,
};

/// Fragments given as they are: what a strategy reads in a test.
const LAYOUT: &str = "
@group(0) @binding(0) var<storage, read> given_offsets: array<u32>;
@group(0) @binding(1) var<storage, read> given: array<vec2<u32>>;
var<private> lfb_first: u32;
var<private> lfb_place: u32;
var<private> lfb_end: u32;
fn lfb_begin(pixel: u32) {
    lfb_first = given_offsets[pixel];
    lfb_place = lfb_first;
    lfb_end = given_offsets[pixel + 1u];
}
fn lfb_more() -> bool { return lfb_place < lfb_end; }
fn lfb_next() -> vec2<u32> { let f = given[lfb_place]; lfb_place += 1u; return f; }
fn lfb_len() -> u32 { return lfb_end - lfb_first; }
fn lfb_at(i: u32) -> vec2<u32> { return given[lfb_first + i]; }
";

/// What is added for strategies that order them where they are.
const REWRITE: &str = "
fn lfb_cursor() -> u32 { return lfb_place; }
fn lfb_seek(cursor: u32) { lfb_place = cursor; }
fn lfb_put(f: vec2<u32>) { given[lfb_place] = f; lfb_place += 1u; }
";

/// Puts the given fragments into a buffer that may be written.
const COPY: &str = "
@group(0) @binding(0) var<storage, read> originals: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> given: array<vec2<u32>>;
@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = (group.y * 32768u + group.x) * 64u + lane;
    if i < arrayLength(&given) { given[i] = originals[i]; }
}
";

/// Pixels for one interval: every count of it in every pattern, and pixels that are too deep.
fn pixels(interval: Interval, base: bool) -> Vec<Vec<Fragment>> {
    let counts: Vec<u32> = if interval.high <= 256 {
        let low = if base { 0 } else { interval.low };
        (low..=interval.high).chain([interval.high + 1, interval.high + 9]).collect()
    } else {
        vec![interval.low, interval.high - 1, interval.high, interval.high + 1]
    };
    let mut pixels = Vec::new();
    for count in counts {
        for pattern in patterns::PATTERNS {
            pixels.push(pattern.fragments(count as usize, u64::from(count)));
        }
    }
    pixels
}

fn emitted(
    device: &mut dyn Device,
    strategy: &dyn SortStrategy,
    spec: SortSpec,
    random_access: bool,
    pixels: &[Vec<Fragment>],
) -> Result<Vec<Vec<Fragment>>, GpuError> {
    let mut offsets = vec![0u32];
    for pixel in pixels {
        offsets.push(offsets[offsets.len() - 1] + pixel.len() as u32);
    }
    let all: Vec<Fragment> = pixels.iter().flatten().copied().collect();
    let bytes = |data: &[u8]| Arc::<[u8]>::from(data);
    let wgsl = if spec.store == Store::Global {
        LAYOUT.replace("read> given:", "read_write> given:") + REWRITE
    } else {
        LAYOUT.to_owned()
    };
    let program = Program {
        layout: Layout { name: "given", wgsl: &wgsl, random_access },
        strategy,
        spec,
        entry: Entry::Pixels,
        output: Output::Emit,
        width_px: pixels.len() as u32,
        height_px: 1,
    };
    let shader = Shader::new(strategy.name(), program.wgsl().expect("it assembles"));
    let groups = workgroups(pixels.len() as u64, strategy.pixels_per_workgroup(&spec));
    let groups = Dispatch::Workgroups(groups);
    let given = bytes(bytemuck::cast_slice(&all));
    let mut buffers = vec![
        Buffer::data("given_offsets", bytes(bytemuck::cast_slice(&offsets))),
        Buffer::data("emit_offsets", bytes(bytemuck::cast_slice(&offsets))),
        Buffer::new("emitted", 8 * all.len() as u64),
    ];
    let mut passes = Vec::new();
    if spec.store == Store::Global {
        buffers.push(Buffer::data("originals", given));
        buffers.push(Buffer::new("given", 8 * all.len() as u64));
        let all = Dispatch::Workgroups(workgroups(all.len() as u64, 64));
        passes.push(Pass::compute("capture", Shader::new("copy", COPY), all));
    } else {
        buffers.push(Buffer::data("given", given));
    }
    passes.push(Pass::compute("resolve", shader, groups));
    let name = format!("{} {spec:?}", strategy.name());
    let plan = Plan { name, buffers, targets: Vec::new(), passes };
    let id = device.prepare(&plan)?;
    device.poison(id).expect("it is poisoned");
    device.run(id).expect("it runs");
    let out: Vec<Fragment> =
        bytemuck::pod_collect_to_vec(&device.read(id, "emitted").expect("it is read"));
    let range = |pair: &[u32]| out[pair[0] as usize..pair[1] as usize].to_vec();
    Ok(offsets.windows(2).map(range).collect())
}

/// What the kernel should have emitted, nearest first.
fn check(
    strategy: &dyn SortStrategy,
    spec: SortSpec,
    given: &[Fragment],
    mut found: Vec<Fragment>,
    scratch: &mut Scratch,
) -> Result<(), String> {
    let expected = sorted(strategy, &spec, given, scratch);
    found.truncate(expected.len());
    if strategy.blends_from() == End::Back {
        found.reverse();
    }
    let right = match spec.ties {
        Ties::Total => found == expected,
        // Fragments of equal depth may come in any order.
        Ties::Depth => {
            let keys = |list: &[Fragment]| {
                let mut keys: Vec<u64> = list.iter().map(|f| f.key()).collect();
                if strategy.sorts() {
                    keys.sort_unstable();
                }
                keys
            };
            let ordered = found.is_sorted_by_key(|f| f.depth_key) || !strategy.sorts();
            ordered && keys(&found) == keys(expected)
        }
    };
    if right {
        return Ok(());
    }
    let place = found.iter().zip(expected).position(|(a, b)| a != b).unwrap_or(expected.len());
    let near = |list: &[Fragment]| format!("{:?}", &list[place..list.len().min(place + 3)]);
    Err(format!("from place {place} on, {} and not {}", near(&found), near(expected)))
}

/// llvmpipe, the software driver, ends a program's loops after 65,535 iterations over all its
/// nesting and invocations: too few for an insertion sort of 512 fragments.
fn deepest(device: &dyn Device) -> u32 {
    if device.info().name.contains("llvmpipe") { 256 } else { 512 }
}

/// # Errors
/// What the device lacks, and from which interval on: larger subgroups, say.
fn conforms(
    device: &mut dyn Device,
    strategy: &dyn SortStrategy,
    store: Store,
) -> Result<(), String> {
    let mut scratch = Scratch::default();
    for interval in Intervals::powers_of_two(deepest(device)).iter() {
        if strategy.limit_in(store).is_some_and(|limit| interval.high > limit) {
            continue;
        }
        // Of the other stores one rule is enough: they compare as the default one does.
        let default = store == strategy.stores()[0];
        for &ties in if default { &Ties::ALL[..] } else { &[Ties::Total] } {
            // Deep programs are slow to compile on software devices: one form of each is enough.
            let forms = if interval.high <= 32 { 2 } else { 1 };
            for form in 0..forms {
                let base = form == 1;
                // Where there is one form, each tie rule has its own way of reading.
                let random_access = if forms == 1 { ties == Ties::Total } else { !base };
                let min_frags = if base { 0 } else { interval.low };
                let max_frags = interval.high;
                let spec = SortSpec { min_frags, max_frags, ties, store };
                let pixels = pixels(interval, base);
                let found = match emitted(device, strategy, spec, random_access, &pixels) {
                    Ok(found) => found,
                    Err(GpuError::Unsupported(reason)) => {
                        let is_lacking =
                            strategy.lanes(&spec) > 1 || reason.contains("64-bit integers");
                        assert!(is_lacking, "{}: {reason}", strategy.name());
                        return Err(format!("from {} fragments on: {reason}", interval.low));
                    }
                    Err(error) => panic!("{} {spec:?}: {error}", strategy.name()),
                };
                for (given, found) in pixels.iter().zip(found) {
                    if let Err(text) = check(strategy, spec, given, found, &mut scratch) {
                        panic!("{} {spec:?}, {} fragments: {text}", strategy.name(), given.len());
                    }
                }
            }
            device.reset();
        }
    }
    Ok(())
}

#[test]
fn every_kernel_sorts_as_its_twin() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        for strategy in STRATEGIES {
            for &store in strategy.stores() {
                let name = store_name(*strategy, store);
                match conforms(&mut *device, *strategy, store) {
                    Ok(()) => println!("{id}: {name} conforms"),
                    Err(reason) => println!("{id}: {name} SKIPPED {reason}"),
                }
            }
        }
    }
}

/// The deepest pixels that techniques hold, by strategies whose loops are short enough even where
/// they are cut off ([`deepest`]).
#[test]
fn pixels_of_4096_fragments_are_sorted() {
    let mut scratch = Scratch::default();
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        if id.starts_with("wgpu") && device.info().name.contains("llvmpipe") {
            println!(
                "{id}: SKIPPED: wgpu fills arrays with zeros, thousands of stores for llvmpipe"
            );
            continue;
        }
        let max_frags = 4096;
        for name in ["rbs_hier", "rbs_heap"] {
            let strategy = strategy(name).expect("a strategy");
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
            let found = emitted(&mut *device, strategy, spec, false, &pixels)
                .unwrap_or_else(|error| panic!("{id} {name}: {error}"));
            for (given, found) in pixels.iter().zip(found) {
                if let Err(text) = check(strategy, spec, given, found, &mut scratch) {
                    panic!("{id} {name} {spec:?}, {} fragments: {text}", given.len());
                }
            }
            println!("{id}: {name} sorts {max_frags}");
            device.reset();
        }
    }
}
