//! Stochastic transparency.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb};
use oit_gpu::{Blend, Buffer, Format, Pass, Plan};

use crate::draw::{COVERAGE, finish, into, no_color, pixels, scene, target};
use crate::twin;

/// Each fragment covers each of a pixel's samples with the probability of its alpha, and every sample
/// keeps the depth of the nearest fragment that covers it. A second draw adds each fragment's colour
/// times the share of samples that it is not behind, which is what it is seen of; the sums are scaled
/// to the exact transmittance (the paper's alpha correction).
///
/// Samples lie in a buffer and are found by atomic minimum, not by the hardware's multisampling. Which
/// samples a fragment covers is a hash of its pixel, depth and colour, so that a frame is the same each
/// time it is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Stochastic;

/// Samples of a pixel where no number is given.
const SAMPLES: u32 = 16;

const COVER: &str = "
// PCG (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 2020).
fn scrambled(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

@group(0) @binding(1) var<storage, read_write> samples: array<atomic<u32>>;

@fragment
fn fs(in: Varyings) -> @location(0) vec4<f32> {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let key = depth_key(fragment_depth(in));
    let rgba = shade(in);
    let seed = scrambled(scrambled(scrambled(pixel) ^ key) ^ rgba);
    let alpha = f32(rgba >> 24u) / 255.0;
    for (var i = 0u; i < SAMPLESu; i += 1u) {
        if (f32(scrambled(seed + i) >> 8u) < alpha * 16777216.0) {
            // Inverted, so that zeros are beyond every depth.
            atomicMax(&samples[i * PIXELSu + pixel], ~key);
        }
    }
    return vec4<f32>();
}
";

const ADD: &str = "
@group(0) @binding(1) var<storage, read> samples: array<u32>;

struct Added {
    @location(0) seen: vec4<f32>,
    @location(1) covered: f32,
}

@fragment
fn fs(in: Varyings) -> Added {
    discard_uncovered(in);
    let pixel = pixel_index(in.position);
    let key = depth_key(fragment_depth(in));
    let own = unpack4x8unorm(shade(in));
    var before = 0u;
    for (var i = 0u; i < SAMPLESu; i += 1u) {
        before += u32(~samples[i * PIXELSu + pixel] >= key);
    }
    let weight = own.a * f32(before) / SAMPLES.0;
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
    return vec4<f32>(sum.rgb / max(sum.a, 1e-20) * covered, covered);
}
";

fn scrambled(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Whether a fragment of this pixel covers a sample.
fn covers(pixel: usize, fragment: Fragment, sample: u32) -> bool {
    let seed = scrambled(scrambled(scrambled(pixel as u32) ^ fragment.depth_key) ^ fragment.rgba);
    let alpha = (fragment.rgba >> 24) as f32 / 255.0;
    ((scrambled(seed.wrapping_add(sample)) >> 8) as f32) < alpha * 16_777_216.0
}

impl Method for Stochastic {
    fn name(&self) -> &'static str {
        "stochastic"
    }

    fn summary(&self) -> &'static str {
        "Stochastic transparency: random coverage of samples, drawn twice, with alpha correction."
    }

    fn citation(&self) -> &'static str {
        "Enderton, Sintorn, Shirley and Luebke, Stochastic Transparency, I3D 2010"
    }

    fn size(&self) -> Option<Size> {
        Some(Size { word: "samples", range: 1..=256, default: Some(SAMPLES) })
    }

    fn accuracy(&self, size: Option<u32>, _: &DepthHistogram) -> Accuracy {
        let samples = size.unwrap_or(SAMPLES);
        Accuracy::Approximate(format!("{samples} random samples a pixel"))
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let samples = request.size.unwrap_or(SAMPLES);
        let count = pixels(request);
        let wgsl = |text: &str| {
            text.replace("SAMPLES", &samples.to_string()).replace("PIXELS", &count.to_string())
        };
        let mut buffers = request.geometry.buffers();
        buffers.push(Buffer::new("samples", 4 * u64::from(samples) * u64::from(count)));
        let sums = vec![
            into("seen", 0.0, Some(Blend::Add)),
            into("transmittance", 1.0, Some(Blend::Attenuate)),
        ];
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
                Pass::clear("clear", "samples"),
                scene(
                    request,
                    "capture",
                    "capture: cover samples".into(),
                    &wgsl(COVER),
                    vec![no_color()],
                ),
                scene(request, "blend", "blend: what is seen".into(), &wgsl(ADD), sums),
                finish("resolve: alpha correction".into(), FINISH),
            ],
        })
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let samples = size.unwrap_or(SAMPLES);
        twin::pixels(submitted, |pixel, fragments, nearest: &mut Vec<u32>| {
            nearest.clear();
            nearest.extend((0..samples).map(|sample| {
                let covering = fragments.iter().filter(|own| covers(pixel, **own, sample));
                covering.map(|fragment| fragment.depth_key).min().unwrap_or(u32::MAX)
            }));
            let (mut sum, mut transmittance) = ([0.0f32; 4], 1.0f32);
            for &fragment in fragments {
                let [r, g, b, a] = twin::rgba(fragment);
                let before = nearest.iter().filter(|&&key| key >= fragment.depth_key).count();
                let weight = a * before as f32 / samples as f32;
                for (sum, own) in sum.iter_mut().zip([r, g, b, 1.0]) {
                    *sum += own * weight;
                }
                transmittance *= 1.0 - a;
            }
            let covered = 1.0 - transmittance;
            let [r, g, b] = [0, 1, 2].map(|c| sum[c] / sum[3].max(1e-20) * covered);
            [r, g, b, covered]
        })
    }
}
