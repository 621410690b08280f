//! Adaptive transparency.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb, depth_from_key};
use oit_gpu::{Blend, Buffer, Format, Pass, Plan};

use crate::draw::{COVERAGE, finish, into, no_color, pixels, scene, target};
use crate::twin;

/// How much light comes through to each depth of a pixel is kept as a curve of a few steps. A fragment
/// adds a step; where there is no room for one, that step is removed which changes the area under the
/// curve least, and what it took away is taken away at the step before it. A second draw adds each
/// fragment's colour by what the curve says of its depth.
///
/// A step that was removed darkens fragments before it too. The order in which fragments arrive decides
/// which steps are removed, so the picture depends on it. The transmittance is exact, and where
/// fragments of one depth would add up to more than it leaves, they are scaled to it: that is not in
/// the paper.
///
/// A curve is changed under a lock, one a pixel, which fragments try for so many turns. A fragment that
/// does not get it is missing in the curve, and counted in the buffer `lost` (one `u32`). Steps are
/// 64-bit words: a float of depth, 16 bits of transmittance, and which change wrote it, since WGSL does
/// not promise that who takes a lock sees what its last holder wrote.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive {
    /// Turns that a fragment takes at the lock. Fewer than 65,535, after which llvmpipe ends a loop.
    pub tries: u32,
}

/// Nodes of a pixel where no number is given.
const NODES: u32 = 8;

/// Times a node is read again before the lock is given back for what its last holder wrote to arrive.
const WAITS: u32 = 64;

const INSERT: &str = include_str!("adaptive.wgsl");

const ADD: &str = "
@group(0) @binding(1) var<storage, read> nodes: array<u64>;

struct Added {
    @location(0) seen: vec4<f32>,
    @location(1) covered: f32,
}

@fragment
fn fs(in: Varyings) -> Added {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let depth = ~depth_key(fragment_depth(in));
    let own = unpack4x8unorm(shade(in));
    var left = 65535u;
    for (var i = 0u; i < NODES; i += 1u) {
        let node = nodes[i * PIXELS + pixel];
        if (u32(node >> 32u) > depth) {
            left = 65535u - u32((node >> 16u) & 0xFFFFlu);
        }
    }
    let weight = own.a * (f32(left) / 65535.0);
    return Added(vec4<f32>(own.rgb, 1.0) * weight, own.a);
}
";

const FINISH: &str = "
@group(0) @binding(0) var seen: texture_2d<f32>;
@group(0) @binding(1) var transmittance: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    let sum = textureLoad(seen, at, 0);
    let covered = 1.0 - textureLoad(transmittance, at, 0).x;
    return vec4<f32>(sum.rgb * min(covered / max(sum.a, 1e-20), 1.0), covered);
}
";

/// Steps of a pixel's transmittance, from the nearest: where, inverted and as sortable bits, and what
/// is left behind it, of 65535.
#[derive(Default)]
struct Curve {
    steps: Vec<(u32, u32)>,
}

impl Curve {
    fn through(left: u32, alpha: u32) -> u32 {
        (left * (255 - alpha) + 127) / 255
    }

    fn insert(&mut self, nodes: usize, fragment: Fragment) {
        let (depth, alpha) = (!fragment.depth_key, fragment.rgba >> 24);
        if alpha == 0 {
            return;
        }
        let steps = &mut self.steps;
        let place = steps.partition_point(|step| step.0 >= depth);
        let before = if place == 0 { 65_535 } else { steps[place - 1].1 };
        for step in &mut steps[place..] {
            step.1 = Self::through(step.1, alpha);
        }
        steps.insert(place, (depth, Self::through(before, alpha)));
        if steps.len() > nodes {
            let (mut least, mut least_area) = (1, 1e30);
            for i in 1..steps.len() {
                let length = depth_from_key(!steps[i].0) - depth_from_key(!steps[i - 1].0);
                let area = length * (steps[i - 1].1 - steps[i].1) as f32;
                if area < least_area {
                    (least, least_area) = (i, area);
                }
            }
            steps[least - 1].1 = steps[least].1;
            steps.remove(least);
        }
    }

    /// What is left before this depth, of 65535.
    fn before(&self, depth_key: u32) -> u32 {
        let place = self.steps.partition_point(|step| step.0 > !depth_key);
        if place == 0 { 65_535 } else { self.steps[place - 1].1 }
    }
}

impl Adaptive {
    /// Patient enough for some hundred fragments at one pixel at once.
    pub const PATIENT: Self = Self { tries: 8192 };
}

impl Method for Adaptive {
    fn name(&self) -> &'static str {
        "adaptive"
    }

    fn summary(&self) -> &'static str {
        "Adaptive transparency: a curve of transmittance in a few steps a pixel, drawn twice."
    }

    fn citation(&self) -> &'static str {
        "Salvi, Montgomery and Lefohn, Adaptive Transparency, HPG 2011; with a spin lock"
    }

    fn size(&self) -> Option<Size> {
        Some(Size { word: "nodes", range: 2..=32, default: Some(NODES) })
    }

    fn accuracy(&self, size: Option<u32>, _: &DepthHistogram) -> Accuracy {
        let nodes = size.unwrap_or(NODES);
        Accuracy::Approximate(format!("transmittance in {nodes} steps of 16 bits"))
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let (nodes, count) = (request.size.unwrap_or(NODES), pixels(request));
        let constants = format!(
            "const NODES = {nodes}u;\nconst PIXELS = {count}u;\nconst TRIES = {}u;\n\
             const WAITS = {WAITS}u;\n",
            self.tries
        );
        let mut buffers = request.geometry.buffers();
        buffers.push(Buffer::new("nodes", 8 * u64::from(nodes) * u64::from(count)));
        buffers.push(Buffer::new("locks", 4 * u64::from(count)));
        buffers.push(Buffer::new("lost", 4));
        let sums = vec![
            into("seen", 0.0, Some(Blend::Add)),
            into("transmittance", 1.0, Some(Blend::Attenuate)),
        ];
        let insert = [&constants, INSERT].concat();
        Ok(Plan {
            name: self.name().to_owned(),
            buffers,
            targets: vec![
                target(COVERAGE, Format::R8Unorm, request),
                target("seen", Format::Rgba32Float, request),
                target("transmittance", Format::R32Float, request),
                target(PICTURE, Format::Rgba32Float, request),
            ],
            passes: vec![
                Pass::clear("clear", "nodes"),
                Pass::clear("clear", "locks"),
                Pass::clear("clear", "lost"),
                scene(request, "capture", "capture: curves".into(), &insert, vec![no_color()]),
                scene(request, "blend", "blend: what is seen".into(), &(constants + ADD), sums),
                finish("resolve: no more than is covered".into(), FINISH),
            ],
        })
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let nodes = size.unwrap_or(NODES) as usize;
        twin::pixels(submitted, |_, fragments, curve: &mut Curve| {
            curve.steps.clear();
            for &fragment in fragments {
                curve.insert(nodes, fragment);
            }
            let (mut sum, mut transmittance) = ([0.0f32; 4], 1.0f32);
            for &fragment in fragments {
                let [r, g, b, a] = twin::rgba(fragment);
                let weight = a * (curve.before(fragment.depth_key) as f32 / 65_535.0);
                for (sum, own) in sum.iter_mut().zip([r, g, b, 1.0]) {
                    *sum += own * weight;
                }
                transmittance *= 1.0 - a;
            }
            let covered = 1.0 - transmittance;
            let scale = (covered / sum[3].max(1e-20)).min(1.0);
            [sum[0] * scale, sum[1] * scale, sum[2] * scale, covered]
        })
    }
}
