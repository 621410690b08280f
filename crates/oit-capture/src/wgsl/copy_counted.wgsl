// Copies counts from a target to COUNTS, row by row.
@group(0) @binding(0) var counted: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> COUNTS: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let word = (group.y * ROW + group.x) * 256u + lane;
    if (word < WORDS) {
        var count = 0u;
        if (word < PIXELS) {
            count = u32(textureLoad(counted, vec2<u32>(word % WIDTH, word / WIDTH), 0).r);
        }
        COUNTS[word] = count;
    }
}
