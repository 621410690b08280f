// A triangle for each point (section 3.4.1).
layout(points) in;
layout(triangle_strip, max_vertices = 3) out;

layout(location = 0) in uvec2 sphere[];
layout(location = 0) flat out vec4 out_sphere;
layout(location = 1) flat out uvec2 out_ids;
layout(location = 2) flat out vec2 out_center_clip;

void main() {
    uint object = sphere[0].x;
    if (object == 0xffffffffu) {
        return;
    }
    vec4 placed_sphere = sphere_of(object, sphere[0].y);
    Board board = board_of(placed_sphere);
    if (!board.seen) {
        return;
    }
    uvec2 ids = ids_of(object, sphere[0].y);
    vec2 center_clip = view.projection[2].zw * placed_sphere.z + view.projection[3].zw;
    vec4 middle = middle_of(board);
    for (uint number = 0u; number < 3u; number++) {
        gl_Position = corner_of(board, middle, number);
        out_sphere = placed_sphere;
        out_ids = ids;
        out_center_clip = center_clip;
        EmitVertex();
    }
    EndPrimitive();
}
