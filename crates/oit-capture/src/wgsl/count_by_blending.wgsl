// Counts each pixel's fragments by additive blending, without shading them. Follows frame.wgsl.
@vertex
fn vs(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return project(position);
}

@fragment
fn fs() -> @location(0) f32 {
    return 1.0;
}
