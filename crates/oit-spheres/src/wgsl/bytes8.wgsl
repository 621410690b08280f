fn fragment_of(ids: vec2<u32>, hit: Hit) -> Fragment {
    var out: Fragment;
    out.ids = ids.x;
    out.behind = -hit.position.z;
    return out;
}
