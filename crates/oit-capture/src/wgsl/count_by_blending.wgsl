// Counts each pixel's fragments by additive blending, without shading them. Follows frame.wgsl and
// positions.wgsl or spheres.wgsl.
@fragment
fn fs(in: Varyings) -> @location(0) f32 {
    discard_uncovered(in);
    return 1.0;
}
