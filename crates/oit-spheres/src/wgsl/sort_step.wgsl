// One step of a bitonic round that reaches beyond a block.
@group(0) @binding(7) var<storage, read_write> sorted: array<vec2<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let pair = slot_of(group, local);
    if pair >= LENGTH / 2u {
        return;
    }
    let low = 2u * pair - (pair & (STEP - 1u));
    let a = sorted[low];
    let b = sorted[low + STEP];
    let swap = a.x > b.x || (a.x == b.x && a.y > b.y);
    if swap == ((low & ROUND) == 0u) {
        sorted[low] = b;
        sorted[low + STEP] = a;
    }
}
