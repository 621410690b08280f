// The objects in the order in which they are submitted.
@group(0) @binding(7) var<storage, read> order: array<u32>;

fn object_at(slot: u32) -> u32 {
    return order[slot];
}
