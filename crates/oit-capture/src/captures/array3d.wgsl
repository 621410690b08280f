// Follows frame.wgsl, scene.wgsl and the constant STRIDE.
@group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> fragments: array<vec2<u32>>;

@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let layer = atomicAdd(&counts[pixel], 1u);
    // A fragment without room is counted, so that it is known how much room there should be.
    if (layer < arrayLength(&fragments) / STRIDE) {
        fragments[layer * STRIDE + pixel] = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
    }
}
