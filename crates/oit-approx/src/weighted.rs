//! Weighted, blended order-independent transparency.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Blend, Format, Plan};

use crate::draw::{finish, into, scene, target};
use crate::twin;

/// Colours are added with weights that fall with depth, and normalised by the sum of the weights; the
/// transmittance is exact. One draw of the scene, two targets, nothing else.
///
/// The weight is equation 10 of the paper, of window depth: `alpha * clamp(3000 (1 - z)^3, 0.01, ..)`.
#[derive(Clone, Copy, Debug)]
pub struct Weighted;

const ADD: &str = "
struct Added {
    @location(0) weighted: vec4<f32>,
    @location(1) covered: f32,
}

@fragment
fn fs(in: Varyings) -> Added {
    discard_uncovered(in);
    let own = unpack4x8unorm(shade(in));
    let nearness = 1.0 - fragment_depth(in);
    let weight = own.a * max(0.01, 3000.0 * nearness * nearness * nearness);
    return Added(vec4<f32>(own.rgb * own.a, own.a) * weight, own.a);
}
";

const FINISH: &str = "
@group(0) @binding(0) var weighted: texture_2d<f32>;
@group(0) @binding(1) var transmittance: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    let sum = textureLoad(weighted, at, 0);
    let covered = 1.0 - textureLoad(transmittance, at, 0).x;
    return vec4<f32>(sum.rgb / max(sum.a, 1e-20) * covered, covered);
}
";

impl Method for Weighted {
    fn name(&self) -> &'static str {
        "weighted"
    }

    fn summary(&self) -> &'static str {
        "Weighted, blended OIT: colours added with weights that fall with depth, exact transmittance."
    }

    fn citation(&self) -> &'static str {
        "McGuire and Bavoil, Weighted Blended Order-Independent Transparency, JCGT 2013, equation 10"
    }

    fn accuracy(&self, _: Option<u32>, _: &DepthHistogram) -> Accuracy {
        Accuracy::Approximate("colours are a weighted average".into())
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let color = vec![
            into("weighted", 0.0, Some(Blend::Add)),
            into("transmittance", 1.0, Some(Blend::Attenuate)),
        ];
        Ok(Plan {
            name: self.name().to_owned(),
            buffers: request.geometry.buffers(),
            targets: vec![
                target("weighted", Format::Rgba32Float, request),
                target("transmittance", Format::R32Float, request),
                target(PICTURE, Format::Rgba32Float, request),
            ],
            passes: vec![
                scene(request, "capture", "capture: weighted sums".into(), ADD, color),
                finish("resolve: weighted average".into(), FINISH),
            ],
        })
    }

    fn twin(&self, _: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        twin::pixels(submitted, |_, fragments, (): &mut ()| {
            let mut sum = [0.0f32; 4];
            let mut transmittance = 1.0f32;
            for &fragment in fragments {
                let [r, g, b, a] = twin::rgba(fragment);
                let nearness = 1.0 - fragment.depth();
                let weight = a * (3000.0 * nearness * nearness * nearness).max(0.01);
                for (sum, own) in sum.iter_mut().zip([r * a, g * a, b * a, a]) {
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
