// The first number of each object's atoms, rising.
@group(0) @binding(18) var<storage, read> first_ids: array<u32>;

// An atom of an object as one word: its number among all atoms of all objects.
fn id_of(object: u32, atom: u32) -> u32 {
    return first_ids[object] + (atom - placed[2u * object].w);
}

// The object and the atom of such a word: the last object whose numbers begin there or before.
fn of_id(id: u32) -> vec2<u32> {
    var object = 0u;
    var beyond = view.objects;
    while beyond - object > 1u {
        let middle = object + (beyond - object) / 2u;
        if first_ids[middle] <= id {
            object = middle;
        } else {
            beyond = middle;
        }
    }
    return vec2<u32>(object, placed[2u * object].w + (id - first_ids[object]));
}
