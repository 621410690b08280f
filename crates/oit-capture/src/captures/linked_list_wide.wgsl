// Follows frame.wgsl, scene.wgsl and a definition of count_fragment.
@group(0) @binding(1) var<storage, read_write> node_count: atomic<u32>;
@group(0) @binding(2) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> nexts: array<u32>;
@group(0) @binding(4) var<storage, read_write> fragments: array<vec4<u32>>;

// Halves of whole 255ths: red, green, blue, and the opacity for each.
fn wide_fragment(rgba: u32, depth_key: u32) -> vec4<u32> {
    let c = vec4<f32>((vec4<u32>(rgba) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u));
    return vec4<u32>(
        pack2x16float(c.rg),
        pack2x16float(c.ba),
        pack2x16float(c.aa),
        depth_key,
    );
}

@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let node = atomicAdd(&node_count, 1u);
    count_fragment(pixel);
    // A fragment without room is counted, so that it is known how much room there should be.
    if (node < arrayLength(&fragments)) {
        nexts[node] = atomicExchange(&heads[pixel], node + 1u);
        fragments[node] = wide_fragment(shade(in), depth_key(fragment_depth(in)));
    }
}
