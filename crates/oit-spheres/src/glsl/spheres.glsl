// What view.wgsl, spheres.wgsl, billboard.wgsl and pulled.wgsl say, for stages that WGSL lacks.
layout(std140, set = 0, binding = 0) uniform View {
    mat4 projection;
    vec4 turn;
    vec3 eye;
    float near;
    vec3 light;
    float ambient;
    vec2 pixel_scale;
    vec2 pixel_offset;
    vec4 sides[4];
    uint width_px;
    uint height_px;
    uint objects;
    float far;
    vec3 stripes;
    uint striped;
    vec4 stripe_rgba;
    float board_near;
} view;
layout(std430, set = 0, binding = 1) readonly buffer Atoms { vec4 data[]; } atoms;
layout(std430, set = 0, binding = 2) readonly buffer Placed { uvec4 data[]; } placed;

vec4 sphere_of(uint object, uint atom) {
    vec3 position = uintBitsToFloat(placed.data[2u * object].xyz);
    vec4 by = uintBitsToFloat(placed.data[2u * object + 1u]);
    vec4 sphere = atoms.data[atom];
    vec3 t = 2.0 * cross(by.xyz, sphere.xyz);
    return vec4(position + sphere.xyz + by.w * t + cross(by.xyz, t), sphere.w);
}

#ifdef NUMBERED_IDS
layout(std430, set = 0, binding = 18) readonly buffer FirstIds { uint data[]; } first_ids;
#endif

uvec2 ids_of(uint object, uint atom) {
    if (!PACKED_IDS) {
        return uvec2(object, atom);
    }
    uint within = atom - placed.data[2u * object].w;
#ifdef NUMBERED_IDS
    return uvec2(first_ids.data[object] + within, 0u);
#else
    return uvec2(object << ATOM_BITS | within, 0u);
#endif
}

struct Board {
    bool seen;
    float depth;
    vec2 center;
    mat2 axes;
};

Board board_of(vec4 sphere) {
    float depth = -sphere.z;
    float radius = sphere.w;
    float near = depth - radius;
    Board board;
    board.seen = depth + radius >= view.near;
    board.depth = max(near, view.board_near);
    board.center = sphere.xy;
    board.axes = mat2(radius, 0.0, 0.0, radius);
    if (!PERSPECTIVE) {
        return board;
    }
    if (near >= view.near) {
        float k = 1.0 / ((depth - radius) * (depth + radius));
        float off_axis = dot(sphere.xy, sphere.xy);
        vec2 across = off_axis > 0.0 ? sphere.xy * inversesqrt(off_axis) : vec2(1.0, 0.0);
        float wide = radius * sqrt(off_axis * k * k + k) * board.depth;
        float narrow = radius * sqrt(k) * board.depth;
        board.center = sphere.xy * (depth * k * board.depth);
        board.axes = mat2(across * wide, vec2(-across.y, across.x) * narrow);
        return board;
    }
    for (uint side = 0u; side < 4u; side++) {
        board.seen = board.seen && dot(view.sides[side].xyz, sphere.xyz) + view.sides[side].w >= -radius;
    }
    board.center = vec2(0.0);
    board.axes = mat2(2.0 * board.depth / view.projection[0].x, 0.0, 0.0, 2.0 * board.depth / view.projection[1].y);
    return board;
}

const vec2 CORNERS[3] = vec2[3](vec2(-1.7320508, -1.0), vec2(1.7320508, -1.0), vec2(0.0, 2.0));

// The board's middle in clip space, to which its corners are offset there.
vec4 middle_of(Board board) {
    vec2 scale = vec2(view.projection[0].x, view.projection[1].y);
    vec4 center = view.projection[2] * -board.depth + view.projection[3];
    return vec4(board.center * scale, center.zw);
}

vec4 corner_of(Board board, vec4 middle, uint number) {
    vec2 offset = board.axes * CORNERS[number];
    if (PROJECT_CENTER) {
        return vec4(middle.xy + offset * vec2(view.projection[0].x, view.projection[1].y), middle.zw);
    }
    return view.projection * vec4(board.center + offset, -board.depth, 1.0);
}
