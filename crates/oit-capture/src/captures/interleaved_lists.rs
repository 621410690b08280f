//! `interleaved_lists`: the fragments of 32 neighbours of a list of pixels side by side.

use std::borrow::Cow;
use std::fmt::Write;

use oit_fragments::{Lfb, LfbError};
use oit_gpu::Buffer;

use super::interleaved::{
    CAPTURE, COUNT, GROUP, LAYOUT, buffers, count_passes, deepest, gather, group_pass, lay_out,
    places_pass, refuses, usage,
};
use super::rewrite::rewritable_slots;
use crate::draw::{capture_pass, coverage, pixel_buffer};
use crate::scan::Scan;
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Lists, Usage,
    words_buffer,
};

const BASE: &str = include_str!("interleaved_lists_base.wgsl");
const SCATTER: &str = include_str!("interleaved_lists_scatter.wgsl");

/// [`crate::Interleaved`] in the order of the schedule's lists of pixels: groups are of 32
/// consecutive entries of a list, so that the invocations of a resolve of that list read
/// neighbouring addresses, and a group's pixels have about the same number of fragments, which
/// leaves few slots unused. Fragment i of a pixel has the slot `bases[pixel] + 32 * i`.
///
/// Buffers: as [`crate::Interleaved`], and `bases` (a `u32` a pixel, undefined for those without
/// fragments). Groups of all lists lie one behind the other; `rows` has one more a list, since the
/// last group of each may be part of one.
///
/// The order within a list differs from run to run, and with it the slots that are used.
/// [`Capture::slots`] holds for every order: where n entries make g groups, their rows are the counts
/// of g of the entries, and so no more than the g largest.
///
/// Pixels deeper than the last list's upper bound are in that list, with all their fragments.
/// `counts` are zero between the group pass and the capture pass.
///
/// Beside what is read and written for each fragment (4 bytes to count it, 4 to read where it goes
/// and 4 to place it), and in bytes a pixel: `clear` writes 4; `group` is the schedule's (4 read, 4
/// written); `scan` reads the list twice and the counts once and writes these and the bases (12 read,
/// 8 written), and moves 5/8 to write, add up and read rows; a resolve reads 8 beside the list.
#[derive(Clone, Copy, Debug)]
pub struct InterleavedLists;

