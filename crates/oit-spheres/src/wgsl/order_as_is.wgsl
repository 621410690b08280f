fn object_at(slot: u32) -> u32 {
    return slot;
}
