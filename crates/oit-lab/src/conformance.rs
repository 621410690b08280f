//! Whether a sort sorts: every kernel, in every store, against its CPU twin, before it is timed. Both
//! tie rules, every count and those about each interval's edge, every pattern, pixels deeper than the
//! array.

use std::sync::Arc;

use oit_bma::{Interval, Intervals};
use oit_fragments::{Element, Fragment, Ties};
use oit_gpu::{Buffer, Device, Dispatch, GpuError, Pass, Plan, Shader};
use oit_record::Conformance;
use oit_sort::{
    End, Entry, Layout, Output, Program, Scratch, SortSpec, SortStrategy, Store, patterns, sorted,
    workgroups,
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

/// What the strategy's compute program emits of these pixels, each nearest or farthest first as it
/// blends. Beyond the array's size a pixel's list is not written.
///
/// # Errors
/// What the device lacks ([`GpuError::Unsupported`]), or that it failed.
pub fn emitted(
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
        layout: Layout { name: "given", wgsl: &wgsl, random_access, element: Element::Narrow },
        strategy,
        spec,
        entry: Entry::Pixels,
        output: Output::Emit,
        width_px: pixels.len() as u32,
        height_px: 1,
    };
    let plan_name = format!("{} {spec:?}", strategy.name());
    let wgsl = program
        .wgsl()
        .map_err(|error| GpuError::Plan { plan: plan_name.clone(), what: error.to_string() })?;
    let shader = Shader::new(strategy.name(), wgsl);
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
    let plan = Plan { name: plan_name, buffers, targets: Vec::new(), passes };
    let id = device.prepare(&plan)?;
    device.poison(id)?;
    device.run(id)?;
    let out: Vec<Fragment> = bytemuck::pod_collect_to_vec(&device.read(id, "emitted")?);
    let range = |pair: &[u32]| out[pair[0] as usize..pair[1] as usize].to_vec();
    Ok(offsets.windows(2).map(range).collect())
}

/// Compares what a kernel emitted with what its twin makes of the same pixel.
///
/// # Errors
/// Where they differ, and how.
pub fn check_emitted(
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
fn deepest_on(device: &dyn Device) -> u32 {
    if device.info().name.contains("llvmpipe") { 256 } else { 512 }
}

/// Runs a strategy's compute programs of all intervals up to `deepest` fragments, 512 at most, and
/// compares them with the twin. Ends with the first that is wrong or that the device cannot run.
///
/// # Errors
/// Where the device fails; what it lacks is no error.
pub fn kernel_conforms(
    device: &mut dyn Device,
    strategy: &dyn SortStrategy,
    store: Store,
    deepest: u32,
) -> Result<Conformance, GpuError> {
    let mut scratch = Scratch::default();
    let mut done = Conformance {
        compared: "compute programs with the CPU twin".into(),
        ..Conformance::default()
    };
    for interval in Intervals::powers_of_two(deepest.min(deepest_on(device))).iter() {
        if strategy.limit_in(store).is_some_and(|limit| interval.high > limit) {
            continue;
        }
        for ties in Ties::ALL {
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
                        done.lacking =
                            Some(format!("from {} fragments on: {reason}", interval.low));
                        return Ok(done);
                    }
                    Err(error) => return Err(error),
                };
                done.programs += 1;
                for (given, found) in pixels.iter().zip(found) {
                    if let Err(text) = check_emitted(strategy, spec, given, found, &mut scratch) {
                        done.wrong = Some(format!("{spec:?}, {} fragments: {text}", given.len()));
                        return Ok(done);
                    }
                    done.lists += 1;
                }
            }
        }
        device.reset();
        done.up_to = interval.high;
    }
    Ok(done)
}

/// The same of the CPU twin, against the standard library's sort: where there is no kernel to run.
#[must_use]
pub fn twin_conforms(strategy: &dyn SortStrategy, store: Store, deepest: u32) -> Conformance {
    let mut scratch = Scratch::default();
    let mut done = Conformance {
        compared: "the CPU twin with the standard library's sort".into(),
        ..Conformance::default()
    };
    for interval in Intervals::powers_of_two(deepest.min(512)).iter() {
        if strategy.limit_in(store).is_some_and(|limit| interval.high > limit) {
            continue;
        }
        let (min_frags, max_frags) = (interval.low, interval.high);
        let spec = SortSpec { min_frags, max_frags, ties: Ties::Total, store };
        done.programs += 1;
        for given in pixels(interval, false) {
            let mut expected = given[..given.len().min(max_frags as usize)].to_vec();
            if strategy.sorts() {
                expected.sort_unstable_by_key(|fragment| fragment.key());
            }
            if sorted(strategy, &spec, &given, &mut scratch) != expected {
                done.wrong = Some(format!("{spec:?}, {} fragments: not in order", given.len()));
                return done;
            }
            done.lists += 1;
        }
        done.up_to = interval.high;
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves fragments as they are, and claims to sort.
    struct Broken;

    impl SortStrategy for Broken {
        fn name(&self) -> &'static str {
            "broken"
        }

        fn summary(&self) -> &'static str {
            "Does not sort."
        }

        fn citation(&self) -> &'static str {
            "none"
        }

        fn stores(&self) -> &'static [Store] {
            &[Store::Local]
        }

        fn blends_from(&self) -> End {
            End::Front
        }

        fn template(&self) -> &'static str {
            ""
        }

        fn sort(&self, _: &SortSpec, _: &mut [Fragment], _: &mut Vec<Fragment>) {}
    }

    #[test]
    fn a_twin_that_does_not_sort_is_found() {
        let found = twin_conforms(&Broken, Store::Local, 64);
        assert!(found.wrong.is_some_and(|wrong| wrong.contains("not in order")));
        let insertion = oit_sort::strategy("insertion").unwrap();
        let found = twin_conforms(insertion, Store::Local, 64);
        assert_eq!((found.wrong, found.up_to, found.programs), (None, 64, 4));
    }

    #[test]
    fn what_a_kernel_emits_out_of_order_is_wrong() {
        let insertion = oit_sort::strategy("insertion").unwrap();
        let spec = SortSpec { min_frags: 1, max_frags: 8, ties: Ties::Total, store: Store::Local };
        let given = patterns::PATTERNS[0].fragments(8, 3);
        let mut scratch = Scratch::default();
        // It blends from the back: what it emits is farthest first.
        let mut right = sorted(insertion, &spec, &given, &mut scratch).to_vec();
        right.reverse();
        let check =
            |found, scratch: &mut Scratch| check_emitted(insertion, spec, &given, found, scratch);
        assert_eq!(check(right.clone(), &mut scratch), Ok(()));
        right.swap(2, 3);
        let wrong = check(right, &mut scratch).unwrap_err();
        assert!(wrong.contains("from place 4 on"), "{wrong}");
    }
}
