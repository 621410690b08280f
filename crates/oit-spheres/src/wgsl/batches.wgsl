// Each object's atoms in batches of at most `BATCH` (section 3.4.1); a counter says where they go,
// so that objects follow one another in any order.
@group(0) @binding(8) var<storage, read_write> batches: array<vec4<u32>>;
@group(0) @binding(9) var<storage, read_write> batch_count: array<atomic<u32>, 4>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let object = slot_of(group, local);
    if object == 0u {
        // The one instance of an indirect draw of `batch_count` vertices.
        atomicStore(&batch_count[1], 1u);
    }
    if object >= view.objects {
        return;
    }
    let level = choose(object);
    if level == NONE {
        return;
    }
    let count = levels[level].atoms;
    let number = (count + BATCH - 1u) / BATCH;
    let at = atomicAdd(&batch_count[0], number);
    for (var i = 0u; i < number; i++) {
        let first = i * BATCH;
        batches[at + i] =
            vec4<u32>(levels[level].first_atom + first, min(BATCH, count - first), object, 0u);
    }
}
