//! `interleaved`: the fragments of 32 neighbouring pixels side by side.

use std::borrow::Cow;

use oit_fragments::{Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Pass, Shader};

use super::rewrite::rewritable_slots;
use crate::draw::{capture_pass, count_pass, coverage, pixel_buffer, pool_slots};
use crate::scan::{Scan, workgroups};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// Pixels of a group: as many as a GPU's subgroup has invocations, mostly.
pub(super) const GROUP: u32 = 32;

pub(super) const CAPTURE: &str = include_str!("interleaved.wgsl");
pub(super) const COUNT: &str = include_str!("interleaved_count.wgsl");
pub(super) const LAYOUT: &str = include_str!("interleaved_layout.wgsl");
const BASE: &str = include_str!("interleaved_base.wgsl");
const GROUPS: &str = include_str!("interleaved_group.wgsl");
const PIXELS: &str = include_str!("interleaved_pixels.wgsl");

/// [`crate::Linearized`] by groups of 32 consecutive pixels: the i-th fragments of a group's pixels
/// lie next to each other, so that invocations of a compute resolve that take neighbouring pixels
/// read neighbouring addresses. Fragment i of a pixel has the slot
/// `32 * (rows[pixel / 32] + i) + pixel % 32`. A group has as many rows as its deepest pixel has
/// fragments; what its other pixels leave of them is memory overhead.
///
/// Buffers: `counts` (a `u32` a pixel), `rows` (a `u32` a group: the rows before it), `row_total` (one
/// `u32`), `total` (one `u32`: fragments that were counted), `fragments` (a `vec2<u32>` a slot), and
/// the scan's own.
///
/// Beside what is read and written for each fragment (4 bytes to count it, 4 to place it), and in
/// bytes a pixel: `clear` writes 4; `scan` reads 4 and writes 4 to find the rows of groups, and moves
/// 1/2 to write these and add them up; a resolve reads 4 and 1/8.
///
/// In a pool that is too small whole rows are cut, and one in part, from the end.
#[derive(Clone, Copy, Debug)]
pub struct Interleaved;

impl Capture for Interleaved {
    fn name(&self) -> &'static str {
        "interleaved"
    }

    fn summary(&self) -> &'static str {
        "linearized by groups of 32 pixels, their i-th fragments side by side."
    }

    fn citation(&self) -> &'static str {
        "This project; after Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL \
         Insights, 2012, section 20.4"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        [BASE, LAYOUT].concat().into()
    }

    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        rewritable_slots(self, "32u")
    }

    fn random_access(&self) -> bool {
        true
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        COUNT.into()
    }

    fn slots(&self, demand: &Demand) -> u64 {
        let rows = demand.counts.chunks(GROUP as usize).map(deepest).map(u64::from);
        u64::from(GROUP) * rows.sum::<u64>()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        refuses(self, demand)
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        // No device has buffers for a picture that does not fit.
        let pixels = request.width_px.saturating_mul(request.height_px);
        let groups = pixels.div_ceil(GROUP);
        let (own, scan) = Scan::Blocks.exclusive("scan", "rows", "rows", groups, "row_total");
        let mut passes = count_passes(request);
        passes.push(group_pass(groups, &format!("const PIXELS = {pixels}u;\n{PIXELS}")));
        passes.extend(scan);
        passes.push(capture_pass(request, "interleaved", &[BASE, CAPTURE]));
        let mut buffers = buffers(request, groups);
        buffers.extend(own);
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        usage(read)
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let counts = read.words("counts", read.pixels())?;
        let rows = read.words("rows", read.pixels().div_ceil(u64::from(GROUP)))?;
        let mut before = 0;
        for (group, (&row, counts)) in rows.iter().zip(counts.chunks(GROUP as usize)).enumerate() {
            if u64::from(row) != before {
                let what = format!("its group has {before} rows before it, and {row} are stored");
                return Err(LfbError::Structure { pixel: group * GROUP as usize, what }.into());
            }
            before += u64::from(deepest(counts));
        }
        let base = |pixel: usize| {
            u64::from(GROUP) * u64::from(rows[pixel / GROUP as usize])
                + (pixel % GROUP as usize) as u64
        };
        gather(read, &counts, before, base)
    }

    /// A pixel's rows are filled from the first: the order is that of submission.
    fn order(&self, _submitted: &mut Lfb) {}

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let counts: Vec<u32> = submitted.counts().collect();
        let (mut rows, mut row_total) = (Vec::new(), 0);
        for group in counts.chunks(GROUP as usize) {
            rows.push(row_total);
            row_total += deepest(group);
        }
        let base = |pixel: usize| GROUP * rows[pixel / GROUP as usize] + pixel as u32 % GROUP;
        let bases: Vec<u32> = (0..counts.len()).map(base).collect();
        let mut buffers = lay_out(submitted, &bases, row_total);
        buffers.push(words_buffer("rows", &rows));
        buffers
    }
}

