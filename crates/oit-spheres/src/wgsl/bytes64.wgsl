// Whole numbers as floats, 24 bits in each.
fn numbered(number: u32) -> vec4<f32> {
    return vec4<f32>(f32(number & 0xffffffu), f32(number >> 24u), 0.0, 1.0);
}

fn fragment_of(ids: vec2<u32>, hit: Hit) -> Fragment {
    var out: Fragment;
    out.atom = numbered(ids.y);
    out.instance = numbered(ids.x);
    out.position = vec4<f32>(hit.position, 1.0);
    out.normal = vec4<f32>(hit.normal, 0.0);
    return out;
}
