@group(1) @binding(2) var position_out: texture_2d<f32>;
@group(1) @binding(3) var normal_out: texture_2d<f32>;

fn seen_at(pixel: vec2<u32>) -> Seen {
    let ids = ids_at(pixel);
    let position = textureLoad(position_out, pixel, 0).xyz;
    let normal = textureLoad(normal_out, pixel, 0).xyz;
    return Seen(ids.z != 0u, ids.x, ids.y, position, normal);
}
