//! Every check below on every GPU of this machine: one test of each check and device.
//!
//! Without a GPU there is one ignored test that says why, or, with `OIT_REQUIRE_GPU=1` in the
//! environment, one that fails.

use libtest_mimic::{Arguments, Trial};
use oit_gpu::{
    Blend, Buffer, ColorAttachment, Compare, Depth, DepthStencil, Device, Dispatch, Draw, Format,
    Glsl, GpuError, Load, Mesh, Pass, Plan, PlanId, PreRaster, Raster, Shader, SharedBuffer,
    Stencil, StencilOp, Target, Tessellation, Topology, VertexAttribute, VertexFormat,
    VertexLayout, Vulkan, Work, enumerate, open,
};
use std::path::Path;
use std::sync::Arc;
use std::{env, fs};

/// A check that runs on a freshly opened device.
type Check = fn(&mut dyn Device);

const CHECKS: &[(&str, Check)] = &[
    ("binds_buffers_by_name", binds_buffers_by_name),
    ("arrays_are_as_long_as_their_buffers", arrays_are_as_long_as_their_buffers),
    ("clears_a_buffer", clears_a_buffer),
    ("dispatches_by_a_buffer", dispatches_by_a_buffer),
    ("runs_subgroups_or_says_why_not", runs_subgroups_or_says_why_not),
    ("subgroups_are_as_large_as_asked_and_full", subgroups_are_as_large_as_asked_and_full),
    ("fragments_append_by_subgroup", fragments_append_by_subgroup),
    ("a_chain_of_64_bit_maxima_keeps_the_largest", a_chain_of_64_bit_maxima_keeps_the_largest),
    ("counts_fragments_with_atomics", counts_fragments_with_atomics),
    ("draws_indexed_vertices", draws_indexed_vertices),
    ("row_0_is_the_top_and_y_is_up", row_0_is_the_top_and_y_is_up),
    ("formats_hold_colours", formats_hold_colours),
    ("draws_what_a_buffer_says", draws_what_a_buffer_says),
    ("draws_many_times_from_a_buffer", draws_many_times_from_a_buffer),
    ("fragments_write_depth", fragments_write_depth),
    ("draws_to_eight_targets", draws_to_eight_targets),
    ("geometry_stages_make_squares_of_points", geometry_stages_make_squares_of_points),
    ("tessellation_stages_make_a_grid", tessellation_stages_make_a_grid),
    ("counts_what_each_raster_pass_does", counts_what_each_raster_pass_does),
    ("points_are_as_large_as_told", points_are_as_large_as_told),
    ("mesh_stages_make_squares", mesh_stages_make_squares),
    ("minima_and_maxima_of_64_bits", minima_and_maxima_of_64_bits),
    ("stencil_rejects_before_the_shader_writes", stencil_rejects_before_the_shader_writes),
    ("depth_rejects_before_the_shader_writes", depth_rejects_before_the_shader_writes),
    ("clips_at_both_planes", clips_at_both_planes),
    ("unclipped_draws_past_both_planes", unclipped_draws_past_both_planes),
    ("late_writes_show_the_rejected", late_writes_show_the_rejected),
    ("blends", blends),
    ("counts_by_blending_as_by_atomics", counts_by_blending_as_by_atomics),
    ("shaders_read_targets", shaders_read_targets),
    ("poisons_what_has_no_given_contents", poisons_what_has_no_given_contents),
    ("plans_share_buffers_by_name_and_size", plans_share_buffers_by_name_and_size),
    ("exports_what_is_shared_or_says_why_not", exports_what_is_shared_or_says_why_not),
    ("tells_the_memory_of_each_resource", tells_the_memory_of_each_resource),
    ("tells_what_became_of_each_shader", tells_what_became_of_each_shader),
    ("clears_more_than_32_bits_of_bytes", clears_more_than_32_bits_of_bytes),
    ("moves_more_than_the_staging_holds", moves_more_than_the_staging_holds),
    ("times_stages", times_stages),
    ("refuses_faulty_plans", refuses_faulty_plans),
    ("refuses_what_is_too_large", refuses_what_is_too_large),
    ("reset_frees_and_prepare_works_again", reset_frees_and_prepare_works_again),
    ("is_steady_over_many_runs", is_steady_over_many_runs),
];

fn main() {
    let arguments = Arguments::from_args();
    let listed = enumerate();
    let usable: Vec<String> =
        listed.iter().filter(|d| d.info.is_ok()).map(|device| device.id.clone()).collect();
    let mut trials = Vec::new();
    for id in &usable {
        for &(name, check) in CHECKS {
            let id = id.clone();
            trials.push(Trial::test(format!("{id}::{name}"), move || {
                with_device(&id, |device, _| check(device));
                Ok(())
            }));
        }
        let of = id.clone();
        trials.push(Trial::test(format!("{id}::survives_a_damaged_cache"), move || {
            survives_a_damaged_cache(&of);
            Ok(())
        }));
        let of = id.clone();
        trials.push(Trial::test(format!("{id}::tells_the_same_out_of_the_cache"), move || {
            tells_the_same_out_of_the_cache(&of);
            Ok(())
        }));
        if let Some(index) = id.strip_prefix("vulkan:").and_then(|index| index.parse().ok()) {
            let validated = move || {
                validation_layer_is_quiet(index);
                Ok(())
            };
            trials.push(
                Trial::test(format!("{id}::validation_layer_is_quiet"), validated)
                    .with_ignored_flag(!Vulkan::has_validation_layer()),
            );
        }
    }
    let together = usable.clone();
    let same = move || {
        all_devices_agree(&together);
        Ok(())
    };
    trials.push(Trial::test("all_devices_agree", same).with_ignored_flag(usable.len() < 2));
    if usable.is_empty() {
        let why = listed.into_iter().map(|device| match device.info {
            Ok(_) => device.id,
            Err(reason) => format!("{}: {reason}", device.id),
        });
        let why = why.collect::<Vec<_>>().join("; ");
        eprintln!("no GPU, so nothing is tested on one: {why}");
        let required = env::var_os("OIT_REQUIRE_GPU").is_some_and(|value| value == "1");
        trials.push(
            Trial::test("a_gpu_is_there", move || Err(why.into())).with_ignored_flag(!required),
        );
    }
    libtest_mimic::run(&arguments, trials).exit();
}

fn with_device(id: &str, check: impl FnOnce(&mut dyn Device, &Path)) {
    let cache = tempfile::tempdir().expect("a directory");
    let mut device = open(id, cache.path()).expect("opens, since it was listed");
    assert_eq!(device.info().id, id);
    check(&mut *device, cache.path());
}

fn validation_layer_is_quiet(index: usize) {
    let cache = tempfile::tempdir().expect("a directory");
    let mut device = Vulkan::open(index, cache.path(), true).expect("opens, since it was listed");
    assert_eq!(device.validation_errors(), Some(vec![]));
    for (name, check) in CHECKS {
        check(&mut device);
        device.reset();
        assert_eq!(device.validation_errors(), Some(vec![]), "{name}");
    }
}

const FULL_SCREEN: &str = "
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.5, 1.0);
}
";

const COUNTING: &str = "
@group(0) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;
@fragment @early_depth_test(force) fn fs() -> @location(0) vec4<f32> {
    atomicAdd(&counts[0], 1u);
    return vec4<f32>(1.0);
}
";

fn words(values: &[u32]) -> Arc<[u8]> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn floats(values: &[f32]) -> Arc<[u8]> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn to_words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn to_floats(bytes: &[u8]) -> Vec<f32> {
    to_words(bytes).into_iter().map(f32::from_bits).collect()
}

fn compute(label: &str, wgsl: &str, workgroups: [u32; 3]) -> Pass {
    Pass::compute("count", Shader::new(label, wgsl), Dispatch::Workgroups(workgroups))
}

fn target(name: &str, format: Format, width: u32, height: u32) -> Target {
    Target { name: name.to_owned(), format, width, height }
}

fn color(target: &str, blend: Option<Blend>, load: Load<[f32; 4]>) -> ColorAttachment {
    ColorAttachment { target: target.to_owned(), load, blend, write: true }
}

/// A triangle that covers everything, in this shader.
fn full_screen(fragment: &str, color: Vec<ColorAttachment>) -> Raster {
    let shader = Shader::new("full screen", format!("{FULL_SCREEN}{fragment}"));
    Raster { color, ..Raster::new(shader, Draw::Vertices { count: 3, instances: 1 }) }
}

fn plan(buffers: Vec<Buffer>, targets: Vec<Target>, passes: Vec<Pass>) -> Plan {
    Plan { name: "test".to_owned(), buffers, targets, passes }
}

/// Prepares and runs.
fn ran(device: &mut dyn Device, plan: &Plan) -> PlanId {
    let id = device.prepare(plan).expect("prepared");
    device.run(id).expect("ran");
    id
}

/// Prepares, runs and reads `u32`s.
fn words_of(device: &mut dyn Device, plan: &Plan, resource: &str) -> Vec<u32> {
    let id = ran(device, plan);
    to_words(&device.read(id, resource).expect("read"))
}

/// Whether the device says that it lacks this. If so it must refuse the plan, with a reason; the
/// check is over then, and says so.
fn lacks(device: &mut dyn Device, feature: &str, plan: &Plan) -> bool {
    if device.info().unsupported.iter().all(|missing| missing.feature != feature) {
        return false;
    }
    match device.prepare(plan) {
        Err(GpuError::Unsupported(reason)) => {
            eprintln!("{}: not checked: {reason}", device.info().id);
            true
        }
        other => panic!("without {feature} it should be refused: {other:?}"),
    }
}

fn naming_plan() -> Plan {
    // Bind groups with a gap, and bindings in another order than the plan's buffers.
    let wgsl = "
        struct Scale { factor: u32, offset: u32 }
        @group(2) @binding(3) var<uniform> scale: Scale;
        @group(0) @binding(1) var<storage, read> input: array<u32>;
        @group(0) @binding(0) var<storage, read_write> output: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < arrayLength(&input) {
                output[id.x] = input[id.x] * scale.factor + scale.offset;
            }
        }";
    let input: Vec<u32> = (0..100).collect();
    let buffers = vec![
        Buffer::data("scale", words(&[3, 7])),
        Buffer::new("output", 400),
        Buffer::data("input", words(&input)),
    ];
    plan(buffers, vec![], vec![compute("scale", wgsl, [2, 1, 1])])
}

fn binds_buffers_by_name(device: &mut dyn Device) {
    let expected: Vec<u32> = (0..100).map(|i| i * 3 + 7).collect();
    assert_eq!(words_of(device, &naming_plan(), "output"), expected);
    // A second plan with another input takes the same pipeline, not the same data.
    let mut other = naming_plan();
    other.buffers[2] = Buffer::data("input", words(&[5; 100]));
    assert_eq!(words_of(device, &other, "output"), [22; 100]);
}

