// Follows frame.wgsl, scene.wgsl, a definition of count_fragment, and the constant TURNS.
@group(0) @binding(1) var<storage, read_write> node_count: atomic<u32>;
@group(0) @binding(2) var<storage, read_write> links: array<atomic<u64>>;
@group(0) @binding(3) var<storage, read_write> fragments: array<atomic<u64>>;
@group(0) @binding(4) var<storage, read_write> lost: atomic<u32>;

// The low half of a link is the next node plus one, or 0 at the end. Then come 16 bits of the attempt
// that linked that node in, and 16 of the attempt that linked in the node whose link it is, 0 for a
// pixel's.
const NEXT = 0xFFFFFFFFlu;
const FROM_NEXT_ON = 0xFFFFFFFFFFFFlu;

// Atomics are relaxed: who meets a node may not yet see its key, nor its link as it was when the node
// was linked in. A key is never 0, and whoever is told of a node is told by which attempt it was linked
// in: then its own link says the same, and later attempts of its owner there are none. So a link is
// gone by, and exchanged, only once it has arrived, and nothing rests on the order of two addresses.
// Nodes are never taken out again.
fn store_fragment(pixel: u32, fragment: vec2<u32>) {
    let room = arrayLength(&fragments);
    let node = atomicAdd(&node_count, 1u);
    if (node >= room) {
        // A fragment without room is counted, so that it is known how much room there should be.
        count_fragment(pixel);
        return;
    }
    let key = (u64(fragment.y) << 32u) | u64(fragment.x);
    atomicStore(&fragments[node], key);
    // Whose link is looked at, and by which attempt that node was linked in.
    var at = room + pixel;
    var linked_by = 0u;
    var attempt = 0u;
    var done = false;
    // Nobody holds anything while others wait: a turn that achieves nothing waits for a word to arrive,
    // or another fragment was linked in at the same place.
    for (var turn = 0u; turn < TURNS && !done; turn += 1u) {
        let link = atomicLoad(&links[at]);
        let next = u32(link & NEXT);
        if (u32(link >> 48u) == linked_by) {
            // The end lies behind all fragments.
            var other = 0xFFFFFFFFFFFFFFFFlu;
            if (next != 0u) {
                other = atomicLoad(&fragments[next - 1u]);
            }
            if (other >= key) {
                attempt += 1u;
                atomicStore(&links[node], (u64(attempt) << 48u) | (link & FROM_NEXT_ON));
                let own = (u64(linked_by) << 48u) | (u64(attempt) << 32u) | u64(node + 1u);
                done = atomicCompareExchangeWeak(&links[at], link, own).exchanged;
            } else if (other != 0lu) {
                at = next - 1u;
                linked_by = u32(link >> 32u) & 0xFFFFu;
            }
        }
    }
    if (done) {
        count_fragment(pixel);
    } else {
        // In no list, and in no count by which a list is read: it is told of instead.
        atomicStore(&fragments[node], 0lu);
        atomicAdd(&lost, 1u);
    }
}

// Helper invocations cover no sample. Atomics give them nothing, so that they would go on to the end
// of the loop, and the others of their subgroup with them.
@fragment
fn fs(in: Varyings, @builtin(sample_mask) mask: u32) {
    if (mask != 0u && covered(in)) {
        let fragment = vec2<u32>(shade(in), depth_key(fragment_depth(in)));
        store_fragment(pixel_index(in.position), fragment);
    }
    discard_uncovered(in);
}
