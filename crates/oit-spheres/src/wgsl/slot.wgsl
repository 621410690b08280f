// The invocation's place in the order of objects.
fn slot_of(group: vec3<u32>, local: u32) -> u32 {
    return (group.y * ROW + group.x) * 256u + local;
}
