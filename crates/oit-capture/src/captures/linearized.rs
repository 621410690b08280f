//! `linearized`: each pixel's fragments in one run of an array.

use std::borrow::Cow;

use oit_fragments::{Lfb, LfbError};
use oit_gpu::{Buffer, Pass};

use super::rewrite::rewritable_slots;
use crate::draw::{
    MOST_BLENDED, capture_pass, copy_counted, count_by_blending, count_pass, counted, coverage,
    pixel_buffer, pool_slots,
};
use crate::scan::Scan;
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// Each pixel's fragments in one run of an array (LFB chapter, section 20.4). A first pass counts
/// each pixel's fragments, prefix sums turn the counts into where the runs start, and a second pass
/// puts the fragments there.
///
/// Buffers: `offsets` (a `u32` a pixel: its count, then where its run starts, and in the end where
/// it ends, so that a run starts where the one before it ends; padded to a power of two for
/// [`Linearized::SWEEP`]), `fragments` (a `vec2<u32>` each), `total` (one `u32`), and the scan's own.
/// [`Linearized::LOOK_BACK`] counts in a buffer of its own, `counts`.
///
/// Beside what is read and written for each fragment (4 bytes to count it and 4 to place it), and in
/// bytes a pixel: `clear` writes 4 for the counts; `scan` reads 8 and writes 4 by blocks, reads 16
/// and writes 12 by sweeps, reads 4 and writes 4 looking back; a resolve reads 4 once each offset is
/// in a cache. Blending has no `clear`: `count` clears the target (4 written) and copies it (4 read,
/// 4 written).
///
/// In a pool that is too small the runs that fit are whole, one is cut, and those behind it are
/// empty: `offsets` then say where the runs would be.
#[derive(Clone, Copy, Debug)]
pub struct Linearized {
    name: &'static str,
    summary: &'static str,
    citation: &'static str,
    scan: Scan,
    counting: Counting,
}

/// How fragments are counted (LFB chapter, section 20.4.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Counting {
    /// An atomic increment a fragment.
    Atomics,
    /// 1 is blended into a target of floats, and the target copied to the table.
    Blending,
}

const CHAPTER: &str = "Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL \
                       Insights, 2012, section 20.4";

impl Linearized {
    /// Prefix sums by blocks.
    pub const BLOCKS: Self = Self {
        name: "linearized",
        summary: "Each pixel's fragments in one run of an array: counted, prefix sums, captured.",
        citation: CHAPTER,
        scan: Scan::Blocks,
        counting: Counting::Atomics,
    };

    /// Prefix sums as in the chapter: over a table padded to a power of two, a pass a level.
    pub const SWEEP: Self = Self {
        name: "linearized_sweep",
        summary: "linearized with the chapter's prefix sums: padded to a power of two, a pass a level.",
        citation: CHAPTER,
        scan: Scan::Sweep,
        counting: Counting::Atomics,
    };

    /// Prefix sums in one pass. Refuses views of 2^30 fragments and more.
    pub const LOOK_BACK: Self = Self {
        name: "linearized_lookback",
        summary: "linearized with prefix sums in one pass: decoupled look-back that waits for nobody.",
        citation: "Merrill and Garland, Single-pass Parallel Prefix Scan with Decoupled Look-back, \
                   NVIDIA NVR-2016-002; Smith, Levien and Owens, Decoupled Fallback, SPAA 2025",
        scan: Scan::LookBack,
        counting: Counting::Atomics,
    };

    /// Counts by additive blending. Needs a device that blends 32-bit floats, and refuses views with
    /// more than 2^24 fragments on a pixel.
    pub const BLEND: Self = Self {
        name: "linearized_blend",
        summary: "linearized with fragments counted by additive blending, and the counts copied.",
        citation: "Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL Insights, \
                   2012, section 20.4.1",
        scan: Scan::Blocks,
        counting: Counting::Blending,
    };
}

impl Capture for Linearized {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn citation(&self) -> &'static str {
        self.citation
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        include_str!("linearized_layout.wgsl").into()
    }

    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        rewritable_slots(self, "1u")
    }

    fn layout_cuda(&self) -> Option<&'static str> {
        Some(include_str!("linearized_layout.cuh"))
    }

    fn random_access(&self) -> bool {
        true
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linearized_count.wgsl").into()
    }

    fn slots(&self, demand: &Demand) -> u64 {
        demand.histogram.total()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        let (total, limit) = (demand.histogram.total(), self.scan.limit());
        let peak = demand.histogram.peak();
        if self.counting == Counting::Blending && peak > MOST_BLENDED {
            return Some(format!("{peak} fragments on a pixel: blending counts {MOST_BLENDED}"));
        }
        (total >= limit).then(|| {
            format!("{total} fragments: the prefix sums of {} hold totals below {limit}", self.name)
        })
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        // No device has buffers for a picture that does not fit.
        let pixels = request.width_px.saturating_mul(request.height_px);
        let mut buffers = request.geometry.buffers();
        let counts = if self.scan.in_place() {
            "offsets"
        } else {
            buffers.push(pixel_buffer("counts", request));
            "counts"
        };
        let (sums, scan) = self.scan.exclusive("scan", counts, "offsets", pixels, "total");
        let offsets = pixel_buffer("offsets", request);
        let words = self.scan.words(pixels);
        buffers.extend([
            Buffer::new("offsets", offsets.bytes.max(4 * words)),
            Buffer::new("total", 4),
            Buffer::new("fragments", 8 * pool_slots(request.pool_slots)),
        ]);
        buffers.extend(sums);
        let (mut targets, mut passes) = (vec![coverage(request)], Vec::new());
        match self.counting {
            Counting::Atomics => {
                passes.extend([Pass::clear("clear", counts), count_pass(request, counts)]);
            }
            Counting::Blending => {
                targets.push(counted(request));
                let copy = copy_counted(request, counts, words);
                passes.extend([count_by_blending(request), copy]);
            }
        }
        passes.extend(scan);
        passes.push(capture_pass(request, "linearized", &[include_str!("linearized.wgsl")]));
        CapturePasses { buffers, targets, passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        let total = u64::from(read.words("total", 1)?[0]);
        Ok(Usage { fragments: total, slots: total })
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let total = self.usage(read)?.fragments;
        let stored = total.min(pool_slots(read.pool_slots));
        let ends = read.words("offsets", read.pixels())?;
        let fragments = read.fragments(stored)?;

        let mut offsets = Vec::with_capacity(ends.len() + 1);
        offsets.push(0);
        let mut start = 0;
        for (pixel, &end) in ends.iter().enumerate() {
            if end < start {
                return Err(LfbError::OffsetsFall { pixel }.into());
            }
            start = end;
            offsets.push(u64::from(end).min(stored) as usize);
        }
        if u64::from(start) != total {
            let what = format!("{total} fragments were counted and {start} captured");
            return Err(LfbError::Structure { pixel: ends.len().saturating_sub(1), what }.into());
        }
        Ok(Lfb::new(read.width_px, read.height_px, offsets, fragments)?)
    }

    /// A run is filled from its start: the order is that of submission.
    fn order(&self, _submitted: &mut Lfb) {}

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let ends: Vec<u32> = submitted.offsets()[1..].iter().map(|&end| end as u32).collect();
        vec![
            words_buffer("offsets", &ends),
            words_buffer("total", &[submitted.fragments().len() as u32]),
            fragments_buffer(submitted.fragments()),
        ]
    }
}
