// Finds the rows of each group, as many as its deepest pixel has fragments, and adds up all
// fragments. Counts become zero: the capture counts again as it stores. Follows a definition of
// entry.
@group(0) @binding(0) var<storage, read_write> counts: array<u32>;
@group(0) @binding(1) var<storage, read_write> rows: array<u32>;
@group(0) @binding(2) var<storage, read_write> total: array<atomic<u32>>;

var<workgroup> deepest: array<atomic<u32>, 8>;
var<workgroup> sum: atomic<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    if (lane < 8u) {
        atomicStore(&deepest[lane], 0u);
    }
    if (lane == 0u) {
        atomicStore(&sum, 0u);
    }
    workgroupBarrier();
    let block = group.y * ROW + group.x;
    let pixel = entry(block * 256u + lane);
    if (pixel != NO_PIXEL) {
        let count = counts[pixel];
        counts[pixel] = 0u;
        atomicMax(&deepest[lane / 32u], count);
        atomicAdd(&sum, count);
    }
    workgroupBarrier();
    let own = block * 8u + lane;
    if (lane < 8u && own < GROUPS) {
        rows[own] = atomicLoad(&deepest[lane]);
    }
    if (lane == 0u) {
        atomicAdd(&total[0], atomicLoad(&sum));
    }
}
