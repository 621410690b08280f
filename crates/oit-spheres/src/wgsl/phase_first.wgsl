// The first phase draws what was last seen. Whatever is here, the picture is right: what is not drawn
// now is looked at in the second phase.
@group(0) @binding(15) var<storage, read> seen: array<u32>;

fn in_phase(object: u32, center: vec3<f32>, radius: f32) -> bool {
    return seen[object] != 0u;
}
