// Follows frame.wgsl, scene.wgsl and a definition of lfb_base.
@group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> fragments: array<vec2<u32>>;

@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let slot = lfb_base(pixel) + 32u * atomicAdd(&counts[pixel], 1u);
    if (slot < arrayLength(&fragments)) {
        fragments[slot] = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
    }
}
