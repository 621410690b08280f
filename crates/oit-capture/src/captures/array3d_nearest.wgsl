// Follows frame.wgsl, scene.wgsl, nearest.wgsl and the constant STRIDE.
@group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;

fn store_fragment(pixel: u32, fragment: vec2<u32>) {
    // All are counted, so that it is known how much room there should be.
    atomicAdd(&counts[pixel], 1u);
    let layers = arrayLength(&fragments) / STRIDE;
    keep_nearest(pixel, layers * STRIDE, STRIDE, fragment);
}

@fragment
fn fs(in: Varyings) {
    store_fragment(pixel_index(in.position), vec2<u32>(shade(in), depth_key(in.position.z)));
}
