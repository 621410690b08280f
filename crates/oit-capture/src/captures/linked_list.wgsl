// Follows frame.wgsl, scene.wgsl and a definition of count_fragment; precedes an `fs`.
@group(0) @binding(1) var<storage, read_write> node_count: atomic<u32>;
@group(0) @binding(2) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> nexts: array<u32>;
@group(0) @binding(4) var<storage, read_write> fragments: array<vec2<u32>>;

fn link_fragment(node: u32, in: Varyings) {
    let pixel = pixel_index(in.position);
    count_fragment(pixel);
    // A fragment without room is counted, so that it is known how much room there should be.
    if (node < arrayLength(&fragments)) {
        nexts[node] = atomicExchange(&heads[pixel], node + 1u);
        fragments[node] = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
    }
}
