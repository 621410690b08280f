// What a pixel shows.
struct Seen {
    covered: bool,
    object: u32,
    atom: u32,
    // In view space.
    position: vec3<f32>,
    normal: vec3<f32>,
}

fn towards_camera(pixel: vec2<u32>) -> vec3<f32> {
    let at = pixel_at(vec2<f32>(pixel) + 0.5);
    return vec3<f32>(select(vec2<f32>(), -at, PERSPECTIVE), 1.0);
}
