//! `linearized_nearest`: each pixel's nearest fragments in one run of an array.

use std::borrow::Cow;

use oit_fragments::{Lfb, LfbError};
use oit_gpu::{Buffer, Pass, Shader};

use super::nearest::{CITATION, NEAREST, read_back, sort, stored};
use crate::draw::{capture_pass, count_pass, coverage, pixel_buffer, pool_slots};
use crate::scan::{Scan, workgroups};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// Runs of an array as in [`Linearized`](super::Linearized), each filled by 64-bit atomic maxima as
/// in [`Array3dNearest`](super::Array3dNearest). Where the pool has no room for all, no pixel gets
/// more slots than a cap, the largest under which the view fits
/// ([`cap_for`](oit_fragments::DepthHistogram::cap_for)): each keeps that many of its nearest
/// fragments, sorted front to back, the same from run to run.
///
/// Buffers: `counts` (a `u32` a pixel: the fragments counted), `offsets` (a `u32` a pixel and one
/// more: where its run starts, which is where the one before it ends), `fragments` (a `vec2<u32>`
/// each, inverted; zeros are empty), `total` (one `u32`, the last offset), and the scan's own.
///
/// Beside what `linearized` does, the whole pool is cleared, and counts and offsets are both kept.
#[derive(Clone, Copy, Debug)]
pub struct LinearizedNearest;

const SCAN: Scan = Scan::Blocks;

/// The pass that caps the counts, and puts a 0 behind them.
fn cap_pass(request: &CaptureRequest, pixels: u32) -> Pass {
    let cap = request.histogram.cap_for(pool_slots(request.pool_slots));
    let (row, dispatch) = workgroups((pixels / 256).saturating_add(1));
    let constants =
        format!("const PIXELS = {pixels}u;\nconst CAP = {cap}u;\nconst ROW = {row}u;\n\n");
    let wgsl = constants + include_str!("linearized_nearest_cap.wgsl");
    Pass::compute("scan", Shader::new("scan: cap counts", wgsl), dispatch)
}

impl Capture for LinearizedNearest {
    fn name(&self) -> &'static str {
        "linearized_nearest"
    }

    fn summary(&self) -> &'static str {
        "Each pixel's nearest fragments in one run of an array, sorted by 64-bit atomics."
    }

    fn citation(&self) -> &'static str {
        CITATION
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        let parts =
            [include_str!("nearest_slot.wgsl"), include_str!("linearized_nearest_layout.wgsl")];
        parts.concat().into()
    }

    fn random_access(&self) -> bool {
        true
    }

    /// The fragments it keeps.
    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linearized_nearest_count.wgsl").into()
    }

    fn keeps_nearest(&self) -> bool {
        true
    }

    fn delivers_sorted(&self) -> bool {
        true
    }

    fn slots(&self, demand: &Demand) -> u64 {
        demand.histogram.total()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        let (total, limit) = (demand.histogram.total(), SCAN.limit());
        (total >= limit)
            .then(|| format!("{total} fragments: the prefix sums hold totals below {limit}"))
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        // No device has buffers for a picture that does not fit.
        let pixels = request.width_px.saturating_mul(request.height_px);
        let length = pixels.saturating_add(1);
        let (sums, scan) = SCAN.exclusive("scan", "offsets", "offsets", length, "total");
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            pixel_buffer("counts", request),
            Buffer::new("offsets", 4 * u64::from(length)),
            Buffer::new("total", 4),
            Buffer::new("fragments", 8 * pool_slots(request.pool_slots)),
        ]);
        buffers.extend(sums);
        let mut passes = vec![
            Pass::clear("clear", "counts"),
            Pass::clear("clear", "fragments"),
            count_pass(request, "counts"),
            cap_pass(request, pixels),
        ];
        passes.extend(scan);
        let fs = [NEAREST, include_str!("linearized_nearest.wgsl")];
        passes.push(capture_pass(request, self.name(), &fs));
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        let counts = read.words("counts", read.pixels())?;
        let total = counts.iter().map(|&count| u64::from(count)).sum();
        Ok(Usage { fragments: total, slots: total })
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let counts = read.words("counts", read.pixels())?;
        let starts = read.words("offsets", read.pixels() + 1)?;
        let kept = starts.last().copied().unwrap_or(0);
        let stored = u64::from(kept).min(pool_slots(read.pool_slots));
        let slots = read.fragments(stored)?;

        let mut offsets = Vec::with_capacity(starts.len());
        let mut fragments = Vec::with_capacity(slots.len());
        offsets.push(0);
        for (pixel, (run, &count)) in starts.windows(2).zip(&counts).enumerate() {
            let Some(held) = run[1].checked_sub(run[0]) else {
                return Err(LfbError::OffsetsFall { pixel }.into());
            };
            if held > count {
                let what = format!("{held} slots for {count} fragments");
                return Err(LfbError::Structure { pixel, what }.into());
            }
            let [first, end] = [run[0], run[1]].map(|at| u64::from(at).min(stored) as usize);
            read_back(pixel, slots[first..end].iter().copied(), &mut fragments)?;
            offsets.push(fragments.len());
        }
        if starts[0] != 0 {
            let what = format!("its run starts at {}", starts[0]);
            return Err(LfbError::Structure { pixel: 0, what }.into());
        }
        Ok(Lfb::new(read.width_px, read.height_px, offsets, fragments)?)
    }

    /// Sorted front to back.
    fn order(&self, submitted: &mut Lfb) {
        sort(submitted);
    }

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let counts: Vec<u32> = submitted.counts().collect();
        let starts: Vec<u32> = submitted.offsets().iter().map(|&start| start as u32).collect();
        vec![
            words_buffer("counts", &counts),
            words_buffer("offsets", &starts),
            words_buffer("total", &[submitted.fragments().len() as u32]),
            fragments_buffer(stored(submitted).fragments()),
        ]
    }
}
