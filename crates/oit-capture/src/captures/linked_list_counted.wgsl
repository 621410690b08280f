@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

fn count_fragment(pixel: u32) {
    atomicAdd(&counts[pixel], 1u);
}

