
// Follows linked_pages_layout.wgsl. A cursor is the slot of the next fragment plus one, or 0 at the end.
fn lfb_cursor() -> u32 {
    if (lfb_page == 0u) {
        return 0u;
    }
    return (lfb_page - 1u) * PAGE + lfb_left;
}

fn lfb_seek(cursor: u32) {
    if (cursor == 0u) {
        lfb_page = 0u;
        return;
    }
    let slot = cursor - 1u;
    lfb_page = slot / PAGE + 1u;
    lfb_left = slot % PAGE + 1u;
}

fn lfb_put(f: vec2<u32>) {
    let page = lfb_page - 1u;
    let left = lfb_left - 1u;
    lfb_left = left;
    if (left == 0u) {
        lfb_open(nexts[page]);
    }
    fragments[page * PAGE + left] = f;
}
