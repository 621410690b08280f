// Bitonic sort (Batcher 1968) of blocks of 2048 in workgroup memory: the rounds from `FIRST` to
// `LAST`, each from its steps of at most 1024 on.
@group(0) @binding(7) var<storage, read_write> sorted: array<vec2<u32>>;

var<workgroup> block: array<vec2<u32>, 2048>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let first = (group.y * ROW + group.x) * 2048u;
    if first >= LENGTH {
        return;
    }
    for (var i = local; i < 2048u; i += 256u) {
        block[i] = sorted[first + i];
    }
    workgroupBarrier();
    for (var round = FIRST; round <= LAST; round *= 2u) {
        for (var step = min(round / 2u, 1024u); step > 0u; step /= 2u) {
            for (var pair = local; pair < 1024u; pair += 256u) {
                let low = 2u * pair - (pair & (step - 1u));
                let a = block[low];
                let b = block[low + step];
                let swap = a.x > b.x || (a.x == b.x && a.y > b.y);
                let rising = ((first + low) & round) == 0u;
                if swap == rising {
                    block[low] = b;
                    block[low + step] = a;
                }
            }
            workgroupBarrier();
        }
    }
    for (var i = local; i < 2048u; i += 256u) {
        sorted[first + i] = block[i];
    }
}
