// One level of the down-sweep: where a pair of VALUES ends lies the sum before the pair, which is
// the sum before its left half; with the left half added it is the sum before the right one.
// Follows a definition of sum_before.
@group(0) @binding(0) var<storage, read_write> VALUES: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let pair = (group.y * ROW + group.x) * 256u + lane;
    if (pair < PAIRS) {
        let right = (2u * pair + 2u) * HALF - 1u;
        let left = right - HALF;
        let before = sum_before(right);
        let sum = VALUES[left];
        VALUES[left] = before;
        VALUES[right] = before + sum;
    }
}
