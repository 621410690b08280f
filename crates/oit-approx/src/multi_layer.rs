//! Multi-layer alpha blending.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Buffer, Format, Pass, Plan};

use crate::draw::{COVERAGE, each_pixel, no_color, pixels, scene, target};
use crate::k_buffer::{CORE, NEAREST, STORE};
use crate::twin;

/// A few nodes a pixel, in order of depth. A fragment becomes a node; where there is no node left for
/// it, the farthest two are blended into one, at the depth of the nearer. So all nodes but the last are
/// the nearest fragments, and the last is all others, in the order in which they were driven out: the
/// picture depends on the order of arrival.
///
/// The paper changes a pixel's nodes in a critical section, of which WGSL has none. Here a node is one
/// 64-bit word, depth and colour, and each step of the insertion is one atomic: the nearest by maximum,
/// as [`KBuffer`](crate::KBuffer) does it, and the last by compare and exchange. Each fragment enters the
/// last node once, in some order, as if one fragment came after the other. Colours are not
/// premultiplied, so that up to as many fragments as there are nodes are exact; what is blended is
/// rounded to eight bits, and what adds less than half of 1/255 to the last node's alpha adds nothing.
///
/// A fragment that has been overtaken for too long at the last node is left out, and counted in the
/// buffer `lost` (one `u32`).
#[derive(Clone, Copy, Debug)]
pub struct MultiLayer {
    /// Turns that a fragment takes at the last node. Fewer than 65,535, after which llvmpipe ends a
    /// loop.
    pub tries: u32,
}

/// Nodes of a pixel where no number is given.
const NODES: u32 = 4;

const KEEP: &str = "
@group(0) @binding(1) var<storage, read_write> nearest: array<atomic<u64>>;
@group(0) @binding(2) var<storage, read_write> lost: atomic<u32>;

const TAIL = NODES - 1u;

// Keys are inverted, so that zeros are empty and the nearest is the largest. Whole numbers alone: the
// same on every device.
fn merged(front: u64, back: u64) -> u64 {
    let places = vec4<u32>(0u, 8u, 16u, 24u);
    let near = (vec4<u32>(~u32(front & 0xFFFFFFFFlu)) >> places) & vec4<u32>(255u);
    let far = (vec4<u32>(~u32(back & 0xFFFFFFFFlu)) >> places) & vec4<u32>(255u);
    let shares = vec2<u32>(near.a * 255u, (255u - near.a) * far.a);
    let all = shares.x + shares.y;
    let color = (near.rgb * shares.x + far.rgb * shares.y + all / 2u) / max(all, 1u);
    let rgba = vec4<u32>(color, (all + 127u) / 255u) << places;
    return (front & 0xFFFFFFFF00000000lu) | u64(~(rgba.x | rgba.y | rgba.z | rgba.w));
}

fn insert(pixel: u32, fragment: vec2<u32>) {
    var key = ~((u64(fragment.y) << 32u) | u64(fragment.x));
    for (var i = 0u; i < TAIL && key != 0lu; i += 1u) {
        key = min(key, atomicMax(&nearest[i * PIXELS + pixel], key));
    }
    if (key == 0lu) {
        return;
    }
    let tail = TAIL * PIXELS + pixel;
    var seen = atomicLoad(&nearest[tail]);
    var done = false;
    for (var turn = 0u; turn < TRIES && !done; turn += 1u) {
        var next = key;
        if (seen != 0lu) {
            next = merged(max(key, seen), min(key, seen));
        }
        let found = atomicCompareExchangeWeak(&nearest[tail], seen, next);
        seen = found.old_value;
        done = found.exchanged;
    }
    if (!done) {
        atomicAdd(&lost, 1u);
    }
}

// Helper invocations cover no sample. Atomics give them nothing, so that they would go on to the end
// of the loop.
@fragment
fn fs(in: Varyings, @builtin(sample_mask) mask: u32) -> @location(0) vec4<f32> {
    if (mask != 0u && covered(in)) {
        insert(pixel_index(in.position), vec2<u32>(shade(in), depth_key(fragment_depth(in))));
    }
    discard_uncovered(in);
    return vec4<f32>();
}
";

