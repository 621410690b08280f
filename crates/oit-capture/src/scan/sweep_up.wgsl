// One level of the up-sweep: where a right half of VALUES ends, the sum of both halves.
@group(0) @binding(0) var<storage, read_write> VALUES: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let pair = (group.y * ROW + group.x) * 256u + lane;
    if (pair < PAIRS) {
        let right = (2u * pair + 2u) * HALF - 1u;
        VALUES[right] += VALUES[right - HALF];
    }
}
