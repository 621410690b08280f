//! One draw over a list of atoms: 8 bytes for each that is drawn.

use oit_gpu::{Buffer, Pass};

use crate::context::{Context, Phase};
use crate::scan;
use crate::text::{word, workgroups};

/// The most bytes that Vulkan and WebGPU can bind of a buffer.
const MAX_BYTES: u64 = u32::MAX as u64;

pub(super) fn buffers(context: &Context) -> Result<Vec<Buffer>, String> {
    let atoms = context.request.spheres.places_of(1);
    let bytes = 8 * atoms;
    if bytes > MAX_BYTES {
        return Err(format!(
            "a list of {atoms} atoms takes {bytes} bytes, and {MAX_BYTES} can be bound"
        ));
    }
    let mut buffers = scan::buffers(context.objects());
    buffers.push(Buffer::new("chosen", 4 * u64::from(context.objects())));
    buffers.push(Buffer::new("list", bytes));
    buffers.push(Buffer::new("list_draw", 16));
    Ok(buffers)
}

pub(super) fn passes(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let objects = context.objects();
    let counts = include_str!("../wgsl/counts.wgsl");
    let mut passes =
        vec![context.choosing("list: atoms of each object", phase, &[word("UNIT", 1)], counts)];
    passes.extend(scan::passes(context, objects));
    let constants = [word("CORNERS", context.corners)];
    let order = context.order_wgsl();
    passes.push(context.listing(
        "list: atoms",
        &constants,
        &[include_str!("../wgsl/view.wgsl"), order, include_str!("../wgsl/index_list.wgsl")],
        workgroups(u64::from(objects)),
    ));
    passes
}
