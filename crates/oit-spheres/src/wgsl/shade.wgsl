// The picture from what was left of each pixel.
@group(0) @binding(13) var<storage, read> atom_rgba: array<u32>;
@group(0) @binding(14) var<storage, read> object_rgba: array<u32>;

fn color_of(object: u32, atom: u32) -> vec3<f32> {
    let bytes = vec3<u32>(0u, 8u, 16u);
    let a = (vec3<u32>(atom_rgba[atom]) >> bytes) & vec3<u32>(255u);
    let b = (vec3<u32>(object_rgba[object]) >> bytes) & vec3<u32>(255u);
    return vec3<f32>((a * b + 127u) / 255u) / 255.0;
}

fn shaded(pixel: vec2<u32>) -> vec4<f32> {
    let seen = seen_at(pixel);
    if !seen.covered {
        return vec4<f32>();
    }
    var color = color_of(seen.object, seen.atom);
    if view.striped != 0u {
        let inverse = vec4<f32>(-view.turn.xyz, view.turn.w);
        let along = dot(view.eye + turned(inverse, seen.position), view.stripes);
        color = select(color, view.stripe_rgba.xyz, fract(along) < 0.5);
    }
    let light = view.ambient + (1.0 - view.ambient) * abs(dot(seen.normal, view.light));
    return vec4<f32>(color * light, 1.0);
}
