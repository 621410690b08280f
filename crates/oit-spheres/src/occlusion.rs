//! Two-phase occlusion culling: objects that were seen are drawn; their depths make a pyramid (Greene,
//! Kass and Miller 1993); objects that it does not hide are drawn as well, and are what was seen.
//!
//! What was seen is left from the plan's last run, or from that of another plan that shares the
//! buffer. It may be anything: the picture is right whatever it is, and only the time depends on it.
//! Where buffers were filled with `0xCD`, all counts as seen, and the first phase draws everything.

use oit_gpu::{Buffer, Dispatch, Pass};

use crate::context::Context;
use crate::output::early_ids_wgsl;
use crate::text::word;

/// Sizes of the pyramid's levels: each a quarter as wide and as high as what is below it.
fn sizes(context: &Context) -> Vec<(u32, u32)> {
    let mut size = (context.request.width_px, context.request.height_px);
    let mut sizes = Vec::new();
    while sizes.is_empty() || size.0.max(size.1) > 1 {
        size = (size.0.div_ceil(4), size.1.div_ceil(4));
        sizes.push(size);
    }
    sizes
}

pub(crate) fn levels(context: &Context) -> u32 {
    sizes(context).len() as u32
}

pub(crate) fn buffers(context: &Context) -> Vec<Buffer> {
    let texels = |&(width, height): &(u32, u32)| u64::from(width) * u64::from(height);
    vec![
        Buffer::new("seen", 4 * u64::from(context.objects())),
        Buffer::new("pyramid", 4 * sizes(context).iter().map(texels).sum::<u64>()),
    ]
}

/// The passes that make the pyramid of what is drawn.
pub(crate) fn passes(context: &mut Context) -> Vec<Pass> {
    let sizes = sizes(context);
    let dispatch = |(width, height): (u32, u32)| {
        Dispatch::Workgroups([width.div_ceil(8), height.div_ceil(8), 1])
    };
    let constants = [context.perspective_wgsl(), context.ids_wgsl()];
    let texts = [
        include_str!("wgsl/view.wgsl"),
        include_str!("wgsl/spheres.wgsl"),
        include_str!("wgsl/meet.wgsl"),
        early_ids_wgsl(context.variation.raster, context.variation.output),
        include_str!("wgsl/pyramid_base.wgsl"),
    ];
    let mut passes = vec![context.listing("pyramid: base", &constants, &texts, dispatch(sizes[0]))];
    let mut below = 0;
    for pair in sizes.windows(2) {
        let (width, height) = pair[0];
        let size = format!("const BELOW_SIZE = vec2<u32>({width}u, {height}u);\n");
        let constants = [word("BELOW", below), size];
        let text = include_str!("wgsl/pyramid_level.wgsl");
        passes.push(context.listing("pyramid: level", &constants, &[text], dispatch(pair[1])));
        below += width * height;
    }
    passes
}
