// Every atom that is drawn, with its object, in the order of objects: a workgroup an object.
struct Level {
    first_atom: u32,
    atoms: u32,
    from_distance: f32,
}

@group(0) @binding(4) var<storage, read> levels: array<Level>;
@group(0) @binding(8) var<storage, read> counts: array<u32>;
@group(0) @binding(9) var<storage, read> chosen: array<u32>;
@group(0) @binding(10) var<storage, read> total: array<u32, 4>;
@group(0) @binding(11) var<storage, read_write> list: array<vec2<u32>>;
@group(0) @binding(12) var<storage, read_write> list_draw: array<u32, 4>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = group.y * ROW + group.x;
    if slot == 0u && local == 0u {
        list_draw = array<u32, 4>(CORNERS * total[0], 1u, 0u, 0u);
    }
    if slot >= view.objects || chosen[slot] == 0xffffffffu {
        return;
    }
    let level = levels[chosen[slot]];
    let object = object_at(slot);
    for (var i = local; i < level.atoms; i += 64u) {
        list[counts[slot] + i] = vec2<u32>(level.first_atom + i, object);
    }
}
