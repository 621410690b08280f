
// Also counts the pixel's fragments: 1 is added to a target of floats.
@fragment
fn fs(in: Varyings) -> @location(0) f32 {
    discard_uncovered(in);
    link_fragment(atomicAdd(&node_count, 1u), in);
    return 1.0;
}