/// `merged` of the shader, of keys that are not inverted.
fn merged(front: u64, back: u64) -> u64 {
    let channels = |key: u64| (key as u32).to_le_bytes().map(u32::from);
    let (near, far) = (channels(front), channels(back));
    let shares = [near[3] * 255, (255 - near[3]) * far[3]];
    let all = shares[0] + shares[1];
    let color =
        [0, 1, 2].map(|c| (near[c] * shares[0] + far[c] * shares[1] + all / 2) / all.max(1));
    let rgba = [color[0], color[1], color[2], (all + 127) / 255].map(|channel| channel as u8);
    (front & 0xFFFF_FFFF_0000_0000) | u64::from(u32::from_le_bytes(rgba))
}

impl MultiLayer {
    /// Patient enough for thousands of fragments at one pixel at once: each turn that one of them
    /// takes in vain is another's that was not.
    pub const PATIENT: Self = Self { tries: 8192 };
}

impl Method for MultiLayer {
    fn name(&self) -> &'static str {
        "multi_layer"
    }

    fn summary(&self) -> &'static str {
        "Multi-layer alpha blending: a few nodes a pixel, of which the farthest two are merged."
    }

    fn citation(&self) -> &'static str {
        "Salvi and Vaidyanathan, Multi-Layer Alpha Blending, I3D 2014; without a critical section"
    }

    fn size(&self) -> Option<Size> {
        Some(Size { word: "nodes", range: 2..=64, default: Some(NODES) })
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        let (nodes, peak) = (size.unwrap_or(NODES), histogram.peak());
        if peak <= nodes {
            return Accuracy::Exact;
        }
        let what = format!("up to {peak} fragments in {nodes} nodes, in the order of arrival");
        Accuracy::Approximate(what)
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let (nodes, count) = (request.size.unwrap_or(NODES), pixels(request));
        let constants = format!(
            "const NODES = {nodes}u;\nconst PIXELS = {count}u;\nconst TRIES = {}u;\n",
            self.tries
        );
        let blend = CORE.replace("Ku", &format!("{nodes}u")) + STORE;
        let mut buffers = request.geometry.buffers();
        buffers.push(Buffer::new("nearest", 8 * u64::from(nodes) * u64::from(count)));
        buffers.push(Buffer::new("lost", 4));
        buffers.push(Buffer::new(PICTURE, 16 * u64::from(count)));
        Ok(Plan {
            name: self.name().to_owned(),
            buffers,
            targets: vec![target(COVERAGE, Format::R8Unorm, request)],
            passes: vec![
                Pass::clear("clear", "nearest"),
                Pass::clear("clear", "lost"),
                scene(
                    request,
                    "capture",
                    format!("capture: {nodes} nodes"),
                    &(constants + KEEP),
                    vec![no_color()],
                ),
                each_pixel(request, "resolve: the nodes, in order", NEAREST, &blend),
            ],
        })
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let nodes = size.unwrap_or(NODES) as usize;
        twin::pixels(submitted, |_, fragments, keys: &mut Vec<u64>| {
            keys.clear();
            for fragment in fragments {
                let key = fragment.key();
                let place = keys.partition_point(|&other| other <= key);
                keys.insert(place, key);
                if keys.len() > nodes {
                    let back = keys.pop().expect("more than there are nodes");
                    let front = keys.last_mut().expect("a node");
                    *front = merged(*front, back);
                }
            }
            let (mut color, mut left) = ([0.0f32; 3], 1.0f32);
            for &key in &*keys {
                let [r, g, b, a] = (key as u32).to_le_bytes().map(|c| f32::from(c) / 255.0);
                for (color, own) in color.iter_mut().zip([r, g, b]) {
                    *color += left * a * own;
                }
                left *= 1.0 - a;
            }
            [color[0], color[1], color[2], 1.0 - left]
        })
    }
}
