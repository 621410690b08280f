@group(0) @binding(11) var<storage, read> list: array<vec2<u32>>;

@vertex
fn vs(@builtin(vertex_index) vertex: u32) -> Corner {
    let entry = list[vertex / 3u];
    return corner(entry.y, entry.x, vertex % 3u);
}
