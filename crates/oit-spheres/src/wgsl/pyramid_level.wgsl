// A level of the pyramid from the one below it.
@group(0) @binding(17) var<storage, read_write> pyramid: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = (BELOW_SIZE + 3u) / 4u;
    if any(id.xy >= size) {
        return;
    }
    var far = -3e38;
    let end = min(4u * id.xy + 4u, BELOW_SIZE);
    for (var y = 4u * id.y; y < end.y; y++) {
        for (var x = 4u * id.x; x < end.x; x++) {
            far = max(far, pyramid[BELOW + y * BELOW_SIZE.x + x]);
        }
    }
    pyramid[BELOW + BELOW_SIZE.x * BELOW_SIZE.y + id.y * size.x + id.x] = far;
}
