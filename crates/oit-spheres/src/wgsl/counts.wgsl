// Of each object, in order: its level, and how much room it takes in a list, `UNIT` atoms to a place.
@group(0) @binding(8) var<storage, read_write> counts: array<u32>;
@group(0) @binding(9) var<storage, read_write> chosen: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = slot_of(group, local);
    if slot >= view.objects {
        return;
    }
    let level = choose(object_at(slot));
    var count = 0u;
    if level != NONE {
        count = (levels[level].atoms + UNIT - 1u) / UNIT;
    }
    counts[slot] = count;
    chosen[slot] = level;
}
