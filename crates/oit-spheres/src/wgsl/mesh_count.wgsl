// The first of three passes (section 3.4.3): each object's level, and its rank among those of it.
@group(0) @binding(8) var<storage, read_write> instances: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> ranks: array<vec2<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let object = slot_of(group, local);
    if object >= view.objects {
        return;
    }
    let level = choose(object);
    var rank = 0u;
    if level != NONE {
        rank = atomicAdd(&instances[level], 1u);
    }
    ranks[object] = vec2<u32>(level, rank);
}
