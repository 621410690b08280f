// From the fragments of each pixel to those it keeps. Follows the constants PIXELS, CAP and ROW.
@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read_write> offsets: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let pixel = (workgroup.y * ROW + workgroup.x) * 256u + local;
    if (pixel < PIXELS) {
        offsets[pixel] = min(counts[pixel], CAP);
    } else if (pixel == PIXELS) {
        offsets[pixel] = 0u;
    }
}