fn arrays_are_as_long_as_their_buffers(device: &mut dyn Device) {
    for bytes in [16, 4096, 4100] {
        let wgsl = "
            @group(0) @binding(0) var<storage, read> written: array<u32>;
            @group(0) @binding(1) var<storage, read> given: array<u32>;
            @group(0) @binding(2) var<storage, read_write> lengths: array<u32, 4>;
            @compute @workgroup_size(1) fn main() {
                lengths[0] = arrayLength(&written);
                lengths[1] = arrayLength(&given);
            }";
        let buffers = vec![
            Buffer::new("written", bytes),
            Buffer::data("given", vec![0; bytes as usize].into()),
            Buffer::new("lengths", 16),
        ];
        let passes = vec![Pass::clear("clear", "written"), compute("lengths", wgsl, [1, 1, 1])];
        let plan = plan(buffers, vec![], passes);
        let words = bytes as u32 / 4;
        assert_eq!(words_of(device, &plan, "lengths")[..2], [words, words], "{bytes}");
    }
    // The largest there may be: a driver may allow more than it can count.
    let largest = device.info().max_storage_buffer_bytes / 4;
    let wgsl = "
        @group(0) @binding(0) var<storage, read> large: array<u32>;
        @group(0) @binding(1) var<storage, read_write> lengths: array<u32, 4>;
        @compute @workgroup_size(1) fn main() { lengths[0] = arrayLength(&large); }";
    let buffers = vec![Buffer::new("large", 4 * largest), Buffer::new("lengths", 16)];
    let plan = plan(buffers, vec![], vec![compute("lengths", wgsl, [1, 1, 1])]);
    match device.prepare(&plan) {
        Ok(id) => {
            device.run(id).expect("ran");
            let lengths = to_words(&device.read(id, "lengths").expect("read"));
            assert_eq!(u64::from(lengths[0]), largest);
        }
        Err(error) => {
            assert!(matches!(error, GpuError::OutOfMemory(_)), "{error}");
            println!("{}: not checked: {error}", device.info().id);
        }
    }
}

fn clears_a_buffer(device: &mut dyn Device) {
    let plan = plan(vec![Buffer::new("b", 1003)], vec![], vec![Pass::clear("clear", "b")]);
    let id = device.prepare(&plan).expect("prepared");
    device.poison(id).expect("poisoned");
    device.run(id).expect("ran");
    assert_eq!(device.read(id, "b").expect("read"), [0; 1003]);
}

fn dispatches_by_a_buffer(device: &mut dyn Device) {
    let counts = "
        @group(0) @binding(0) var<storage, read_write> groups: array<u32>;
        @compute @workgroup_size(1) fn main() {
            groups[2] = 5u;
            groups[3] = 3u;
            groups[4] = 2u;
        }";
    let tally = "
        @group(0) @binding(0) var<storage, read_write> tally: atomic<u32>;
        @compute @workgroup_size(4) fn main() { atomicAdd(&tally, 1u); }";
    let indirect = Dispatch::Indirect { buffer: "groups".to_owned(), offset_bytes: 8 };
    let passes = vec![
        Pass::clear("clear", "tally"),
        compute("counts", counts, [1, 1, 1]),
        Pass::compute("count", Shader::new("tally", tally), indirect),
    ];
    let buffers = vec![Buffer::new("groups", 20), Buffer::new("tally", 4)];
    assert_eq!(words_of(device, &plan(buffers, vec![], passes), "tally"), [5 * 3 * 2 * 4]);
}

fn runs_subgroups_or_says_why_not(device: &mut dyn Device) {
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> sums: array<u32>;
        @compute @workgroup_size(64) fn main(
            @builtin(local_invocation_index) i: u32,
            @builtin(subgroup_size) size: u32,
        ) {
            let next = subgroupShuffleXor(i, 1u);
            sums[i] = subgroupAdd(1u) * 1000u + next;
        }";
    let plan = plan(vec![Buffer::new("sums", 256)], vec![], vec![compute("sums", wgsl, [1, 1, 1])]);
    if lacks(device, "subgroups in compute", &plan) {
        return;
    }
    let (least, most) = device.info().subgroup_size.expect("told, since subgroups are there");
    for (i, sum) in (0..).zip(words_of(device, &plan, "sums")) {
        assert_eq!(sum % 1000, i ^ 1);
        assert!((least..=most).contains(&(sum / 1000)), "{sum}");
    }
}

/// Groups of neighbouring invocations of a subgroup, by its number and theirs in it: each has its
/// members and its own number.
fn subgroups_are_as_large_as_asked_and_full(device: &mut dyn Device) {
    for lanes in [1, 2, 4, 8, 16, 32, 64] {
        let wgsl = format!(
            "
            enable subgroups;
            const SUBGROUP_AT_LEAST = {lanes}u;
            @group(0) @binding(0) var<storage, read_write> seen: array<vec4<u32>>;
            @compute @workgroup_size(64) fn main(
                @builtin(subgroup_id) subgroup: u32,
                @builtin(subgroup_size) size: u32,
                @builtin(subgroup_invocation_id) lane: u32,
            ) {{
                let group = subgroup * (size / {lanes}u) + lane / {lanes}u;
                let place = group * {lanes}u + lane % {lanes}u;
                var sum = 1u;
                for (var d = 1u; d < {lanes}u; d *= 2u) {{
                    sum += subgroupShuffleXor(sum, d);
                }}
                seen[place] = vec4<u32>(size, sum, subgroupShuffleXor(place, {lanes}u - 1u), 7u);
            }}"
        );
        let passes = vec![compute("seen", &wgsl, [1, 1, 1])];
        let plan = plan(vec![Buffer::new("seen", 1024)], vec![], passes);
        if lacks(device, "subgroups in compute", &plan) {
            return;
        }
        let (least, most) = device.info().subgroup_size.expect("told, since subgroups are there");
        match device.prepare(&plan) {
            Ok(_) => assert!(lanes <= most),
            Err(GpuError::Unsupported(reason)) => {
                assert!(lanes > least, "{reason}");
                assert!(reason.contains(&format!("subgroups of {lanes} are needed")), "{reason}");
                continue;
            }
            Err(error) => panic!("{error}"),
        }
        let words = words_of(device, &plan, "seen");
        for (place, seen) in (0..64).zip(words.chunks_exact(4)) {
            assert!(seen[0] >= lanes, "{lanes}: {seen:?}");
            assert_eq!(seen[1..], [lanes, place ^ (lanes - 1), 7], "{lanes}, place {place}");
        }
    }
}

/// Triangles of a few pixels that lie over each other: many quads are partly covered.
const SMALL_TRIANGLES: &str = "
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    var hash = (i / 3u) * 2654435769u;
    hash = (hash ^ (hash >> 15u)) * 2246822519u;
    let corner = vec2<f32>(f32(hash & 0xFFFFu), f32(hash >> 16u)) / 32768.0 - 1.0;
    let side = 0.1 + 0.05 * f32(i % 7u);
    let offset = vec2<f32>(f32(i % 3u == 1u), f32(i % 3u == 2u)) * side;
    return vec4<f32>(corner + offset, 0.5, 1.0);
}
";

fn fragments_append_by_subgroup(device: &mut dyn Device) {
    // The leader is the first lane that is no helper, so that helpers take no index and add nothing.
    let append = "
        enable subgroups;
        @group(0) @binding(0) var<storage, read_write> next: atomic<u32>;
        @group(0) @binding(1) var<storage, read_write> taken: array<atomic<u32>>;
        @group(0) @binding(2) var<storage, read_write> leaders: atomic<u32>;
        fn below(lane: u32, word: u32) -> u32 {
            return extractBits(0xFFFFFFFFu, 0u, min(max(lane, word * 32u) - word * 32u, 32u));
        }
        @fragment fn fs(
            @builtin(sample_mask) mask: u32,
            @builtin(subgroup_invocation_id) lane: u32,
            @builtin(subgroup_size) size: u32,
        ) -> @location(0) vec4<f32> {
            let live = subgroupBallot(mask != 0u);
            let bits = countOneBits(live);
            var leader = size;
            var rank = 0u;
            for (var word = 0u; word < 4u; word++) {
                if leader == size && live[word] != 0u {
                    leader = word * 32u + countTrailingZeros(live[word]);
                }
                rank += countOneBits(live[word] & below(lane, word));
            }
            var first = 0u;
            if mask != 0u && lane == leader {
                first = atomicAdd(&next, bits.x + bits.y + bits.z + bits.w);
                atomicAdd(&leaders, 1u);
            }
            first = subgroupShuffle(first, min(leader, size - 1u));
            if mask != 0u {
                atomicAdd(&taken[first + rank], 1u);
            }
            return vec4<f32>(1.0);
        }";
    let draw = |fragment: &str| {
        let shader = Shader::new("small triangles", [SMALL_TRIANGLES, fragment].concat());
        Raster {
            color: vec![color("image", None, Load::Clear([0.0; 4]))],
            ..Raster::new(shader, Draw::Vertices { count: 300, instances: 1 })
        }
    };
    let targets = || vec![target("image", Format::R8Unorm, 61, 45)];
    let passes = vec![Pass::clear("clear", "counts"), Pass::raster("count", draw(COUNTING))];
    let counting = plan(vec![Buffer::new("counts", 4)], targets(), passes);
    let fragments = words_of(device, &counting, "counts")[0];
    assert!(fragments > 1000, "{fragments}");
    let passes = vec![
        Pass::clear("clear", "next"),
        Pass::clear("clear", "taken"),
        Pass::clear("clear", "leaders"),
        Pass::raster("capture", draw(append)),
    ];
    let buffers = vec![
        Buffer::new("next", 4),
        Buffer::new("taken", u64::from(fragments) * 8),
        Buffer::new("leaders", 4),
    ];
    let plan = plan(buffers, targets(), passes);
    if lacks(device, "subgroups in fragment", &plan) {
        return;
    }
    let id = ran(device, &plan);
    assert_eq!(to_words(&device.read(id, "next").expect("read"))[0], fragments);
    let taken = to_words(&device.read(id, "taken").expect("read"));
    let (once, never) = taken.split_at(fragments as usize);
    assert!(once.iter().all(|&times| times == 1), "each index is handed out once: {once:?}");
    assert!(never.iter().all(|&times| times == 0), "{never:?}");
    let leaders = to_words(&device.read(id, "leaders").expect("read"))[0];
    assert!(leaders < fragments, "{leaders} atomics for {fragments} fragments");
}

