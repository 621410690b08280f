// As count.wgsl, of geometry that is not clipped. Follows frame.wgsl.
@group(0) @binding(1) var<storage, read_write> offsets: array<atomic<u32>>;

@vertex
fn vs(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return project(position);
}

// The depth test rejects what is at or behind the far plane; what is at or before the near plane
// passes it.
@fragment @early_depth_test(force)
fn fs(@builtin(position) position: vec4<f32>) {
    if (position.z > 0.0) {
        atomicAdd(&offsets[pixel_index(position)], 1u);
    }
}
