//! `linked_list`, `linked_list_subgroup`, `linked_list_blend`: a list of nodes a pixel.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};

use oit_fragments::{Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Pass};
use rayon::prelude::*;

use super::rewrite::rewritable;
use crate::draw::{
    MOST_BLENDED, capture_and_count_pass, capture_pass, copy_counted, counted, coverage,
    pixel_buffer, pool_slots,
};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// A list of nodes a pixel, grown at its head (LFB chapter, section 20.3). One pass: a global
/// counter hands out nodes, and the exchange of a pixel's head links one in. By subgroups, one
/// invocation asks the counter for as many nodes as its subgroup has fragments.
///
/// Buffers: `heads` (a `u32` a pixel: 0, or the newest node plus one), `nexts` (a `u32` a node, the
/// same), `fragments` (a `vec2<u32>` a node), `node_count` (one `u32`), and `counts` if asked for: by
/// an atomic addition a fragment, or for [`LinkedList::BLEND`] by blending 1 into a target of floats
/// in the pass that captures, which is copied to the buffer afterwards.
#[derive(Clone, Copy, Debug)]
pub struct LinkedList {
    name: &'static str,
    summary: &'static str,
    citation: &'static str,
    /// Whether the counter is asked once a subgroup, else once a fragment.
    subgroups: bool,
    /// Whether a pixel's fragments are counted by blending.
    blending: bool,
}

const CITATION: &str = "Yang et al., Real-Time Concurrent Linked List Construction on the GPU, EGSR \
                        2010; Knowles et al., Efficient Layered Fragment Buffer Techniques, OpenGL \
                        Insights, 2012, section 20.3";

/// For capture passes that need not count.
pub(super) const UNCOUNTED: &str = "\nfn count_fragment(pixel: u32) {}\n\n";

/// Pixels whose links one thread follows at a time.
const PIXELS_AT_ONCE: usize = 4096;

/// The links of every pixel, each followed from its head to its end, many pixels at once; `take`
/// appends what the `what` (a node, a page) of this number holds. Returns where each pixel's
/// fragments start, where the last ends, and the fragments.
///
/// # Errors
/// Where something is linked twice, is none of those used, or is linked nowhere.
pub(super) fn follow(
    what: &str,
    heads: &[u32],
    nexts: &[u32],
    take: impl Fn(usize, &mut Vec<Fragment>) + Sync,
) -> Result<(Vec<usize>, Vec<Fragment>), CaptureError> {
    // What was met ends every walk, so that links that run in a circle do as well.
    let seen: Vec<AtomicBool> = nexts.iter().map(|_| AtomicBool::new(false)).collect();
    let walk = |first: usize, heads: &[u32]| {
        let (mut ends, mut taken) = (Vec::with_capacity(heads.len()), Vec::new());
        for (pixel, &head) in (first..).zip(heads) {
            let mut link = head;
            while link != 0 {
                let place = link as usize - 1;
                let what = match seen.get(place).map(|seen| seen.swap(true, Ordering::Relaxed)) {
                    Some(false) => {
                        take(place, &mut taken);
                        link = nexts[place];
                        continue;
                    }
                    Some(true) => format!("{what} {place} is linked twice"),
                    None => {
                        let used = nexts.len();
                        format!("{what} {place} of a pool in which {used} are used")
                    }
                };
                return Err(LfbError::Structure { pixel, what });
            }
            ends.push(taken.len());
        }
        Ok((ends, taken))
    };
    let chunks = heads.par_chunks(PIXELS_AT_ONCE).enumerate();
    let walked: Vec<_> = chunks.map(|(index, heads)| walk(index * PIXELS_AT_ONCE, heads)).collect();
    let mut offsets = Vec::with_capacity(heads.len() + 1);
    offsets.push(0);
    let mut parts = Vec::with_capacity(walked.len());
    let mut first = 0;
    for part in walked {
        let (ends, taken) = part?;
        offsets.extend(ends.into_iter().map(|end| first + end));
        first += taken.len();
        parts.push(taken);
    }
    if let Some(node) = seen.iter().position(|seen| !seen.load(Ordering::Relaxed)) {
        return Err(CaptureError::Lost { node });
    }
    Ok((offsets, parts.concat()))
}