fn a_chain_of_64_bit_maxima_keeps_the_largest(device: &mut dyn Device) {
    const KEPT: usize = 4;
    const LAYERS: u32 = 16;
    let key = |layer: u32, pixel: u32| {
        let low = (layer * 7919 + pixel * 104_729).wrapping_mul(2_654_435_769);
        u64::from(low.rotate_left(9) ^ pixel) << 32 | u64::from(low)
    };
    let chain = "
        @group(0) @binding(0) var<storage, read_write> slots: array<atomic<u64>>;
        struct Layer { @builtin(position) at: vec4<f32>, @location(0) @interpolate(flat) id: u32 }
        @vertex fn vs(
            @builtin(vertex_index) i: u32, @builtin(instance_index) layer: u32,
        ) -> Layer {
            let at = vec2<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0);
            return Layer(vec4<f32>(at, 0.5, 1.0), layer);
        }
        @fragment fn fs(layer: Layer) -> @location(0) vec4<f32> {
            let pixel = u32(layer.at.y) * 8u + u32(layer.at.x);
            let low = (layer.id * 7919u + pixel * 104729u) * 2654435769u;
            var key = (u64((low << 9u | low >> 23u) ^ pixel) << 32u) | u64(low);
            for (var i = 0u; i < 4u; i++) {
                key = min(key, atomicMax(&slots[pixel * 4u + i], key));
            }
            return vec4<f32>(1.0);
        }";
    let raster = Raster {
        color: vec![color("image", None, Load::Clear([0.0; 4]))],
        ..Raster::new(Shader::new("chain", chain), Draw::Vertices { count: 3, instances: LAYERS })
    };
    let passes = vec![Pass::clear("clear", "slots"), Pass::raster("capture", raster)];
    let bytes = 8 * 5 * KEPT as u64 * 8;
    let targets = vec![target("image", Format::R8Unorm, 8, 5)];
    let plan = plan(vec![Buffer::new("slots", bytes)], targets, passes);
    if lacks(device, "64-bit atomics", &plan) {
        return;
    }
    let id = ran(device, &plan);
    let slots = device.read(id, "slots").expect("read");
    let slots: Vec<u64> = slots
        .chunks_exact(8)
        .map(|bytes| u64::from_le_bytes(bytes.try_into().expect("eight bytes")))
        .collect();
    for (pixel, kept) in (0..).zip(slots.chunks_exact(KEPT)) {
        let mut keys: Vec<u64> = (0..LAYERS).map(|layer| key(layer, pixel)).collect();
        keys.sort_unstable_by(|a, b| b.cmp(a));
        assert_eq!(kept, &keys[..KEPT], "pixel {pixel}");
    }
}

fn counts_fragments_with_atomics(device: &mut dyn Device) {
    // The target is a pretext: it is not written.
    let mut nothing = color("pretext", None, Load::Clear([0.0; 4]));
    nothing.write = false;
    let passes = vec![
        Pass::clear("clear", "counts"),
        Pass::raster("count", full_screen(COUNTING, vec![nothing])),
    ];
    let targets = vec![target("pretext", Format::R8Unorm, 37, 21)];
    let plan = plan(vec![Buffer::new("counts", 4)], targets, passes);
    let id = ran(device, &plan);
    assert_eq!(to_words(&device.read(id, "counts").expect("read"))[0], 37 * 21);
    assert_eq!(device.read(id, "pretext").expect("read"), [0; 37 * 21]);
}

fn draws_indexed_vertices(device: &mut dyn Device) {
    // The left half and the right half of the screen as quads of one vertex buffer.
    let wgsl = "
        struct Out {
            @builtin(position) at: vec4<f32>,
            @location(0) color: vec4<f32>,
            @location(1) @interpolate(flat) id: u32,
        }
        @vertex fn vs(
            @location(0) at: vec3<f32>,
            @location(1) color: vec4<f32>,
            @location(2) id: u32,
        ) -> Out {
            return Out(vec4<f32>(at, 1.0), color, id);
        }
        @fragment fn fs(in: Out) -> @location(0) vec4<f32> {
            return vec4<f32>(in.color.rgb, f32(in.id));
        }";
    let mut vertices = Vec::new();
    for (left, rgba, id) in [(-1.0_f32, [255, 0, 51, 255], 7_u32), (0.0, [0, 255, 0, 255], 9)] {
        for (x, y) in [(left, -1.0_f32), (left + 1.0, -1.0), (left, 1.0), (left + 1.0, 1.0)] {
            vertices.extend_from_slice(&floats(&[x, y, 0.5]));
            vertices.extend_from_slice(&rgba);
            vertices.extend_from_slice(&id.to_le_bytes());
        }
    }
    let attribute =
        |location, format, offset_bytes| VertexAttribute { location, format, offset_bytes };
    let attributes = vec![
        attribute(0, VertexFormat::Float32x3, 0),
        attribute(1, VertexFormat::Unorm8x4, 12),
        attribute(2, VertexFormat::Uint32, 16),
    ];
    let draw = Draw::Indexed {
        vertices: "vertices".to_owned(),
        layout: VertexLayout { stride_bytes: 20, attributes },
        indices: "indices".to_owned(),
        count: 12,
    };
    let raster = Raster {
        color: vec![color("image", None, Load::Clear([0.0; 4]))],
        ..Raster::new(Shader::new("indexed", wgsl), draw)
    };
    let buffers = vec![
        Buffer::data("vertices", vertices.into()),
        Buffer::data("indices", words(&[0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7])),
    ];
    let targets = vec![target("image", Format::Rgba32Float, 4, 2)];
    let id = ran(device, &plan(buffers, targets, vec![Pass::raster("draw", raster)]));
    let pixels = to_floats(&device.read(id, "image").expect("read"));
    let (left, right) = ([1.0, 0.0, 0.2, 7.0], [0.0, 1.0, 0.0, 9.0]);
    let expected = [left, left, right, right, left, left, right, right].concat();
    for (seen, expected) in pixels.iter().zip(&expected) {
        assert!((seen - expected).abs() < 1e-5, "{pixels:?}");
    }
}

/// Every format of colour holds what can be told exactly in it.
fn formats_hold_colours(device: &mut dyn Device) {
    let fragment = "@fragment fn fs() -> @location(0) vec4<f32> {
        return vec4<f32>(0.0, 1.0, 0.0, 1.0);
    }";
    let (one, half) = (1.0_f32.to_le_bytes(), 0x3C00_u16.to_le_bytes());
    let wide = [[0; 4], one, [0; 4], one].concat();
    let narrow = [[0; 2], half, [0; 2], half].concat();
    // 1 is 15 << 6 in the second eleven bits.
    let packed = (0x3C0_u32 << 11).to_le_bytes();
    for (format, expected) in [
        (Format::Rgba32Float, &wide[..]),
        (Format::Rgba16Float, &narrow[..]),
        (Format::Rg32Float, &wide[..8]),
        (Format::Rg16Float, &narrow[..4]),
        (Format::R32Float, &wide[..4]),
        (Format::R16Float, &narrow[..2]),
        (Format::Rg11b10Float, &packed[..]),
        (Format::Rgba8Unorm, &[0, 255, 0, 255][..]),
        (Format::R8Unorm, &[0][..]),
    ] {
        let draw = full_screen(fragment, vec![color("image", None, Load::Clear([0.5; 4]))]);
        let targets = vec![target("image", format, 3, 2)];
        let plan = plan(vec![], targets, vec![Pass::raster("draw", draw)]);
        if lacks(device, &format!("{format:?}"), &plan) {
            continue;
        }
        let id = ran(device, &plan);
        assert_eq!(device.read(id, "image").expect("read"), expected.repeat(6), "{format:?}");
    }
}

/// A compute pass says how much two draws draw, and calls the third off.
fn draws_what_a_buffer_says(device: &mut dyn Device) {
    let says = "
        @group(0) @binding(0) var<storage, read_write> said: array<u32>;
        @compute @workgroup_size(1) fn main() {
            let all = array<u32, 14>(3u, 1u, 0u, 0u, 6u, 1u, 0u, 0u, 0u, 3u, 0u, 0u, 0u, 0u);
            for (var i = 0u; i < 14u; i += 1u) { said[i] = all[i]; }
        }";
    let fragment = "@fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(0.25); }";
    let indirect = |offset_bytes| {
        let color = vec![color("image", Some(Blend::Add), Load::Keep)];
        let draw = Draw::VerticesIndirect { arguments: "said".to_owned(), offset_bytes, draws: 1 };
        Raster { draw, ..full_screen(fragment, color) }
    };
    let square = [-1.0, -1.0, 0.5, 1.0, -1.0, 0.5, -1.0, 1.0, 0.5, 1.0, 1.0, 0.5];
    let attribute =
        VertexAttribute { location: 0, format: VertexFormat::Float32x3, offset_bytes: 0 };
    let indexed = Raster {
        color: vec![color("image", Some(Blend::Add), Load::Keep)],
        ..Raster::new(
            Shader::new(
                "square",
                "@vertex fn vs(@location(0) at: vec3<f32>) -> @builtin(position) vec4<f32> {
                    return vec4<f32>(at, 1.0);
                }
                @fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(0.5); }",
            ),
            Draw::IndexedIndirect {
                vertices: "vertices".to_owned(),
                layout: VertexLayout { stride_bytes: 12, attributes: vec![attribute] },
                indices: "indices".to_owned(),
                arguments: "said".to_owned(),
                offset_bytes: 16,
            },
        )
    };
    let clear = full_screen(
        "@fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(); }",
        vec![color("image", None, Load::Clear([0.0; 4]))],
    );
    let passes = vec![
        compute("say", says, [1, 1, 1]),
        Pass::raster("draw", clear),
        Pass::raster("draw", indirect(0)),
        Pass::raster("draw", indexed),
        Pass::raster("draw", indirect(36)),
    ];
    let buffers = vec![
        Buffer::new("said", 56),
        Buffer::data("vertices", floats(&square)),
        Buffer::data("indices", words(&[0, 1, 2, 2, 1, 3])),
    ];
    let targets = vec![target("image", Format::Rgba16Float, 4, 2)];
    let id = ran(device, &plan(buffers, targets, passes));
    // 0.25 of the first, 0.5 of the second, none of the third.
    let three_quarters = 0x3A00_u16.to_le_bytes();
    assert_eq!(device.read(id, "image").expect("read"), three_quarters.repeat(4 * 8));
}

