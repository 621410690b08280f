// The pixels whose centres a sphere can cover: the first and the last of x and of y. Nothing where
// the last is before the first.
struct Extent {
    first: vec2<i32>,
    last: vec2<i32>,
}

fn extent_of(sphere: vec4<f32>) -> Extent {
    let size = vec2<i32>(vec2<u32>(view.width_px, view.height_px));
    let depth = -sphere.z;
    let radius = sphere.w;
    if depth + radius < view.near {
        return Extent(vec2<i32>(0), vec2<i32>(-1));
    }
    var low = sphere.xy - radius;
    var high = sphere.xy + radius;
    if PERSPECTIVE {
        if depth - radius < view.near {
            var seen = true;
            for (var side = 0u; side < 4u; side++) {
                let plane = view.sides[side];
                seen = seen && dot(plane.xyz, sphere.xyz) + plane.w >= -radius;
            }
            return Extent(vec2<i32>(0), select(vec2<i32>(-1), size - 1, seen));
        }
        // The tangents from the eye, in x and in y.
        let k = 1.0 / ((depth - radius) * (depth + radius));
        let half_width = radius * sqrt(sphere.xy * sphere.xy * k * k + k);
        low = sphere.xy * (depth * k) - half_width;
        high = sphere.xy * (depth * k) + half_width;
    }
    let a = (low - view.pixel_offset) / view.pixel_scale;
    let b = (high - view.pixel_offset) / view.pixel_scale;
    // Clamped as floats: what lies far outside is no integer.
    let limit = vec2<f32>(size);
    let first = clamp(ceil(min(a, b) - 0.5), vec2<f32>(0.0), limit);
    let last = clamp(floor(max(a, b) - 0.5), vec2<f32>(-1.0), limit - 1.0);
    return Extent(vec2<i32>(first), vec2<i32>(last));
}
