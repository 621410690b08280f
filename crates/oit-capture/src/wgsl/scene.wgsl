// Triangles: vertices with all they carry, and how a fragment is shaded. Follows frame.wgsl.
struct Varyings {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rgba: vec4<f32>,
}

@vertex
fn vs(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rgba: vec4<f32>,
) -> Varyings {
    return Varyings(project(position), position, normal, rgba);
}

fn fragment_depth(in: Varyings) -> f32 {
    return in.position.z;
}

// Two-sided Lambert. Alpha is the colour's own.
fn shade(in: Varyings) -> u32 {
    var rgba = in.rgba;
    if (frame.striped != 0u && fract(dot(in.world, frame.stripes)) < 0.5) {
        rgba = frame.stripe_rgba;
    }
    // A normal of length zero is lit by the ambient term alone.
    let cosine = abs(dot(in.normal, frame.light)) / max(length(in.normal), 1e-20);
    let light = frame.ambient + (1.0 - frame.ambient) * cosine;
    return pack4x8unorm(vec4<f32>(rgba.rgb * light, rgba.a));
}

// What the rasteriser covers is a fragment, all of it: these are as if they were not there. Spheres
// have others.
fn covered(in: Varyings) -> bool {
    return true;
}

fn discard_uncovered(in: Varyings) {}