/// Draws of one pass tell themselves apart by their first instance, and count their vertices from
/// the first.
fn draws_many_times_from_a_buffer(device: &mut dyn Device) {
    let columns = "
        struct Out { @builtin(position) at: vec4<f32>, @location(0) @interpolate(flat) id: u32 }
        @vertex fn vs(
            @builtin(vertex_index) v: u32, @builtin(instance_index) i: u32,
        ) -> Out {
            let corner = array<vec2<u32>, 6>(
                vec2(0u, 0u), vec2(1u, 0u), vec2(0u, 1u), vec2(0u, 1u), vec2(1u, 0u), vec2(1u, 1u),
            )[v % 6u];
            let x = f32(i + corner.x) / 4.0 - 1.0;
            let at = vec4<f32>(x, f32(corner.y) * 2.0 - 1.0, 0.5, 1.0);
            return Out(at, i * 100u + v / 6u);
        }
        @fragment fn fs(in: Out) -> @location(0) u32 { return in.id; }";
    // Before them a word that no draw reads; the third draws nothing.
    let said = [
        [7, 7, 7, 7],
        [6, 1, 0, 3],
        [6, 2, 0, 5],
        [6, 0, 0, 2],
        [6, 1, 6, 1],
        // One more than the pass draws.
        [6, 1, 0, 0],
    ];
    let raster = Raster {
        color: vec![color("ids", None, Load::Clear([f32::INFINITY, 0.0, 0.0, 0.0]))],
        ..Raster::new(
            Shader::new("columns", columns),
            Draw::VerticesIndirect { arguments: "said".to_owned(), offset_bytes: 16, draws: 4 },
        )
    };
    let read = "
        @group(0) @binding(0) var ids: texture_2d<u32>;
        @group(0) @binding(1) var<storage, read_write> copied: array<u32>;
        @compute @workgroup_size(8, 2) fn main(
            @builtin(local_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32,
        ) {
            copied[i] = textureLoad(ids, id.xy, 0).x;
        }";
    let passes = vec![Pass::raster("draw", raster), compute("read", read, [1, 1, 1])];
    let buffers = vec![Buffer::data("said", words(&said.concat())), Buffer::new("copied", 64)];
    let plan = plan(buffers, vec![target("ids", Format::R32Uint, 8, 2)], passes);
    assert!(plan.to_string().contains("draws vertices 4 times, from said at byte 16 on"));
    for feature in ["several indirect draws in a pass", "first instance of indirect draws"] {
        if lacks(device, feature, &plan) {
            return;
        }
    }
    let id = ran(device, &plan);
    let none = u32::MAX;
    let row = [none, 101, none, 300, none, 500, 600, none];
    assert_eq!(to_words(&device.read(id, "ids").expect("read")), [row, row].concat());
    assert_eq!(to_words(&device.read(id, "copied").expect("read")), [row, row].concat());
}

/// A surface that leans although its triangle does not: tested and stored at the depth it writes,
/// whatever it promises of that depth.
fn fragments_write_depth(device: &mut dyn Device) {
    for (attribute, triangle) in [
        ("", 0.9),
        ("@early_depth_test(less_equal)", 1.0),
        ("@early_depth_test(greater_equal)", 0.0),
    ] {
        let wgsl = format!(
            "{}
            struct Out {{ @location(0) color: vec4<f32>, @builtin(frag_depth) depth: f32 }}
            @fragment {attribute} fn fs(@builtin(position) at: vec4<f32>) -> Out {{
                return Out(vec4<f32>(1.0), at.x / 16.0);
            }}",
            FULL_SCREEN.replace("0.5, 1.0", &format!("{triangle:?}, 1.0"))
        );
        let depth = Some(Depth { load: Load::Clear(0.5), compare: Compare::Less, write: true });
        let raster = Raster {
            depth_stencil: Some(DepthStencil { target: "depth".to_owned(), depth, stencil: None }),
            color: vec![color("image", None, Load::Clear([0.0; 4]))],
            ..Raster::new(Shader::new("leaning", wgsl), Draw::Vertices { count: 3, instances: 1 })
        };
        let targets = vec![
            target("image", Format::R8Unorm, 16, 2),
            target("depth", Format::Depth32Float, 16, 2),
        ];
        let plan = plan(vec![], targets, vec![Pass::raster("draw", raster)]);
        let id = match device.prepare(&plan) {
            Ok(id) => id,
            Err(GpuError::Unsupported(reason)) if !attribute.is_empty() => {
                eprintln!("{}: not checked: {reason}", device.info().id);
                continue;
            }
            Err(error) => panic!("{attribute}: {error}"),
        };
        device.run(id).expect("ran");
        let image = device.read(id, "image").expect("read");
        let depths = to_floats(&device.read(id, "depth").expect("read"));
        for (i, (color, depth)) in image.into_iter().zip(depths).enumerate() {
            let (x, written) = (i % 16, ((i % 16) as f32 + 0.5) / 16.0);
            assert_eq!(color, if x < 8 { 255 } else { 0 }, "{attribute}: {i}");
            let expected = if x < 8 { written } else { 0.5 };
            assert!((depth - expected).abs() < 1e-6, "{attribute}: {i}: {depth}");
        }
    }
}

/// All that a pass may draw to at once, of floats and of integers.
fn draws_to_eight_targets(device: &mut dyn Device) {
    let wgsl = "
        struct Out {
            @location(0) a: vec4<f32>,
            @location(1) b: vec4<f32>,
            @location(2) c: vec4<f32>,
            @location(3) d: f32,
            @location(4) e: vec2<f32>,
            @location(5) f: u32,
            @location(6) g: vec4<u32>,
            @location(7) h: vec4<f32>,
        }
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> Out {
            let x = u32(at.x);
            return Out(
                vec4<f32>(1.0, 2.0, 3.0, at.x), vec4<f32>(0.0, 1.0, 0.0, 1.0),
                vec4<f32>(1.0, 0.0, 1.0, 0.0), at.y, vec2<f32>(1.0, 0.0), 0xFFFFFF00u + x,
                vec4<u32>(1u, 2u, 0xFFFFFFFFu, x), vec4<f32>(4.0),
            );
        }";
    let formats = [
        Format::Rgba32Float,
        Format::Rgba16Float,
        Format::Rgba8Unorm,
        Format::R32Float,
        Format::Rg16Float,
        Format::R32Uint,
        Format::Rgba32Uint,
        Format::R32Float,
    ];
    let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
    let attach = |name: &&str| color(name, None, Load::Clear([0.0; 4]));
    let raster = full_screen(wgsl, names.iter().map(attach).collect());
    let targets = names.iter().zip(formats).map(|(name, format)| target(name, format, 2, 1));
    let plan = plan(vec![], targets.collect(), vec![Pass::raster("draw", raster)]);
    let id = match device.prepare(&plan) {
        Ok(id) => id,
        Err(GpuError::Unsupported(reason)) => {
            assert!(reason.contains("colour targets"), "{reason}");
            eprintln!("{}: not checked: {reason}", device.info().id);
            return;
        }
        Err(error) => panic!("{error}"),
    };
    device.run(id).expect("ran");
    let mut read = |name| device.read(id, name).expect("read");
    assert_eq!(to_floats(&read("a")), [1.0, 2.0, 3.0, 0.5, 1.0, 2.0, 3.0, 1.5]);
    let half =
        |values: &[u16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    assert_eq!(read("b"), half(&[0, 0x3C00, 0, 0x3C00, 0, 0x3C00, 0, 0x3C00]));
    assert_eq!(read("c"), [255, 0, 255, 0, 255, 0, 255, 0]);
    assert_eq!(to_floats(&read("d")), [0.5, 0.5]);
    assert_eq!(read("e"), half(&[0x3C00, 0, 0x3C00, 0]));
    assert_eq!(to_words(&read("f")), [0xFFFF_FF00, 0xFFFF_FF01]);
    assert_eq!(to_words(&read("g")), [1, 2, u32::MAX, 0, 1, 2, u32::MAX, 1]);
    assert_eq!(to_floats(&read("h")), [4.0, 4.0]);
}

/// Columns of the screen's upper half, by stages in GLSL: of each pair of a buffer `columns`, the
/// second in the column that the first says. `fs` writes what it is given to the target `ids`.
fn columns(pre_raster: PreRaster, draw: Draw) -> Plan {
    // A vertex stage that is not used may stand there.
    let fragment = "
        @vertex fn vs() -> @builtin(position) vec4<f32> { return vec4<f32>(0.0); }
        @fragment fn fs(@location(1) @interpolate(flat) id: u32) -> @location(0) u32 { return id; }";
    let raster = Raster {
        pre_raster,
        color: vec![color("ids", None, Load::Clear([0.0; 4]))],
        ..Raster::new(Shader::new("columns", fragment), draw)
    };
    let columns = Buffer::data("columns", words(&[2, 100, 7, 0xFFFF_FFFF, 4, 300]));
    plan(
        vec![columns],
        vec![target("ids", Format::R32Uint, 8, 4)],
        vec![Pass::raster("draw", raster)],
    )
}

const DRAWN_COLUMNS: [u32; 8] = [0, 0, 100, 0, 300, 0, 0, u32::MAX];

fn assert_columns_are_drawn(device: &mut dyn Device, plan: &Plan) {
    let ids = words_of(device, plan, "ids");
    let none = [0; 8];
    assert_eq!(ids, [DRAWN_COLUMNS, DRAWN_COLUMNS, none, none].concat());
}

const COLUMNS: &str = "
layout(set = 0, binding = 0, std430) readonly buffer Columns { uvec2 of[]; } columns;
vec4 corner(uint column, vec2 at) {
    return vec4((float(column) + at.x) / 4.0 - 1.0, at.y, 0.5, 1.0);
}
";

/// GLSL for Vulkan with [`COLUMNS`] after the version.
fn glsl(extension: &str, source: &str) -> Arc<str> {
    format!("#version 460\n{extension}\n{COLUMNS}{source}").into()
}

fn geometry_stages_make_squares_of_points(device: &mut dyn Device) {
    let plan = geometry_columns();
    let listed = plan.to_string();
    assert!(listed.contains("stages in GLSL: vertex, geometry; of points"), "{listed}");
    assert!(listed.contains("    reads columns\n"), "{listed}");
    if !lacks(device, "geometry shader", &plan) {
        assert_columns_are_drawn(device, &plan);
    }
}

fn geometry_columns() -> Plan {
    let vertex = "#version 460
        layout(location = 0) flat out int number;
        void main() { number = gl_VertexIndex; gl_Position = vec4(0.0, 0.0, 0.5, 1.0); }";
    let geometry = "
        layout(points) in;
        layout(triangle_strip, max_vertices = 4) out;
        layout(location = 0) flat in int number[];
        layout(location = 1) flat out uint id;
        void main() {
            uvec2 column = columns.of[number[0]];
            for (int i = 0; i < 4; ++i) {
                id = column.y;
                gl_Position = corner(column.x, vec2(i & 1, i >> 1));
                EmitVertex();
            }
        }";
    let stages = PreRaster::from(Glsl {
        topology: Topology::Points,
        vertex: vertex.into(),
        tessellation: None,
        geometry: Some(glsl("", geometry)),
    });
    columns(stages, Draw::Vertices { count: 3, instances: 1 })
}

fn tessellation_stages_make_a_grid(device: &mut dyn Device) {
    let vertex = "#version 460
        layout(location = 0) out int number;
        void main() { number = gl_VertexIndex; gl_Position = vec4(0.0, 0.0, 0.5, 1.0); }";
    let control = "#version 460
        layout(vertices = 1) out;
        layout(location = 0) in int number[];
        layout(location = 0) out int patch_number[];
        void main() {
            patch_number[gl_InvocationID] = number[gl_InvocationID];
            for (int i = 0; i < 4; ++i) gl_TessLevelOuter[i] = 4.0;
            for (int i = 0; i < 2; ++i) gl_TessLevelInner[i] = 4.0;
        }";
    let evaluation = "
        layout(quads, equal_spacing) in;
        layout(location = 0) in int patch_number[];
        layout(location = 1) flat out uint id;
        void main() {
            uvec2 column = columns.of[patch_number[0]];
            id = column.y;
            gl_Position = corner(column.x, gl_TessCoord.xy);
        }";
    let both = Tessellation { control: control.into(), evaluation: glsl("", evaluation) };
    let stages = PreRaster::from(Glsl {
        topology: Topology::Patches(1),
        vertex: vertex.into(),
        tessellation: Some(both),
        geometry: None,
    });
    let plan = columns(stages, Draw::Vertices { count: 3, instances: 1 });
    if !lacks(device, "tessellation shader", &plan) {
        assert_columns_are_drawn(device, &plan);
    }
}

/// Three columns of 8 pixels by a geometry stage, and four screens of 37 x 21 before them, by a plan
/// that also does what is no raster pass.
fn counts_what_each_raster_pass_does(device: &mut dyn Device) {
    let draw = Draw::Vertices { count: 3, instances: 4 };
    let color = vec![color("image", None, Load::Clear([0.0; 4]))];
    let screens = Raster { draw, ..full_screen(COUNTING, color) };
    let passes = vec![Pass::clear("clear", "counts"), Pass::raster("count", screens)];
    let targets = vec![target("image", Format::R8Unorm, 37, 21)];
    let plan = plan(vec![Buffer::new("counts", 4)], targets, passes);
    let id = device.prepare(&plan).expect("prepared");
    device.poison(id).expect("poisoned");
    let lacking = &device.info().unsupported;
    if lacking.iter().any(|missing| missing.feature == "pipeline statistics") {
        let refused = device.statistics(id);
        assert!(matches!(refused, Err(GpuError::Unsupported(_))), "{refused:?}");
        return;
    }
    for _ in 0..2 {
        let counted = device.statistics(id).expect("counted");
        let [counted] = &counted[..] else { panic!("one raster pass: {counted:?}") };
        assert_eq!(counted.pass, 1);
        assert_eq!((counted.geometry_invocations, counted.tessellation_patches), (None, None));
        assert!(counted.vertex_invocations >= 3, "{counted:?}");
        assert_eq!(counted.clipping_invocations, 4, "{counted:?}");
        assert!(counted.clipping_primitives >= 4, "{counted:?}");
        // Quads that are partly outside may be counted in full.
        assert!((4 * 37 * 21..=4 * 38 * 22 * 2).contains(&counted.fragment_invocations));
        assert!(counted.input_vertices.is_none_or(|vertices| vertices == 12), "{counted:?}");
        assert!(counted.input_primitives.is_none_or(|primitives| primitives == 4), "{counted:?}");
        // It is a run like any other.
        assert_eq!(to_words(&device.read(id, "counts").expect("read"))[0], 4 * 37 * 21);
    }
    assert!(device.run(id).expect("ran").stages.len() <= 2);
    let empty = device.prepare(&self::plan(vec![], vec![], vec![])).expect("prepared");
    assert_eq!(device.statistics(empty).expect("counted"), []);
    let geometry = geometry_columns();
    if lacks(device, "geometry shader", &geometry) {
        return;
    }
    let id = device.prepare(&geometry).expect("prepared");
    let counted = &device.statistics(id).expect("counted")[0];
    assert_eq!((counted.input_vertices, counted.vertex_invocations), (Some(3), 3), "{counted:?}");
    assert_eq!(counted.geometry_invocations, Some(3), "{counted:?}");
    assert_eq!(counted.geometry_primitives, Some(6), "{counted:?}");
    assert!(counted.fragment_invocations >= 6, "{counted:?}");
}

fn mesh_stages_make_squares(device: &mut dyn Device) {
    let task = "
        struct First { uint column; };
        taskPayloadSharedEXT First first;
        layout(local_size_x = 1) in;
        void main() {
            first.column = gl_WorkGroupID.x;
            EmitMeshTasksEXT(1, 1, 1);
        }";
    let mesh = |column: &str, payload: &str| {
        let source = format!(
            "{payload}
            layout(local_size_x = 4) in;
            layout(triangles, max_vertices = 4, max_primitives = 2) out;
            // What `fs` reads is of a vertex: WGSL has no other.
            layout(location = 1) flat out uint id[];
            void main() {{
                uvec2 column = columns.of[{column}];
                uint i = gl_LocalInvocationIndex;
                SetMeshOutputsEXT(4, 2);
                id[i] = column.y;
                gl_MeshVerticesEXT[i].gl_Position = corner(column.x, vec2(i & 1, i >> 1));
                if (i < 2) {{
                    gl_PrimitiveTriangleIndicesEXT[i] = uvec3(i, i + 1, i + 2);
                }}
            }}"
        );
        glsl("#extension GL_EXT_mesh_shader : require", &source)
    };
    let payload = "struct First { uint column; }; taskPayloadSharedEXT First first;";
    let alone = Mesh { task: None, mesh: mesh("gl_WorkGroupID.x", "") };
    let task = glsl("#extension GL_EXT_mesh_shader : require", task);
    let after = Mesh { task: Some(task), mesh: mesh("first.column", payload) };
    for stages in [alone, after] {
        let draw = Draw::Mesh { workgroups: [3, 1, 1] };
        let plan = columns(stages.into(), draw);
        if !lacks(device, "mesh shaders", &plan) {
            assert_columns_are_drawn(device, &plan);
        }
    }
}

fn points_are_as_large_as_told(device: &mut dyn Device) {
    let vertex = "#version 460
        layout(location = 1) flat out uint id;
        void main() {
            id = 5;
            gl_PointSize = 3.0;
            gl_Position = vec4(0.125, 0.25, 0.5, 1.0);
        }";
    let stages = PreRaster::from(Glsl {
        topology: Topology::Points,
        vertex: vertex.into(),
        tessellation: None,
        geometry: None,
    });
    let plan = columns(stages, Draw::Vertices { count: 1, instances: 1 });
    if device.info().backend == "wgpu" {
        let refused = device.prepare(&plan);
        assert!(matches!(refused, Err(GpuError::Unsupported(_))), "{refused:?}");
        return;
    }
    // In pixel 4 of row 1.
    let ids = words_of(device, &plan, "ids");
    let row = [0, 0, 0, 5, 5, 5, 0, 0];
    assert_eq!(ids, [row, row, row, [0; 8]].concat());
}

/// Without a result, as a framebuffer of depth and object in one word wants them, in both stages.
fn minima_and_maxima_of_64_bits(device: &mut dyn Device) {
    const ATOMICS: &str = "
        @group(0) @binding(0) var<storage, read_write> most: array<atomic<u64>>;
        @group(0) @binding(1) var<storage, read_write> least: array<atomic<u64>>;
        fn note(i: u32, key: u64) {
            atomicMax(&most[i], key);
            atomicMin(&least[i], key);
        }";
    // 64 keys, of which the first is the smallest by its upper half and the last the largest.
    let init = "
        @group(0) @binding(0) var<storage, read_write> most: array<u64>;
        @group(0) @binding(1) var<storage, read_write> least: array<u64>;
        @compute @workgroup_size(2) fn main(@builtin(local_invocation_index) i: u32) {
            most[i] = 0lu;
            least[i] = 0xFFFFFFFFFFFFFFFFlu;
        }";
    let keys = "
        @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) i: u32) {
            note(0u, (u64(i + 5u) << 32u) | u64(1000u - i));
        }";
    let fragment = "
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            let i = u32(at.y) * 8u + u32(at.x);
            note(1u, (u64(i + 7u) << 32u) | u64(2000u - i));
            return vec4<f32>(1.0);
        }";
    let image = vec![color("image", None, Load::Clear([0.0; 4]))];
    let passes = vec![
        compute("init", init, [1, 1, 1]),
        compute("keys", &[ATOMICS, keys].concat(), [1, 1, 1]),
        Pass::raster("draw", full_screen(&[ATOMICS, fragment].concat(), image)),
    ];
    let targets = vec![target("image", Format::R8Unorm, 8, 4)];
    let plan = plan(vec![Buffer::new("most", 16), Buffer::new("least", 16)], targets, passes);
    if lacks(device, "64-bit atomic minimum and maximum", &plan) {
        return;
    }
    let id = ran(device, &plan);
    let mut read = |name| to_words(&device.read(id, name).expect("read"));
    assert_eq!(read("least"), [1000, 5, 2000, 7]);
    assert_eq!(read("most"), [1000 - 63, 5 + 63, 2000 - 31, 7 + 31]);
}

