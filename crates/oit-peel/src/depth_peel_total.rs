//! Depth peeling by the total order, which loses no fragment.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb, Ties};
use oit_gpu::{Buffer, ColorAttachment, Dispatch, Format, Load, Pass, Plan, Shader};
use oit_sort::{End, composite};

use crate::draw::{When, scene, target};
use crate::{passes, twin};

/// Draws the scene once a layer and once more. A layer is what has the nearest key of depth and
/// colour (64 bits) beyond the layer before: a 64-bit atomic minimum finds the key, and the next draw
/// counts the fragments that have it. A compute pass blends them, as often as they are.
///
/// So fragments at one depth, and even equal ones, are all there. Layers of unlike colour at one depth
/// take a pass each.
#[derive(Clone, Copy, Debug)]
pub struct DepthPeelTotal;

const PEEL: &str = "
@group(0) @binding(1) var<storage, read> reached: array<u64>;
@group(0) @binding(2) var<storage, read_write> next: array<atomic<u64>>;
@group(0) @binding(3) var<storage, read_write> times: array<atomic<u32>>;

@fragment
fn fs(in: Varyings) -> @location(0) vec4<f32> {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    // Inverted, so that zeros are beyond every fragment and the nearest is the largest.
    let key = ~((u64(depth_key(fragment_depth(in))) << 32u) | u64(shade(in)));
    let before = reached[pixel];
    if (before == 0lu || key < before) {
        atomicMax(&next[pixel], key);
    } else if (key == before) {
        atomicAdd(&times[pixel], 1u);
    }
    return vec4<f32>();
}
";

const BLEND: &str = "
@group(0) @binding(0) var<storage, read_write> reached: array<u64>;
@group(0) @binding(1) var<storage, read_write> next: array<u64>;
@group(0) @binding(2) var<storage, read_write> times: array<u32>;
@group(0) @binding(3) var<storage, read_write> image: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = (group.y * groups.x + group.x) * 256u + lane;
    if (pixel >= PIXELSu) {
        return;
    }
    let layer = reached[pixel];
    if (layer != 0lu) {
        let own = unpack4x8unorm(u32((~layer) & 0xFFFFFFFFlu));
        var picture = image[pixel];
        for (var i = times[pixel]; i > 0u; i -= 1u) {
            picture += (1.0 - picture.w) * vec4<f32>(own.rgb * own.a, own.a);
        }
        image[pixel] = picture;
        times[pixel] = 0u;
    }
    // 1 is beyond every fragment: the pixel is done.
    reached[pixel] = select(1lu, next[pixel], next[pixel] != 0lu);
    next[pixel] = 0lu;
}
";

impl Method for DepthPeelTotal {
    fn name(&self) -> &'static str {
        "depth_peel_total"
    }

    fn summary(&self) -> &'static str {
        "Depth peeling by 64-bit keys of depth and colour, front to back: fragments at one depth are \\
         peeled one after the other, and equal ones are counted."
    }

    fn citation(&self) -> &'static str {
        "This project; after Everitt, Interactive Order-Independent Transparency, NVIDIA 2001"
    }

    fn size(&self) -> Option<Size> {
        Some(passes::size())
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        passes::accuracy(size, histogram, 1, Accuracy::Exact)
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let count = passes::recorded(request, 1, false)?;
        let pixels = request.width_px.saturating_mul(request.height_px);
        let words = u64::from(pixels);
        let mut plan = Plan {
            name: self.name().to_owned(),
            buffers: request.geometry.buffers(),
            targets: vec![target("coverage", Format::R8Unorm, request)],
            passes: Vec::new(),
        };
        for (name, bytes) in [("reached", 8), ("next", 8), ("times", 4), (PICTURE, 16)] {
            plan.buffers.push(Buffer::new(name, bytes * words));
            plan.passes.push(Pass::clear("clear", name));
        }
        let groups = pixels.div_ceil(256);
        let x = groups.clamp(1, 32_768);
        let all = Dispatch::Workgroups([x, groups.div_ceil(x), 1]);
        for pass in 0..=count {
            let none = ColorAttachment {
                target: "coverage".into(),
                load: Load::Clear([0.0; 4]),
                blend: None,
                write: false,
            };
            let label = format!("peel: layer {pass}, and how often the one before is there");
            plan.passes.push(scene(request, When::Always, label, PEEL, vec![none], None));
            let wgsl = BLEND.replace("PIXELS", &pixels.to_string());
            let shader = Shader::new(format!("blend: the layer before {pass}"), wgsl);
            plan.passes.push(Pass::compute("blend", shader, all.clone()));
        }
        Ok(plan)
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        twin::pixels(submitted, |fragments, sorted: &mut Vec<Fragment>| {
            sorted.clear();
            sorted.extend_from_slice(fragments);
            sorted.sort_unstable_by(|&a, &b| Ties::Total.compare(a, b));
            let count = passes::of_twin(self, size, fragments.len() as u32, 1) as usize;
            let layers = sorted.chunk_by(|a, b| a == b).take(count);
            composite(layers.flatten().copied(), End::Front)
        })
    }
}
