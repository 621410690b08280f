// Each count becomes the sum of those before it.
@group(0) @binding(8) var<storage, read_write> counts: array<u32>;
@group(0) @binding(9) var<storage, read> block_sums: array<u32>;

var<workgroup> sums: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group.y * ROW + group.x;
    var own: array<u32, 4>;
    var sum = 0u;
    for (var i = 0u; i < 4u; i++) {
        let at = block * 1024u + local * 4u + i;
        own[i] = 0u;
        if at < LENGTH {
            own[i] = counts[at];
        }
        sum += own[i];
    }
    sums[local] = sum;
    workgroupBarrier();
    for (var step = 1u; step < 256u; step *= 2u) {
        var left = 0u;
        if local >= step {
            left = sums[local - step];
        }
        workgroupBarrier();
        sums[local] += left;
        workgroupBarrier();
    }
    if block >= (LENGTH + 1023u) / 1024u {
        return;
    }
    var next = block_sums[block] + sums[local] - sum;
    for (var i = 0u; i < 4u; i++) {
        let at = block * 1024u + local * 4u + i;
        if at < LENGTH {
            counts[at] = next;
        }
        next += own[i];
    }
}