fn row_0_is_the_top_and_y_is_up(device: &mut dyn Device) {
    // A triangle whose y is above 0.5: it covers the upper quarter.
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> rows: array<u32>;
        @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
            return vec4<f32>(f32(i & 1u) * 8.0 - 1.0, 0.5 + f32(i & 2u) * 4.0, 0.5, 1.0);
        }
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            rows[u32(at.y)] = u32(at.y) + 100u;
            return vec4<f32>(1.0);
        }";
    let raster = Raster {
        shader: Shader::new("upper quarter", wgsl),
        ..full_screen("", vec![color("image", None, Load::Clear([0.0; 4]))])
    };
    let passes = vec![Pass::clear("clear", "rows"), Pass::raster("draw", raster)];
    let targets = vec![target("image", Format::R8Unorm, 4, 8)];
    let id = ran(device, &plan(vec![Buffer::new("rows", 32)], targets, passes));
    let image = device.read(id, "image").expect("read");
    assert_eq!(image, [[255; 8].as_slice(), &[0; 24]].concat());
    let rows = to_words(&device.read(id, "rows").expect("read"));
    assert_eq!(rows, [100, 101, 0, 0, 0, 0, 0, 0]);
}

/// Marks the left half of a stencil target with 3, then counts where it is 3 and where it is not.
fn stencil_plan() -> Plan {
    let mark = "
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            if at.x >= 24.0 { discard; }
            return vec4<f32>(1.0);
        }";
    let image = || vec![color("image", Some(Blend::Add), Load::Keep)];
    let masked = |clear, compare, pass, fail, mut raster: Raster| {
        let stencil = Some(Stencil { clear, compare, reference: 3, pass, fail });
        raster.depth_stencil =
            Some(DepthStencil { target: "mask".to_owned(), depth: None, stencil });
        raster
    };
    let (keep, replace) = (StencilOp::Keep, StencilOp::Replace);
    let cleared = vec![color("image", None, Load::Clear([0.0; 4]))];
    let count = || full_screen(COUNTING, image());
    let passes = vec![
        Pass::clear("clear", "counts"),
        Pass::raster(
            "mask",
            masked(Some(0), Compare::Always, replace, keep, full_screen(mark, cleared)),
        ),
        Pass::raster("resolve", masked(None, Compare::Equal, keep, keep, count())),
        // 3 becomes 0 where it passes, 0 becomes 1 where it fails.
        Pass::raster(
            "resolve",
            masked(None, Compare::Equal, StencilOp::Zero, StencilOp::IncrementClamp, count()),
        ),
        // 3 <= 1 nowhere: the count stays.
        Pass::raster("resolve", masked(None, Compare::LessEqual, keep, keep, count())),
        // 3 > 1 and 3 > 0 everywhere.
        Pass::raster("resolve", masked(None, Compare::Greater, keep, keep, count())),
    ];
    let targets = vec![
        target("mask", Format::Stencil8, 40, 30),
        target("image", Format::Rgba16Float, 40, 30),
    ];
    plan(vec![Buffer::new("counts", 4)], targets, passes)
}

fn stencil_rejects_before_the_shader_writes(device: &mut dyn Device) {
    let id = ran(device, &stencil_plan());
    let counts = to_words(&device.read(id, "counts").expect("read"));
    assert_eq!(counts[0], 2 * 24 * 30 + 40 * 30);
    let mask = device.read(id, "mask").expect("read");
    let row = [[0; 24].as_slice(), &[1; 16]].concat();
    assert_eq!(mask, row.repeat(30));
}

