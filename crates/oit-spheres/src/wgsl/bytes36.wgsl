fn fragment_of(ids: vec2<u32>, hit: Hit) -> Fragment {
    var out: Fragment;
    out.ids = ids.x;
    out.position = vec4<f32>(hit.position, 1.0);
    out.normal = vec4<f32>(hit.normal, 0.0);
    return out;
}
