//! `linearized_unclipped`, `linearized_late`: what early tests are for where nothing is clipped.

use std::borrow::Cow;

use oit_fragments::Lfb;
use oit_gpu::{Buffer, Compare, Depth, DepthStencil, Format, Load, Pass, Shader, Target, Work};

use super::Linearized;
use crate::draw::{capture_pass, coverage, pass};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage, words_buffer,
};

/// [`Linearized`] where the triangles that cross the near and the far plane are drawn whole, as the
/// LFB chapter has it (section 20.4.1), and forced early depth tests keep what lies beyond out of
/// both passes: the depth target holds 1, and what is not less is rejected before its shader runs.
/// What lies before the near plane passes that test and is left out by the shader.
///
/// With `late`, the second pass does without forcing its test. Its shader then runs, and writes,
/// before the test rejects, so the passes disagree and runs flow over into those behind them.
///
/// Neither is exact against captures that clip: these move the corners where they cut, and depths
/// with them, by rounding. A capture of this kind does not mark the pixels it draws to.
///
/// Spheres have no clipping to do without: their shader leaves out what lies beyond either plane, and
/// both are [`Linearized`] then, the tests passing everything.
///
/// Buffers: those of [`Linearized`], and `captured` (one `u32`: the fragments of the second pass).
/// Target: `depth_range`.
#[derive(Clone, Copy, Debug)]
pub struct LinearizedUnclipped {
    /// Whether the second pass writes before it tests.
    pub late: bool,
}

const LINEARIZED: Linearized = Linearized::BLOCKS;

/// The target of the depth test: 1 everywhere, never written.
const RANGE: &str = "depth_range";

/// The pass, drawing past both planes under a test that rejects what is behind the far one.
fn unclipped(mut pass: Pass, late: bool) -> Pass {
    if let Work::Raster(raster) = &mut pass.work {
        let depth = Depth { load: Load::Clear(1.0), compare: Compare::Less, write: false };
        raster.depth_stencil =
            Some(DepthStencil { target: RANGE.into(), depth: Some(depth), stencil: None });
        raster.unclipped = true;
        raster.late_writes = late;
    }
    pass
}

fn count_pass(request: &CaptureRequest) -> Pass {
    let wgsl = request.geometry.positions_wgsl() + include_str!("linearized_unclipped_count.wgsl");
    let shader = Shader::new("count: fragments into offsets, unclipped", wgsl);
    unclipped(pass("count", shader, request.geometry.draw_positions(), None), false)
}

/// Both passes must have met the same fragments.
fn agree(read: &mut LfbReader) -> Result<(), CaptureError> {
    let [counted, captured] = ["total", "captured"].map(|buffer| read.words(buffer, 1));
    let (counted, captured) = (counted?[0], captured?[0]);
    if counted == captured { Ok(()) } else { Err(CaptureError::Disagree { counted, captured }) }
}

impl Capture for LinearizedUnclipped {
    fn name(&self) -> &'static str {
        if self.late { "linearized_late" } else { "linearized_unclipped" }
    }

    fn summary(&self) -> &'static str {
        if self.late {
            "A fault shown on purpose: linearized_unclipped, capturing before it tests."
        } else {
            "linearized without clipping, kept to the depth range by forced early tests."
        }
    }

    fn citation(&self) -> &'static str {
        "Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL Insights, 2012, \
         section 20.4.1"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        LINEARIZED.layout_wgsl()
    }

    fn random_access(&self) -> bool {
        LINEARIZED.random_access()
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        LINEARIZED.count_wgsl()
    }

    fn marks(&self) -> bool {
        false
    }

    fn slots(&self, demand: &Demand) -> u64 {
        LINEARIZED.slots(demand)
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        LINEARIZED.refuses(demand)
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let request = &CaptureRequest { mark: None, ..*request };
        let mut passes = LINEARIZED.build(request);
        passes.buffers.push(Buffer::new("captured", 4));
        let range =
            Target { name: RANGE.into(), format: Format::Depth32Float, ..coverage(request) };
        passes.targets.push(range);
        let early = if self.late { "" } else { "@early_depth_test(force)" };
        let fs = include_str!("linearized_unclipped.wgsl").replace("EARLY", early);
        let capture = unclipped(capture_pass(request, self.name(), &[&fs]), self.late);
        for pass in &mut passes.passes {
            match pass.stage {
                "count" => *pass = count_pass(request),
                "capture" => *pass = capture.clone(),
                _ => {}
            }
        }
        passes.passes.insert(0, Pass::clear("clear", "captured"));
        passes
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        agree(read)?;
        LINEARIZED.usage(read)
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        agree(read)?;
        LINEARIZED.unpack(read)
    }

    fn order(&self, submitted: &mut Lfb) {
        LINEARIZED.order(submitted);
    }

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let mut buffers = LINEARIZED.upload(submitted);
        buffers.push(words_buffer("captured", &[submitted.fragments().len() as u32]));
        buffers
    }
}
