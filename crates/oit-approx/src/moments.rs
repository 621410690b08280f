//! Moment-based order-independent transparency.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Blend, ColorAttachment, Format, Plan, Target};

use crate::draw::{finish, into, scene, target};
use crate::hamburger::{self, LAGUERRE};
use crate::twin;

/// A first draw adds up each fragment's absorbance, `-ln(1 - alpha)`, and its products with the powers
/// of depth. From these moments follows, for the second draw, about how much absorbance lies before a
/// fragment, and colours are added times the transmittance of that. The sums are scaled to the
/// transmittance of all.
///
/// Moments tell little of depths that lie close together. The paper spreads depth logarithmically
/// between the nearest and the farthest that may be transparent. A twin knows window depth alone, so
/// depth here is `2 z - 1` of window depth `z`, which perspective crowds towards the far plane; or it is
/// spread evenly between each pixel's own nearest and farthest fragment, for which the scene is drawn
/// once more, before all else.
///
/// The paper's 16 bits are whole numbers of moments that were transformed first. Ours are half floats
/// of the moments themselves, which are coarser and need a larger bias.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    /// How many: 4, 6 or 8.
    pub count: usize,
    /// How they are kept.
    pub sums: Sums,
}

/// How [`Moments`] are kept.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sums {
    /// As floats of 32 bits.
    Floats,
    /// As half floats, the colours too.
    Halves,
    /// As floats of 32 bits, of depths that are spread between each pixel's nearest and farthest
    /// fragment. Half floats are too coarse for that: moments of depths that reach -1 and 1 are large,
    /// and with few fragments a picture would depend on how the device rounds.
    Bounded,
}

/// The absorbance of an opaque fragment, whose own is without bound: the transmittance is 4.5e-5.
const OPAQUE: f32 = 10.0;

const BOUND: &str = "
@fragment
fn fs(in: Varyings) -> @location(0) vec2<f32> {
    discard_uncovered(in);
    let depth = fragment_depth(in);
    return vec2<f32>(-depth, depth);
}
";

const WINDOW: &str = "
fn depth_of(in: Varyings) -> f32 {
    return 2.0 * fragment_depth(in) - 1.0;
}
";

const BOUNDED: &str = "
@group(0) @binding(4) var bounds: texture_2d<f32>;

fn depth_of(in: Varyings) -> f32 {
    let ends = textureLoad(bounds, vec2<i32>(in.position.xy), 0);
    let length = ends.x + ends.y;
    if (length <= 0.0) {
        return 0.0;
    }
    return 2.0 * ((fragment_depth(in) + ends.x) / length) - 1.0;
}
";

const ADD: &str = "
fn powers(absorbance: f32, depth: f32) -> array<f32, 2 * ROOTS + 1> {
    var sums: array<f32, 2 * ROOTS + 1>;
    var power = absorbance;
    for (var k = 0; k <= 2 * ROOTS; k += 1) {
        sums[k] = power;
        power *= depth;
    }
    return sums;
}

@fragment
fn fs(in: Varyings) -> Added {
    discard_uncovered(in);
    let alpha = unpack4x8unorm(shade(in)).a;
    // No alpha of eight bits but 255 is that near to 1.
    var absorbance = OPAQUE;
    if (alpha < 1.0) {
        absorbance = -log(1.0 - alpha);
    }
    var b = powers(absorbance, depth_of(in));
    return Added(ADDED);
}
";

const WEIGH: &str = "
@group(0) @binding(1) var absorbance: texture_2d<f32>;
@group(0) @binding(2) var moments_low: texture_2d<f32>;
HIGH

@fragment
fn fs(in: Varyings) -> @location(0) vec4<f32> {
    discard_uncovered(in);
    let own = unpack4x8unorm(shade(in));
    let at = vec2<i32>(in.position.xy);
    let all = textureLoad(absorbance, at, 0).x;
    if (all <= 0.0) {
        return vec4<f32>();
    }
    let low = textureLoad(moments_low, at, 0);
    READ
    var b = array<f32, 2 * ROOTS + 1>(1.0, LISTED);
    var bias = array<f32, 2 * ROOTS + 1>(0.0, BIASES);
    for (var k = 1; k <= 2 * ROOTS; k += 1) {
        b[k] = b[k] / all * (1.0 - BIAS) + bias[k] * BIAS;
    }
    let seen = reconstructed(all, b, depth_of(in));
    return vec4<f32>(own.rgb, 1.0) * (own.a * seen);
}
";

const FINISH: &str = "
@group(0) @binding(0) var absorbance: texture_2d<f32>;
@group(0) @binding(1) var seen: texture_2d<f32>;

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    let covered = 1.0 - exp(-textureLoad(absorbance, at, 0).x);
    let sum = textureLoad(seen, at, 0);
    return vec4<f32>(sum.rgb / max(sum.a, 1e-20) * covered, covered);
}
";

