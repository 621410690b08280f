// The sphere behind its triangle.
fn depth_of(hit: Hit, in: Corner) -> f32 {
    if PROJECT_FRAGMENT {
        let clip = view.projection * vec4<f32>(hit.position, 1.0);
        return clip.z / clip.w;
    }
    let clip = in.center_clip - view.projection[2].zw * hit.behind;
    return clip.x / clip.y;
}
