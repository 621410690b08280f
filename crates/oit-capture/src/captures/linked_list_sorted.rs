//! `linked_list_sorted`: a list of nodes a pixel, kept in order while it is captured.

use std::borrow::Cow;

use oit_fragments::{Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Pass};

use super::linked_list::{UNCOUNTED, follow};
use super::nearest::sort;
use crate::draw::{capture_pass, coverage, pixel_buffer, pool_slots};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage,
    fragments_buffer, words_buffer,
};

/// A list of nodes a pixel, sorted by insertion during capture: a fragment follows its pixel's list
/// from the head to the first that is not nearer, and is linked in before it by a compare and exchange
/// of one link. Every fragment is read again by every one that is inserted behind it: the RBS paper
/// (section 2.1) rejects such captures for their "many duplicate global memory accesses which are
/// expensive for deep scenes". What they save is the sort: the list is read in order.
///
/// WGSL's atomics order nothing but what happens at one address, so each link says which attempt of a
/// node's owner it is of (see the shader), and keys and links are 64-bit atomics that begin as 0. That
/// makes nodes 16 bytes, cleared in every frame. A fragment that finds no place in so many turns is
/// counted in `lost` and takes no part: the pool is then said to be too small, whatever its size, so
/// that the frame is rendered again, and fails where it happens again.
///
/// Buffers: `links` (a `u64` a slot, then one a pixel: the low half is the next node plus one, or 0 at
/// the end), `fragments` (a `vec2<u32>` a slot; 0 is none), `node_count` and `lost` (one `u32` each),
/// and `counts` if asked for.
#[derive(Clone, Copy, Debug)]
pub struct LinkedListSorted {
    /// Turns that a fragment has: as many as nodes that it passes, and some more where it meets others
    /// at work. At most 65,535: attempts are told apart by 16 bits.
    pub turns: u32,
}

impl LinkedListSorted {
    /// Turns for four times the deepest pixel that any sort holds.
    pub const PATIENT: Self = Self { turns: 16_384 };

    /// Fragments that the last run found no turn for.
    fn lost(read: &mut LfbReader) -> Result<u64, CaptureError> {
        Ok(u64::from(read.words("lost", 1)?[0]))
    }
}

impl Capture for LinkedListSorted {
    fn name(&self) -> &'static str {
        "linked_list_sorted"
    }

    fn summary(&self) -> &'static str {
        "A linked list a pixel, kept sorted by insertion while it is captured, by 64-bit atomics."
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 2.1 (sorting fragments during capture); lock-free \
         insertion after Harris, A Pragmatic Implementation of Non-Blocking Linked-Lists, DISC 2001"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        include_str!("linked_list_sorted_layout.wgsl").into()
    }

    fn random_access(&self) -> bool {
        false
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        include_str!("linked_list_count.wgsl").into()
    }

    fn delivers_sorted(&self) -> bool {
        true
    }

    fn slots(&self, demand: &Demand) -> u64 {
        demand.histogram.total()
    }

    fn refuses(&self, demand: &Demand) -> Option<String> {
        let (peak, turns) = (demand.histogram.peak(), self.turns);
        (peak >= turns).then(|| {
            format!(
                "{peak} fragments on a pixel: a fragment passes fewer than {turns} to its place"
            )
        })
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let slots = pool_slots(request.pool_slots);
        let pixels = u64::from(request.width_px) * u64::from(request.height_px);
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            Buffer::new("links", 8 * (slots + pixels)),
            Buffer::new("node_count", 4),
            Buffer::new("lost", 4),
            Buffer::new("fragments", 8 * slots),
        ]);
        let cleared = ["links", "node_count", "lost", "fragments"];
        let mut passes = cleared.map(|buffer| Pass::clear("clear", buffer)).to_vec();
        let counted = if request.counts {
            buffers.push(pixel_buffer("counts", request));
            passes.push(Pass::clear("clear", "counts"));
            include_str!("linked_list_counted.wgsl")
        } else {
            UNCOUNTED
        };
        let turns = format!("const TURNS = {}u;\n\n", self.turns.min(u32::from(u16::MAX)));
        let fs = [counted, &turns, include_str!("linked_list_sorted.wgsl")];
        passes.push(capture_pass(request, self.name(), &fs));
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        let nodes = u64::from(read.words("node_count", 1)?[0]);
        let slots = match Self::lost(read)? {
            0 => nodes,
            // No pool is large enough for what was lost.
            lost => nodes.max(pool_slots(read.pool_slots)) + lost,
        };
        Ok(Usage { fragments: nodes, slots })
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let (pixels, room) = (read.pixels() as usize, pool_slots(read.pool_slots));
        let stored = u64::from(read.words("node_count", 1)?[0]).min(room);
        let lost = Self::lost(read)?;
        let links = read.words("links", 2 * (room + pixels as u64))?;
        let fragments = read.fragments(stored)?;

        let next = |link: usize| links[2 * link];
        let mut heads: Vec<u32> = (0..pixels).map(|pixel| next(room as usize + pixel)).collect();
        let mut nexts: Vec<u32> = (0..fragments.len()).map(next).collect();
        // Nodes of lost fragments are in no list; here they make up one more.
        let mut last = 0;
        let mut without_place = 0u64;
        for (node, next) in nexts.iter_mut().enumerate() {
            if fragments[node] == Fragment::default() {
                *next = std::mem::replace(&mut last, node as u32 + 1);
                without_place += 1;
            }
        }
        heads.push(last);
        let (mut offsets, mut listed) =
            follow("node", &heads, &nexts, |node, listed| listed.push(fragments[node]))?;
        if without_place != lost {
            let what = format!("{without_place} nodes are empty and {lost} fragments were lost");
            return Err(LfbError::Structure { pixel: 0, what }.into());
        }
        offsets.pop();
        listed.truncate(offsets.last().copied().unwrap_or(0));
        for (pixel, range) in offsets.windows(2).enumerate() {
            let own = &listed[range[0]..range[1]];
            if let Some(place) = own.windows(2).position(|pair| pair[1].key() < pair[0].key()) {
                let what = format!("its fragment {} is nearer than the one before", place + 1);
                return Err(LfbError::Structure { pixel, what }.into());
            }
        }
        Ok(Lfb::new(read.width_px, read.height_px, offsets, listed)?)
    }

    /// Sorted front to back.
    fn order(&self, submitted: &mut Lfb) {
        sort(submitted);
    }

    /// Nodes are handed out as when whole layers are drawn, the farthest first.
    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let mut sorted = submitted.clone();
        sort(&mut sorted);
        let total = sorted.fragments().len();
        let room = pool_slots(total as u64) as usize;
        let mut links = vec![0u32; 2 * (room + sorted.pixels())];
        let mut fragments = Vec::with_capacity(total);
        let mut pixels: Vec<usize> = (0..sorted.pixels()).collect();
        for layer in 1.. {
            pixels.retain(|&pixel| layer <= sorted.pixel(pixel).len());
            if pixels.is_empty() {
                break;
            }
            for &pixel in &pixels {
                let own = sorted.pixel(pixel);
                let node = fragments.len();
                fragments.push(own[own.len() - layer]);
                links[2 * node] =
                    std::mem::replace(&mut links[2 * (room + pixel)], node as u32 + 1);
            }
        }
        let counts: Vec<u32> = sorted.counts().collect();
        vec![
            words_buffer("links", &links),
            words_buffer("node_count", &[total as u32]),
            words_buffer("lost", &[0]),
            words_buffer("counts", &counts),
            fragments_buffer(&fragments),
        ]
    }
}
