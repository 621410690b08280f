@group(0) @binding(0) var<storage, read> links: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> fragments: array<vec2<u32>>;

// The next node plus one, or 0 at the end.
var<private> lfb_node: u32;

// The pixels' links follow those of all nodes that there is room for.
fn lfb_begin(pixel: u32) {
    lfb_node = links[arrayLength(&fragments) + pixel].x;
}

fn lfb_more() -> bool {
    return lfb_node != 0u;
}

fn lfb_next() -> vec2<u32> {
    let node = lfb_node - 1u;
    lfb_node = links[node].x;
    return fragments[node];
}
