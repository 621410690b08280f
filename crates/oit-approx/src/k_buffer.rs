//! The k nearest fragments of each pixel, exactly, and what becomes of the others.

use oit_capture::{Accuracy, Method, MethodRequest, PICTURE, Size};
use oit_fragments::{DepthHistogram, Fragment, Lfb, Ties};
use oit_gpu::{Blend, Buffer, Format, Pass, Plan};

use crate::draw::{COVERAGE, each_pixel, into, no_color, pixels, scene, target};
use crate::twin;

/// Keeps each pixel's k nearest fragments, sorted by 64-bit atomics as they arrive, in one draw and
/// without a lock: a fragment is compared with slot after slot, and goes on with the farther of the
/// two.
///
/// The original k-buffer merges what it has no room for, fragment by fragment as they arrive, with its
/// farthest: that is [`MultiLayer`](crate::MultiLayer). Here the picture does not depend on the order of
/// arrival.
#[derive(Clone, Copy, Debug)]
pub struct KBuffer {
    /// What becomes of the fragments behind them.
    pub tail: Tail,
}

/// What becomes of the fragments that a k-buffer has no room for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Tail {
    /// They are left out.
    Dropped,
    /// Their colours are averaged by alpha, their transmittance is exact, and both lie behind the k
    /// nearest: hybrid transparency.
    Merged,
}

/// Fragments of a pixel where no number is given.
const K: u32 = 8;

pub(crate) const KEEP: &str = "
@group(0) @binding(1) var<storage, read_write> nearest: array<atomic<u64>>;

// Keys are inverted, so that zeros are empty and the nearest is the largest.
fn keep(pixel: u32, fragment: vec2<u32>) {
    var key = ~((u64(fragment.y) << 32u) | u64(fragment.x));
    for (var i = 0u; i < Ku && key != 0lu; i += 1u) {
        key = min(key, atomicMax(&nearest[i * PIXELSu + pixel], key));
    }
}
";

const DROP: &str = "
@fragment
fn fs(in: Varyings) -> @location(0) vec4<f32> {
    discard_uncovered(in);
    keep(pixel_index(in.position), vec2<u32>(shade(in), depth_key(fragment_depth(in))));
    return vec4<f32>();
}
";

const MERGE: &str = "
struct Sums {
    @location(0) colors: vec4<f32>,
    @location(1) covered: f32,
}

@fragment
fn fs(in: Varyings) -> Sums {
    discard_uncovered(in);
    let rgba = shade(in);
    keep(pixel_index(in.position), vec2<u32>(rgba, depth_key(fragment_depth(in))));
    let own = unpack4x8unorm(rgba);
    return Sums(vec4<f32>(own.rgb * own.a, own.a), own.a);
}
";

pub(crate) const NEAREST: &str = "
@group(0) @binding(0) var<storage, read> nearest: array<u64>;
@group(0) @binding(1) var<storage, read_write> image: array<vec4<f32>>;
";

const SUMS: &str = "
@group(0) @binding(2) var colors: texture_2d<f32>;
@group(0) @binding(3) var transmittance: texture_2d<f32>;
";

pub(crate) const CORE: &str = "
    var color = vec3<f32>();
    var left = 1.0;
    var sum = vec4<f32>();
    for (var i = 0u; i < Ku; i += 1u) {
        let key = ~nearest[i * PIXELS + pixel];
        if (key == ~0lu) {
            break;
        }
        let own = unpack4x8unorm(u32(key & 0xFFFFFFFFlu));
        color += left * own.a * own.rgb;
        left *= 1.0 - own.a;
        sum += vec4<f32>(own.rgb * own.a, own.a);
    }
";

const TAIL: &str = "
    let at = vec2<u32>(pixel % WIDTHu, pixel / WIDTHu);
    let tail = max(textureLoad(colors, at, 0) - sum, vec4<f32>());
    let behind = select(0.0, min(textureLoad(transmittance, at, 0).x / left, 1.0), left > 0.0);
    let average = min(tail.rgb / max(tail.a, 1e-20), vec3<f32>(1.0));
    color += left * (1.0 - behind) * average;
    left *= behind;
";

pub(crate) const STORE: &str = "
    image[pixel] = vec4<f32>(color, 1.0 - left);
";

