// Counts each pixel's fragments in COUNTS, without shading them. Follows frame.wgsl and positions.wgsl
// or spheres.wgsl.
@group(0) @binding(1) var<storage, read_write> COUNTS: array<atomic<u32>>;

@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    atomicAdd(&COUNTS[pixel_index(in.position)], 1u);
}
