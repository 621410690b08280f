// The second phase draws what the pyramid does not hide and was not drawn in the first.
@group(0) @binding(15) var<storage, read_write> seen: array<u32>;
@group(0) @binding(17) var<storage, read> pyramid: array<f32>;

fn hidden(center: vec3<f32>, radius: f32) -> bool {
    let near = -center.z - radius;
    if near < view.near {
        return false;
    }
    let extent = extent_of(vec4<f32>(center, radius));
    if any(extent.last < extent.first) {
        return true;
    }
    // The level where it is at most 3 + 1 texels wide and high, each of 4, 16, 64... pixels.
    var size = (vec2<u32>(view.width_px, view.height_px) + 3u) / 4u;
    var begin = 0u;
    var shift = 2u;
    let span = vec2<u32>(extent.last - extent.first);
    for (var level = 1u; level < PYRAMID_LEVELS; level++) {
        if max(span.x, span.y) >> shift <= 3u {
            break;
        }
        begin += size.x * size.y;
        size = (size + 3u) / 4u;
        shift += 2u;
    }
    let first = vec2<u32>(extent.first) >> vec2<u32>(shift);
    let last = vec2<u32>(extent.last) >> vec2<u32>(shift);
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            // A margin for rounding.
            let far = pyramid[begin + y * size.x + x];
            if near <= far + abs(far) * 1e-5 {
                return false;
            }
        }
    }
    return true;
}

fn in_phase(object: u32, center: vec3<f32>, radius: f32) -> bool {
    let before = seen[object];
    let visible = !hidden(center, radius);
    seen[object] = select(0u, 1u, visible);
    return visible && before == 0u;
}
