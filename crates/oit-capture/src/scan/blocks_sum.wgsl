// Adds up each block of VALUES: 256 invocations with four values each.
@group(0) @binding(0) var<storage, read> VALUES: array<u32>;
@group(0) @binding(1) var<storage, read_write> SUMS: array<u32>;

var<workgroup> partial: array<u32, 256>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let block = group.y * ROW + group.x;
    // Neighbouring invocations read neighbouring values: the order of a sum is of no account.
    var sum = 0u;
    for (var i = 0u; i < 4u; i++) {
        let at = block * 1024u + i * 256u + lane;
        if (at < LENGTH) {
            sum += VALUES[at];
        }
    }
    partial[lane] = sum;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if (lane < half) {
            partial[lane] += partial[lane + half];
        }
    }
    if (lane == 0u && block < BLOCKS) {
        SUMS[block] = partial[0];
    }
}
