
// Follows a layout in which lfb_slot is where the next fragment is.
fn lfb_cursor() -> u32 {
    return lfb_slot;
}

fn lfb_seek(cursor: u32) {
    lfb_slot = cursor;
}

fn lfb_put(f: vec2<u32>) {
    let slot = lfb_slot;
    lfb_slot = slot + STRIDE;
    fragments[slot] = f;
}
