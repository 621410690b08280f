//! Layouts whose fragments are put into order where they were captured.

use std::borrow::Cow;

use crate::Capture;

/// A capture's layout with `fragments` to be written, followed by WGSL that writes them.
pub(super) fn rewritable(capture: &dyn Capture, writes: &str) -> Option<Cow<'static, str>> {
    let layout = capture.layout_wgsl();
    let (reads, writable) = ("storage, read> fragments", "storage, read_write> fragments");
    debug_assert!(layout.contains(reads), "{} reads no fragments", capture.name());
    Some((layout.replace(reads, writable) + writes).into())
}

/// The same where a pixel's fragments are `stride` (in WGSL) slots apart.
pub(super) fn rewritable_slots(capture: &dyn Capture, stride: &str) -> Option<Cow<'static, str>> {
    rewritable(capture, &include_str!("slots_rewrite.wgsl").replace("STRIDE", stride))
}
