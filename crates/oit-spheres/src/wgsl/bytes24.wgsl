fn fragment_of(ids: vec2<u32>, hit: Hit) -> Fragment {
    let normal = half_turned(hit.normal, hit.towards);
    var out: Fragment;
    out.ids = ids.x;
    out.position = vec4<f32>(hit.position, normal.x);
    out.normal = normal.y;
    return out;
}
