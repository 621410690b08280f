// An atom of an object as one word. `ATOM_BITS` of it are the atom's number within its level.
fn id_of(object: u32, atom: u32) -> u32 {
    return object << ATOM_BITS | (atom - placed[2u * object].w);
}

// The object and the atom of such a word.
fn of_id(id: u32) -> vec2<u32> {
    let object = id >> ATOM_BITS;
    return vec2<u32>(object, placed[2u * object].w + (id & ((1u << ATOM_BITS) - 1u)));
}
