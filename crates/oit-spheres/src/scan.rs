//! Prefix sums of `counts`: where each object's part of a list begins. Blocks of 1024, their sums,
//! and both added up.

use oit_gpu::{Buffer, Dispatch, Pass};

use crate::context::Context;
use crate::text::{word, workgroups};

const BLOCK: u32 = 1024;

pub(crate) fn buffers(length: u32) -> Vec<Buffer> {
    vec![
        Buffer::new("counts", 4 * u64::from(length)),
        Buffer::new("block_sums", 4 * u64::from(length.div_ceil(BLOCK))),
        Buffer::new("total", 16),
    ]
}

/// Passes that make of each count the sum of those before it, and their sum `total`.
pub(crate) fn passes(context: &mut Context, length: u32) -> Vec<Pass> {
    let blocks = workgroups(u64::from(length.div_ceil(BLOCK)));
    let constants = [word("LENGTH", length)];
    let one = Dispatch::Workgroups([1, 1, 1]);
    [
        ("scan: sums of blocks", include_str!("wgsl/scan_blocks.wgsl"), blocks.clone()),
        ("scan: sums of sums", include_str!("wgsl/scan_sums.wgsl"), one),
        ("scan: sums", include_str!("wgsl/scan_add.wgsl"), blocks),
    ]
    .into_iter()
    .map(|(label, text, dispatch)| context.listing(label, &constants, &[text], dispatch))
    .collect()
}
