//! `linked_pages4`, `linked_pages6`: a list of pages a pixel.

use std::borrow::Cow;

use oit_fragments::{Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Pass};

use super::linked_list::{UNCOUNTED, follow};
use super::rewrite::rewritable;
use crate::draw::{capture_pass, coverage, pixel_buffer, pool_slots};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// A list of pages a pixel, each with room for some fragments (LFB chapter, section 20.2). One
/// pass: a fragment takes the next slot of its pixel's newest page; where that is full, one
/// invocation at a time fetches a new page from a global counter and links it in at the head. So
/// the counter is asked once a page, and a page may end up partly filled.
///
/// The semaphore that Crassin has for each pixel is the top bit of its head, and his index within
/// the page is counted in the page: then nothing rests on the order in which atomics at two
/// addresses are seen, of which WGSL promises none. An invocation that has waited for long fetches a
/// page without the lock, so that none can wait for ever.
///
/// Buffers: `heads` (a `u32` a pixel: 0, or the newest page plus one), `nexts` (a `u32` a page, the
/// same), `fills` (a `u32` a page: slots asked for after its first), `fragments` (a `vec2<u32>` a
/// slot, page after page), `page_count` (one `u32`: pages asked for), `dropped` (a `u32` a pixel:
/// fragments that found the pool full), and `counts` if asked for.
#[derive(Clone, Copy, Debug)]
pub struct LinkedPages {
    /// Slots of a page: 4 or 6, "around four to six" in the chapter.
    pub page: u32,
    /// Turns that an invocation takes at a locked head before it fetches a page without the lock.
    /// Fewer than 65,535, after which llvmpipe ends a loop.
    pub tries: u32,
}

impl LinkedPages {
    /// Pages of this many slots, and patience for some hundred times what fetching a page takes.
    ///
    /// # Panics
    /// Where a page would have no slot.
    #[must_use]
    pub const fn new(page: u32) -> Self {
        assert!(page > 0, "a page has a slot");
        Self { page, tries: 256 }
    }

    /// Whole pages of a pool.
    fn pages(&self, pool: u64) -> u64 {
        pool_slots(pool) / u64::from(self.page)
    }

    fn page_wgsl(&self) -> String {
        format!("const PAGE = {}u;\n", self.page)
    }

    /// Slots of the pages that this many fragments of one pixel fill.
    fn page_slots(&self, count: u32) -> u64 {
        u64::from(count.div_ceil(self.page)) * u64::from(self.page)
    }

    /// Pages that the last run used, and what each pixel had no page for.
    fn used(&self, read: &mut LfbReader) -> Result<(u64, Vec<u32>), CaptureError> {
        let room = self.pages(read.pool_slots);
        let asked = u64::from(read.words("page_count", 1)?[0]);
        let dropped = read.words("dropped", read.pixels())?;
        if let Some(pixel) = dropped.iter().position(|&dropped| dropped > 0 && asked <= room) {
            let what = format!("fragments without a page, and {asked} of {room} pages were used");
            return Err(LfbError::Structure { pixel, what }.into());
        }
        Ok((asked.min(room), dropped))
    }

    /// The fragments that a page of this fill holds.
    fn held(&self, fill: u32) -> u32 {
        fill.saturating_add(1).min(self.page)
    }
}

