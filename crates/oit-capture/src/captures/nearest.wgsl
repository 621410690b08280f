// Follows frame.wgsl and scene.wgsl. A slot holds a fragment's key inverted, so that zeros are
// empty and the nearest is the largest.
@group(0) @binding(2) var<storage, read_write> fragments: array<atomic<u64>>;

// Of what is put into the slots from `first` on, each `step` behind the last and all before `end`,
// they keep the nearest, sorted front to back: each slot takes the nearest that comes by, and what
// it gives up for that goes on to the next. What a slot holds depends on no order of arrival.
fn keep_nearest(first: u32, end: u32, step: u32, fragment: vec2<u32>) {
    var key = ~((u64(fragment.y) << 32u) | u64(fragment.x));
    for (var slot = first; slot < end && key != 0lu; slot += step) {
        key = min(key, atomicMax(&fragments[slot], key));
    }
}

