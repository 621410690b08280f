@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read> fragments: array<vec2<u32>>;

var<private> lfb_first: u32;
var<private> lfb_slot: u32;
var<private> lfb_end: u32;

fn lfb_begin(pixel: u32) {
    let room = arrayLength(&fragments);
    let first = min(offsets[pixel], room);
    lfb_first = first;
    lfb_slot = first;
    lfb_end = min(offsets[pixel + 1u], room);
}

fn lfb_more() -> bool {
    return lfb_slot < lfb_end;
}

fn lfb_next() -> vec2<u32> {
    let slot = lfb_slot;
    lfb_slot = slot + 1u;
    return lfb_slot_at(slot);
}

fn lfb_len() -> u32 {
    return lfb_end - lfb_first;
}

fn lfb_at(i: u32) -> vec2<u32> {
    return lfb_slot_at(lfb_first + i);
}
