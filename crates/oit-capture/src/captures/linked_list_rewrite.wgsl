
// Follows linked_list_layout.wgsl.
fn lfb_cursor() -> u32 {
    return lfb_node;
}

fn lfb_seek(cursor: u32) {
    lfb_node = cursor;
}

fn lfb_put(f: vec2<u32>) {
    let node = lfb_node - 1u;
    lfb_node = nexts[node];
    fragments[node] = f;
}
