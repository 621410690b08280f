
@fragment
fn fs(in: Varyings) {
    discard_uncovered(in);
    link_fragment(atomicAdd(&node_count, 1u), in);
}
