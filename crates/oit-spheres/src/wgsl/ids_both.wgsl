fn ids_of(object: u32, atom: u32) -> vec2<u32> {
    return vec2<u32>(object, atom);
}
