@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read> fragments: array<vec2<u32>>;

fn pixel_count(pixel: u32) -> u32 {
    return min(counts[pixel], arrayLength(&fragments) / arrayLength(&counts));
}
