// Sums of blocks of 1024.
@group(0) @binding(8) var<storage, read> counts: array<u32>;
@group(0) @binding(9) var<storage, read_write> block_sums: array<u32>;

var<workgroup> sums: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let block = group.y * ROW + group.x;
    var sum = 0u;
    for (var i = 0u; i < 4u; i++) {
        let at = block * 1024u + local * 4u + i;
        if at < LENGTH {
            sum += counts[at];
        }
    }
    sums[local] = sum;
    workgroupBarrier();
    for (var half = 128u; half > 0u; half /= 2u) {
        if local < half {
            sums[local] += sums[local + half];
        }
        workgroupBarrier();
    }
    if local == 0u && block < (LENGTH + 1023u) / 1024u {
        block_sums[block] = sums[0];
    }
}