fn depth_rejects_before_the_shader_writes(device: &mut dyn Device) {
    // A plane that leans: its depth is x, drawn over 0.5 with each comparison.
    let wgsl = format!(
        "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
            let x = f32(i & 1u) * 4.0 - 1.0;
            return vec4<f32>(x, f32(i & 2u) * 2.0 - 1.0, (x + 1.0) * 0.25, 1.0);
        }}{COUNTING}"
    );
    let draw = |load, compare, write| {
        let depth = Some(Depth { load, compare, write });
        let raster = Raster {
            shader: Shader::new("leaning", wgsl.as_str()),
            depth_stencil: Some(DepthStencil { target: "depth".to_owned(), depth, stencil: None }),
            ..full_screen("", vec![color("image", None, Load::Clear([0.0; 4]))])
        };
        vec![Pass::clear("clear", "counts"), Pass::raster("draw", raster)]
    };
    let targets =
        vec![target("depth", Format::Depth32Float, 16, 4), target("image", Format::R8Unorm, 16, 4)];
    let counted = |device: &mut dyn Device, passes| {
        let plan = plan(vec![Buffer::new("counts", 4)], targets.clone(), passes);
        let id = ran(device, &plan);
        let counts = to_words(&device.read(id, "counts").expect("read"));
        (counts[0], to_floats(&device.read(id, "depth").expect("read")))
    };
    // Depth at the middle of column i is (i + 0.5) / 32, from 0.016 to 0.484.
    let (count, depth) = counted(device, draw(Load::Clear(0.25), Compare::Less, false));
    assert_eq!((count, depth), (8 * 4, vec![0.25; 64]));
    let (count, depth) = counted(device, draw(Load::Clear(0.25), Compare::Greater, true));
    assert_eq!(count, 8 * 4);
    for (i, depth) in depth.into_iter().enumerate() {
        let expected = (((i % 16) as f32 + 0.5) / 32.0).max(0.25);
        assert!((depth - expected).abs() < 1e-6, "{i}: {depth}");
    }
    let (count, _) = counted(device, draw(Load::Keep, Compare::GreaterEqual, false));
    assert_eq!(count, 8 * 4);
}

fn clips_at_both_planes(device: &mut dyn Device) {
    // Depth runs from -1 to 3 over the screen's width and twice that: a quarter lies in 0 to 1.
    let wgsl = format!(
        "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
            let x = f32(i & 1u) * 4.0 - 1.0;
            return vec4<f32>(x, f32(i & 2u) * 2.0 - 1.0, x * 2.0 + 1.0, 1.0);
        }}{}",
        COUNTING.replace("@early_depth_test(force)", "")
    );
    let raster = Raster {
        shader: Shader::new("steep", wgsl),
        ..full_screen("", vec![color("image", None, Load::Clear([0.0; 4]))])
    };
    let passes = vec![Pass::clear("clear", "counts"), Pass::raster("draw", raster)];
    let targets = vec![target("image", Format::R8Unorm, 32, 4)];
    let plan = plan(vec![Buffer::new("counts", 4)], targets, passes);
    assert_eq!(words_of(device, &plan, "counts")[0], 8 * 4);
}

fn unclipped_draws_past_both_planes(device: &mut dyn Device) {
    // Depth at the middle of column i is (i - 7.5) / 8, from -0.94 to 2.94.
    let wgsl = format!(
        "@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
            let x = f32(i & 1u) * 4.0 - 1.0;
            return vec4<f32>(x, f32(i & 2u) * 2.0 - 1.0, x * 2.0 + 1.0, 1.0);
        }}{COUNTING}"
    );
    let depth = Some(Depth { load: Load::Clear(0.0), compare: Compare::Always, write: true });
    let steep = |unclipped| {
        let raster = Raster {
            shader: Shader::new("steep", wgsl.as_str()),
            depth_stencil: Some(DepthStencil { target: "depth".to_owned(), depth, stencil: None }),
            unclipped,
            ..full_screen("", vec![color("image", None, Load::Clear([0.0; 4]))])
        };
        let passes = vec![Pass::clear("clear", "counts"), Pass::raster("draw", raster)];
        let targets = vec![
            target("image", Format::R8Unorm, 32, 4),
            target("depth", Format::Depth32Float, 32, 4),
        ];
        plan(vec![Buffer::new("counts", 4)], targets, passes)
    };
    assert_eq!(words_of(device, &steep(false), "counts")[0], 8 * 4);
    if lacks(device, "unclipped depth", &steep(true)) {
        return;
    }
    let id = ran(device, &steep(true));
    assert_eq!(to_words(&device.read(id, "counts").expect("read"))[0], 32 * 4);
    let depths = to_floats(&device.read(id, "depth").expect("read"));
    for (i, depth) in (0..).zip(depths) {
        let expected = (((i % 32) as f32 - 7.5) / 8.0).clamp(0.0, 1.0);
        assert!((depth - expected).abs() < 1e-6, "{i}: {depth}");
    }
    // The pipelines of both are kept side by side.
    assert_eq!(words_of(device, &steep(false), "counts")[0], 8 * 4);
}

fn late_writes_show_the_rejected(device: &mut dyn Device) {
    let late = COUNTING.replace("@early_depth_test(force)", "");
    let compare = |compare| {
        let (clear, pass, fail) = (Some(0), StencilOp::Keep, StencilOp::Keep);
        let stencil = Some(Stencil { clear, compare, reference: 1, pass, fail });
        let raster = Raster {
            depth_stencil: Some(DepthStencil { target: "mask".to_owned(), depth: None, stencil }),
            late_writes: true,
            ..full_screen(&late, vec![color("image", None, Load::Clear([0.0; 4]))])
        };
        let passes = vec![Pass::clear("clear", "counts"), Pass::raster("draw", raster)];
        let targets =
            vec![target("image", Format::R8Unorm, 8, 4), target("mask", Format::Stencil8, 8, 4)];
        plan(vec![Buffer::new("counts", 4)], targets, passes)
    };
    for test in [Compare::Greater, Compare::Equal] {
        let id = ran(device, &compare(test));
        assert_eq!(to_words(&device.read(id, "counts").expect("read"))[0], 8 * 4, "{test:?}");
        let drawn = if test == Compare::Greater { 255 } else { 0 };
        assert_eq!(device.read(id, "image").expect("read"), [drawn; 8 * 4]);
    }
}

fn blends(device: &mut dyn Device) {
    let fill = |rgba: [f32; 4], blend, load| {
        let fragment = format!(
            "@fragment fn fs() -> @location(0) vec4<f32> {{ return vec4<f32>({}); }}",
            rgba.map(|value| format!("{value:?}")).join(", ")
        );
        Pass::raster("draw", full_screen(&fragment, vec![color("image", blend, load)]))
    };
    let clear = Load::Clear([0.25, 0.5, 0.0, 0.5]);
    for (blend, expected) in [
        (None, [0.5, 0.25, 0.125, 0.75]),
        (Some(Blend::Add), [0.75, 0.75, 0.125, 1.25]),
        (Some(Blend::Max), [0.5, 0.5, 0.125, 0.75]),
        (Some(Blend::Min), [0.25, 0.25, 0.0, 0.5]),
        (Some(Blend::Over), [0.5625, 0.375, 0.125, 0.875]),
        (Some(Blend::Under), [0.5, 0.625, 0.0625, 0.875]),
        (Some(Blend::Attenuate), [0.125, 0.375, 0.0, 0.125]),
    ] {
        let passes = vec![fill([0.5, 0.25, 0.125, 0.75], blend, clear)];
        let targets = vec![target("image", Format::Rgba32Float, 2, 2)];
        let id = ran(device, &plan(vec![], targets, passes.clone()));
        let image = to_floats(&device.read(id, "image").expect("read"));
        assert_eq!(image, expected.repeat(4), "{blend:?}");
        // In half floats the same numbers are exact too.
        let targets = vec![target("image", Format::Rgba16Float, 2, 2)];
        let id = ran(device, &plan(vec![], targets, passes));
        let half = |value: f32| {
            let bits = value.to_bits();
            let exponent = (bits >> 23) as i32 - 127 + 15;
            if value == 0.0 { 0 } else { (exponent as u16) << 10 | (bits >> 13 & 0x3FF) as u16 }
        };
        let expected: Vec<u8> = expected.iter().flat_map(|&v| half(v).to_le_bytes()).collect();
        assert_eq!(device.read(id, "image").expect("read"), expected.repeat(4), "{blend:?}");
    }
}

fn counts_by_blending_as_by_atomics(device: &mut dyn Device) {
    let one = "@fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }";
    let atomic = "
        @group(0) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            atomicAdd(&counts[u32(at.y) * 61u + u32(at.x)], 1u);
            return vec4<f32>(1.0);
        }";
    let copy = "
        @group(0) @binding(0) var depth_complexity: texture_2d<f32>;
        @group(0) @binding(1) var<storage, read_write> copied: array<u32>;
        @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            let size = textureDimensions(depth_complexity);
            if id.x < size.x && id.y < size.y {
                copied[id.y * size.x + id.x] = u32(textureLoad(depth_complexity, id.xy, 0).x);
            }
        }";
    let draw = |fragment: &str, target: &str, blend| {
        let shader = Shader::new("small triangles", [SMALL_TRIANGLES, fragment].concat());
        let color = vec![color(target, blend, Load::Clear([0.0; 4]))];
        Raster { color, ..Raster::new(shader, Draw::Vertices { count: 300, instances: 1 }) }
    };
    let passes = vec![
        Pass::raster("count", draw(one, "depth_complexity", Some(Blend::Add))),
        compute("copy", copy, [8, 6, 1]),
        Pass::clear("clear", "counts"),
        Pass::raster("count", draw(atomic, "pretext", None)),
    ];
    let targets = vec![
        target("depth_complexity", Format::R32Float, 61, 45),
        target("pretext", Format::R8Unorm, 61, 45),
    ];
    let bytes = 61 * 45 * 4;
    let buffers = vec![Buffer::new("copied", bytes), Buffer::new("counts", bytes)];
    let plan = plan(buffers, targets, passes);
    if lacks(device, "32-bit float blending", &plan) {
        return;
    }
    let id = device.prepare(&plan).expect("prepared");
    for _ in 0..2 {
        device.poison(id).expect("poisoned");
        device.run(id).expect("ran");
        let counts = to_words(&device.read(id, "counts").expect("read"));
        assert!(counts.iter().any(|&count| count > 3), "{counts:?}");
        assert_eq!(to_words(&device.read(id, "copied").expect("read")), counts);
        let blended = to_floats(&device.read(id, "depth_complexity").expect("read"));
        assert!(blended.iter().zip(&counts).all(|(&sum, &count)| sum == count as f32));
    }
}

