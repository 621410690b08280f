//! One indirect draw for each object (section 3.4.2).

use oit_gpu::{Buffer, Pass};

use crate::context::{Context, Phase};

pub(super) fn buffers(context: &Context) -> Vec<Buffer> {
    vec![Buffer::new("commands", 16 * u64::from(context.objects()))]
}

pub(super) fn passes(context: &mut Context, phase: Phase) -> Vec<Pass> {
    let text = include_str!("../wgsl/per_object.wgsl");
    vec![context.choosing("list: a command for each object", phase, &[], text)]
}
