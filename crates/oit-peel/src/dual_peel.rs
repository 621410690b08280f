//! Dual depth peeling: the nearest and the farthest layer in every pass.

use half::f16;
use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb};
use oit_gpu::{Blend, Format, Load, Plan};

use crate::draw::{
    When, full_screen, note_left, picture, scene, stop_buffers, stop_clear, stop_if_done, target,
    to,
};
use crate::twin::{self, max, over, premultiplied};
use crate::{passes, small_float};

/// Draws the scene once for the depths of the nearest and the farthest layer, as the maximum of
/// (-z, z), and then once for every two layers: the fragments at the two depths are peeled, those
/// between them are candidates for the next pass. All targets are blended by maximum. The colour in
/// front is kept in the shader and forwarded from pass to pass; a fragment only adds to it.
///
/// Of fragments at one depth a mixture is kept: the largest of each channel.
#[derive(Clone, Copy, Debug)]
pub struct DualPeel {
    /// How layers from the back are put together.
    pub back: Back,
    /// What depths are kept in between passes.
    pub depth: DepthBits,
    /// Whether passes are called off once nothing is left to peel, without knowing how many there
    /// are; otherwise they are as many as the deepest pixel needs.
    pub stops: bool,
}

/// How layers from the back are put together.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Back {
    /// A full-screen draw after each pass blends the layer over those behind it: seven attachments.
    Blended,
    /// The shader blends over what it forwards from pass to pass, and adds [`BOGUS`] to every channel
    /// each time, so that the new value is the maximum. No full-screen draws, six attachments; in
    /// four 32-bit floats.
    ForwardedRgba32,
    /// The same in four 16-bit floats.
    ForwardedRgba16,
    /// The same in eleven, eleven and ten bits. There is no room for alpha: the picture has that of
    /// its layers from the front.
    ForwardedR11g11b10,
}

/// What depths are kept in between passes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DepthBits {
    /// 32-bit floats: depths as they are.
    ThirtyTwo,
    /// 16-bit floats; depths are compared in that precision too, since otherwise none would be equal.
    Sixteen,
}

/// What is added to a forwarded colour in each pass.
pub(crate) const BOGUS: f32 = 2.0;

/// In place of (-z, z) where nothing is to be peeled: no depth is beyond it.
const DONE: f32 = -2.0;

/// A depth from 0 to 1 as the nearest 16-bit float, ties to even. By whole numbers: NVIDIA's compiler
/// (580) takes `unpack2x16float(pack2x16float(..))` away, and then no depth equals what was stored.
const QUANTISED_16: &str = "fn quantised(z: f32) -> f32 {
    // Below the smallest normal one they are 2^-24 apart.
    if (z < 0.00006103515625) {
        return round(z * 16777216.0) / 16777216.0;
    }
    let bits = bitcast<u32>(z);
    return bitcast<f32>((bits + 0xFFFu + ((bits >> 13u) & 1u)) & 0xFFFFE000u);
}
";

const INIT: &str = "
@fragment
fn fs(in: Varyings) -> @location(0) vec2<f32> {
    discard_uncovered(in);
    let z = quantised(fragment_depth(in));
    return vec2<f32>(-z, z);
}
";

const PEEL: &str = "
@group(0) @binding(1) var DEPTHS: texture_2d<f32>;
@group(0) @binding(2) var FRONT: texture_2d<f32>;
BACK_BEFORE

struct Peeled {
    @location(0) depths: vec2<f32>,
    @location(1) front: vec4<f32>,
    @location(2) back: vec4<f32>,
}

@fragment
fn fs(in: Varyings) -> Peeled {
    discard_uncovered(in);
    let at = vec2<i32>(in.position.xy);
    let z = quantised(fragment_depth(in));
    let depths = textureLoad(DEPTHS, at, 0).xy;
    let nearest = -depths.x;
    let farthest = depths.y;
    var out = Peeled(vec2<f32>(-2.0), textureLoad(FRONT, at, 0), BACK);
    if (z < nearest || z > farthest) {
        return out;
    }
    if (z > nearest && z < farthest) {
        out.depths = vec2<f32>(-z, z);
        return out;
    }
    let own = unpack4x8unorm(shade(in));
    let color = vec4<f32>(own.rgb * own.a, own.a);
    if (z == nearest) {
        out.front += (1.0 - out.front.a) * color;
    } else {
        out.back = BACK_WITH;
    }
    return out;
}
";