fn shaders_read_targets(device: &mut dyn Device) {
    // Each pixel's place in sixteenths, which every format holds exactly enough; then read by a
    // raster pass, by a vertex shader too, turned upside down, and that again by a compute pass.
    let place = "
        @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
            return vec4<f32>(floor(at.x) + floor(at.y) * 4.0, at.x, at.y, 8.0) / 16.0;
        }";
    let turn = "
        @group(0) @binding(2) var first: texture_2d<f32>;
        struct Out { @builtin(position) at: vec4<f32>, @location(0) @interpolate(flat) last: f32 }
        @vertex fn vs(@builtin(vertex_index) i: u32) -> Out {
            let at = vec2<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0);
            return Out(vec4<f32>(at, 0.5, 1.0), textureLoad(first, vec2<i32>(3, 2), 0).x);
        }
        @fragment fn fs(in: Out) -> @location(0) vec4<f32> {
            // Turned before it is made an integer: at `2 - i32(y)` NVIDIA's driver 580 reads nothing.
            let pixel = vec2<i32>(vec2<f32>(in.at.x, 3.0 - in.at.y));
            return vec4<f32>(textureLoad(first, pixel, 0).xyz, in.last);
        }";
    let copy = "
        @group(1) @binding(0) var second: texture_2d<f32>;
        @group(0) @binding(1) var<storage, read_write> copied: array<vec4<f32>>;
        @compute @workgroup_size(4, 3) fn main(
            @builtin(local_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32,
        ) {
            copied[i] = textureLoad(second, id.xy, 0);
        }";
    for format in [Format::Rgba32Float, Format::Rgba16Float, Format::R32Float, Format::R8Unorm] {
        let draw = |fragment, target| {
            full_screen(fragment, vec![color(target, None, Load::Clear([0.0; 4]))])
        };
        let turned = Raster { shader: Shader::new("turn", turn), ..draw("", "second") };
        let passes = vec![
            Pass::raster("draw", draw(place, "first")),
            Pass::raster("draw", turned),
            compute("copy", copy, [1, 1, 1]),
            // Drawn to again, after it was read.
            Pass::raster("draw", draw(place, "second")),
        ];
        let targets = vec![target("first", format, 4, 3), target("second", format, 4, 3)];
        let id = ran(device, &plan(vec![Buffer::new("copied", 4 * 3 * 16)], targets, passes));
        let copied = to_floats(&device.read(id, "copied").expect("read"));
        for (i, rgba) in copied.chunks_exact(4).enumerate() {
            let (x, y) = (i % 4, 2 - i / 4);
            let at = |place: usize| (place as f32 + 0.5) / 16.0;
            let mut expected = [(x + y * 4) as f32 / 16.0, at(x), at(y), 11.0 / 16.0];
            if matches!(format, Format::R32Float | Format::R8Unorm) {
                expected[1..].copy_from_slice(&[0.0, 0.0, 1.0]);
            }
            for (seen, expected) in rgba.iter().zip(expected) {
                assert!((seen - expected).abs() < 0.51 / 255.0, "{format:?}: {i}: {rgba:?}");
            }
        }
        let first = device.read(id, "first").expect("read");
        assert_eq!(first, device.read(id, "second").expect("read"), "{format:?}");
    }
}

fn poisons_what_has_no_given_contents(device: &mut dyn Device) {
    let plan = naming_plan();
    let id = ran(device, &plan);
    device.poison(id).expect("poisoned");
    assert_eq!(device.read(id, "output").expect("read"), [0xCD; 400]);
    assert_eq!(device.read(id, "scale").expect("read"), words(&[3, 7]).to_vec());
    device.run(id).expect("ran");
    assert_eq!(to_words(&device.read(id, "output").expect("read"))[99], 99 * 3 + 7);
}

fn plans_share_buffers_by_name_and_size(device: &mut dyn Device) {
    let of = |bytes, passes| plan(vec![Buffer::new("both", bytes)], vec![], passes);
    let write = "
        @group(0) @binding(0) var<storage, read_write> both: array<u32>;
        @compute @workgroup_size(1) fn main() { both[0] = 4711u; }";
    let write = of(64, vec![compute("write", write, [1, 1, 1])]);
    let same = device.prepare(&of(64, vec![])).expect("prepared");
    let other = device.prepare(&of(128, vec![])).expect("prepared");
    for id in [same, other] {
        device.poison(id).expect("poisoned");
    }
    ran(device, &write);
    let first = |device: &mut dyn Device, id| to_words(&device.read(id, "both").expect("read"))[0];
    assert_eq!(first(device, same), 4711);
    assert_eq!(first(device, other), 0xCDCD_CDCD);
}

/// A plan that counts from `first` in threes into a buffer of this name, and clears another.
fn counting(name: &str, first: u32) -> Plan {
    let wgsl = format!(
        "@group(0) @binding(0) var<storage, read_write> {name}: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            {name}[id.x] = {first}u + 3u * id.x;
        }}"
    );
    let buffers = vec![Buffer::new(name, 4 * 4096), Buffer::new("kept", 64)];
    let passes = vec![compute("numbers", &wgsl, [64, 1, 1]), Pass::clear("clear", "kept")];
    plan(buffers, vec![], passes)
}

fn exports_what_is_shared_or_says_why_not(device: &mut dyn Device) {
    let shared = counting("numbers", 0x5EED_0000);
    let expected: Vec<u32> = (0..4096).map(|i| 0x5EED_0000 + 3 * i).collect();
    let unsupported = |answer: Result<SharedBuffer, GpuError>| match answer {
        Err(GpuError::Unsupported(reason)) => reason,
        other => panic!("{other:?}"),
    };
    let lacking = device.info().unsupported.iter();
    let lacking = lacking.map(|lacking| (lacking.feature.clone(), lacking.reason.clone()));
    let lacking = lacking.collect::<std::collections::HashMap<_, _>>();
    if let Some(why) = lacking.get("memory shared with CUDA") {
        match device.prepare_shared(&shared, &["numbers"]) {
            Err(GpuError::Unsupported(reason)) => assert!(reason.contains(why), "{reason}"),
            other => panic!("{other:?}"),
        }
        // To ask for nothing is to prepare.
        let id = device.prepare_shared(&shared, &[]).expect("prepared");
        device.run(id).expect("ran");
        assert_eq!(to_words(&device.read(id, "numbers").expect("read")), expected);
        let reason = unsupported(device.export(id, "numbers"));
        assert!(reason.contains(why), "{reason}");
        eprintln!("{}: not checked: {reason}", device.info().id);
        return;
    }
    let unknown = device.prepare_shared(&shared, &["numbers", "nowhere"]);
    assert!(matches!(unknown, Err(GpuError::Plan { .. })), "{unknown:?}");
    let id = device.prepare_shared(&shared, &["numbers"]).expect("prepared");
    device.run(id).expect("ran");
    // A plan that shares nothing has a buffer of its own, whatever its name and size.
    ran(device, &counting("numbers", 7));
    assert_eq!(to_words(&device.read(id, "numbers").expect("read")), expected);
    let reason = unsupported(device.export(id, "kept"));
    assert!(reason.contains("not asked for"), "{reason}");
    let nowhere = device.export(id, "nowhere");
    assert!(matches!(nowhere, Err(GpuError::Plan { .. })), "{nowhere:?}");
    let exported = device.export(id, "numbers").expect("exported");
    let SharedBuffer { uuid, memory_bytes, offset_bytes, bytes, .. } = exported;
    assert_eq!((Some(uuid), bytes), (device.uuid(), 4 * 4096));
    assert!(offset_bytes + bytes <= memory_bytes, "{exported:?}");
    // Two handles are of one memory, and each can be closed.
    let again = device.export(id, "numbers").expect("exported");
    drop(exported);
    device.poison(id).expect("poisoned");
    device.run(id).expect("ran");
    device.reset();
    let stale = device.export(id, "numbers");
    assert!(matches!(stale, Err(GpuError::Plan { .. })), "{stale:?}");
    holds(&device.info().id, again, &words(&expected));
}

/// Sees to it that exported memory holds these bytes, where it is memory of the host.
#[cfg(target_os = "linux")]
fn holds(id: &str, exported: SharedBuffer, expected: &[u8]) {
    use std::io::{Read, Seek};
    use std::os::fd::AsRawFd;
    let link = format!("/proc/self/fd/{}", exported.handle.as_raw_fd());
    let target = fs::read_link(&link).expect("an open file descriptor");
    if !target.to_string_lossy().starts_with("/memfd:") {
        eprintln!("{id}: {} cannot be read as a file", target.display());
        return;
    }
    // Mesa's software drivers put a header of their own before the allocation.
    let (mut file, mut held) = (fs::File::from(exported.handle), Vec::new());
    file.rewind().expect("a file in memory has a beginning");
    file.read_to_end(&mut held).expect("a file in memory can be read");
    assert!(held.len() as u64 >= exported.memory_bytes, "{} bytes", held.len());
    assert!(held.windows(expected.len()).any(|held| held == expected), "{id}: other bytes");
}

#[cfg(not(target_os = "linux"))]
fn holds(_id: &str, _exported: SharedBuffer, _expected: &[u8]) {}

fn tells_the_memory_of_each_resource(device: &mut dyn Device) {
    let data: Arc<[u8]> = vec![7; 3001].into();
    let buffers =
        vec![Buffer::new("large", 5_000_001), Buffer::data("given", data), Buffer::new("small", 1)];
    let targets = vec![
        target("image", Format::Rgba32Float, 301, 203),
        target("mask", Format::Stencil8, 301, 203),
    ];
    let whole = plan(buffers.clone(), targets, vec![]);
    let id = device.prepare(&whole).expect("prepared");
    let listed = device.resource_bytes(id).expect("listed");
    let declared = [
        ("large", 5_000_001),
        ("given", 3001),
        ("small", 16),
        ("image", 301 * 203 * 16),
        ("mask", 301 * 203),
    ];
    assert_eq!(listed.len(), declared.len(), "{listed:?}");
    // Devices align to tiles and pages, and a stencil may come with depth.
    for ((name, bytes), (declared_name, declared)) in listed.iter().zip(declared) {
        assert_eq!(name, declared_name);
        assert!((declared..declared * 8 + (4 << 20)).contains(bytes), "{listed:?}");
    }
    let sum: u64 = listed.iter().map(|(_, bytes)| bytes).sum();
    assert_eq!(device.memory_bytes(id).expect("told"), sum);
    assert!(sum >= whole.bytes());
    // What both plans have is counted in both.
    let part = device.prepare(&plan(buffers[..1].to_vec(), vec![], vec![])).expect("prepared");
    assert_eq!(device.resource_bytes(part).expect("listed"), listed[..1]);
    device.reset();
    let stale = device.memory_bytes(id);
    assert!(matches!(stale, Err(GpuError::Plan { .. })), "{stale:?}");
}

/// A compute shader, a buffer cleared, and a draw.
fn shaders_plan() -> Plan {
    let wgsl = "
        @group(0) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;
        var<workgroup> held: array<u32, 32>;
        @compute @workgroup_size(8, 4) fn main(@builtin(local_invocation_index) i: u32) {
            held[i] = i;
            workgroupBarrier();
            atomicAdd(&counts[0], held[31u - i]);
        }";
    let image = target("image", Format::Rgba32Float, 4, 4);
    let raster = full_screen(COUNTING, vec![color("image", None, Load::Clear([0.0; 4]))]);
    let passes = vec![
        compute("sum", wgsl, [1, 1, 1]),
        Pass::clear("clear", "counts"),
        Pass::raster("draw", raster),
    ];
    plan(vec![Buffer::new("counts", 4)], vec![image], passes)
}

fn tells_what_became_of_each_shader(device: &mut dyn Device) {
    let plan = shaders_plan();
    let labels: Vec<&str> = plan.passes.iter().filter_map(shader).collect();
    let id = device.prepare(&plan).expect("prepared");
    let compiled = device.compiled(id).expect("told");
    if device.info().backend == "wgpu" {
        assert_eq!(compiled, []);
        return;
    }
    let told: Vec<&str> = compiled.iter().map(|compiled| compiled.shader.as_str()).collect();
    assert_eq!(told, labels);
    let main = compiled[0].main.as_ref().expect("a compute shader");
    assert_eq!((main.workgroup_size, main.workgroup_bytes), ([8, 4, 1], 128));
    assert_eq!(compiled[1].main, None);
    let lacking = &device.info().unsupported;
    let lacks = lacking.iter().any(|lacking| lacking.feature == "pipeline executable properties");
    for compiled in &compiled {
        assert!(compiled.compile_ns.is_some_and(|ns| ns > 0), "{compiled:?}");
        assert!(!lacks || compiled.executables.is_none(), "{compiled:?}");
        for executable in compiled.executables.iter().flatten() {
            assert!(!executable.name.is_empty(), "{executable:?}");
            assert!(executable.statistics.iter().all(|told| !told.name.is_empty()));
        }
    }
    device.reset();
    let stale = device.compiled(id);
    assert!(matches!(stale, Err(GpuError::Plan { .. })), "{stale:?}");
}

