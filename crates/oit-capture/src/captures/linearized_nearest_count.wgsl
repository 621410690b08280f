@group(0) @binding(0) var<storage, read> offsets: array<u32>;

fn pixel_count(pixel: u32) -> u32 {
    return offsets[pixel + 1u] - offsets[pixel];
}
