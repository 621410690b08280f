// Follows frame.wgsl and scene.wgsl.
@group(0) @binding(1) var<storage, read_write> offsets: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> fragments: array<vec2<u32>>;

@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    let slot = atomicAdd(&offsets[pixel_index(in.position)], 1u);
    if (slot < arrayLength(&fragments)) {
        fragments[slot] = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
    }
}
