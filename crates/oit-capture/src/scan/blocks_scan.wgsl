// Replaces each value of VALUES by the sum of all values before it, block by block. 256 invocations
// with four values each. Follows a definition of sum_before and put_total.
@group(0) @binding(0) var<storage, read_write> VALUES: array<u32>;

var<workgroup> partial: array<u32, 256>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let block = group.y * ROW + group.x;
    let first = block * 1024u + lane * 4u;
    var values: array<u32, 4>;
    var own = 0u;
    for (var i = 0u; i < 4u; i++) {
        // Written in any case: an array holds anything before that.
        values[i] = 0u;
        if (first + i < LENGTH) {
            values[i] = VALUES[first + i];
        }
        own += values[i];
    }
    // Hillis and Steele: after the step of `reach`, each sum covers the 2 * reach values up to it.
    var sum = own;
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        partial[lane] = sum;
        workgroupBarrier();
        if (lane >= reach) {
            sum += partial[lane - reach];
        }
        workgroupBarrier();
    }
    var before = sum_before(block) + sum - own;
    for (var i = 0u; i < 4u; i++) {
        if (first + i < LENGTH) {
            VALUES[first + i] = before;
        }
        before += values[i];
    }
    if (lane == 255u) {
        put_total(before);
    }
}