/// What a pass forwards, taken apart and put together: the whole part counts its layers. Alpha grows
/// from layer to layer by itself, and is left alone.
const FORWARD: &str = "
fn forwarded(before: vec4<f32>, color: vec4<f32>) -> vec4<f32> {
    let whole = 2.0 * floor(before.r / 2.0);
    let behind = before.rgb - whole;
    let blended = (1.0 - color.a) * behind + color.rgb + whole + 2.0;
    return vec4<f32>(blended, before.a + (1.0 - before.a) * color.a);
}
";

const BLEND_BACK: &str = "
@group(0) @binding(1) var back: texture_2d<f32>;
@group(0) @binding(2) var DEPTHS: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    if (textureLoad(DEPTHS, at, 0).y >= 0.0) {
        left();
    }
    return textureLoad(back, at, 0);
}
";

const FINISH: &str = "
@group(0) @binding(1) var FRONT_A: texture_2d<f32>;
@group(0) @binding(2) var FRONT_B: texture_2d<f32>;
BACKS

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    // The later of the two: what is in front only grows.
    let front = max(textureLoad(FRONT_A, at, 0), textureLoad(FRONT_B, at, 0));
    var behind = BEHIND;
    return front + (1.0 - front.a) * behind;
}
";

const DEPTHS: [&str; 2] = ["depths_even", "depths_odd"];
const FRONT: [&str; 2] = ["front_even", "front_odd"];
const BACK: [&str; 2] = ["back_even", "back_odd"];
const BEHIND: &str = "behind";

impl Back {
    fn is_forwarded(self) -> bool {
        self != Self::Blended
    }

    fn format(self) -> Format {
        match self {
            Self::Blended | Self::ForwardedRgba32 => Format::Rgba32Float,
            Self::ForwardedRgba16 => Format::Rgba16Float,
            Self::ForwardedR11g11b10 => Format::Rg11b10Float,
        }
    }

    /// A colour as the format keeps it.
    fn stored(self, color: [f32; 4]) -> [f32; 4] {
        match self {
            Self::Blended | Self::ForwardedRgba32 => color,
            Self::ForwardedRgba16 => color.map(|channel| f16::from_f32(channel).to_f32()),
            Self::ForwardedR11g11b10 => small_float::r11g11b10(color),
        }
    }
}

impl DepthBits {
    fn format(self) -> Format {
        match self {
            Self::ThirtyTwo => Format::Rg32Float,
            Self::Sixteen => Format::Rg16Float,
        }
    }

    /// A depth as the format keeps it.
    fn stored(self, depth: f32) -> f32 {
        match self {
            Self::ThirtyTwo => depth,
            Self::Sixteen => f16::from_f32(depth).to_f32(),
        }
    }

    fn wgsl(self) -> &'static str {
        match self {
            Self::ThirtyTwo => "fn quantised(z: f32) -> f32 { return z; }\n",
            Self::Sixteen => QUANTISED_16,
        }
    }
}

impl DualPeel {
    /// The draw of the scene that peels two layers.
    fn peel_wgsl(&self, before: usize) -> String {
        let (declared, forwarded, with) = if self.back.is_forwarded() {
            let name = BACK[before];
            (
                format!("@group(0) @binding(3) var {name}: texture_2d<f32>;\n{FORWARD}"),
                format!("textureLoad({name}, at, 0)"),
                "forwarded(out.back, color)",
            )
        } else {
            (String::new(), "vec4<f32>()".to_owned(), "color")
        };
        let peel = PEEL
            .replace("DEPTHS", DEPTHS[before])
            .replace("FRONT", FRONT[before])
            .replace("BACK_BEFORE", &declared)
            .replace("BACK_WITH", with)
            .replace("BACK", &forwarded);
        self.depth.wgsl().to_owned() + &peel
    }

