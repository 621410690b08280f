// A workgroup for each batch, in rows as long as one another: what a dispatch or a draw of mesh shaders
// reads. Fewer are left over than there are rows.
@group(0) @binding(9) var<storage, read> batch_count: array<u32, 4>;
@group(0) @binding(10) var<storage, read_write> batch_groups: array<u32, 3>;

@compute @workgroup_size(1)
fn main() {
    let count = batch_count[0];
    let rows = max((count + ROW - 1u) / ROW, 1u);
    batch_groups = array<u32, 3>((count + rows - 1u) / rows, rows, 1u);
}
