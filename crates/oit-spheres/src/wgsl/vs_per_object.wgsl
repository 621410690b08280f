@vertex
fn vs(@builtin(vertex_index) vertex: u32, @builtin(instance_index) object: u32) -> Corner {
    return corner(object, vertex / 3u, vertex % 3u);
}