fn shader(pass: &Pass) -> Option<&str> {
    match &pass.work {
        Work::Clear { .. } => None,
        Work::Compute { shader, .. } => Some(&shader.label),
        Work::Raster(raster) => Some(&raster.shader.label),
    }
}

fn tells_the_same_out_of_the_cache(id: &str) {
    let cache = tempfile::tempdir().expect("a directory");
    let told = || {
        let mut device = open(id, cache.path()).expect("opens, since it was listed");
        let plan = device.prepare(&shaders_plan()).expect("prepared");
        let compiled = device.compiled(plan).expect("told").into_iter();
        let found: Vec<_> = compiled.map(|one| (one.from_cache, one.executables)).collect();
        found
    };
    let (first, second) = (told(), told());
    for ((from_cache, executables), (again_from_cache, again)) in first.into_iter().zip(second) {
        // What a driver's own caches have to do with it is the driver's to say.
        eprintln!("{id}: from the cache: {from_cache:?}, then {again_from_cache:?}");
        assert_eq!(executables, again);
    }
}

fn clears_more_than_32_bits_of_bytes(device: &mut dyn Device) {
    // 5 GiB that no shader binds. A device of software would take them from the host.
    let bytes = (5 << 30) + 12;
    let id = device.info().id.clone();
    if device.info().kind == "cpu" {
        eprintln!("{id}: not checked: its memory is the host's");
        return;
    }
    let plan = plan(vec![Buffer::new("vast", bytes)], vec![], vec![Pass::clear("clear", "vast")]);
    let prepared = match device.prepare(&plan) {
        Ok(prepared) => prepared,
        Err(error @ (GpuError::Unsupported(_) | GpuError::OutOfMemory(_))) => {
            eprintln!("{id}: not checked: {error}");
            return;
        }
        Err(error) => panic!("{error}"),
    };
    device.poison(prepared).expect("poisoned");
    let poisoned = device.read(prepared, "vast").expect("read");
    assert!(poisoned.len() as u64 == bytes && poisoned.iter().all(|&byte| byte == 0xCD));
    drop(poisoned);
    device.run(prepared).expect("ran");
    let cleared = device.read(prepared, "vast").expect("read");
    let first = cleared.iter().position(|&byte| byte != 0);
    assert!(first.is_none(), "byte {first:?} is not cleared");
    device.reset();
}

fn moves_more_than_the_staging_holds(device: &mut dyn Device) {
    // 64 MiB go at once; the last bytes are no multiple of 4.
    let bytes = (64 << 20) + 4099;
    let data: Arc<[u8]> =
        (0..bytes).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let plan = plan(
        vec![Buffer::data("large", data.clone()), Buffer::new("undefined", u64::from(bytes))],
        vec![],
        vec![],
    );
    let id = ran(device, &plan);
    let read = device.read(id, "large").expect("read");
    assert!(read.as_slice() == &data[..], "the bytes differ");
    device.poison(id).expect("poisoned");
    let read = device.read(id, "undefined").expect("read");
    assert!(read.len() == bytes as usize && read.iter().all(|&byte| byte == 0xCD));
}

fn times_stages(device: &mut dyn Device) {
    let heavy = "
        @group(0) @binding(0) var<storage, read_write> sums: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            var hash = id.x;
            for (var i = 0u; i < 2000u; i++) { hash = hash * 1664525u + 1013904223u; }
            sums[id.x] = hash;
        }";
    let stage = |stage, label| {
        let dispatch = Dispatch::Workgroups([256, 1, 1]);
        Pass { stage, ..Pass::compute("", Shader::new(label, heavy), dispatch) }
    };
    let passes = vec![
        Pass::clear("clear", "sums"),
        stage("count", "first"),
        stage("resolve", "second"),
        stage("count", "third"),
        stage("count", "fourth"),
    ];
    let plan = plan(vec![Buffer::new("sums", 65536)], vec![], passes);
    let id = ran(device, &plan);
    let timing = device.run(id).expect("ran");
    let Some(period_ns) = device.info().timestamp_period_ns else {
        assert!(timing.stages.is_empty() && timing.total_ns == 0, "{timing:?}");
        return;
    };
    let names: Vec<_> = timing.stages.iter().map(|&(name, _)| name).collect();
    assert_eq!(names, ["clear", "count", "resolve"]);
    for &(name, time_ns) in &timing.stages[1..] {
        assert!(time_ns > 0, "{name}: {timing:?}");
    }
    // Each of the four intervals is rounded to whole nanoseconds.
    let sum: u64 = timing.stages.iter().map(|&(_, time_ns)| time_ns).sum();
    let slack = 4 * (period_ns.ceil() as u64);
    assert!(sum.abs_diff(timing.total_ns) <= slack, "{timing:?}");
    let empty = self::plan(vec![], vec![], vec![]);
    let id = ran(device, &empty);
    assert_eq!(device.run(id).expect("ran").total_ns, 0);
}

fn refuses_faulty_plans(device: &mut dyn Device) {
    let what = |result: Result<PlanId, GpuError>| match result {
        Err(GpuError::Plan { what, .. }) => what,
        other => panic!("a faulty plan was expected: {other:?}"),
    };
    let mut unknown = naming_plan();
    unknown.buffers[2].name = "inputs".to_owned();
    let unknown = what(device.prepare(&unknown));
    assert!(unknown.contains("`input`") && unknown.contains("\"inputs\""), "{unknown}");
    let bad = plan(vec![], vec![], vec![compute("bad.wgsl", "fn main() -> u32 {}", [1, 1, 1])]);
    let bad = what(device.prepare(&bad));
    assert!(bad.contains("bad.wgsl:1:"), "{bad}");
    let id = ran(device, &naming_plan());
    let missing = device.read(id, "outputs");
    assert!(matches!(missing, Err(GpuError::Plan { .. })), "{missing:?}");
}

fn refuses_what_is_too_large(device: &mut dyn Device) {
    let info = device.info().clone();
    let reason = |device: &mut dyn Device, plan: &Plan| match device.prepare(plan) {
        Err(GpuError::Unsupported(reason)) => reason,
        other => panic!("it should not be supported: {other:?}"),
    };
    let fill = "
        @group(0) @binding(0) var<storage, read_write> large: array<u32>;
        @compute @workgroup_size(1) fn main() { large[0] = 1u; }";
    let too_large = info.max_storage_buffer_bytes + 4;
    let fill = vec![compute("fill", fill, [1, 1, 1])];
    let text = reason(device, &plan(vec![Buffer::new("large", too_large)], vec![], fill));
    for number in [too_large.next_multiple_of(4), info.max_storage_buffer_bytes] {
        assert!(text.contains(&number.to_string()), "{text}");
    }
    let size = info.max_workgroup_invocations + 1;
    let wide = format!("@compute @workgroup_size({size}) fn main() {{}}");
    let text = reason(device, &plan(vec![], vec![], vec![compute("wide", &wide, [1, 1, 1])]));
    assert!(text.contains(&size.to_string()), "{text}");
    let words = info.max_workgroup_bytes / 4 + 1;
    let deep = format!(
        "var<workgroup> deep: array<u32, {words}>;
        @compute @workgroup_size(1) fn main() {{ deep[0] = 1u; }}"
    );
    let text = reason(device, &plan(vec![], vec![], vec![compute("deep", &deep, [1, 1, 1])]));
    assert!(text.contains(&(words * 4).to_string()), "{text}");
    let huge = vec![target("huge", Format::R8Unorm, 1 << 20, 1)];
    let text = reason(device, &plan(vec![], huge, vec![]));
    assert!(text.contains("1048576"), "{text}");
}

fn reset_frees_and_prepare_works_again(device: &mut dyn Device) {
    let before = ran(device, &naming_plan());
    device.reset();
    let stale = device.run(before);
    assert!(matches!(stale, Err(GpuError::Plan { .. })), "{stale:?}");
    binds_buffers_by_name(device);
    // As much again and again as there is no room for if nothing were freed.
    let (bytes, rounds) = match device.info().memory_bytes {
        Some(memory) if device.info().kind != "cpu" => {
            let bytes = (memory / 20).min(2 << 30);
            (bytes, memory / bytes + 2)
        }
        _ => (96 << 20, 40),
    };
    let before = resident_bytes();
    for round in 0..rounds {
        let plan = plan(vec![Buffer::new("large", bytes + round * 4)], vec![], vec![]);
        let id = device.prepare(&plan).expect("prepared");
        device.poison(id).expect("poisoned");
        device.reset();
    }
    // A software device takes the process's own memory, in which the other tests run too.
    if let (Some(before), Some(after)) = (before, resident_bytes()) {
        assert!(after < before + rounds * bytes / 2, "{before} bytes grew to {after}");
    }
}

/// The memory that the process holds, where the system tells.
fn resident_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

fn is_steady_over_many_runs(device: &mut dyn Device) {
    let id = device.prepare(&stencil_plan()).expect("prepared");
    let mut first = None;
    for _ in 0..20 {
        device.poison(id).expect("poisoned");
        device.run(id).expect("ran");
        let seen = (device.read(id, "counts"), device.read(id, "mask"));
        let seen = (seen.0.expect("read"), seen.1.expect("read"));
        assert_eq!(*first.get_or_insert_with(|| seen.clone()), seen);
    }
}

fn survives_a_damaged_cache(id: &str) {
    let cache = tempfile::tempdir().expect("a directory");
    let directory = cache.path().join("pipelines");
    let runs = || {
        let mut device = open(id, &directory).expect("opens, since it was listed");
        binds_buffers_by_name(&mut *device);
    };
    runs();
    let Ok(files) = fs::read_dir(&directory) else {
        assert!(id.starts_with("wgpu:"), "only wgpu may be without a cache");
        return;
    };
    let files: Vec<_> = files.map(|file| file.expect("listed").path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    let whole = fs::read(&files[0]).expect("read");
    for damaged in [whole[..whole.len() / 2].to_vec(), vec![0xFF; whole.len()], vec![]] {
        fs::write(&files[0], &damaged).expect("written");
        runs();
        assert_ne!(fs::read(&files[0]).expect("read"), damaged, "it was not replaced");
    }
    runs();
}

fn all_devices_agree(ids: &[String]) {
    let mut results = Vec::new();
    for id in ids {
        with_device(id, |device, _| {
            let mut bytes = Vec::new();
            for (plan, resources) in
                [(naming_plan(), vec!["output"]), (stencil_plan(), vec!["counts", "mask", "image"])]
            {
                let id = ran(device, &plan);
                bytes.extend(resources.iter().map(|name| device.read(id, name).expect("read")));
            }
            results.push(bytes);
        });
    }
    for (id, bytes) in ids.iter().zip(&results) {
        assert!(*bytes == results[0], "{id} and {} differ", ids[0]);
    }
}