impl Moments {
    /// The distribution that is mixed in, as moments 1 and on, and its share, so that rounding leaves
    /// moments that some distribution has. The paper's, but for the share with half floats: of shares
    /// that were tried it is the least with which llvmpipe and the twin give nearly one picture.
    fn bias(self) -> (&'static [f32], f32) {
        match (self.count, self.half()) {
            (4, false) => (&[0.0, 0.375, 0.0, 0.375], 5e-7),
            (4, true) => (&[0.0, 0.375, 0.0, 0.375], 1e-3),
            (6, false) => (&[0.0, 0.48, 0.0, 0.451, 0.0, 0.45], 5e-6),
            (6, true) => (&[0.0, 0.48, 0.0, 0.451, 0.0, 0.45], 5e-3),
            (_, false) => (&EIGHT, 5e-5),
            (_, true) => (&EIGHT, 2e-2),
        }
    }

    fn half(self) -> bool {
        self.sums == Sums::Halves
    }

    fn bounded(self) -> bool {
        self.sums == Sums::Bounded
    }

    /// Targets of the sums, and how many channels each has.
    fn targets(self) -> Vec<(&'static str, usize)> {
        let mut sums = vec![("absorbance", 1), ("moments_low", 4)];
        if self.count > 4 {
            sums.push(("moments_high", self.count - 4));
        }
        sums
    }

    fn format(self, channels: usize) -> Format {
        match (channels, self.half()) {
            (1, false) => Format::R32Float,
            (1, true) => Format::R16Float,
            (2, false) => Format::Rg32Float,
            (2, true) => Format::Rg16Float,
            (_, false) => Format::Rgba32Float,
            (_, true) => Format::Rgba16Float,
        }
    }

    fn wgsl(self, text: &str) -> String {
        let constants = format!(
            "const ROOTS = {};\nconst LAGUERRE = {LAGUERRE};\nconst OPAQUE = {OPAQUE:?};\n",
            self.count / 2
        );
        [constants.as_str(), if self.bounded() { BOUNDED } else { WINDOW }, text].concat()
    }

    fn add_wgsl(self) -> String {
        let (mut members, mut added) = (Vec::new(), Vec::new());
        let mut first = 0;
        for (location, (name, channels)) in self.targets().into_iter().enumerate() {
            let of = if channels == 1 { "f32".to_owned() } else { format!("vec{channels}<f32>") };
            members.push(format!("    @location({location}) {name}: {of},\n"));
            let listed: Vec<_> = (first..first + channels).map(|k| format!("b[{k}]")).collect();
            added.push(format!("{of}({})", listed.join(", ")));
            first += channels;
        }
        let added = ADD.replace("ADDED", &added.join(", "));
        self.wgsl(&format!("struct Added {{\n{}}}\n{added}", members.concat()))
    }

    fn weigh_wgsl(self) -> String {
        let (biases, bias) = self.bias();
        let biases: Vec<_> = biases.iter().map(|bias| format!("{bias:?}")).collect();
        let mut listed: Vec<_> = (0..4).map(|i| format!("low[{i}]")).collect();
        listed.extend((0..self.count - 4).map(|i| format!("high[{i}]")));
        let (high, read) = match self.count {
            4 => ("", ""),
            _ => (
                "@group(0) @binding(3) var moments_high: texture_2d<f32>;",
                "let high = textureLoad(moments_high, at, 0);",
            ),
        };
        let text = WEIGH
            .replace("HIGH", high)
            .replace("READ", read)
            .replace("LISTED", &listed.join(", "))
            .replace("BIASES", &biases.join(", "))
            .replace("BIAS", &format!("{bias:?}"));
        self.wgsl(&[include_str!("moments.wgsl"), &text].concat())
    }

    /// A sum as its target keeps it.
    fn kept(self, sum: f32) -> f32 {
        if self.half() { half(sum) } else { sum }
    }
}

/// Moments of the distribution that eight moments are mixed with.
const EIGHT: [f32; 8] = [0.0, 0.75, 0.0, 0.676_666_7, 0.0, 0.63, 0.0, 0.600_303_05];

/// A float as one of 16 bits keeps it, rounded to the nearest; beyond the largest it is the largest.
fn half(value: f32) -> f32 {
    let exponent = ((value.to_bits() >> 23) & 0xFF) as i32 - 127;
    // Below 2^-14 steps are equal.
    let step = 2.0f32.powi(exponent.max(-14) - 10);
    ((value / step).round_ties_even() * step).clamp(-65_504.0, 65_504.0)
}

