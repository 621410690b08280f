// Each sphere's triangle from the number of the vertex alone.
fn corner(object: u32, atom: u32, number: u32) -> Corner {
    let sphere = sphere_of(object, atom);
    let board = board(sphere);
    let offset = board.axes * corner_of(number);
    let m = view.projection;
    var out: Corner;
    if PROJECT_CENTER {
        // The image is parallel to the billboard: x and y are scaled, and nothing else changes.
        let center = m[2] * -board.depth + m[3];
        let scale = vec2<f32>(m[0].x, m[1].y);
        out.position = vec4<f32>((board.center + offset) * scale, center.zw);
    } else {
        out.position = m * vec4<f32>(board.center + offset, -board.depth, 1.0);
    }
    if !board.seen {
        out.position = vec4<f32>(0.0, 0.0, -1.0, 1.0);
    }
    out.sphere = sphere;
    out.ids = ids_of(object, atom);
    out.center_clip = m[2].zw * sphere.z + m[3].zw;
    return out;
}
