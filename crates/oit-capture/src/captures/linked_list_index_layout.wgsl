@group(0) @binding(0) var<storage, read> heads: array<u32>;
@group(0) @binding(1) var<storage, read> nexts: array<u32>;
@group(0) @binding(2) var<storage, read> fragments: array<vec4<u32>>;

// The next node plus one, or 0 at the end.
var<private> lfb_node: u32;

fn lfb_begin(pixel: u32) {
    lfb_node = heads[pixel];
}

fn lfb_more() -> bool {
    return lfb_node != 0u;
}

fn lfb_next() -> vec2<u32> {
    let node = lfb_node - 1u;
    lfb_node = nexts[node];
    return vec2<u32>(node, fragments[node].w);
}

fn lfb_payload(index: u32) -> vec3<u32> {
    return fragments[index].xyz;
}
