// Follows scene_wgsl and the constants NODES, PIXELS, TRIES and WAITS. The CPU twin is `Curve` in
// adaptive.rs.
@group(0) @binding(1) var<storage, read_write> locks: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> nodes: array<atomic<u64>>;
@group(0) @binding(3) var<storage, read_write> lost: atomic<u32>;

// A lock with this bit is held. Its other bits count how often the pixel's nodes were changed.
const LOCKED = 0x80000000u;

// Of a node the upper half is its depth, inverted, so that zeros are empty and lie behind all others.
// Then come 16 bits of what is covered before what lies behind it, and 16 of the change that wrote it.
fn word(depth: u32, left: u32, change: u32) -> u64 {
    return (u64(depth) << 32u) | u64(((65535u - left) << 16u) | (change & 0xFFFFu));
}

// 65535 is all light. Whole numbers alone: the same on every device.
fn through(left: u32, alpha: u32) -> u32 {
    return (left * (255u - alpha) + 127u) / 255u;
}

fn depth_of(inverted: u32) -> f32 {
    return bitcast<f32>(~inverted & 0x7FFFFFFFu);
}

// Atomics are relaxed: who takes a lock may not yet see what its last holder wrote. So each node says
// which change it is of, and the holder waits for that which the lock counts. As each change writes all
// nodes, and starts with having seen all of the last, nothing rests on the order of two addresses.
fn insert(pixel: u32, depth: u32, alpha: u32) {
    var done = false;
    for (var turn = 0u; turn < TRIES && !done; turn += 1u) {
        let change = atomicLoad(&locks[pixel]);
        var locked = false;
        if ((change & LOCKED) == 0u) {
            locked = atomicCompareExchangeWeak(&locks[pixel], change, change | LOCKED).exchanged;
        }
        // Who locks also unlocks before the next turn: invocations in lockstep with it wait for
        // nothing that they hold up themselves.
        if (locked) {
            var depths: array<u32, NODES + 1>;
            var lefts: array<u32, NODES + 1>;
            var whole = true;
            for (var i = 0u; i < NODES; i += 1u) {
                var held = atomicLoad(&nodes[i * PIXELS + pixel]);
                for (var wait = 0u; wait < WAITS; wait += 1u) {
                    if ((u32(held & 0xFFFFlu)) == (change & 0xFFFFu)) {
                        break;
                    }
                    held = atomicLoad(&nodes[i * PIXELS + pixel]);
                }
                whole = whole && u32(held & 0xFFFFlu) == (change & 0xFFFFu);
                depths[i] = u32(held >> 32u);
                lefts[i] = 65535u - u32((held >> 16u) & 0xFFFFlu);
            }
            if (whole) {
                var place = 0u;
                var before = 65535u;
                for (var i = 0u; i < NODES; i += 1u) {
                    if (depths[i] >= depth) {
                        place = i + 1u;
                        before = lefts[i];
                    }
                }
                depths[NODES] = 0u;
                for (var i = NODES; i > place; i -= 1u) {
                    depths[i] = depths[i - 1u];
                    lefts[i] = through(lefts[i - 1u], alpha);
                }
                depths[place] = depth;
                lefts[place] = through(before, alpha);
                if (depths[NODES] != 0u) {
                    var least = 1u;
                    var least_area = 1e30;
                    for (var i = 1u; i <= NODES; i += 1u) {
                        let length = depth_of(depths[i]) - depth_of(depths[i - 1u]);
                        let area = length * f32(lefts[i - 1u] - lefts[i]);
                        if (area < least_area) {
                            least = i;
                            least_area = area;
                        }
                    }
                    // The node before covers at once what the two covered one after the other.
                    lefts[least - 1u] = lefts[least];
                    for (var i = least; i < NODES; i += 1u) {
                        depths[i] = depths[i + 1u];
                        lefts[i] = lefts[i + 1u];
                    }
                }
                for (var i = 0u; i < NODES; i += 1u) {
                    atomicStore(&nodes[i * PIXELS + pixel], word(depths[i], lefts[i], change + 1u));
                }
            }
            atomicStore(&locks[pixel], (change + u32(whole)) & ~LOCKED);
            done = whole;
        }
    }
    if (!done) {
        atomicAdd(&lost, 1u);
    }
}

// Helper invocations cover no sample. Atomics give them nothing, so that they would go on to the end
// of the loop.
@fragment
fn fs(in: Varyings, @builtin(sample_mask) mask: u32) -> @location(0) vec4<f32> {
    let alpha = shade(in) >> 24u;
    if (mask != 0u && alpha != 0u && covered(in)) {
        insert(pixel_index(in.position), ~depth_key(fragment_depth(in)), alpha);
    }
    discard_uncovered(in);
    return vec4<f32>();
}
