struct Lfb {
    const u32 *heads;
    const u32 *nexts;
    const Frag *fragments;
    u32 room;
    // The next node plus one, or 0 at the end.
    u32 node;
};

INLINE void lfb_begin(Lfb &lfb, u32 pixel) {
    lfb.node = __ldg(lfb.heads + pixel);
}

INLINE bool lfb_more(const Lfb &lfb) {
    return lfb.node != 0;
}

INLINE Frag lfb_next(Lfb &lfb) {
    u32 node = lfb.node - 1;
    lfb.node = __ldg(lfb.nexts + node);
    return __ldg(lfb.fragments + node);
}