impl LinkedList {
    /// The counter is asked once a fragment.
    pub const EACH: Self = Self {
        name: "linked_list",
        summary: "A linked list a pixel, its nodes handed out by one atomic counter, in one pass.",
        citation: CITATION,
        subgroups: false,
        blending: false,
    };
    /// The counter is asked once a subgroup.
    pub const SUBGROUPS: Self = Self {
        name: "linked_list_subgroup",
        summary: "A linked list a pixel, its nodes handed out by one atomic addition a subgroup, in \
                  one pass.",
        subgroups: true,
        ..Self::EACH
    };
    /// Counts by additive blending. Needs a device that blends 32-bit floats, and refuses views with
    /// more than 2^24 fragments on a pixel.
    pub const BLEND: Self = Self {
        name: "linked_list_blend",
        summary: "linked_list with each pixel's fragments counted by additive blending in the same \
                  pass, and the counts copied.",
        citation: "Knowles et al., Backwards Memory Allocation and Improved OIT, Pacific Graphics \
                   2013, section 3; Knowles et al., Efficient Layered Fragment Buffer Techniques, \
                   OpenGL Insights, 2012, section 20.4.1",
        blending: true,
        ..Self::EACH
    };
}

impl Capture for LinkedList {
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
        include_str!("linked_list_layout.wgsl").into()
    }

    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        rewritable(self, include_str!("linked_list_rewrite.wgsl"))
    }

    fn layout_cuda(&self) -> Option<&'static str> {
        Some(include_str!("linked_list_layout.cuh"))
    }

    fn random_access(&self) -> bool {
        false
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linked_list_count.wgsl").into()
    }

    fn slots(&self, demand: &Demand) -> u64 {
        demand.histogram.total()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        let peak = demand.histogram.peak();
        (self.blending && peak > MOST_BLENDED)
            .then(|| format!("{peak} fragments on a pixel: blending counts {MOST_BLENDED}"))
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let slots = pool_slots(request.pool_slots);
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            pixel_buffer("heads", request),
            Buffer::new("node_count", 4),
            Buffer::new("nexts", 4 * slots),
            Buffer::new("fragments", 8 * slots),
        ]);
        let mut targets = vec![coverage(request)];
        let mut passes = vec![Pass::clear("clear", "heads"), Pass::clear("clear", "node_count")];
        if request.counts {
            buffers.push(pixel_buffer("counts", request));
        }
        if request.counts && self.blending {
            targets.push(counted(request));
            let fs = [
                UNCOUNTED,
                include_str!("linked_list.wgsl"),
                include_str!("linked_list_blended.wgsl"),
            ];
            let words = u64::from(request.width_px) * u64::from(request.height_px);
            passes.push(capture_and_count_pass(request, self.name, &fs));
            passes.push(copy_counted(request, "counts", words));
            return CapturePasses { buffers, targets, passes, lists_at: None };
        }
        let counting = if request.counts {
            passes.push(Pass::clear("clear", "counts"));
            include_str!("linked_list_counted.wgsl")
        } else {
            UNCOUNTED
        };
        let fs = if self.subgroups {
            include_str!("linked_list_subgroup.wgsl")
        } else {
            include_str!("linked_list_each.wgsl")
        };
        let fs = [counting, include_str!("linked_list.wgsl"), fs];
        passes.push(capture_pass(request, self.name, &fs));
        CapturePasses { buffers, targets, passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        let nodes = u64::from(read.words("node_count", 1)?[0]);
        Ok(Usage { fragments: nodes, slots: nodes })
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let stored = self.usage(read)?.slots.min(pool_slots(read.pool_slots));
        let heads = read.words("heads", read.pixels())?;
        let nexts = read.words("nexts", stored)?;
        let fragments = read.fragments(stored)?;

        let (offsets, listed) =
            follow("node", &heads, &nexts, |node, listed| listed.push(fragments[node]))?;
        Ok(Lfb::new(read.width_px, read.height_px, offsets, listed)?)
    }

    /// A list is read from its head: the last submitted comes first.
    fn order(&self, submitted: &mut Lfb) {
        submitted.reorder(<[_]>::reverse);
    }

    /// Nodes are handed out as when whole layers are drawn: the first fragment of every pixel, then
    /// the second of every pixel that has one, and so on.
    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let total = submitted.fragments().len();
        let mut heads = vec![0u32; submitted.pixels()];
        let mut nexts = Vec::with_capacity(total);
        let mut fragments = Vec::with_capacity(total);
        let mut pixels: Vec<usize> = (0..submitted.pixels()).collect();
        for layer in 0.. {
            pixels.retain(|&pixel| layer < submitted.pixel(pixel).len());
            if pixels.is_empty() {
                break;
            }
            for &pixel in &pixels {
                fragments.push(submitted.pixel(pixel)[layer]);
                nexts.push(std::mem::replace(&mut heads[pixel], fragments.len() as u32));
            }
        }
        let counts: Vec<u32> = submitted.counts().collect();
        vec![
            words_buffer("heads", &heads),
            words_buffer("nexts", &nexts),
            words_buffer("node_count", &[total as u32]),
            words_buffer("counts", &counts),
            fragments_buffer(&fragments),
        ]
    }
}
