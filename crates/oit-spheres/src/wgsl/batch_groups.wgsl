// A workgroup for each batch, in rows: what a dispatch or a draw of mesh shaders reads.
@group(0) @binding(9) var<storage, read> batch_count: array<u32, 4>;
@group(0) @binding(10) var<storage, read_write> batch_groups: array<u32, 3>;

@compute @workgroup_size(1)
fn main() {
    let count = batch_count[0];
    batch_groups = array<u32, 3>(min(count, ROW), (count + ROW - 1u) / ROW, 1u);
}
