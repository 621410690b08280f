// The objects as they were sorted: a key and an object for each.
@group(0) @binding(7) var<storage, read> sorted: array<vec2<u32>>;

fn object_at(slot: u32) -> u32 {
    return sorted[slot].y;
}
