// The second: each level's command, and where its instances begin.
struct Level {
    first_atom: u32,
    atoms: u32,
    from_distance: f32,
}

@group(0) @binding(4) var<storage, read> levels: array<Level>;
@group(0) @binding(8) var<storage, read> instances: array<u32>;
@group(0) @binding(10) var<storage, read_write> commands: array<vec4<u32>>;
@group(0) @binding(11) var<storage, read_write> taken: atomic<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let level = slot_of(group, local);
    if level >= LEVELS {
        return;
    }
    let count = instances[level];
    var first = 0u;
    if count != 0u {
        first = atomicAdd(&taken, count);
    }
    commands[level] =
        vec4<u32>(CORNERS * levels[level].atoms, count, CORNERS * levels[level].first_atom, first);
}
