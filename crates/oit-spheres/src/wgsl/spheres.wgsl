// The spheres, with objects as `choose.wgsl` placed them in view space: two words of four for each,
// its position and its level's first atom, and how it is turned.
@group(0) @binding(1) var<storage, read> atoms: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> placed: array<vec4<u32>>;

// A sphere in view space: its centre and radius.
fn sphere_of(object: u32, atom: u32) -> vec4<f32> {
    let position = bitcast<vec3<f32>>(placed[2u * object].xyz);
    let turn = bitcast<vec4<f32>>(placed[2u * object + 1u]);
    let sphere = atoms[atom];
    return vec4<f32>(position + turned(turn, sphere.xyz), sphere.w);
}

// An atom of an object as one word. `ATOM_BITS` of it are the atom's number within its level.
fn id_of(object: u32, atom: u32) -> u32 {
    return object << ATOM_BITS | (atom - placed[2u * object].w);
}

// The object and the atom of such a word.
fn of_id(id: u32) -> vec2<u32> {
    let object = id >> ATOM_BITS;
    return vec2<u32>(object, placed[2u * object].w + (id & ((1u << ATOM_BITS) - 1u)));
}
