//! One indirect draw for each level of each kind, its objects as instances: three passes of
//! compaction (section 3.4.3).

use oit_gpu::{Buffer, Pass};

use crate::context::{Context, Phase};
use crate::text::{invocations, word};

pub(super) fn buffers(context: &Context) -> Vec<Buffer> {
    let (objects, levels) = (u64::from(context.objects()), u64::from(context.levels()));
    vec![
        Buffer::new("instances", 4 * levels),
        Buffer::new("ranks", 8 * objects),
        Buffer::new("commands", 16 * levels),
        Buffer::new("taken", 4),
        Buffer::new("by_mesh", 4 * objects),
    ]
}

pub(super) fn passes(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let (objects, levels) = (context.objects(), context.levels());
    let mut passes = context.clears(&["instances", "taken"]);
    let count = include_str!("../wgsl/mesh_count.wgsl");
    passes.push(context.choosing("list: objects of each mesh", phase, &[], count));
    let view = include_str!("../wgsl/view.wgsl");
    let slot = include_str!("../wgsl/slot.wgsl");
    let constants = [word("LEVELS", levels), word("CORNERS", context.corners)];
    passes.push(context.listing(
        "list: where each mesh's begin",
        &constants,
        &[slot, include_str!("../wgsl/mesh_offsets.wgsl")],
        invocations(u64::from(levels)),
    ));
    passes.push(context.listing(
        "list: objects by mesh",
        &[],
        &[view, slot, include_str!("../wgsl/mesh_scatter.wgsl")],
        invocations(u64::from(objects)),
    ));
    passes
}
