// The greatest depth of each four by four pixels.
@group(0) @binding(17) var<storage, read_write> pyramid: array<f32>;

const EMPTY = 3e38;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let image = vec2<u32>(view.width_px, view.height_px);
    let size = (image + 3u) / 4u;
    if any(id.xy >= size) {
        return;
    }
    var far = -EMPTY;
    let end = min(4u * id.xy + 4u, image);
    for (var y = 4u * id.y; y < end.y; y++) {
        for (var x = 4u * id.x; x < end.x; x++) {
            let ids = ids_at(vec2<u32>(x, y));
            if ids.z == 0u {
                far = EMPTY;
            } else {
                let hit = meet(sphere_of(ids.x, ids.y), vec2<f32>(f32(x), f32(y)) + 0.5);
                far = max(far, -hit.position.z);
            }
        }
    }
    pyramid[id.y * size.x + id.x] = far;
}
