// A normal that is seen lies in the hemisphere about the direction to the camera. With half a turn
// about what lies midway, that direction becomes the z axis, and x and y tell the rest (section
// 3.3.2). About the image's own axis they would not: under perspective one sees round a sphere.
fn half_turned(v: vec3<f32>, towards: vec3<f32>) -> vec3<f32> {
    let midway = normalize(towards) + vec3<f32>(0.0, 0.0, 1.0);
    return midway * (dot(v, midway) / midway.z) - v;
}

fn from_hemisphere(xy: vec2<f32>, towards: vec3<f32>) -> vec3<f32> {
    let z = sqrt(max(1.0 - dot(xy, xy), 0.0));
    return half_turned(vec3<f32>(xy, z), towards);
}
