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
            depth_stencil: Some(mark()),
            ..Raster::new(
                Shader::new(format!("group: mark {low} to {high}"), wgsl),
                Draw::Vertices { count: 3, instances: 1 },
            )
        },
    )
}

/// The test by which a capture marks every pixel that it draws to: it rejects nothing.
#[must_use]
pub fn mark() -> DepthStencil {
    stencil(MARKING)
}

const MARKING: Stencil = Stencil {
    clear: Some(0),
    compare: Compare::Always,
    reference: MARK,
    pass: StencilOp::Replace,
    fail: StencilOp::Keep,
};

fn stencil(test: Stencil) -> DepthStencil {
    DepthStencil { target: STENCIL.into(), depth: None, stencil: Some(test) }
}

/// The most fragments of a pixel that a stencil counts.
pub const MOST_COUNTED: u32 = 255;

/// The test by which a capture counts each pixel's fragments, up to [`MOST_COUNTED`]: it rejects
/// nothing.
#[must_use]
pub fn count_drawn() -> DepthStencil {
    stencil(Stencil { pass: StencilOp::IncrementClamp, ..MARKING })
}

/// The test by which a resolve runs on pixels with at least `low` fragments that a stencil counted.
/// Those that it runs on count none from then on, so that intervals are resolved from the deepest
/// to the shallowest (BMA paper, section 3: in descending order).
///
/// # Panics
/// Where `low` is 0 or above [`MOST_COUNTED`].
#[must_use]
pub fn counted(low: u32) -> DepthStencil {
    assert!((1..=MOST_COUNTED).contains(&low), "a stencil does not count {low}");
    stencil(Stencil {
        clear: None,
        compare: Compare::LessEqual,
        reference: low as u8,
        pass: StencilOp::Zero,
        fail: StencilOp::Keep,
    })
}

/// The test by which a resolve runs on marked pixels only.
#[must_use]
pub fn masked() -> DepthStencil {
    stencil(Stencil {
        clear: None,
        compare: Compare::Equal,
        reference: MARK,
        pass: StencilOp::Keep,
        fail: StencilOp::Keep,
    })
}
