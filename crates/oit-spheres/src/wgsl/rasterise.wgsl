// A compute rasteriser: an invocation draws a small sphere, a workgroup a large one. A pixel keeps
// the greatest of its words: the depth, which is reversed, then the sphere's id.
@group(0) @binding(8) var<storage, read> batches: array<vec4<u32>>;
@group(0) @binding(9) var<storage, read> batch_count: array<u32, 4>;
@group(0) @binding(10) var<storage, read> batch_groups: array<u32, 3>;
@group(0) @binding(16) var<storage, read_write> nearest: array<atomic<u64>>;

// Pixels of the largest small one.
const SMALL = 32;

var<workgroup> large: array<vec4<f32>, 64>;
var<workgroup> large_id: array<u32, 64>;
var<workgroup> large_count: atomic<u32>;

fn draw(sphere: vec4<f32>, id: u32, pixel: vec2<i32>) {
    let hit = meet(sphere, vec2<f32>(pixel) + 0.5);
    if !hit.covered {
        return;
    }
    let clip = view.projection[2].zw * (sphere.z - hit.behind) + view.projection[3].zw;
    let depth = min(clip.x / clip.y, 1.0);
    if depth > 0.0 {
        let word = u64(bitcast<u32>(depth)) << 32u | u64(id);
        atomicMax(&nearest[u32(pixel.y) * view.width_px + u32(pixel.x)], word);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let number = group.y * batch_groups[0] + group.x;
    var batch = vec4<u32>();
    if number < batch_count[0] {
        batch = batches[number];
    }
    if local == 0u {
        atomicStore(&large_count, 0u);
    }
    workgroupBarrier();
    if local < batch.y {
        let atom = batch.x + local;
        let sphere = sphere_of(batch.z, atom);
        let extent = extent_of(sphere);
        let size = extent.last - extent.first + 1;
        if all(size > vec2<i32>(0)) {
            let id = id_of(batch.z, atom);
            if size.x <= SMALL && size.y <= SMALL && size.x * size.y <= SMALL {
                for (var y = extent.first.y; y <= extent.last.y; y++) {
                    for (var x = extent.first.x; x <= extent.last.x; x++) {
                        draw(sphere, id, vec2<i32>(x, y));
                    }
                }
            } else {
                let at = atomicAdd(&large_count, 1u);
                large[at] = sphere;
                large_id[at] = id;
            }
        }
    }
    workgroupBarrier();
    let count = atomicLoad(&large_count);
    for (var i = 0u; i < count; i++) {
        let sphere = large[i];
        let extent = extent_of(sphere);
        let size = vec2<u32>(extent.last - extent.first + 1);
        for (var at = local; at < size.x * size.y; at += 64u) {
            let offset = vec2<i32>(vec2<u32>(at % size.x, at / size.x));
            draw(sphere, large_id[i], extent.first + offset);
        }
    }
}
