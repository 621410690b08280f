//! What a capture method is.

use oit_fragments::{Lfb, LfbError};
use oit_gpu::{Buffer, Pass, Target};

use crate::{Geometry, LfbReader};

/// One way to fill a layered fragment buffer: passes of a plan, the WGSL by which a resolve reads
/// what they leave, and how its bytes become an [`Lfb`].
///
/// Its CPU twin is [`Capture::order`]: the rasteriser gives every fragment in submission order, and
/// the twin says in what order this layout's reader meets them.
pub trait Capture: Sync {
    /// The name in technique coordinates.
    fn name(&self) -> &'static str;

    /// One sentence: what it does.
    fn summary(&self) -> &'static str;

    /// Where it comes from.
    fn citation(&self) -> &'static str;

    /// WGSL that declares its buffers read only and defines `lfb_begin`, `lfb_more`, `lfb_next`
    /// and, with random access, `lfb_len` and `lfb_at` (see `oit_sort::Layout`).
    fn layout_wgsl(&self) -> &'static str;

    /// Whether the i-th fragment of a pixel can be read without reading those before it.
    fn random_access(&self) -> bool;

    /// WGSL that declares what it needs and defines `fn pixel_count(pixel: u32) -> u32`, the
    /// fragments of a pixel. Needs `CaptureRequest::counts`.
    fn count_wgsl(&self) -> &'static str;

    /// The passes that fill the buffer, and what they need.
    fn build(&self, request: &CaptureRequest) -> CapturePasses;

    /// How many fragments the last run would have stored had the pool been large enough.
    ///
    /// # Errors
    /// Where a buffer cannot be read.
    fn needed(&self, read: &mut LfbReader) -> Result<u64, CaptureError>;

    /// The fragments the last run stored, in the order its reader meets them.
    ///
    /// # Errors
    /// Where a buffer cannot be read, or is damaged: a list that runs into itself, an offset
    /// beyond the pool.
    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError>;

    /// The CPU twin: from the fragments in submission order to the order this layout's reader meets.
    fn order(&self, submitted: &mut Lfb);
}

/// What a capture is asked to fill.
#[derive(Clone, Copy, Debug)]
pub struct CaptureRequest<'a> {
    /// What is drawn.
    pub geometry: &'a Geometry,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Room in the pool, in fragments (at least 1). What does not fit is counted, not stored.
    pub pool_fragments: u64,
    /// Whether [`Capture::count_wgsl`] will be used: a layout that has no counts of its own makes
    /// them only then, and is charged for it.
    pub counts: bool,
}

/// The passes of a capture, and what they need.
#[derive(Clone, Debug, Default)]
pub struct CapturePasses {
    /// Buffers.
    pub buffers: Vec<Buffer>,
    /// Targets.
    pub targets: Vec<Target>,
    /// Passes, in order.
    pub passes: Vec<Pass>,
}

/// Why a capture could not be read back.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// A buffer could not be read from the device.
    #[error(transparent)]
    Read(#[from] oit_gpu::GpuError),
    /// A buffer is smaller than it was made.
    #[error("buffer {buffer:?} has {bytes} bytes, {expected} are needed")]
    Short {
        /// The buffer.
        buffer: &'static str,
        /// What it has.
        bytes: usize,
        /// What it should have at least.
        expected: u64,
    },
    /// A stored fragment belongs to no pixel.
    #[error("node {node} is in no list")]
    Lost {
        /// The first such node.
        node: usize,
    },
    /// What was read is no layered fragment buffer.
    #[error(transparent)]
    Damaged(#[from] LfbError),
}
