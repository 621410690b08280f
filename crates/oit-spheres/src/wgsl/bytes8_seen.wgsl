@group(1) @binding(2) var behind_out: texture_2d<f32>;

fn position_at(pixel: vec2<i32>) -> vec3<f32> {
    let depth = textureLoad(behind_out, vec2<u32>(pixel), 0).x;
    let at = pixel_at(vec2<f32>(pixel) + 0.5);
    return vec3<f32>(at * select(1.0, depth, PERSPECTIVE), -depth);
}

// From one neighbour to the next, on that side where depth changes less: the other may be another
// sphere. Beyond the image and where nothing is, depth is 0 and far from all there is.
fn slope(pixel: vec2<i32>, here: vec3<f32>, along: vec2<i32>) -> vec3<f32> {
    let size = vec2<i32>(vec2<u32>(view.width_px, view.height_px));
    var after = here;
    var before = here;
    if all(pixel + along < size) {
        after = position_at(pixel + along);
    }
    if all(pixel - along >= vec2<i32>(0)) {
        before = position_at(pixel - along);
    }
    let ahead = abs(after.z - here.z);
    let behind = abs(before.z - here.z);
    let is_ahead = all(pixel + along < size)
        && (ahead <= behind || any(pixel - along < vec2<i32>(0)));
    return select(here - before, after - here, is_ahead);
}

// Position and normal from depth: the normal is that of the plane through neighbours.
fn seen_at(pixel: vec2<u32>) -> Seen {
    let ids = ids_at(pixel);
    let at = vec2<i32>(pixel);
    let position = position_at(at);
    let across = cross(slope(at, position, vec2<i32>(0, 1)), slope(at, position, vec2<i32>(1, 0)));
    let normal = across * inverseSqrt(max(dot(across, across), 1e-30));
    return Seen(ids.z != 0u, ids.x, ids.y, position, normal);
}
