//! What the methods' passes have in common.

use oit_capture::{MethodRequest, PICTURE, scene_wgsl};
use oit_gpu::{Blend, ColorAttachment, Dispatch, Draw, Format, Load, Pass, Raster, Shader, Target};

const FULL_SCREEN: &str = "
@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
";

/// A target of the picture's size.
pub(crate) fn target(name: &str, format: Format, request: &MethodRequest) -> Target {
    Target { name: name.to_owned(), format, width: request.width_px, height: request.height_px }
}

/// A colour attachment that is cleared to the same value in every channel, and written.
pub(crate) fn into(target: &str, clear: f32, blend: Option<Blend>) -> ColorAttachment {
    let load = Load::Clear([clear; 4]);
    ColorAttachment { target: target.to_owned(), load, blend, write: true }
}

/// The attachment of a pass that writes buffers alone.
pub(crate) const COVERAGE: &str = "coverage";

/// An attachment to [`COVERAGE`], which is never written.
pub(crate) fn no_color() -> ColorAttachment {
    ColorAttachment { write: false, ..into(COVERAGE, 0.0, None) }
}

/// Draws the scene with this fragment stage.
pub(crate) fn scene(
    request: &MethodRequest,
    stage: &'static str,
    label: String,
    fragment_stage: &str,
    color: Vec<ColorAttachment>,
) -> Pass {
    let shader = Shader::new(label, scene_wgsl(request.geometry, fragment_stage));
    Pass::raster(stage, Raster { color, ..Raster::new(shader, request.geometry.draw()) })
}

/// Draws every pixel of the picture with this fragment stage.
pub(crate) fn finish(label: String, fragment_stage: &str) -> Pass {
    let shader = Shader::new(label, [FULL_SCREEN, fragment_stage].concat());
    let color = vec![into(PICTURE, 0.0, None)];
    let all = Draw::Vertices { count: 3, instances: 1 };
    Pass::raster("resolve", Raster { color, ..Raster::new(shader, all) })
}

/// Pixels of the picture.
pub(crate) fn pixels(request: &MethodRequest) -> u32 {
    // No device has buffers for a picture that does not fit.
    request.width_px.saturating_mul(request.height_px)
}

/// Runs a compute shader once for each pixel: in it `PIXELS` is their number, and `main` starts with
/// `pixel`.
pub(crate) fn each_pixel(request: &MethodRequest, label: &str, declared: &str, body: &str) -> Pass {
    let pixels = pixels(request);
    let groups = pixels.div_ceil(64);
    let x = groups.clamp(1, 32_768);
    let wgsl = format!(
        "const PIXELS = {pixels}u;
{declared}
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {{
    let pixel = (group.y * groups.x + group.x) * 64u + lane;
    if (pixel >= PIXELS) {{
        return;
    }}
{body}}}
"
    );
    let all = Dispatch::Workgroups([x, groups.div_ceil(x), 1]);
    Pass::compute("resolve", Shader::new(label, wgsl), all)
}
