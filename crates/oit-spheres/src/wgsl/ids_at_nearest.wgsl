@group(0) @binding(16) var<storage, read> nearest: array<vec2<u32>>;

// A pixel's object and atom, and whether it has one.
fn ids_at(pixel: vec2<u32>) -> vec3<u32> {
    let word = nearest[pixel.y * view.width_px + pixel.x];
    if word.y == 0u {
        return vec3<u32>();
    }
    return vec3<u32>(of_id(word.x), 1u);
}
