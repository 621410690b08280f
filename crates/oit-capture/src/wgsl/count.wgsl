// Counts each pixel's fragments in COUNTS, without shading them. Follows frame.wgsl.
@group(0) @binding(1) var<storage, read_write> COUNTS: array<atomic<u32>>;

@vertex
fn vs(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return project(position);
}

@fragment
fn fs(@builtin(position) position: vec4<f32>) {
    atomicAdd(&COUNTS[pixel_index(position)], 1u);
}
