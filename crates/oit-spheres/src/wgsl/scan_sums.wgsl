// The sums of blocks become where each block begins: one workgroup, 1024 blocks at a time.
@group(0) @binding(9) var<storage, read_write> block_sums: array<u32>;
@group(0) @binding(10) var<storage, read_write> total: array<u32, 4>;

const BLOCKS = (LENGTH + 1023u) / 1024u;

var<workgroup> sums: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
    var before = 0u;
    for (var first = 0u; first < BLOCKS; first += 1024u) {
        var own: array<u32, 4>;
        var sum = 0u;
        for (var i = 0u; i < 4u; i++) {
            let at = first + local * 4u + i;
            own[i] = 0u;
            if at < BLOCKS {
                own[i] = block_sums[at];
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
        var next = before + sums[local] - sum;
        for (var i = 0u; i < 4u; i++) {
            let at = first + local * 4u + i;
            if at < BLOCKS {
                block_sums[at] = next;
            }
            next += own[i];
        }
        before += sums[255];
        workgroupBarrier();
    }
    if local == 0u {
        total[0] = before;
    }
}
