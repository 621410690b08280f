//! Exact compositing of fragments that were kept with fewer bits.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Buffer, Format, Pass, Plan};

use crate::draw::{COVERAGE, each_pixel, no_color, pixels, scene, target};
use crate::k_buffer::{KEEP, NEAREST, STORE};
use crate::twin;

/// Every fragment of each pixel, sorted as [`KBuffer`](crate::KBuffer) sorts, but with a depth of few
/// bits, a colour that was multiplied by alpha and rounded again, or both. What is wrong in the picture
/// is the format's fault alone.
///
/// Depth is window depth in equal steps, as depth buffers of whole numbers have it. Of the nearer half of
/// the range a 32-bit float has finer steps than 24 bits, of the farther half it has the same.
/// Fragments that fall on one step are in the order of their colours.
#[derive(Clone, Copy, Debug)]
pub struct Quantised {
    /// Bits of depth, 16 or 24; `None`: the float.
    pub depth_bits: Option<u32>,
    /// Whether colours are kept multiplied by their alpha, eight bits a channel.
    pub premultiplied: bool,
}

const CAPTURE: &str = "
fn kept_depth(depth: f32) -> u32 {
    return DEPTH;
}

fn kept_color(rgba: u32) -> u32 {
    let channels = vec4<u32>(rgba, rgba >> 8u, rgba >> 16u, rgba >> 24u) & vec4<u32>(255u);
    return COLOR;
}

@fragment
fn fs(in: Varyings) -> @location(0) vec4<f32> {
    discard_uncovered(in);
    let kept = vec2<u32>(kept_color(shade(in)), kept_depth(fragment_depth(in)));
    keep(pixel_index(in.position), kept);
    return vec4<f32>();
}
";

const BLEND: &str = "
    var color = vec3<f32>();
    var left = 1.0;
    for (var i = 0u; i < Ku; i += 1u) {
        let key = ~nearest[i * PIXELS + pixel];
        if (key == ~0lu) {
            break;
        }
        let own = unpack4x8unorm(u32(key & 0xFFFFFFFFlu));
        color += left * SHARE;
        left *= 1.0 - own.a;
    }
";

impl Quantised {
    /// The largest depth in steps.
    fn steps(bits: u32) -> u32 {
        (1 << bits) - 1
    }

    /// Fragments of the deepest pixel, or as many as are asked for.
    fn kept(size: Option<u32>, histogram: &DepthHistogram) -> u32 {
        size.unwrap_or_else(|| histogram.peak()).max(1)
    }

    fn capture_wgsl(self, k: u32, count: u32) -> String {
        let depth = match self.depth_bits {
            // One multiplication and whole steps: nothing that a compiler may round otherwise.
            Some(bits) => {
                format!("u32(round(clamp(depth, 0.0, 1.0) * {}.0))", Self::steps(bits))
            }
            None => "depth_key(depth)".to_owned(),
        };
        let color = if self.premultiplied {
            "dot((vec4<u32>(channels.rgb * channels.a + 127u, channels.a * 255u) / 255u) \
             << vec4<u32>(0u, 8u, 16u, 24u), vec4<u32>(1u))"
        } else {
            "rgba"
        };
        let capture = CAPTURE.replace("DEPTH", &depth).replace("COLOR", color);
        let keep = KEEP.replace("PIXELS", &count.to_string()).replace("Ku", &format!("{k}u"));
        keep + &capture
    }
}

