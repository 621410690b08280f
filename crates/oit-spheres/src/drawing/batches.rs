//! Objects in batches of atoms: what one patch can be tessellated into (section 3.4.1), or what one
//! workgroup draws. How many workgroups that is only the device knows, so it also says it to the draw.

use oit_gpu::{Buffer, Dispatch, Pass};

use crate::context::{Context, Phase};
use crate::text::{invocations, word};
use crate::{Billboard, Order, Raster, scan};

/// Vertices that every device can tessellate a patch into, as isolines: 64 lines of 65 points.
const PATCH_BATCH: u32 = 64 * 65;

/// Atoms of a batch that a workgroup of the compute rasteriser draws.
const COMPUTE_BATCH: u32 = 64;

/// Atoms of a batch that a workgroup of a mesh shader draws: one subgroup's invocations, and as many
/// vertices and primitives as NVIDIA's hardware allots in steps of 32.
pub(crate) const MESH_BATCH: u32 = 32;

/// Atoms of a batch.
fn size(context: &Context) -> u32 {
    match context.variation.raster {
        Raster::Billboards { billboard: Billboard::MeshShader, .. } => MESH_BATCH,
        Raster::Billboards { .. } => PATCH_BATCH,
        Raster::Compute => COMPUTE_BATCH,
    }
}

/// Whether a workgroup draws a batch, not a patch.
fn by_workgroups(context: &Context) -> bool {
    size(context) != PATCH_BATCH
}

pub(super) fn buffers(context: &Context) -> Result<Vec<Buffer>, String> {
    let batches = context.request.spheres.places_of(size(context));
    let mut buffers = vec![Buffer::new("batches", 16 * batches), Buffer::new("batch_count", 16)];
    if by_workgroups(context) {
        buffers.push(Buffer::new("batch_groups", 12));
    }
    if context.variation.order != Order::AsIs {
        buffers.extend(scan::buffers(context.objects()));
        buffers.push(Buffer::new("chosen", 4 * u64::from(context.objects())));
    }
    Ok(buffers)
}

pub(super) fn passes(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let mut passes = match context.variation.order {
        Order::AsIs => as_they_come(context, phase),
        _ => in_order(context, phase),
    };
    if by_workgroups(context) {
        let text = include_str!("../wgsl/batch_groups.wgsl");
        let one = Dispatch::Workgroups([1, 1, 1]);
        passes.push(context.listing("list: workgroups", &[], &[text], one));
    }
    passes
}

fn as_they_come(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let batch = word("BATCH", size(context));
    let mut passes = context.clears(&["batch_count"]);
    let text = include_str!("../wgsl/batches.wgsl");
    passes.push(context.choosing("list: batches", phase, &[batch], text));
    passes
}

/// An order that is asked for is kept: a counter would keep it but roughly.
fn in_order(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let (objects, size) = (context.objects(), size(context));
    let (batch, unit) = (word("BATCH", size), word("UNIT", size));
    let counts = include_str!("../wgsl/counts.wgsl");
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
