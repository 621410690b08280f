// Where a pixel's ray meets a sphere.
struct Hit {
    covered: bool,
    // How much deeper than the sphere's centre.
    behind: f32,
    position: vec3<f32>,
    normal: vec3<f32>,
    // Towards the camera, not of length 1.
    towards: vec3<f32>,
}

// Everything is counted from the sphere's centre: a small sphere far away is then as round as any.
// A ray that passes the sphere is given its nearest point. Where the front of the sphere lies before
// the near plane, it is not covered: spheres have no inside.
fn meet(sphere: vec4<f32>, pixel: vec2<f32>) -> Hit {
    let at = pixel_at(pixel);
    let ray = select(vec2<f32>(), at, PERSPECTIVE);
    let q = sphere.xy - at * select(1.0, -sphere.z, PERSPECTIVE);
    let length2 = 1.0 + dot(ray, ray);
    let along = dot(ray, q);
    let inside = along * along + length2 * (sphere.w * sphere.w - dot(q, q));
    let behind = (along - sqrt(max(inside, 0.0))) / length2;
    let depth = behind - sphere.z;
    let from_center = vec3<f32>(ray * behind - q, -behind);
    var hit: Hit;
    hit.covered = inside >= 0.0 && depth >= view.near;
    hit.behind = behind;
    hit.position = sphere.xyz + from_center;
    hit.normal = from_center * inverseSqrt(max(dot(from_center, from_center), 1e-30));
    hit.towards = vec3<f32>(-ray, 1.0);
    return hit;
}
