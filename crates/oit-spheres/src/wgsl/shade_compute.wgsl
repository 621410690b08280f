// The picture in compute.
@group(0) @binding(17) var<storage, read_write> image: array<vec4<f32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < view.width_px && id.y < view.height_px {
        image[id.y * view.width_px + id.x] = shaded(id.xy);
    }
}
