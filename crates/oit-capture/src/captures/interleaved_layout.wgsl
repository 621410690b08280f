// Follows a definition of lfb_base.
@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read> fragments: array<vec2<u32>>;

var<private> lfb_first: u32;
var<private> lfb_slot: u32;
var<private> lfb_end: u32;

// A pixel's fragments are 32 slots apart. What the pool has no room for is cut off.
fn lfb_begin(pixel: u32) {
    let room = arrayLength(&fragments);
    let first = min(lfb_base(pixel), room);
    lfb_first = first;
    lfb_slot = first;
    lfb_end = min(first + 32u * counts[pixel], room);
}

fn lfb_more() -> bool {
    return lfb_slot < lfb_end;
}

fn lfb_next() -> vec2<u32> {
    let slot = lfb_slot;
    lfb_slot = slot + 32u;
    return fragments[slot];
}

fn lfb_len() -> u32 {
    return (lfb_end - lfb_first + 31u) / 32u;
}

fn lfb_at(i: u32) -> vec2<u32> {
    return fragments[lfb_first + 32u * i];
}
