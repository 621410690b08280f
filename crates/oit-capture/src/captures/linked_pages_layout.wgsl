@group(0) @binding(0) var<storage, read> heads: array<u32>;
@group(0) @binding(1) var<storage, read> nexts: array<u32>;
@group(0) @binding(2) var<storage, read> fragments: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> fills: array<u32>;

// The page being read plus one, or 0 at the end, and how many of its fragments are left.
var<private> lfb_page: u32;
var<private> lfb_left: u32;

fn lfb_open(page: u32) {
    lfb_page = page;
    if (page != 0u) {
        // The fill does not count the first slot, and does those asked for in vain.
        lfb_left = min(fills[page - 1u] + 1u, PAGE);
    }
}

fn lfb_begin(pixel: u32) {
    lfb_open(heads[pixel]);
}

fn lfb_more() -> bool {
    return lfb_page != 0u;
}

fn lfb_next() -> vec2<u32> {
    let page = lfb_page - 1u;
    let left = lfb_left - 1u;
    lfb_left = left;
    if (left == 0u) {
        lfb_open(nexts[page]);
    }
    return fragments[page * PAGE + left];
}
