@group(1) @binding(0) var atom_out: texture_2d<f32>;
@group(1) @binding(1) var instance_out: texture_2d<f32>;

fn whole(number: vec4<f32>) -> u32 {
    return u32(number.x) | u32(number.y) << 24u;
}

// A pixel's object and atom, and whether it has one.
fn ids_at(pixel: vec2<u32>) -> vec3<u32> {
    let atom = textureLoad(atom_out, pixel, 0);
    if atom.x < 0.0 {
        return vec3<u32>();
    }
    return vec3<u32>(whole(textureLoad(instance_out, pixel, 0)), whole(atom), 1u);
}
