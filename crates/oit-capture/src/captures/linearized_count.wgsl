@group(0) @binding(0) var<storage, read> offsets: array<u32>;

fn pixel_count(pixel: u32) -> u32 {
    var first = 0u;
    if (pixel > 0u) {
        first = offsets[pixel - 1u];
    }
    return offsets[pixel] - first;
}
