// Batches in the order of objects: `counts` has become where each object's begin.
struct Level {
    first_atom: u32,
    atoms: u32,
    from_distance: f32,
}

@group(0) @binding(4) var<storage, read> levels: array<Level>;
@group(0) @binding(8) var<storage, read> counts: array<u32>;
@group(0) @binding(9) var<storage, read> chosen: array<u32>;
@group(0) @binding(10) var<storage, read> total: array<u32, 4>;
@group(0) @binding(11) var<storage, read_write> batches: array<vec4<u32>>;
@group(0) @binding(12) var<storage, read_write> batch_count: array<u32, 4>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = slot_of(group, local);
    if slot == 0u {
        batch_count = array<u32, 4>(total[0], 1u, 0u, 0u);
    }
    if slot >= view.objects || chosen[slot] == 0xffffffffu {
        return;
    }
    let level = levels[chosen[slot]];
    let object = object_at(slot);
    for (var first = 0u; first < level.atoms; first += BATCH) {
        batches[counts[slot] + first / BATCH] =
            vec4<u32>(level.first_atom + first, min(BATCH, level.atoms - first), object, 0u);
    }
}