/// The most fragments of a group's pixels: its rows.
pub(super) fn deepest(counts: &[u32]) -> u32 {
    counts.iter().copied().max().unwrap_or(0)
}

/// Slots are reckoned in 32 bits, with a row to spare for the reader's end of a pixel.
pub(super) fn refuses(capture: &dyn Capture, demand: &Demand) -> Option<String> {
    let slots = capture.slots(demand);
    let limit = (1 << 32) - u64::from(GROUP);
    (slots > limit).then(|| format!("{slots} slots: {} has at most {limit}", capture.name()))
}

/// The buffers of an interleaved layout but for what says where each pixel starts.
pub(super) fn buffers(request: &CaptureRequest, groups: u32) -> Vec<Buffer> {
    let mut buffers = request.geometry.buffers();
    buffers.extend([
        pixel_buffer("counts", request),
        Buffer::new("rows", 4 * u64::from(groups)),
        Buffer::new("row_total", 4),
        Buffer::new("total", 4),
        Buffer::new("fragments", 8 * pool_slots(request.pool_slots)),
    ]);
    buffers
}

/// The passes up to where `counts` are known.
pub(super) fn count_passes(request: &CaptureRequest) -> Vec<Pass> {
    let clears = ["counts", "total"].map(|buffer| Pass::clear("clear", buffer));
    clears.into_iter().chain([count_pass(request, "counts")]).collect()
}

/// Finds the rows of each group; `entry` is the WGSL that says which pixels it has.
pub(super) fn group_pass(groups: u32, entry: &str) -> Pass {
    places_pass(groups, "find the rows of groups", &[entry, GROUPS])
}

/// A pass with an invocation for each place of each group.
pub(super) fn places_pass(groups: u32, what: &str, parts: &[&str]) -> Pass {
    let (row, dispatch) = workgroups(groups.div_ceil(256 / GROUP));
    let constants = format!("const GROUPS = {groups}u;\nconst ROW = {row}u;\n");
    let shader = Shader::new(format!("scan: {what}"), constants + &parts.concat());
    Pass::compute("scan", shader, dispatch)
}

/// See [`Capture::usage`].
pub(super) fn usage(read: &mut LfbReader) -> Result<Usage, CaptureError> {
    let fragments = u64::from(read.words("total", 1)?[0]);
    let rows = u64::from(read.words("row_total", 1)?[0]);
    Ok(Usage { fragments, slots: u64::from(GROUP) * rows })
}

/// Reads the fragments of pixels that start at `base` and share no slot of their `rows`.
pub(super) fn gather(
    read: &mut LfbReader,
    counts: &[u32],
    rows: u64,
    base: impl Fn(usize) -> u64,
) -> Result<Lfb, CaptureError> {
    let last = counts.len().saturating_sub(1);
    let damaged = |what| Err(LfbError::Structure { pixel: last, what }.into());
    let Usage { fragments: total, slots } = usage(read)?;
    if slots != u64::from(GROUP) * rows {
        return damaged(format!("groups have {rows} rows, and {slots} slots are said to be used"));
    }
    let captured: u64 = counts.iter().copied().map(u64::from).sum();
    if captured != total {
        return damaged(format!("{total} fragments were counted and {captured} captured"));
    }
    let room = slots.min(pool_slots(read.pool_slots));
    let pool = read.fragments(room)?;
    let mut offsets = Vec::with_capacity(counts.len() + 1);
    let mut fragments = Vec::new();
    offsets.push(0);
    for (pixel, &count) in counts.iter().enumerate() {
        if count > 0 {
            let slots = (base(pixel)..room).step_by(GROUP as usize).take(count as usize);
            fragments.extend(slots.map(|slot| pool[slot as usize]));
        }
        offsets.push(fragments.len());
    }
    Ok(Lfb::new(read.width_px, read.height_px, offsets, fragments)?)
}

/// What a run leaves in pixels that start at these bases; the slots between are zero.
pub(super) fn lay_out(submitted: &Lfb, bases: &[u32], rows: u32) -> Vec<Buffer> {
    let mut pool = vec![Fragment::new(0.0, [0; 4]); GROUP as usize * rows as usize];
    for (pixel, &base) in bases.iter().enumerate() {
        for (i, &fragment) in submitted.pixel(pixel).iter().enumerate() {
            pool[base as usize + GROUP as usize * i] = fragment;
        }
    }
    let counts: Vec<u32> = submitted.counts().collect();
    vec![
        words_buffer("counts", &counts),
        words_buffer("total", &[submitted.fragments().len() as u32]),
        words_buffer("row_total", &[rows]),
        fragments_buffer(&pool),
    ]
}
