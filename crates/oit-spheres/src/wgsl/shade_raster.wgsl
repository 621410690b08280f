// The picture as a full-screen pass.
@vertex
fn vs(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(vertex % 2u) * 4.0 - 1.0, f32(vertex / 2u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return shaded(vec2<u32>(position.xy));
}
