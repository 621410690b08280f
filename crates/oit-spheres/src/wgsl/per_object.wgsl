// One command for each object (section 3.4.2).
@group(0) @binding(8) var<storage, read_write> commands: array<vec4<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = slot_of(group, local);
    if slot >= view.objects {
        return;
    }
    let object = object_at(slot);
    let level = choose(object);
    var command = vec4<u32>(0u, 0u, 0u, object);
    if level != NONE {
        command = vec4<u32>(CORNERS * levels[level].atoms, 1u, CORNERS * levels[level].first_atom, object);
    }
    commands[slot] = command;
}