    /// The draw that puts front and back together.
    fn finish_wgsl(&self) -> String {
        let declare =
            |binding, name| format!("@group(0) @binding({binding}) var {name}: texture_2d<f32>;\n");
        let (backs, behind) = if self.back.is_forwarded() {
            let backs = declare(3, BACK[0]) + &declare(4, BACK[1]);
            let [even, odd] = BACK.map(|name| format!("textureLoad({name}, at, 0)"));
            // Alpha is 1 in a target without it.
            let alpha = match self.back {
                Back::ForwardedR11g11b10 => "0.0",
                _ => "max(even.a, odd.a)",
            };
            let apart = format!(
                "vec4<f32>();\n    let even = {even};\n    let odd = {odd};\n    \
                 let last = max(even.rgb, odd.rgb);\n    \
                 behind = vec4<f32>(last - 2.0 * floor(last.r / 2.0), {alpha})"
            );
            (backs, apart)
        } else {
            (declare(3, BEHIND), format!("textureLoad({BEHIND}, at, 0)"))
        };
        FINISH
            .replace("FRONT_A", FRONT[0])
            .replace("FRONT_B", FRONT[1])
            .replace("BACKS", &backs)
            .replace("BEHIND", &behind)
    }
}

impl Method for DualPeel {
    fn name(&self) -> &'static str {
        match (self.back, self.depth) {
            (Back::Blended, DepthBits::ThirtyTwo) => {
                passes::stops_name(self.stops, ["dual_peel", "dual_peel_stop"])
            }
            (Back::Blended, DepthBits::Sixteen) => "dual_peel_depth16",
            (Back::ForwardedRgba32, _) => "dual_peel_forward32",
            (Back::ForwardedRgba16, _) => "dual_peel_forward16",
            (Back::ForwardedR11g11b10, _) => "dual_peel_forward11",
        }
    }

    fn summary(&self) -> &'static str {
        match (self.back, self.depth) {
            (Back::Blended, DepthBits::ThirtyTwo) if self.stops => {
                "Dual depth peeling; passes are called off once nothing is left to peel."
            }
            (Back::Blended, DepthBits::ThirtyTwo) => {
                "Dual depth peeling: the nearest and the farthest layer each time the scene is drawn."
            }
            (Back::Blended, DepthBits::Sixteen) => {
                "Dual depth peeling with depths in 16-bit floats, which breaks the picture."
            }
            (Back::ForwardedRgba32, _) => {
                "Dual depth peeling whose back layers are forwarded with a bogus value, in RGBA32F."
            }
            (Back::ForwardedRgba16, _) => {
                "Dual depth peeling whose back layers are forwarded with a bogus value, in RGBA16F."
            }
            (Back::ForwardedR11g11b10, _) => {
                "Dual depth peeling whose back layers are forwarded with a bogus value, in \
                 R11G11B10F: its alpha has no back layers."
            }
        }
    }

    fn citation(&self) -> &'static str {
        match (self.back, self.depth) {
            (Back::Blended, DepthBits::ThirtyTwo) => {
                "Bavoil and Myers, Order Independent Transparency with Dual Depth Peeling, NVIDIA 2008"
            }
            _ => {
                "Enev, The disastrous failures to optimize dual-depth peeling with NSight; after \
                 Bavoil and Myers, NVIDIA 2008"
            }
        }
    }

    fn size(&self) -> Option<Size> {
        Some(passes::size())
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        let complete = match (self.back, self.depth) {
            (_, DepthBits::Sixteen) => {
                Accuracy::Approximate("depths of 16 bits: many fragments share one".into())
            }
            (Back::Blended, _) => Accuracy::ExactWithoutTies,
            (back, _) => {
                Accuracy::Approximate(format!("back layers are forwarded in {:?}", back.format()))
            }
        };
        passes::accuracy(size, histogram, 2, complete)
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let count = passes::recorded(request, 2, self.stops)?;
        let none = Load::Clear([DONE; 4]);
        let empty = Load::Clear([0.0; 4]);
        let mut plan = Plan {
            name: self.name().to_owned(),
            buffers: request.geometry.buffers(),
            targets: vec![picture(request)],
            passes: Vec::new(),
        };
        for i in 0..2 {
            plan.targets.push(target(DEPTHS[i], self.depth.format(), request));
            plan.targets.push(target(FRONT[i], Format::Rgba32Float, request));
        }
        let backs = if self.back.is_forwarded() { &BACK[..] } else { &["back", BEHIND] };
        for name in backs {
            plan.targets.push(target(name, self.back.format(), request));
        }
        if self.stops {
            plan.buffers.extend(stop_buffers(count));
            plan.passes.push(stop_clear());
        }
        let max_into = |name, load| to(name, load, Some(Blend::Max));
        // The first pass reads what this clears.
        let mut first = vec![max_into(DEPTHS[1], none), max_into(FRONT[1], empty)];
        if self.back.is_forwarded() {
            first.push(max_into(BACK[1], empty));
        }
        first[1..].iter_mut().for_each(|color| color.write = false);
        let init = self.depth.wgsl().to_owned() + INIT;
        let label = "peel: the nearest and the farthest depth".to_owned();
        plan.passes.push(scene(request, When::Always, label, &init, first, None));
        for pass in 0..count {
            let (own, before) = ((pass % 2) as usize, ((pass + 1) % 2) as usize);
            let when = if self.stops && pass > 0 { When::Left(pass) } else { When::Always };
            // What is in front and what is forwarded only grows, so that it need not be cleared
            // again; and where a pass is called off it stays.
            let grown = if pass == 0 { empty } else { Load::Keep };
            let back = match self.back.is_forwarded() {
                true => max_into(BACK[own], grown),
                false => max_into("back", empty),
            };
            let color = vec![max_into(DEPTHS[own], none), max_into(FRONT[own], grown), back];
            let label = format!("peel: layers {pass} from the front and the back");
            plan.passes.push(scene(request, when, label, &self.peel_wgsl(before), color, None));
            if !self.back.is_forwarded() {
                let over = vec![to(BEHIND, grown, Some(Blend::Over))];
                let label = format!("blend: layer {pass} from the back");
                let note = match self.stops {
                    true => note_left(pass),
                    false => "fn left() {}\n".to_owned(),
                };
                let fs = note + &BLEND_BACK.replace("DEPTHS", DEPTHS[own]);
                plan.passes.push(full_screen(when, label, &fs, over));
            }
            if self.stops && pass + 1 < count {
                plan.passes.push(stop_if_done(request, pass));
            }
        }
        let label = "blend: front over back".to_owned();
        let image = vec![to(PICTURE, empty, None)];
        plan.passes.push(full_screen(When::Always, label, &self.finish_wgsl(), image));
        Ok(plan)
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        twin::pixels(submitted, |fragments, left: &mut Vec<Fragment>| {
            let count = passes::of_twin(self, size, fragments.len() as u32, 2);
            left.clear();
            left.extend_from_slice(fragments);
            let (mut front, mut behind) = ([0.0; 4], [0.0; 4]);
            for _ in 0..count {
                let depth = |fragment: &Fragment| self.depth.stored(fragment.depth());
                let nearest = left.iter().map(depth).fold(f32::INFINITY, f32::min);
                let farthest = left.iter().map(depth).fold(f32::NEG_INFINITY, f32::max);
                let (mut next_front, mut layer) = (front, behind);
                if !self.back.is_forwarded() {
                    layer = [0.0; 4];
                }
                for fragment in left.iter() {
                    let color = premultiplied(*fragment);
                    if depth(fragment) == nearest {
                        next_front = max(next_front, over(front, color));
                    } else if depth(fragment) == farthest {
                        let with = match self.back.is_forwarded() {
                            true => self.back.stored(forwarded(behind, color)),
                            false => color,
                        };
                        layer = max(layer, with);
                    }
                }
                front = next_front;
                behind = if self.back.is_forwarded() { layer } else { over(layer, behind) };
                left.retain(|fragment| nearest < depth(fragment) && depth(fragment) < farthest);
            }
            if self.back.is_forwarded() {
                let whole = BOGUS * (behind[0] / BOGUS).floor();
                for channel in &mut behind[..3] {
                    *channel -= whole;
                }
                if self.back == Back::ForwardedR11g11b10 {
                    behind[3] = 0.0;
                }
            }
            over(front, behind)
        })
    }
}

/// The twin of `forwarded` in [`FORWARD`].
fn forwarded(before: [f32; 4], color: [f32; 4]) -> [f32; 4] {
    let whole = BOGUS * (before[0] / BOGUS).floor();
    let blend = |channel: usize| {
        (1.0 - color[3]) * (before[channel] - whole) + color[channel] + whole + BOGUS
    };
    [blend(0), blend(1), blend(2), before[3] + (1.0 - before[3]) * color[3]]
}
