// The triangle about a sphere as it is seen: parallel to the image, through the sphere's nearest
// point, so that the whole sphere lies behind it. Under perspective a sphere is seen as an ellipse,
// whose axes point from and about the middle of the image; the triangle is the smallest about it
// that is equilateral but for the ellipse's axes.
struct Board {
    // 0: nothing of it can be seen.
    seen: bool,
    depth: f32,
    center: vec2<f32>,
    axes: mat2x2<f32>,
}

fn board(sphere: vec4<f32>) -> Board {
    let depth = -sphere.z;
    let radius = sphere.w;
    let near = depth - radius;
    var board: Board;
    board.seen = depth + radius >= view.near;
    board.depth = max(near, view.board_near);
    board.center = sphere.xy;
    board.axes = mat2x2<f32>(radius, 0.0, 0.0, radius);
    if !PERSPECTIVE {
        return board;
    }
    if near >= view.near {
        // Where the cone about the sphere cuts the plane at depth 1, then at the board's.
        let k = 1.0 / ((depth - radius) * (depth + radius));
        let off_axis = dot(sphere.xy, sphere.xy);
        let across = select(vec2<f32>(1.0, 0.0), sphere.xy * inverseSqrt(off_axis), off_axis > 0.0);
        let wide = radius * sqrt(off_axis * k * k + k) * board.depth;
        let narrow = radius * sqrt(k) * board.depth;
        board.center = sphere.xy * (depth * k * board.depth);
        board.axes = mat2x2<f32>(across * wide, vec2<f32>(-across.y, across.x) * narrow);
        return board;
    }
    // It reaches before the near plane: the whole image, unless it lies beside.
    for (var side = 0u; side < 4u; side++) {
        board.seen = board.seen && dot(view.sides[side].xyz, sphere.xyz) + view.sides[side].w >= -radius;
    }
    board.center = vec2<f32>();
    let x = 2.0 * board.depth / view.projection[0].x;
    let y = 2.0 * board.depth / view.projection[1].y;
    board.axes = mat2x2<f32>(x, 0.0, 0.0, y);
    return board;
}

// An equilateral triangle about the circle of radius 1.
fn corner_of(corner: u32) -> vec2<f32> {
    return vec2<f32>(
        select(select(-1.7320508, 1.7320508, corner == 1u), 0.0, corner == 2u),
        select(-1.0, 2.0, corner == 2u)
    );
}
