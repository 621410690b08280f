//! The three scans on every device of this machine against a sum on the processor.

use std::io::Write;

use oit_gpu::{Buffer, Device, Dispatch, Pass, Plan, Shader};
use oit_scene::SplitMix64;

use super::{Scan, workgroups};
use crate::words_buffer;

const SCANS: [Scan; 3] = [Scan::Blocks, Scan::Sweep, Scan::LookBack];

/// Runs a test on every device that can be opened; with `OIT_REQUIRE_GPU=1` there must be one.
fn on_every_device(mut run: impl FnMut(&mut dyn Device)) {
    let cache = tempfile::tempdir().expect("a folder for pipelines");
    let mut ran = 0;
    for listed in oit_gpu::enumerate() {
        let open = |_| oit_gpu::open(&listed.id, cache.path()).map_err(|error| error.to_string());
        match listed.info.and_then(open) {
            Ok(mut device) => {
                run(device.as_mut());
                ran += 1;
            }
            Err(reason) => say(&format!("scans: skipped on {}: {reason}", listed.id)),
        }
    }
    if ran == 0 {
        let required = std::env::var("OIT_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "OIT_REQUIRE_GPU is set and no device can be used");
        say("scans: SKIPPED, no device can be used");
    }
}

/// Past the test harness, which keeps back what passing tests print.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr");
}

/// A plan that copies the words of `input` to where the scan finds its values, and scans them.
fn plan(scan: Scan, input: &[u32]) -> Plan {
    let length = input.len() as u32;
    let (from, to) = if scan.in_place() { ("table", "table") } else { ("table", "sums") };
    let (row, dispatch) = workgroups(length.div_ceil(256));
    let copy = format!(
        "@group(0) @binding(0) var<storage, read> input: array<u32>;
        @group(0) @binding(1) var<storage, read_write> table: array<u32>;
        @compute @workgroup_size(256) fn main(
            @builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3<u32>,
        ) {{
            let i = (group.y * {row}u + group.x) * 256u + lane;
            if (i < {length}u) {{ table[i] = input[i]; }}
        }}"
    );
    let mut buffers = vec![
        words_buffer("input", input),
        Buffer::new("table", 4 * scan.words(length)),
        Buffer::new("total", 4),
    ];
    if from != to {
        buffers.push(Buffer::new(to, 4 * u64::from(length)));
    }
    let mut passes = vec![
        Pass::clear("clear", "table"),
        Pass::compute("clear", Shader::new("copy", copy), dispatch),
    ];
    let (own, scans) = scan.exclusive("scan", from, to, length, "total");
    buffers.extend(own);
    passes.extend(scans);
    Plan { name: format!("{scan:?} of {length}"), buffers, targets: Vec::new(), passes }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
}

/// The sum before each value, and of all, modulo 2^32.
fn expected(values: &[u32]) -> (Vec<u32>, u32) {
    let mut total = 0u32;
    let before = values.iter().map(|&value| {
        let before = total;
        total = total.wrapping_add(value);
        before
    });
    (before.collect(), total)
}

/// Runs it and compares all it gives.
fn compare(device: &mut dyn Device, scan: Scan, values: &[u32], runs: usize) {
    let what = format!("{}: {scan:?} of {}", device.info().id, values.len());
    let id = device.prepare(&plan(scan, values)).expect("the plan is sound");
    let (before, total) = expected(values);
    device.poison(id).expect("fills");
    for run in 0..runs {
        device.run(id).expect("runs");
        let to = if scan.in_place() { "table" } else { "sums" };
        let sums = words(&device.read(id, to).expect("reads"));
        let wrong = before.iter().zip(&sums).position(|(a, b)| a != b);
        assert_eq!(wrong.map(|at| (at, before[at], sums[at])), None, "{what}, run {run}");
        assert!(sums.len() >= before.len(), "{what}");
        let found = words(&device.read(id, "total").expect("reads"))[0];
        assert_eq!(found, total, "{what}, run {run}: total");
    }
}

#[test]
fn scans_add_up() {
    on_every_device(|device| {
        let mut random = SplitMix64::new(1);
        for length in
            [1, 2, 3, 255, 1023, 1024, 1025, 4096, 100_000, (1 << 20) - 1, 1 << 20, (1 << 20) + 1]
        {
            for scan in SCANS {
                // Totals as far as each scan goes.
                let most = (scan.limit() - 1) / length;
                let runs = if length < 100_000 { 3 } else { 2 };
                let mut values = |most: u64| -> Vec<u32> {
                    (0..length).map(|_| random.below(most as usize + 1) as u32).collect()
                };
                compare(device, scan, &values(most.min(40)), runs);
                compare(device, scan, &values(most.min(u64::from(u32::MAX) - 1)), runs);
                compare(device, scan, &values(0), 1);
            }
        }
    });
}

#[test]
fn one_large_value_is_carried_to_the_end() {
    on_every_device(|device| {
        for scan in SCANS {
            for at in [0, 1023, 1024, 4999] {
                let mut values = vec![0; 5000];
                values[at] = (scan.limit() - 1) as u32;
                compare(device, scan, &values, 1);
            }
        }
    });
}

/// The words that another workgroup would have published are missing for good: a single workgroup
/// runs, and all it needs it must add up itself.
#[test]
fn looking_back_waits_for_nobody() {
    on_every_device(|device| {
        let mut random = SplitMix64::new(2);
        // More than a window of 256 blocks.
        let values: Vec<u32> = (0..700 * 1024).map(|_| random.below(9) as u32).collect();
        let (before, _) = expected(&values);
        for block in [1u32, 2, 37] {
            let mut plan = plan(Scan::LookBack, &values);
            for pass in &mut plan.passes {
                if let oit_gpu::Work::Compute { shader, dispatch } = &mut pass.work
                    && shader.label.contains("look back")
                {
                    // As if the workgroups before it had taken their tickets and stood still.
                    let ticket = "ticket = atomicAdd(&sums_status[BLOCKS], 1u);";
                    assert!(shader.wgsl.contains(ticket));
                    shader.wgsl =
                        shader.wgsl.replace(ticket, &format!("ticket = {block}u;")).into();
                    *dispatch = Dispatch::Workgroups([1, 1, 1]);
                }
            }
            let id = device.prepare(&plan).expect("the plan is sound");
            device.poison(id).expect("fills");
            device.run(id).expect("runs");
            let sums = words(&device.read(id, "sums").expect("reads"));
            let own = 1024 * block as usize..1024 * (block as usize + 1);
            assert!(sums[own.clone()] == before[own.clone()], "block {block}");
            assert_eq!(sums[own.start - 1], 0xcdcd_cdcd, "only this block ran");
        }
    });
}

#[test]
fn tables_have_room_for_their_padding() {
    let words = |length| SCANS.map(|scan| scan.words(length));
    assert_eq!(words(1), [1, 2, 1]);
    assert_eq!(words(1024), [1024, 1024, 1024]);
    assert_eq!(words(1025), [1025, 2048, 1025]);
    assert_eq!(words(u32::MAX), [(1 << 32) - 1, 1 << 32, (1 << 32) - 1]);
    // Two passes a level: 2 log2(2^21) at 1080p.
    assert_eq!(plan(Scan::Sweep, &[1; 1025]).passes.len(), 2 + 2 * 11);
}
