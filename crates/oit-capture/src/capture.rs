//! What a capture method is.

use std::borrow::Cow;

use oit_fragments::{DepthHistogram, Element, Lfb, LfbError};
use oit_gpu::{Buffer, DepthStencil, Pass, Target};

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
    fn layout_wgsl(&self) -> Cow<'static, str>;

    /// The same for programs that order fragments where they were captured: `fragments` may be
    /// written, and there are also `lfb_cursor`, `lfb_seek` and `lfb_put` (see `oit_sort::Layout`).
    /// `None` where a fragment cannot take another's place.
    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        None
    }

    /// The same in CUDA C++, where there is one: `struct Lfb` with the buffers it reads, and the
    /// functions on it (see `oit_sort::CudaLayout`).
    fn layout_cuda(&self) -> Option<&'static str> {
        None
    }

    /// What its reader gives of a fragment, and a resolve sorts.
    fn element(&self) -> Element {
        Element::Narrow
    }

    /// Whether the i-th fragment of a pixel can be read without reading those before it.
    fn random_access(&self) -> bool;

    /// WGSL that declares what it needs and defines `fn pixel_count(pixel: u32) -> u32`, the
    /// fragments of a pixel. Needs [`CaptureRequest::counts`].
    fn count_wgsl(&self) -> Cow<'static, str>;

    /// Whether fragments lie in the order of the schedule's lists of pixels
    /// ([`CaptureRequest::lists`]), so that only a schedule that makes lists can use it.
    fn needs_lists(&self) -> bool {
        false
    }

    /// Slots (a fragment each) that a pool needs to hold all of a view, whatever the order in which
    /// its fragments arrive: no run's [`Usage::slots`] is more.
    fn slots(&self, demand: &Demand) -> u64;

    /// Why this capture would be wrong on such a view, where it would: numbers that do not fit the
    /// bits it has for them. Asked before a plan is built.
    fn refuses(&self, _demand: &Demand) -> Option<String> {
        None
    }

    /// Whether a pool that is too small keeps each pixel's nearest fragments, in their total order
    /// and no more than a cap for every pixel, rather than those that came first: then two runs
    /// keep the same, and [`Capture::count_wgsl`] counts what is kept.
    fn keeps_nearest(&self) -> bool {
        false
    }

    /// Whether its reader meets each pixel's fragments nearest first, in their total order: they were
    /// sorted as they were captured, and a resolve that does not sort is exact.
    fn delivers_sorted(&self) -> bool {
        false
    }

    /// Whether its drawing pass can mark pixels ([`CaptureRequest::mark`]).
    fn marks(&self) -> bool {
        true
    }

    /// The passes that fill the buffer, and what they need.
    fn build(&self, request: &CaptureRequest) -> CapturePasses;

    /// What the last run came to.
    ///
    /// # Errors
    /// Where a buffer cannot be read.
    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError>;

    /// The fragments the last run stored, in the order its reader meets them.
    ///
    /// # Errors
    /// Where a buffer cannot be read, or is damaged: a list that runs into itself, an offset
    /// beyond the pool.
    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError>;

    /// The CPU twin: from the fragments in submission order to the order this layout's reader meets.
    fn order(&self, submitted: &mut Lfb);

    /// What a run leaves of these fragments (in submission order) in a pool that holds them all:
    /// every buffer that [`Capture::layout_wgsl`], [`Capture::count_wgsl`] and
    /// [`Capture::unpack`] read, so that a stored buffer is resolved without rasterising.
    fn upload(&self, submitted: &Lfb) -> Vec<Buffer>;

    /// The same for a schedule with lists: where fragments lie in the order of the lists
    /// ([`Capture::needs_lists`]), as a run leaves them whose lists are in the order of pixels.
    fn upload_in_lists(&self, submitted: &Lfb, _lists: &Lists) -> Vec<Buffer> {
        self.upload(submitted)
    }
}

/// What a count pass found, for the size of a pool.
#[derive(Clone, Copy, Debug)]
pub struct Demand<'a> {
    /// Fragments of each pixel, row by row.
    pub counts: &'a [u32],
    /// The same, counted.
    pub histogram: &'a DepthHistogram,
    /// The schedule's lists, if it makes any.
    pub lists: Option<&'a Lists>,
}

/// A schedule's lists of pixels. On the device `group_pixels` holds them one behind the other and
/// `group_counts` (a `u32` a list) how long they are. Pixels without fragments are in none.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Lists {
    /// Where in `group_pixels` each list starts.
    pub firsts: Vec<u32>,
    /// The most fragments of a pixel in each list; the last also takes deeper ones.
    pub uppers: Vec<u32>,
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
    /// Room in the pool, in slots (at least 1). What does not fit is counted, not stored.
    pub pool_slots: u64,
    /// What the count pass found, for captures that share a pool out over the pixels.
    pub histogram: &'a DepthHistogram,
    /// Whether [`Capture::count_wgsl`] will be used: a layout that has no counts of its own makes
    /// them only then, and is charged for it.
    pub counts: bool,
    /// Lists that the schedule's passes make at [`CapturePasses::lists_at`].
    pub lists: Option<&'a Lists>,
    /// A stencil test that rejects nothing, by which the capture's drawing pass marks the pixels
    /// that it draws to.
    pub mark: Option<&'a DepthStencil>,
}

/// What a run of a capture came to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Usage {
    /// Fragments it met, stored or not.
    pub fragments: u64,
    /// Slots that a pool must have to store them all.
    pub slots: u64,
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
    /// Where among the passes the schedule's lists must be made, for a capture that needs them:
    /// [`Capture::count_wgsl`] works from here on.
    pub lists_at: Option<usize>,
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
    /// The pass that counts and the one that captures met different fragments.
    #[error("{counted} fragments were counted and {captured} captured")]
    Disagree {
        /// Fragments that the first pass met.
        counted: u32,
        /// Fragments that the second pass met.
        captured: u32,
    },
    /// What was read is no layered fragment buffer.
    #[error(transparent)]
    Damaged(#[from] LfbError),
}
