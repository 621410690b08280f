fn lfb_slot_at(slot: u32) -> vec2<u32> {
    return ~fragments[slot];
}

