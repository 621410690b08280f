//! Depth peeling from front to back, one layer a pass.

use oit_capture::{Accuracy, Drawn, Geometry, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb};
use oit_gpu::{Blend, Compare, Depth, DepthStencil, Format, Load, Plan};
use oit_sort::{End, composite};

use crate::draw::{
    When, full_screen, note_left, picture, scene, stop_buffers, stop_clear, stop_if_done, target,
    to,
};
use crate::{passes, twin};

/// Draws the scene once a layer. Fragments no farther than the layer before are discarded, a depth
/// test keeps the nearest of the others, and a full-screen draw blends it under those before.
///
/// Of fragments at one depth the one drawn last is kept and the others are lost.
#[derive(Clone, Copy, Debug)]
pub struct DepthPeel {
    /// Whether passes are called off once a layer is empty, without knowing how many there are;
    /// otherwise they are as many as the deepest pixel has fragments.
    pub stops: bool,
}

/// Beyond every depth: a pixel whose layer is empty.
const NO_DEPTH: f32 = 2.0;

const PEEL: &str = "
@group(0) @binding(1) var BEFORE: texture_2d<f32>;

struct Layer {
    @location(0) color: vec4<f32>,
    @location(1) depth: f32,
    TESTED_MEMBER
}

@fragment
fn fs(in: Varyings) -> Layer {
    discard_uncovered(in);
    let depth = fragment_depth(in);
    if (depth <= textureLoad(BEFORE, vec2<i32>(in.position.xy), 0).x) {
        discard;
    }
    let own = unpack4x8unorm(shade(in));
    return Layer(vec4<f32>(own.rgb * own.a, own.a), depthTESTED_VALUE);
}
";

const FIRST: &str = "
struct Layer {
    @location(0) color: vec4<f32>,
    @location(1) depth: f32,
    TESTED_MEMBER
}

@fragment
fn fs(in: Varyings) -> Layer {
    discard_uncovered(in);
    let depth = fragment_depth(in);
    let own = unpack4x8unorm(shade(in));
    return Layer(vec4<f32>(own.rgb * own.a, own.a), depthTESTED_VALUE);
}
";

const BLEND: &str = "
@group(0) @binding(1) var layer: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(layer, vec2<i32>(position.xy), 0);
}
";

const BLEND_AND_NOTE: &str = "
@group(0) @binding(1) var layer: texture_2d<f32>;
@group(0) @binding(2) var DEPTH: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    if (textureLoad(DEPTH, at, 0).x <= 1.0) {
        left();
    }
    return textureLoad(layer, at, 0);
}
";

/// What a layer also has for the depth test where that is not the rasteriser's depth, and its value.
fn tested(geometry: &Geometry) -> [&'static str; 2] {
    match geometry.drawn {
        Drawn::Mesh(_) => ["", ""],
        Drawn::Spheres(_) => ["@builtin(frag_depth) tested: f32,", ", depth"],
    }
}

impl Method for DepthPeel {
    fn name(&self) -> &'static str {
        passes::stops_name(self.stops, ["depth_peel", "depth_peel_stop"])
    }

    fn summary(&self) -> &'static str {
        if self.stops {
            "Depth peeling, front to back; passes are called off once a layer is empty."
        } else {
            "Depth peeling, front to back, one layer each time the scene is drawn."
        }
    }

    fn citation(&self) -> &'static str {
        "Everitt, Interactive Order-Independent Transparency, NVIDIA 2001"
    }

    fn size(&self) -> Option<Size> {
        Some(passes::size())
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        passes::accuracy(size, histogram, 1, Accuracy::ExactWithoutTies)
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let count = passes::recorded(request, 1, self.stops)?;
        let depths = ["depth_even", "depth_odd"];
        let mut plan = Plan {
            name: self.name().to_owned(),
            buffers: request.geometry.buffers(),
            targets: vec![
                picture(request),
                target("layer", Format::Rgba32Float, request),
                target(depths[0], Format::R32Float, request),
                target(depths[1], Format::R32Float, request),
                target("nearest", Format::Depth32Float, request),
            ],
            passes: Vec::new(),
        };
        if self.stops {
            plan.buffers.extend(stop_buffers(count));
            plan.passes.push(stop_clear());
        }
        for pass in 0..count {
            let [own, before] = [pass % 2, (pass + 1) % 2].map(|i| depths[i as usize]);
            let when = if self.stops && pass > 0 { When::Left(pass) } else { When::Always };
            // Or equal, since depth 1, the far plane itself, is inside the view.
            let test = Depth { load: Load::Clear(1.0), compare: Compare::LessEqual, write: true };
            let nearest =
                DepthStencil { target: "nearest".into(), depth: Some(test), stencil: None };
            let fs = if pass == 0 { FIRST.to_owned() } else { PEEL.replace("BEFORE", before) };
            let [member, value] = tested(request.geometry);
            let fs = fs.replace("TESTED_MEMBER", member).replace("TESTED_VALUE", value);
            let color = vec![
                to("layer", Load::Clear([0.0; 4]), None),
                to(own, Load::Clear([NO_DEPTH; 4]), None),
            ];
            let label = format!("peel: layer {pass}");
            plan.passes.push(scene(request, when, label, &fs, color, Some(nearest)));
            let load = if pass == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
            let under = vec![to(PICTURE, load, Some(Blend::Under))];
            let label = format!("blend: layer {pass}");
            if self.stops {
                let fs = note_left(pass) + &BLEND_AND_NOTE.replace("DEPTH", own);
                plan.passes.push(full_screen(when, label, &fs, under));
                if pass + 1 < count {
                    plan.passes.push(stop_if_done(request, pass));
                }
            } else {
                plan.passes.push(full_screen(when, label, BLEND, under));
            }
        }
        Ok(plan)
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        twin::pixels(submitted, |fragments, peeled: &mut Vec<Fragment>| {
            let count = passes::of_twin(self, size, fragments.len() as u32, 1);
            peeled.clear();
            for _ in 0..count {
                let before = peeled.last().map_or(0, |fragment| fragment.depth_key);
                let beyond = fragments.iter().filter(|fragment| fragment.depth_key > before);
                // The last of the nearest, as a test for less or equal keeps it.
                let nearest = beyond.rev().min_by_key(|fragment| fragment.depth_key);
                let Some(&next) = nearest else { break };
                peeled.push(next);
            }
            composite(peeled.iter().copied(), End::Front)
        })
    }
}
