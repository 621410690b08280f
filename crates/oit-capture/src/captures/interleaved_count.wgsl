@group(0) @binding(0) var<storage, read> counts: array<u32>;

fn pixel_count(pixel: u32) -> u32 {
    return counts[pixel];
}
