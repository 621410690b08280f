fn in_phase(object: u32, center: vec3<f32>, radius: f32) -> bool {
    return true;
}