impl Capture for InterleavedLists {
    fn name(&self) -> &'static str {
        "interleaved_lists"
    }

    fn summary(&self) -> &'static str {
        "interleaved by groups of 32 entries of the schedule's lists of pixels."
    }

    fn citation(&self) -> &'static str {
        "This project; after Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL \
         Insights, 2012, section 20.4, and Backwards Memory Allocation and Improved OIT, Pacific \
         Graphics 2013, section 3"
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

    fn needs_lists(&self) -> bool {
        true
    }

    /// An upper bound, whatever the order within the lists. Without lists that of a single one.
    fn slots(&self, demand: &Demand) -> u64 {
        let lists = demand.lists.cloned().unwrap_or_else(one_list);
        let rows = |list: Vec<usize>| {
            let mut counts: Vec<u32> = list.iter().map(|&pixel| demand.counts[pixel]).collect();
            counts.sort_unstable_by(|a, b| b.cmp(a));
            let groups = counts.len().div_ceil(GROUP as usize);
            counts[..groups].iter().copied().map(u64::from).sum::<u64>()
        };
        let lists = lists_of(demand.counts.iter().copied(), &lists);
        u64::from(GROUP) * lists.into_iter().map(rows).sum::<u64>()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        refuses(self, demand)
    }

    /// Without lists, as for a single one.
    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let lists = request.lists.cloned().unwrap_or_else(one_list);
        // No device has buffers for a picture that does not fit.
        let pixels = request.width_px.saturating_mul(request.height_px);
        let groups = pixels.div_ceil(GROUP) + lists.firsts.len() as u32;
        let (own, scan) = Scan::Blocks.exclusive("scan", "rows", "rows", groups, "row_total");
        let entry = entry_wgsl(&lists);
        let mut passes = count_passes(request);
        let lists_at = Some(passes.len());
        passes.push(group_pass(groups, &entry));
        passes.extend(scan);
        passes.push(places_pass(groups, "tell pixels their bases", &[&entry, SCATTER]));
        passes.push(capture_pass(request, "interleaved_lists", &[BASE, CAPTURE]));
        let mut buffers = buffers(request, groups);
        buffers.push(pixel_buffer("bases", request));
        buffers.extend(own);
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        usage(read)
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let counts = read.words("counts", read.pixels())?;
        let bases = read.words("bases", read.pixels())?;
        let mut placed: Vec<usize> = (0..counts.len()).filter(|&pixel| counts[pixel] > 0).collect();
        placed.sort_unstable_by_key(|&pixel| bases[pixel]);
        let mut rows = 0;
        for group in placed.chunk_by(|&a, &b| bases[a] / GROUP == bases[b] / GROUP) {
            let damaged = |pixel, what| Err(LfbError::Structure { pixel, what }.into());
            let first = bases[group[0]] / GROUP;
            if u64::from(first) != rows {
                let what =
                    format!("its group starts at row {first}, the one before ends at {rows}");
                return damaged(group[0], what);
            }
            if let Some(pair) = group.windows(2).find(|pair| bases[pair[0]] == bases[pair[1]]) {
                let what = format!("it has the base {} of pixel {}", bases[pair[1]], pair[0]);
                return damaged(pair[1], what);
            }
            rows += group.iter().map(|&pixel| u64::from(counts[pixel])).max().unwrap_or(0);
        }
        gather(read, &counts, rows, |pixel| u64::from(bases[pixel]))
    }

    /// A pixel's rows are filled from the first: the order is that of submission.
    fn order(&self, _submitted: &mut Lfb) {}

    /// As with a single list, in the order of pixels: a valid buffer, but not in the order in which
    /// a schedule's lists are resolved.
    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        self.upload_in_lists(submitted, &one_list())
    }

    /// Each list in the order of pixels. A schedule makes its lists anew, in an order of its own,
    /// which is the same but for workgroups that overtake each other; a group of 32 invocations
    /// then reads from two groups of slots, mostly.
    fn upload_in_lists(&self, submitted: &Lfb, lists: &Lists) -> Vec<Buffer> {
        let counts: Vec<u32> = submitted.counts().collect();
        let mut bases = vec![0; counts.len()];
        let mut rows = 0;
        for list in lists_of(counts.iter().copied(), lists) {
            for group in list.chunks(GROUP as usize) {
                for (lane, &pixel) in group.iter().enumerate() {
                    bases[pixel] = GROUP * rows + lane as u32;
                }
                let counts: Vec<u32> = group.iter().map(|&pixel| counts[pixel]).collect();
                rows += deepest(&counts);
            }
        }
        let mut buffers = lay_out(submitted, &bases, rows);
        buffers.push(words_buffer("bases", &bases));
        buffers
    }
}

fn one_list() -> Lists {
    Lists { firsts: vec![0], uppers: vec![u32::MAX] }
}

/// The pixels of each list, in order.
fn lists_of(counts: impl Iterator<Item = u32>, lists: &Lists) -> Vec<Vec<usize>> {
    let mut pixels = vec![Vec::new(); lists.uppers.len().max(1)];
    let last = pixels.len() - 1;
    for (pixel, count) in counts.enumerate().filter(|&(_, count)| count > 0) {
        // The last list takes deeper ones too.
        let list = lists.uppers.partition_point(|&upper| upper < count).min(last);
        pixels[list].push(pixel);
    }
    pixels
}

/// WGSL of `entry(at)`, the pixel that has the place `at`: lists lie one behind the other, each
/// filled up to whole groups.
fn entry_wgsl(lists: &Lists) -> String {
    let mut wgsl = "const NO_PIXEL = 0xffffffffu;\n\n\
        @group(0) @binding(8) var<storage, read> group_pixels: array<u32>;\n\
        @group(0) @binding(9) var<storage, read> group_counts: array<u32>;\n\n\
        fn entry(at: u32) -> u32 {\n    var place = at;\n    var length = 0u;\n"
        .to_owned();
    for (list, first) in lists.firsts.iter().enumerate() {
        write!(
            wgsl,
            "    length = group_counts[{list}u];\n    \
                 if (place < length) {{ return group_pixels[{first}u + place]; }}\n    \
                 length = (length + 31u) / 32u * 32u;\n    \
                 if (place < length) {{ return NO_PIXEL; }}\n    \
                 place -= length;\n"
        )
        .expect("strings take all");
    }
    wgsl + "    return NO_PIXEL;\n}\n\n"
}
