
enable subgroups;

// The bits of a word of a ballot that belong to invocations before this one.
fn before(invocation: u32, word: u32) -> u32 {
    return extractBits(0xFFFFFFFFu, 0u, min(max(invocation, word * 32u) - word * 32u, 32u));
}

// Helper invocations cover no sample, and of spheres others cover nothing. They vote with the others
// but take no node, and an atomic of theirs would do nothing: the first that is none asks for all.
@fragment
fn fs(
    in: Varyings,
    @builtin(sample_mask) mask: u32,
    @builtin(subgroup_invocation_id) invocation: u32,
    @builtin(subgroup_size) size: u32,
) {
    let covers = mask != 0u && covered(in);
    let ballot = subgroupBallot(covers);
    var first = size;
    var rank = 0u;
    for (var word = 0u; word < 4u; word++) {
        if (first == size && ballot[word] != 0u) {
            first = word * 32u + countTrailingZeros(ballot[word]);
        }
        rank += countOneBits(ballot[word] & before(invocation, word));
    }
    var node = 0u;
    if (covers && invocation == first) {
        let counts = countOneBits(ballot);
        node = atomicAdd(&node_count, counts.x + counts.y + counts.z + counts.w);
    }
    node = subgroupShuffle(node, min(first, size - 1u));
    if (covers) {
        link_fragment(node + rank, in);
    }
    discard_uncovered(in);
}
