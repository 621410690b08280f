//! What the captures' drawing passes have in common.

use oit_fragments::DepthHistogram;
use oit_gpu::{
    Blend, Buffer, ColorAttachment, DepthStencil, Format, Load, Pass, Plan, Raster, Shader, Target,
};

use crate::scan::workgroups;
use crate::{CaptureRequest, Geometry};

pub(crate) const FRAME: &str = include_str!("wgsl/frame.wgsl");
pub(crate) const SCENE: &str = include_str!("wgsl/scene.wgsl");
pub(crate) const POSITIONS: &str = include_str!("wgsl/positions.wgsl");
const COUNT: &str = include_str!("wgsl/count.wgsl");
const COUNT_BY_BLENDING: &str = include_str!("wgsl/count_by_blending.wgsl");
const COPY_COUNTED: &str = include_str!("wgsl/copy_counted.wgsl");

/// The target that fragments are counted in by blending; `copy_counted.wgsl` names it too.
const COUNTED: &str = "counted";

/// The target of passes that only write buffers: one byte a pixel, never written.
const COVERAGE: &str = "coverage";

/// A plan of the count pass alone: it leaves each pixel's number of fragments in the buffer
/// `counts` (`u32`), and needs no pool. From these follow the size of the pool and the intervals.
#[must_use]
pub fn count_plan(geometry: &Geometry, width_px: u32, height_px: u32) -> Plan {
    let request = &CaptureRequest {
        geometry,
        width_px,
        height_px,
        pool_slots: 1,
        histogram: &DepthHistogram::default(),
        counts: true,
        lists: None,
        mark: None,
    };
    let mut buffers = geometry.buffers();
    buffers.push(pixel_buffer("counts", request));
    Plan {
        name: "count".into(),
        buffers,
        targets: vec![coverage(request)],
        passes: vec![Pass::clear("clear", "counts"), count_pass(request, "counts")],
    }
}

/// A buffer of one `u32` a pixel.
pub(crate) fn pixel_buffer(name: &str, request: &CaptureRequest) -> Buffer {
    Buffer::new(name, 4 * u64::from(request.width_px) * u64::from(request.height_px))
}

/// Slots of a pool. At least two: the shaders take the size from the binding, and no buffer has
/// less than 16 bytes.
pub(crate) fn pool_slots(slots: u64) -> u64 {
    slots.max(2)
}

pub(crate) fn coverage(request: &CaptureRequest) -> Target {
    Target {
        name: COVERAGE.into(),
        format: Format::R8Unorm,
        width: request.width_px,
        height: request.height_px,
    }
}

/// Shades nothing and adds each fragment to its pixel's `u32` in a buffer.
pub(crate) fn count_pass(request: &CaptureRequest, counts: &str) -> Pass {
    let wgsl = request.geometry.positions_wgsl() + &COUNT.replace("COUNTS", counts);
    let shader = Shader::new(format!("count: fragments into {counts}"), wgsl);
    pass("count", shader, request.geometry.draw_positions(), None)
}

/// Shades nothing and adds 1 for each fragment to its pixel of a target of [`counted`], which
/// is cleared first. Floats are whole numbers up to [`MOST_BLENDED`].
pub(crate) fn count_by_blending(request: &CaptureRequest) -> Pass {
    let wgsl = request.geometry.positions_wgsl() + COUNT_BY_BLENDING;
    let shader = Shader::new(format!("count: fragments into {COUNTED} by blending"), wgsl);
    let color = ColorAttachment {
        target: COUNTED.into(),
        load: Load::Clear([0.0; 4]),
        blend: Some(Blend::Add),
        write: true,
    };
    let draw = request.geometry.draw_positions();
    Pass::raster("count", Raster { color: vec![color], ..Raster::new(shader, draw) })
}

/// The target of counts: a 32-bit float a pixel.
pub(crate) fn counted(request: &CaptureRequest) -> Target {
    Target { name: COUNTED.into(), format: Format::R32Float, ..coverage(request) }
}

/// The most fragments of a pixel that blending counts: to a larger float 1 is added in vain.
pub(crate) const MOST_BLENDED: u32 = 1 << 24;

/// Copies the target of counts to the first words of a buffer and fills the rest of its `words` with
/// zero.
pub(crate) fn copy_counted(request: &CaptureRequest, counts: &str, words: u64) -> Pass {
    let (width, height) = (request.width_px, request.height_px);
    // No device has buffers for a picture that does not fit.
    let words = u32::try_from(words).unwrap_or(u32::MAX);
    let (row, dispatch) = workgroups(words.div_ceil(256));
    let constants = format!(
        "const WIDTH = {width}u;\nconst PIXELS = {}u;\nconst WORDS = {words}u;\nconst ROW = {row}u;\n\n",
        width.saturating_mul(height)
    );
    let wgsl = constants + &COPY_COUNTED.replace("COUNTS", counts);
    Pass::compute("count", Shader::new(format!("count: {COUNTED} to {counts}"), wgsl), dispatch)
}

/// Draws the scene; `fs` is the WGSL of the fragment stage and the buffers it fills.
pub(crate) fn capture_pass(request: &CaptureRequest, label: &str, fs: &[&str]) -> Pass {
    let wgsl = request.geometry.scene_wgsl() + &fs.concat();
    let shader = Shader::new(format!("capture: {label}"), wgsl);
    pass("capture", shader, request.geometry.draw(), request.mark.cloned())
}

/// A drawing pass that writes buffers alone. No depth or stencil test rejects anything, so no fragment
/// is rejected after its shader ran: what lies before the near or behind the far plane is clipped, in
/// every pass alike; of spheres, discarded.
pub(crate) fn pass(
    stage: &'static str,
    shader: Shader,
    draw: oit_gpu::Draw,
    mark: Option<DepthStencil>,
) -> Pass {
    let color = ColorAttachment {
        target: COVERAGE.into(),
        load: Load::Clear([0.0; 4]),
        blend: None,
        write: false,
    };
    let raster = Raster { color: vec![color], depth_stencil: mark, ..Raster::new(shader, draw) };
    Pass::raster(stage, raster)
}
