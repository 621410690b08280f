// What a billboard's corners tell its fragments.
struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) sphere: vec4<f32>,
    @location(1) @interpolate(flat) ids: vec2<u32>,
    // The clip coordinates z and w of the sphere's centre.
    @location(2) @interpolate(flat) center_clip: vec2<f32>,
}
