// One view: the same bytes as `View` in view.rs. View space: x to the right, y up, the camera looks
// along -z. A point's depth there is -z; clip space has it reversed, 1 at the near plane and 0 at
// the far plane, since floats are then about as exact everywhere.
struct View {
    projection: mat4x4<f32>,
    turn: vec4<f32>,
    eye: vec3<f32>,
    near: f32,
    light: vec3<f32>,
    ambient: f32,
    pixel_scale: vec2<f32>,
    pixel_offset: vec2<f32>,
    sides: array<vec4<f32>, 4>,
    width_px: u32,
    height_px: u32,
    objects: u32,
    far: f32,
    stripes: vec3<f32>,
    striped: u32,
    stripe_rgba: vec4<f32>,
    board_near: f32,
}

@group(0) @binding(0) var<uniform> view: View;

// A vector turned by a unit quaternion.
fn turned(by: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(by.xyz, v);
    return v + by.w * t + cross(by.xyz, t);
}

// Under perspective a pixel's place at depth 1, else at any depth.
fn pixel_at(pixel: vec2<f32>) -> vec2<f32> {
    return pixel * view.pixel_scale + view.pixel_offset;
}
