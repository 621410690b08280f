// One view of a scene: the same bytes as `Frame` in frame.rs.
struct Frame {
    view_projection: mat4x4<f32>,
    light: vec3<f32>,
    ambient: f32,
    stripes: vec3<f32>,
    striped: u32,
    stripe_rgba: vec4<f32>,
    width_px: u32,
    height_px: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Every pass that must see the same fragments projects by this sum and declares the result
// `@invariant`. The CPU rasteriser adds in the same order.
fn project(position: vec3<f32>) -> vec4<f32> {
    let m = frame.view_projection;
    return ((m[0] * position.x + m[1] * position.y) + m[2] * position.z) + m[3];
}

fn pixel_index(position: vec4<f32>) -> u32 {
    return u32(position.y) * frame.width_px + u32(position.x);
}

// The depth as sortable bits: `oit_fragments::depth_key` for depths of 0 and more.
fn depth_key(depth: f32) -> u32 {
    return bitcast<u32>(max(depth, 0.0)) | 0x80000000u;
}
