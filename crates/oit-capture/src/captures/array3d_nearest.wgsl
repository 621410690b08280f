// Follows frame.wgsl, scene.wgsl, nearest.wgsl and the constant STRIDE.
@group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;

fn store_fragment(pixel: u32, fragment: vec2<u32>) {
    // All are counted, so that it is known how much room there should be.
    atomicAdd(&counts[pixel], 1u);
    let layers = arrayLength(&fragments) / STRIDE;
    keep_nearest(pixel, layers * STRIDE, STRIDE, fragment);
}

// Helper invocations cover no sample. Atomics give them nothing, so that they would go on to the end
// of a loop that ends with what an atomic gives, and the others of their subgroup with them.
@fragment
fn fs(in: Varyings, @builtin(sample_mask) mask: u32) {
    if (mask != 0u && covered(in)) {
        let fragment = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
        store_fragment(pixel_index(in.position), fragment);
    }
    discard_uncovered(in);
}