impl Capture for LinkedPages {
    fn name(&self) -> &'static str {
        match self.page {
            4 => "linked_pages4",
            6 => "linked_pages6",
            _ => "linked_pages",
        }
    }

    fn summary(&self) -> &'static str {
        match self.page {
            4 => "A linked list of pages a pixel, four fragments a page, in one pass.",
            6 => "A linked list of pages a pixel, six fragments a page, in one pass.",
            _ => "A linked list of pages a pixel, in one pass.",
        }
    }

    fn citation(&self) -> &'static str {
        "Crassin, Linked Lists of Fragment Pages, Icare3D Blog, 2010; Knowles et al., Efficient \
         Layered Fragment Buffer Techniques, OpenGL Insights, 2012, section 20.2"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        (self.page_wgsl() + include_str!("linked_pages_layout.wgsl")).into()
    }

    fn rewrite_wgsl(&self) -> Option<Cow<'static, str>> {
        rewritable(self, include_str!("linked_pages_rewrite.wgsl"))
    }

    fn random_access(&self) -> bool {
        false
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linked_list_count.wgsl").into()
    }

    /// As many as full pages come to, and some more: each time an invocation is tired of waiting, a
    /// page stays partly empty.
    fn slots(&self, demand: &Demand) -> u64 {
        let pixels = (0..).zip(&demand.histogram.pixels);
        let full: u64 = pixels.map(|(count, pixels)| self.page_slots(count) * pixels).sum();
        full + full / 64 / u64::from(self.page) * u64::from(self.page)
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let pages = self.pages(request.pool_slots);
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            pixel_buffer("heads", request),
            pixel_buffer("dropped", request),
            Buffer::new("page_count", 4),
            Buffer::new("nexts", 4 * pages),
            Buffer::new("fills", 4 * pages),
            Buffer::new("fragments", 8 * pool_slots(request.pool_slots)),
        ]);
        let cleared = ["heads", "dropped", "page_count", "fills"];
        let mut passes = cleared.map(|buffer| Pass::clear("clear", buffer)).to_vec();
        let counted = if request.counts {
            buffers.push(pixel_buffer("counts", request));
            passes.push(Pass::clear("clear", "counts"));
            include_str!("linked_list_counted.wgsl")
        } else {
            UNCOUNTED
        };
        let constants = format!("{}const TRIES = {}u;\n\n", self.page_wgsl(), self.tries);
        let fs = [counted, &constants, include_str!("linked_pages.wgsl")];
        passes.push(capture_pass(request, self.name(), &fs));
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        let (pages, dropped) = self.used(read)?;
        let fills = read.words("fills", pages)?;
        let stored: u64 = fills.iter().map(|&fill| u64::from(self.held(fill))).sum();
        let missing: u64 = dropped.iter().map(|&dropped| u64::from(dropped)).sum();
        // A pixel that was refused a page had filled those it had.
        let more: u64 = dropped.iter().map(|&dropped| self.page_slots(dropped)).sum();
        Ok(Usage { fragments: stored + missing, slots: pages * u64::from(self.page) + more })
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let (pages, _) = self.used(read)?;
        let heads = read.words("heads", read.pixels())?;
        let nexts = read.words("nexts", pages)?;
        let fills = read.words("fills", pages)?;
        let slots = read.fragments(pages * u64::from(self.page))?;

        let (offsets, listed) = follow("page", &heads, &nexts, |page, listed| {
            let first = page * self.page as usize;
            let held = self.held(fills[page]) as usize;
            listed.extend(slots[first..first + held].iter().rev());
        })?;
        Ok(Lfb::new(read.width_px, read.height_px, offsets, listed)?)
    }

    /// Pages are read from the newest, and a page from its end: the last submitted comes first.
    fn order(&self, submitted: &mut Lfb) {
        submitted.reorder(<[_]>::reverse);
    }

    /// Pages are handed out as when whole layers are drawn: the first page of every pixel, then the
    /// second of every pixel that has one, and so on.
    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let page = self.page as usize;
        let mut heads = vec![0u32; submitted.pixels()];
        let (mut nexts, mut fills, mut fragments) = (Vec::new(), Vec::new(), Vec::new());
        let mut pixels: Vec<usize> = (0..submitted.pixels()).collect();
        for layer in 0.. {
            pixels.retain(|&pixel| layer * page < submitted.pixel(pixel).len());
            if pixels.is_empty() {
                break;
            }
            for &pixel in &pixels {
                let rest = &submitted.pixel(pixel)[layer * page..];
                let own = &rest[..rest.len().min(page)];
                fragments.extend_from_slice(own);
                fills.push(own.len() as u32 - 1);
                fragments.resize(fills.len() * page, Fragment::default());
                nexts.push(std::mem::replace(&mut heads[pixel], fills.len() as u32));
            }
        }
        let counts: Vec<u32> = submitted.counts().collect();
        vec![
            words_buffer("heads", &heads),
            words_buffer("nexts", &nexts),
            words_buffer("fills", &fills),
            words_buffer("page_count", &[fills.len() as u32]),
            words_buffer("dropped", &vec![0; submitted.pixels()]),
            words_buffer("counts", &counts),
            fragments_buffer(&fragments),
        ]
    }
}
