// Tells each pixel where its first fragment goes. Follows a definition of entry.
@group(0) @binding(0) var<storage, read> rows: array<u32>;
@group(0) @binding(1) var<storage, read_write> bases: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let at = (group.y * ROW + group.x) * 256u + lane;
    let pixel = entry(at);
    if (pixel != NO_PIXEL) {
        bases[pixel] = 32u * rows[at / 32u] + at % 32u;
    }
}
