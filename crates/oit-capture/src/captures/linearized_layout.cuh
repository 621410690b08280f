struct Lfb {
    const u32 *offsets;
    const Frag *fragments;
    u32 room;
    u32 first;
    u32 slot;
    u32 end;
};

// An offset is the end of its pixel's run. A run that the pool has no room for ends, or is empty,
// where the pool ends.
INLINE void lfb_begin(Lfb &lfb, u32 pixel) {
    u32 first = pixel > 0 ? __ldg(lfb.offsets + (pixel - 1)) : 0;
    u32 end = __ldg(lfb.offsets + pixel);
    lfb.first = first < lfb.room ? first : lfb.room;
    lfb.slot = lfb.first;
    lfb.end = end < lfb.room ? end : lfb.room;
}

INLINE bool lfb_more(const Lfb &lfb) {
    return lfb.slot < lfb.end;
}

INLINE Frag lfb_next(Lfb &lfb) {
    u32 slot = lfb.slot;
    lfb.slot = slot + 1;
    return __ldg(lfb.fragments + slot);
}

INLINE u32 lfb_len(const Lfb &lfb) {
    return lfb.end - lfb.first;
}

INLINE Frag lfb_at(const Lfb &lfb, u32 i) {
    return __ldg(lfb.fragments + (lfb.first + i));
}
