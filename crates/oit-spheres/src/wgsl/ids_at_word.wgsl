@group(1) @binding(0) var ids_out: texture_2d<u32>;

// A pixel's object and atom, and whether it has one.
fn ids_at(pixel: vec2<u32>) -> vec3<u32> {
    let word = textureLoad(ids_out, pixel, 0).x;
    if word == 0xffffffffu {
        return vec3<u32>();
    }
    return vec3<u32>(of_id(word), 1u);
}
