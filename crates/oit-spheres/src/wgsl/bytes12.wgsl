fn fragment_of(ids: vec2<u32>, hit: Hit) -> Fragment {
    let normal = half_turned(hit.normal, hit.towards);
    let bytes = pack4x8snorm(vec4<f32>(0.0, 0.0, normal.xy));
    var out: Fragment;
    out.ids = ids.x;
    out.xy = pack2x16float(hit.position.xy);
    out.z_normal = pack2x16float(vec2<f32>(hit.position.z, 0.0)) | bytes;
    return out;
}
