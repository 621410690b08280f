//! Grouping by stencil: before each interval's resolve, the stencil is cleared and a full-screen
//! pass marks the interval's pixels (BMA paper, section 3, steps 2a to 2c).

use oit_gpu::{
    Compare, DepthStencil, Draw, Format, Pass, Raster, Shader, Stencil, StencilOp, Target,
};

use crate::{GroupRequest, Interval};

/// The stencil target.
const STENCIL: &str = "stencil";

/// What a marked pixel holds.
const MARK: u8 = 1;

/// The stencil target for an image of this size.
#[must_use]
pub fn stencil_target(request: &GroupRequest) -> Target {
    Target {
        name: STENCIL.into(),
        format: Format::Stencil8,
        width: request.width_px,
        height: request.height_px,
    }
}

/// The pass that marks an interval's pixels, and no others. `last` also takes deeper ones.
#[must_use]
pub fn mask_pass(request: &GroupRequest, interval: Interval, last: bool) -> Pass {
    let Interval { low, high } = interval;
    let above = if last { String::new() } else { format!(" || count > {high}u") };
    let wgsl = format!(
        r"{count_wgsl}
@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}}

// Discarding keeps the stencil as it was, so early tests must not be forced here.
@fragment
fn fs(@builtin(position) position: vec4<f32>) {{
    let count = pixel_count(u32(position.y) * {width}u + u32(position.x));
    if (count < {low}u{above}) {{
        discard;
    }}
}}
",
        count_wgsl = request.count_wgsl,
        width = request.width_px,
    );
    Pass::raster(
        "group",
        Raster {
            depth_stencil: Some(DepthStencil {
                target: STENCIL.into(),
                depth: None,
                stencil: Some(Stencil {
                    clear: Some(0),
                    compare: Compare::Always,
                    reference: MARK,
                    pass: StencilOp::Replace,
                    fail: StencilOp::Keep,
                }),
            }),
            ..Raster::new(
                Shader::new(format!("group: mark {low} to {high}"), wgsl),
                Draw::Vertices { count: 3, instances: 1 },
            )
        },
    )
}

/// The test by which a resolve runs on marked pixels only.
#[must_use]
pub fn masked() -> DepthStencil {
    DepthStencil {
        target: STENCIL.into(),
        depth: None,
        stencil: Some(Stencil {
            clear: None,
            compare: Compare::Equal,
            reference: MARK,
            pass: StencilOp::Keep,
            fail: StencilOp::Keep,
        }),
    }
}
