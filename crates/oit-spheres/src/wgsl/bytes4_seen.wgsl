// The ids name the sphere, and it is met once more.
fn seen_at(pixel: vec2<u32>) -> Seen {
    let ids = ids_at(pixel);
    if ids.z == 0u {
        return Seen();
    }
    let hit = meet(sphere_of(ids.x, ids.y), vec2<f32>(pixel) + 0.5);
    return Seen(true, ids.x, ids.y, hit.position, hit.normal);
}
