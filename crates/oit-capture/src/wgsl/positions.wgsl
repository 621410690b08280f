// Triangles by their positions alone, to be counted. Follows frame.wgsl.
struct Varyings {
    @invariant @builtin(position) position: vec4<f32>,
}

@vertex
fn vs(@location(0) position: vec3<f32>) -> Varyings {
    return Varyings(project(position));
}

// As in scene.wgsl.
fn discard_uncovered(in: Varyings) {}