impl Method for Quantised {
    fn name(&self) -> &'static str {
        match (self.depth_bits, self.premultiplied) {
            (Some(16), false) => "quantised_depth16",
            (Some(16), true) => "quantised_depth16_premultiplied",
            (Some(_), false) => "quantised_depth24",
            (Some(_), true) => "quantised_depth24_premultiplied",
            (None, _) => "quantised_premultiplied",
        }
    }

    fn summary(&self) -> &'static str {
        match (self.depth_bits, self.premultiplied) {
            (Some(16), false) => "Every fragment, sorted by a depth of 16 bits.",
            (Some(16), true) => {
                "Every fragment, depth of 16 bits, colour premultiplied in 8 bits a channel."
            }
            (Some(_), false) => "Every fragment, sorted by a depth of 24 bits.",
            (Some(_), true) => {
                "Every fragment, depth of 24 bits, colour premultiplied in 8 bits a channel."
            }
            (None, _) => "Every fragment, colour premultiplied in 8 bits a channel.",
        }
    }

    fn citation(&self) -> &'static str {
        "Porter and Duff, Compositing Digital Images, SIGGRAPH 1984, for premultiplied colour; Kubisch, \
         Order Independent Transparency in OpenGL 4.x, GTC 2014, for the sort by atomics"
    }

    fn size(&self) -> Option<Size> {
        Some(Size { word: "k", range: 1..=256, default: None })
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        let mut what = Vec::new();
        if let Some(bits) = self.depth_bits {
            what.push(format!("depth of {bits} bits"));
        }
        if self.premultiplied {
            what.push("colours rounded after multiplication by alpha".into());
        }
        let (k, peak) = (Self::kept(size, histogram), histogram.peak());
        if peak > k {
            what.push(format!("{k} of up to {peak} fragments"));
        }
        Accuracy::Approximate(what.join(", "))
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let (k, count) = (Self::kept(request.size, request.histogram), pixels(request));
        let share = if self.premultiplied { "own.rgb" } else { "own.a * own.rgb" };
        let blend = BLEND.replace("Ku", &format!("{k}u")).replace("SHARE", share);
        let mut buffers = request.geometry.buffers();
        buffers.push(Buffer::new("nearest", 8 * u64::from(k) * u64::from(count)));
        buffers.push(Buffer::new(PICTURE, 16 * u64::from(count)));
        let capture = self.capture_wgsl(k, count);
        Ok(Plan {
            name: self.name().to_owned(),
            buffers,
            targets: vec![target(COVERAGE, Format::R8Unorm, request)],
            passes: vec![
                Pass::clear("clear", "nearest"),
                scene(
                    request,
                    "capture",
                    format!("capture: the nearest {k}"),
                    &capture,
                    vec![no_color()],
                ),
                each_pixel(request, "resolve: in order", NEAREST, &(blend + STORE)),
            ],
        })
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let k = size.map_or(usize::MAX, |size| size as usize);
        twin::pixels(submitted, |_, fragments, keys: &mut Vec<u64>| {
            keys.clear();
            keys.extend(fragments.iter().map(|fragment| {
                let depth = self.depth_bits.map_or(fragment.depth_key, |bits| {
                    let steps = Self::steps(bits) as f32;
                    (fragment.depth().clamp(0.0, 1.0) * steps).round_ties_even() as u32
                });
                let [r, g, b, a] = fragment.rgba8();
                let times_alpha =
                    |channel: u8| ((u32::from(channel) * u32::from(a) + 127) / 255) as u8;
                let rgba = match self.premultiplied {
                    true => [r, g, b].map(times_alpha),
                    false => [r, g, b],
                };
                let rgba = u32::from_le_bytes([rgba[0], rgba[1], rgba[2], a]);
                (u64::from(depth) << 32) | u64::from(rgba)
            }));
            keys.sort_unstable();
            let (mut color, mut left) = ([0.0f32; 3], 1.0f32);
            for &key in keys.iter().take(k) {
                let [r, g, b, a] = (key as u32).to_le_bytes().map(|c| f32::from(c) / 255.0);
                let share = if self.premultiplied { 1.0 } else { a };
                for (color, own) in color.iter_mut().zip([r, g, b]) {
                    *color += left * share * own;
                }
                left *= 1.0 - a;
            }
            [color[0], color[1], color[2], 1.0 - left]
        })
    }
}
