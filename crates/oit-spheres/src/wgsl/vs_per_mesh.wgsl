@group(0) @binding(12) var<storage, read> by_mesh: array<u32>;

@vertex
fn vs(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    return corner(by_mesh[instance], vertex / 3u, vertex % 3u);
}