impl Method for KBuffer {
    fn name(&self) -> &'static str {
        match self.tail {
            Tail::Dropped => "k_nearest",
            Tail::Merged => "hybrid",
        }
    }

    fn summary(&self) -> &'static str {
        match self.tail {
            Tail::Dropped => {
                "The k nearest fragments of each pixel, sorted by 64-bit atomics; the rest is left out."
            }
            Tail::Merged => {
                "Hybrid transparency: the k nearest fragments exactly, the rest averaged behind them."
            }
        }
    }

    fn citation(&self) -> &'static str {
        match self.tail {
            Tail::Dropped => {
                "Bavoil et al., Multi-Fragment Effects on the GPU using the k-Buffer, I3D 2007; by \\
                 atomics after Kubisch, Order Independent Transparency in OpenGL 4.x, GTC 2014"
            }
            Tail::Merged => "Maule, Comba, Torchelsen and Bastos, Hybrid Transparency, I3D 2013",
        }
    }

    fn size(&self) -> Option<Size> {
        Some(Size { word: "k", range: 1..=256, default: Some(K) })
    }

    fn accuracy(&self, size: Option<u32>, histogram: &DepthHistogram) -> Accuracy {
        let (k, peak) = (size.unwrap_or(K), histogram.peak());
        match self.tail {
            _ if peak > k => {
                Accuracy::Approximate(format!("{k} of up to {peak} fragments exactly"))
            }
            Tail::Dropped => Accuracy::Exact,
            // What is taken from the sums is not quite nothing where no fragment is behind.
            Tail::Merged => Accuracy::Approximate("the sums of all fragments are rounded".into()),
        }
    }

    fn build(&self, request: &MethodRequest) -> Result<Plan, String> {
        let (k, count) = (request.size.unwrap_or(K), pixels(request));
        let wgsl = |parts: &[&str]| {
            let text = parts.concat();
            text.replace("Ku", &format!("{k}u")).replace("WIDTH", &request.width_px.to_string())
        };
        let keep = KEEP.replace("PIXELS", &count.to_string());
        let mut buffers = request.geometry.buffers();
        buffers.push(Buffer::new("nearest", 8 * u64::from(k) * u64::from(count)));
        buffers.push(Buffer::new(PICTURE, 16 * u64::from(count)));
        let (targets, color, fs, declared, body) = match self.tail {
            Tail::Dropped => (
                vec![target(COVERAGE, Format::R8Unorm, request)],
                vec![no_color()],
                wgsl(&[&keep, DROP]),
                NEAREST.to_owned(),
                wgsl(&[CORE, STORE]),
            ),
            Tail::Merged => (
                vec![
                    target("colors", Format::Rgba32Float, request),
                    target("transmittance", Format::R32Float, request),
                ],
                vec![
                    into("colors", 0.0, Some(Blend::Add)),
                    into("transmittance", 1.0, Some(Blend::Attenuate)),
                ],
                wgsl(&[&keep, MERGE]),
                [NEAREST, SUMS].concat(),
                wgsl(&[CORE, TAIL, STORE]),
            ),
        };
        Ok(Plan {
            name: self.name().to_owned(),
            buffers,
            targets,
            passes: vec![
                Pass::clear("clear", "nearest"),
                scene(request, "capture", format!("capture: the nearest {k}"), &fs, color),
                each_pixel(request, "resolve: the nearest, in order", &declared, &body),
            ],
        })
    }

    fn twin(&self, size: Option<u32>, submitted: &Lfb) -> Vec<[f32; 4]> {
        let k = size.unwrap_or(K) as usize;
        twin::pixels(submitted, |_, fragments, sorted: &mut Vec<Fragment>| {
            sorted.clear();
            sorted.extend_from_slice(fragments);
            sorted.sort_unstable_by(|&a, &b| Ties::Total.compare(a, b));
            let (mut color, mut left) = ([0.0f32; 3], 1.0f32);
            let mut tail = [0.0f32; 4];
            let mut transmittance = 1.0f32;
            for (place, &fragment) in sorted.iter().enumerate() {
                let [r, g, b, a] = twin::rgba(fragment);
                if place < k {
                    for (color, own) in color.iter_mut().zip([r, g, b]) {
                        *color += left * a * own;
                    }
                    left *= 1.0 - a;
                } else {
                    for (sum, own) in tail.iter_mut().zip([r * a, g * a, b * a, a]) {
                        *sum += own;
                    }
                    transmittance *= 1.0 - a;
                }
            }
            if self.tail == Tail::Merged {
                for (color, sum) in color.iter_mut().zip(tail) {
                    *color += left * (1.0 - transmittance) * sum / tail[3].max(1e-20);
                }
                left *= transmittance;
            }
            [color[0], color[1], color[2], 1.0 - left]
        })
    }
}
