// What of an object is drawn: its level of detail, unless it is culled. It also places the object in
// view space.
struct Level {
    first_atom: u32,
    atoms: u32,
    from_distance: f32,
}

struct Kind {
    first_level: u32,
    levels: u32,
    radius: f32,
}

// Two words of four for each object: its position and kind, and how it is turned.
@group(0) @binding(3) var<storage, read> places: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> levels: array<Level>;
@group(0) @binding(5) var<storage, read> kinds: array<Kind>;
@group(0) @binding(6) var<storage, read_write> placed: array<vec4<u32>>;

const NONE = 0xffffffffu;

fn product(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(
        a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz),
        a.w * b.w - dot(a.xyz, b.xyz)
    );
}

// Whether a sphere in view space reaches into the frustum.
fn in_frustum(center: vec3<f32>, radius: f32) -> bool {
    var inside = -center.z + radius >= view.near && -center.z - radius <= view.far;
    for (var side = 0u; side < 4u; side++) {
        let plane = view.sides[side];
        inside = inside && dot(plane.xyz, center) + plane.w >= -radius;
    }
    return inside;
}

// The level of an object, or `NONE`.
fn choose(object: u32) -> u32 {
    let place = places[2u * object];
    let kind = kinds[place.w];
    let from_eye = bitcast<vec3<f32>>(place.xyz) - view.eye;
    let distance = length(from_eye);
    var level = kind.first_level;
    if BY_DISTANCE {
        for (var coarser = level + 1u; coarser < kind.first_level + kind.levels; coarser++) {
            if distance >= levels[coarser].from_distance {
                level = coarser;
            }
        }
    }
    let center = turned(view.turn, from_eye);
    if PHASE != 2u {
        let turn = product(view.turn, bitcast<vec4<f32>>(places[2u * object + 1u]));
        placed[2u * object] = vec4<u32>(bitcast<vec3<u32>>(center), levels[level].first_atom);
        placed[2u * object + 1u] = bitcast<vec4<u32>>(turn);
    }
    if CULLING && !in_frustum(center, kind.radius) {
        return NONE;
    }
    if !in_phase(object, center, kind.radius) {
        return NONE;
    }
    return level;
}