impl Method for Moments {
    fn name(&self) -> &'static str {
        match (self.count, self.sums) {
            (4, Sums::Floats) => "moments4",
            (4, Sums::Halves) => "moments4_16",
            (4, Sums::Bounded) => "moments4_bounded",
            (6, Sums::Floats) => "moments6",
            (6, Sums::Halves) => "moments6_16",
            (6, Sums::Bounded) => "moments6_bounded",
            (_, Sums::Floats) => "moments8",
            (_, Sums::Halves) => "moments8_16",
            (_, Sums::Bounded) => "moments8_bounded",
        }
    }

    fn summary(&self) -> &'static str {
        match self.sums {
            Sums::Floats => "Transmittance from power moments of the absorbance, drawn twice.",
            Sums::Halves => "Transmittance from power moments in half floats, drawn twice.",
            Sums::Bounded => {
                "Transmittance from power moments of depth between each pixel's bounds, drawn thrice."
            }
        }
    }

    fn citation(&self) -> &'static str {
        "Münstermann, Krumpen, Klein and Peters, Moment-Based Order-Independent Transparency, \
         PACMCGIT 2018; depth is window depth"
    }

    fn accuracy(&self, _: Option<u32>, _: &DepthHistogram) -> Accuracy {
        let kept = match self.sums {
            Sums::Floats => "",
            Sums::Halves => " in half floats",
            Sums::Bounded => " between each pixel's bounds",
        };
        Accuracy::Approximate(format!("transmittance from {} moments{kept}", self.count))
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let sums = self.targets();
        let seen = self.format(4);
        let mut targets: Vec<Target> = sums
            .iter()
            .map(|&(name, channels)| target(name, self.format(channels), request))
            .collect();
        targets.push(target("seen", seen, request));
        targets.push(target(PICTURE, Format::Rgba32Float, request));
        let mut passes = Vec::new();
        if self.bounded() {
            targets.push(target("bounds", Format::Rg32Float, request));
            let ends = vec![into("bounds", -1.0, Some(Blend::Max))];
            passes.push(scene(request, "capture", "capture: bounds".into(), BOUND, ends));
        }
        let color: Vec<ColorAttachment> =
            sums.iter().map(|&(name, _)| into(name, 0.0, Some(Blend::Add))).collect();
        passes.extend([
            scene(request, "capture", "capture: moments".into(), &self.add_wgsl(), color),
            scene(
                request,
                "blend",
                "blend: what is seen".into(),
                &self.weigh_wgsl(),
                vec![into("seen", 0.0, Some(Blend::Add))],
            ),
            finish("resolve: scale to the transmittance".into(), FINISH),
        ]);
        Ok(Plan {
            name: self.name().to_owned(),
            buffers: request.geometry.buffers(),
            targets,
            passes,
        })
    }

    fn twin(&self, _: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let (biases, bias) = self.bias();
        twin::pixels(submitted, |_, fragments, (): &mut ()| {
            let depths = fragments.iter().map(|fragment| fragment.depth());
            let near = depths.clone().fold(1.0, f32::min);
            let length = depths.fold(-1.0, f32::max) - near;
            let spread = |depth: f32| match self.bounded() {
                false => 2.0 * depth - 1.0,
                true if length <= 0.0 => 0.0,
                true => 2.0 * ((depth - near) / length) - 1.0,
            };
            let mut sums = [0.0f32; 9];
            let sums = &mut sums[..=self.count];
            for &fragment in fragments {
                let alpha = twin::rgba(fragment)[3];
                let mut power = if alpha < 1.0 { -(1.0 - alpha).ln() } else { OPAQUE };
                for sum in sums.iter_mut() {
                    *sum = self.kept(*sum + self.kept(power));
                    power *= spread(fragment.depth());
                }
            }
            let all = sums[0];
            if all <= 0.0 {
                return [0.0; 4];
            }
            sums[0] = 1.0;
            for (sum, own) in sums[1..].iter_mut().zip(biases) {
                *sum = *sum / all * (1.0 - bias) + own * bias;
            }
            let mut seen = [0.0f32; 4];
            for &fragment in fragments {
                let [r, g, b, a] = twin::rgba(fragment);
                let before = hamburger::before(sums, spread(fragment.depth()));
                let weight = a * (-all * before).exp();
                for (sum, own) in seen.iter_mut().zip([r, g, b, 1.0]) {
                    *sum = self.kept(*sum + self.kept(own * weight));
                }
            }
            let covered = 1.0 - (-all).exp();
            let [r, g, b] = [0, 1, 2].map(|c| seen[c] / seen[3].max(1e-20) * covered);
            [r, g, b, covered]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_rounded_to_the_nearest() {
        for (value, kept) in [
            (1.0 + 0.5 / 1024.0, 1.0),
            (1.0 + 1.5 / 1024.0, 1.0 + 2.0 / 1024.0),
            (-2.0 - 1.1 / 1024.0, -2.0 - 2.0 / 1024.0),
            (1e-9, 0.0),
            (2.0f32.powi(-24), 2.0f32.powi(-24)),
            (1e9, 65_504.0),
        ] {
            assert_eq!(half(value), kept, "{value}");
        }
    }
}
