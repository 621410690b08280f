//! What the peeling passes have in common: targets, draws of the scene, full-screen draws, and the
//! passes that call further ones off.

use oit_capture::{MethodRequest, PICTURE, scene_wgsl};
use oit_gpu::{
    Blend, Buffer, ColorAttachment, DepthStencil, Dispatch, Draw, Format, Load, Pass, Raster,
    Shader, Target,
};

/// A full-screen triangle, and where a fragment of it is.
const FULL_SCREEN: &str = "
@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
";

/// The buffer of indirect arguments: ten words a pass, for the draw of the scene and for the
/// full-screen one.
const ARGUMENTS: &str = "peel_arguments";

/// The buffer of flags: a word a pass, not 0 if something is left to peel after it.
const LEFT: &str = "peel_left";

/// A target of the picture's size.
pub(crate) fn target(name: &str, format: Format, request: &MethodRequest) -> Target {
    Target { name: name.to_owned(), format, width: request.width_px, height: request.height_px }
}

/// The picture's target.
pub(crate) fn picture(request: &MethodRequest) -> Target {
    target(PICTURE, Format::Rgba32Float, request)
}

/// A colour attachment that is written.
pub(crate) fn to(target: &str, load: Load<[f32; 4]>, blend: Option<Blend>) -> ColorAttachment {
    ColorAttachment { target: target.to_owned(), load, blend, write: true }
}

/// Which draws of a pass a shader may call off.
#[derive(Clone, Copy)]
pub(crate) enum When {
    /// None: it is always drawn.
    Always,
    /// Those of this pass, if nothing was left to peel before it.
    Left(u32),
}

/// Draws the scene with this fragment stage.
pub(crate) fn scene(
    request: &MethodRequest,
    when: When,
    label: String,
    fragment_stage: &str,
    color: Vec<ColorAttachment>,
    depth_stencil: Option<DepthStencil>,
) -> Pass {
    let shader = Shader::new(label, scene_wgsl(request.geometry, fragment_stage));
    let draw = match (request.geometry.draw(), when) {
        (Draw::Indexed { vertices, layout, indices, .. }, When::Left(pass)) => {
            let (arguments, offset_bytes) = (ARGUMENTS.to_owned(), 40 * u64::from(pass));
            Draw::IndexedIndirect { vertices, layout, indices, arguments, offset_bytes }
        }
        (Draw::Vertices { .. }, When::Left(pass)) => {
            let (arguments, offset_bytes) = (ARGUMENTS.to_owned(), 40 * u64::from(pass));
            Draw::VerticesIndirect { arguments, offset_bytes, draws: 1 }
        }
        (draw, _) => draw,
    };
    Pass::raster("peel", Raster { color, depth_stencil, ..Raster::new(shader, draw) })
}

/// Draws every pixel with this fragment stage.
pub(crate) fn full_screen(
    when: When,
    label: String,
    fragment_stage: &str,
    color: Vec<ColorAttachment>,
) -> Pass {
    let shader = Shader::new(label, [FULL_SCREEN, fragment_stage].concat());
    let draw = match when {
        When::Always => Draw::Vertices { count: 3, instances: 1 },
        When::Left(pass) => {
            let (arguments, offset_bytes) = (ARGUMENTS.to_owned(), 40 * u64::from(pass) + 20);
            Draw::VerticesIndirect { arguments, offset_bytes, draws: 1 }
        }
    };
    Pass::raster("blend", Raster { color, ..Raster::new(shader, draw) })
}

/// WGSL for a full-screen fragment stage: `left()` notes that something is left to peel after this
/// pass. Takes `@binding(15)`.
pub(crate) fn note_left(pass: u32) -> String {
    format!(
        "@group(0) @binding(15) var<storage, read_write> {LEFT}: array<atomic<u32>>;\n\
         fn left() {{\n    atomicStore(&{LEFT}[{pass}u], 1u);\n}}\n"
    )
}

/// The buffers by which passes are called off.
pub(crate) fn stop_buffers(passes: u32) -> [Buffer; 2] {
    let passes = u64::from(passes) + 1;
    [Buffer::new(LEFT, 4 * passes), Buffer::new(ARGUMENTS, 40 * passes)]
}

/// Forgets what was left.
pub(crate) fn stop_clear() -> Pass {
    Pass::clear("clear", LEFT)
}

/// After a pass: the next one is drawn if something was left, and called off if not.
pub(crate) fn stop_if_done(request: &MethodRequest, pass: u32) -> Pass {
    // Indices or vertices: the arguments of either draw begin with them and the instances.
    let drawn = match request.geometry.draw() {
        Draw::Indexed { count, .. } | Draw::Vertices { count, .. } => count,
        Draw::IndexedIndirect { .. }
        | Draw::VerticesIndirect { .. }
        | Draw::MeshIndirect { .. } => 0,
    };
    let at = 10 * (pass + 1);
    let wgsl = format!(
        "@group(0) @binding(0) var<storage, read> {LEFT}: array<u32>;
@group(0) @binding(1) var<storage, read_write> {ARGUMENTS}: array<u32>;

@compute @workgroup_size(10)
fn main(@builtin(local_invocation_index) i: u32) {{
    let instances = min({LEFT}[{pass}u], 1u);
    let all = array<u32, 10>({drawn}u, instances, 0u, 0u, 0u, 3u, instances, 0u, 0u, 0u);
    {ARGUMENTS}[{at}u + i] = all[i];
}}
"
    );
    let shader = Shader::new(format!("peel: is anything left after pass {pass}"), wgsl);
    Pass::compute("stop", shader, Dispatch::Workgroups([1, 1, 1]))
}
