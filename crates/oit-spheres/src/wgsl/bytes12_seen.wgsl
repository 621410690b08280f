@group(1) @binding(2) var xy_out: texture_2d<u32>;
@group(1) @binding(3) var z_normal_out: texture_2d<u32>;

fn seen_at(pixel: vec2<u32>) -> Seen {
    let ids = ids_at(pixel);
    let z_normal = textureLoad(z_normal_out, pixel, 0).x;
    let xy = unpack2x16float(textureLoad(xy_out, pixel, 0).x);
    let z = unpack2x16float(z_normal & 0xffffu).x;
    let normal = from_hemisphere(unpack4x8snorm(z_normal).zw, towards_camera(pixel));
    return Seen(ids.z != 0u, ids.x, ids.y, vec3<f32>(xy, z), normal);
}
