
@fragment
fn fs(in: Varyings) {
    link_fragment(atomicAdd(&node_count, 1u), in);
}
