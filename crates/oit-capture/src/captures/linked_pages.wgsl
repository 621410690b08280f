// Follows frame.wgsl, scene.wgsl, a definition of count_fragment, and the constants PAGE (slots of
// a page) and TRIES.
@group(0) @binding(1) var<storage, read_write> page_count: atomic<u32>;
@group(0) @binding(2) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> nexts: array<u32>;
@group(0) @binding(4) var<storage, read_write> fragments: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> fills: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> dropped: array<atomic<u32>>;

// A head with this bit is that of a full page, behind which an invocation is fetching a new one.
const LOCKED = 0x80000000u;

// Atomics are relaxed: nothing follows from the order of two that are not at one address. Nothing
// here needs more. A page's first slot is that of the invocation that fetched it, and an addition
// to its fill gives out each other slot once, whoever knows of the page and since when. Heads change
// by exchanges, so that each page is linked from one place. And only who turns a page's own head
// into a locked one fetches the next, so that none is fetched before all slots are given out.
fn store_fragment(pixel: u32, fragment: vec2<u32>) {
    count_fragment(pixel);
    let room = arrayLength(&fragments) / PAGE;
    var done = false;
    // Who locks also unlocks before the next turn: invocations in lockstep with it wait for nothing
    // that they hold up themselves.
    for (var turn = 0u; !done; turn++) {
        let seen = atomicLoad(&heads[pixel]);
        let head = seen & ~LOCKED;
        var slot = PAGE;
        if (seen == head && head != 0u) {
            slot = 1u + atomicAdd(&fills[head - 1u], 1u);
        }
        if (slot < PAGE) {
            fragments[(head - 1u) * PAGE + slot] = fragment;
            done = true;
        } else {
            // After so many turns it fetches a page without the lock, and leaves slots empty.
            var fetches = turn >= TRIES;
            if (!fetches && seen == head) {
                fetches =
                    atomicCompareExchangeWeak(&heads[pixel], head, head | LOCKED).exchanged;
            }
            if (fetches) {
                let page = atomicAdd(&page_count, 1u);
                if (page < room) {
                    fragments[page * PAGE] = fragment;
                    nexts[page] = atomicExchange(&heads[pixel], page + 1u) & ~LOCKED;
                } else {
                    // A fragment without room is counted, so that it is known how much room there
                    // should be.
                    atomicAnd(&heads[pixel], ~LOCKED);
                    atomicAdd(&dropped[pixel], 1u);
                }
                done = true;
            }
        }
    }
}

// Helper invocations cover no sample. Atomics give them nothing, so that they would go on to the end
// of a loop that ends with what an atomic gives, and the others of their subgroup with them.
@fragment
fn fs(in: Varyings, @builtin(sample_mask) mask: u32) {
    if (mask != 0u && covered(in)) {
        let fragment = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
        store_fragment(pixel_index(in.position), fragment);
    }
    discard_uncovered(in);
}
