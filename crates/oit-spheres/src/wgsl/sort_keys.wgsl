// Each object's distance as a key, and the object; behind them what sorts last.
@group(0) @binding(3) var<storage, read> places: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> sorted: array<vec2<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let object = slot_of(group, local);
    if object >= LENGTH {
        return;
    }
    var key = vec2<u32>(0xffffffffu, object);
    if object < view.objects {
        let from_eye = bitcast<vec3<f32>>(places[2u * object].xyz) - view.eye;
        // Nothing is in front of a box's near plane, and floats of one sign sort as integers.
        let depth = max(-turned(view.turn, from_eye).z - view.near, 0.0);
        key.x = bitcast<u32>(select(depth, length(from_eye), PERSPECTIVE));
    }
    sorted[object] = key;
}
