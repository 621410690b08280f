@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read> fragments: array<vec2<u32>>;

var<private> lfb_pixel: u32;
var<private> lfb_stride: u32;
var<private> lfb_slot: u32;
var<private> lfb_held: u32;
var<private> lfb_end: u32;

// A layer has a slot for each count. Of a pixel that met more fragments than there are layers, as
// many are stored as there are layers.
fn lfb_begin(pixel: u32) {
    let stride = arrayLength(&counts);
    let held = min(counts[pixel], arrayLength(&fragments) / stride);
    lfb_pixel = pixel;
    lfb_stride = stride;
    lfb_slot = pixel;
    lfb_held = held;
    lfb_end = pixel + held * stride;
}

fn lfb_more() -> bool {
    return lfb_slot < lfb_end;
}

fn lfb_next() -> vec2<u32> {
    let slot = lfb_slot;
    lfb_slot = slot + lfb_stride;
    return lfb_slot_at(slot);
}

fn lfb_len() -> u32 {
    return lfb_held;
}

fn lfb_at(i: u32) -> vec2<u32> {
    return lfb_slot_at(lfb_pixel + i * lfb_stride);
}
