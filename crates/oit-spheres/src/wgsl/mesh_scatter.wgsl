// The third: the objects, by level.
@group(0) @binding(9) var<storage, read> ranks: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read> commands: array<vec4<u32>>;
@group(0) @binding(12) var<storage, read_write> by_mesh: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let object = slot_of(group, local);
    if object >= view.objects {
        return;
    }
    let rank = ranks[object];
    if rank.x != 0xffffffffu {
        by_mesh[commands[rank.x].w + rank.y] = object;
    }
}
