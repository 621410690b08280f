//! What the captures' drawing passes have in common.

use oit_fragments::DepthHistogram;
use oit_gpu::{
    Buffer, ColorAttachment, DepthStencil, Format, Load, Pass, Plan, Raster, Shader, Target,
};

use crate::{CaptureRequest, Geometry};

const FRAME: &str = include_str!("wgsl/frame.wgsl");
const SCENE: &str = include_str!("wgsl/scene.wgsl");
const COUNT: &str = include_str!("wgsl/count.wgsl");

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

/// Draws positions alone and adds each fragment to its pixel's `u32` in a buffer.
pub(crate) fn count_pass(request: &CaptureRequest, counts: &str) -> Pass {
    let wgsl = [FRAME, &COUNT.replace("COUNTS", counts)].concat();
    let shader = Shader::new(format!("count: fragments into {counts}"), wgsl);
    pass("count", shader, request.geometry.draw_positions(), None)
}

/// Draws the scene; `fs` is the WGSL of the fragment stage and the buffers it fills.
pub(crate) fn capture_pass(request: &CaptureRequest, label: &str, fs: &[&str]) -> Pass {
    let wgsl = [FRAME, SCENE, &fs.concat()].concat();
    let shader = Shader::new(format!("capture: {label}"), wgsl);
    pass("capture", shader, request.geometry.draw(), request.mark.cloned())
}

/// No depth or stencil test rejects anything, so no fragment is rejected after its shader ran: what
/// lies before the near or behind the far plane is clipped, in every pass alike.
fn pass(
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
