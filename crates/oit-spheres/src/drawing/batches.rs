//! Objects in batches of atoms: what one patch can be tessellated into (section 3.4.1), or what one
//! workgroup draws.

use oit_gpu::{Buffer, Dispatch, Pass};

use super::WORKGROUP_BATCH;
use crate::context::{Context, Phase};
use crate::text::{invocations, word};
use crate::{Billboard, Order, Raster, scan};

/// Vertices that every device can tessellate a patch into, as isolines: 64 lines of 65 points.
const PATCH_BATCH: u32 = 64 * 65;

/// Atoms of a batch.
pub(super) fn size(context: &Context) -> u32 {
    match context.variation.raster {
        Raster::Billboards { billboard: Billboard::Geometry, .. } => PATCH_BATCH,
        _ => WORKGROUP_BATCH,
    }
}

pub(super) fn buffers(context: &Context, size: u32) -> Result<Vec<Buffer>, String> {
    let batches = context.request.spheres.places_of(size);
    let mut buffers = vec![Buffer::new("batches", 16 * batches), Buffer::new("batch_count", 16)];
    if context.variation.order != Order::AsIs {
        buffers.extend(scan::buffers(context.objects()));
        buffers.push(Buffer::new("chosen", 4 * u64::from(context.objects())));
    }
    Ok(buffers)
}

pub(super) fn passes(context: &mut Context, size: u32, phase: Phase) -> Vec<Pass> {
    let objects = context.objects();
    let batch = word("BATCH", size);
    if context.variation.order == Order::AsIs {
        let mut passes = context.clears(&["batch_count"]);
        let text = include_str!("../wgsl/batches.wgsl");
        passes.push(context.choosing("list: batches", phase, &[batch], text));
        return passes;
    }
    // An order that is asked for is kept: a counter would keep it but roughly.
    let counts = include_str!("../wgsl/counts.wgsl");
    let unit = word("UNIT", size);
    let mut passes = vec![context.choosing("list: batches of each object", phase, &[unit], counts)];
    passes.extend(scan::passes(context, objects));
    let order = context.order_wgsl();
    passes.push(context.listing(
        "list: batches in order",
        &[batch],
        &[
            include_str!("../wgsl/view.wgsl"),
            include_str!("../wgsl/slot.wgsl"),
            order,
            include_str!("../wgsl/batches_ordered.wgsl"),
        ],
        invocations(u64::from(objects)),
    ));
    passes
}

/// What a compute rasteriser lists: its batches, and how many workgroups they are.
pub(crate) fn workgroup_batches(context: &Context) -> Result<Vec<Buffer>, String> {
    let mut buffers = buffers(context, WORKGROUP_BATCH)?;
    buffers.push(Buffer::new("batch_groups", 12));
    Ok(buffers)
}

/// The passes that list them.
pub(crate) fn groups(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let mut passes = passes(context, WORKGROUP_BATCH, phase);
    let text = include_str!("../wgsl/batch_groups.wgsl");
    let one = Dispatch::Workgroups([1, 1, 1]);
    passes.push(context.listing("list: workgroups", &[], &[text], one));
    passes
}
