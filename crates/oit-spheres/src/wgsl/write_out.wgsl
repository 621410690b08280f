// What the compute rasteriser kept, as fragments of the output's format.
@vertex
fn vs(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(vertex % 2u) * 4.0 - 1.0, f32(vertex / 2u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> Fragment {
    let ids = ids_at(vec2<u32>(position.xy));
    if ids.z == 0u {
        discard;
    }
    return fragment_of(ids_of(ids.x, ids.y), meet(sphere_of(ids.x, ids.y), position.xy));
}
