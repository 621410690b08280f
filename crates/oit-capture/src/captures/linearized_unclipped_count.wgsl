// As count.wgsl, of geometry that is not clipped. Follows frame.wgsl and positions.wgsl
// or spheres.wgsl.
@group(0) @binding(1) var<storage, read_write> offsets: array<atomic<u32>>;

// The depth test rejects what is at or behind the far plane; what is at or before the near plane
// passes it.
@fragment @early_depth_test(force)
fn fs(in: Varyings) {
    discard_uncovered(in);
    if (in.position.z > 0.0) {
        atomicAdd(&offsets[pixel_index(in.position)], 1u);
    }
}
