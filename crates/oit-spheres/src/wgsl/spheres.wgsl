// The spheres, with objects as `choose.wgsl` placed them in view space: two words of four for each,
// its position and its level's first atom, and how it is turned.
@group(0) @binding(1) var<storage, read> atoms: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> placed: array<vec4<u32>>;

// A sphere in view space: its centre and radius.
fn sphere_of(object: u32, atom: u32) -> vec4<f32> {
    let position = bitcast<vec3<f32>>(placed[2u * object].xyz);
    let turn = bitcast<vec4<f32>>(placed[2u * object + 1u]);
    let sphere = atoms[atom];
    return vec4<f32>(position + turned(turn, sphere.xyz), sphere.w);
}
