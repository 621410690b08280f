//! `linked_list128`, `linked_list128_indirect`: a list a pixel of fragments of 128 bits.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use oit_fragments::{Element, Fragment, Lfb, LfbError};
use oit_gpu::{Buffer, Contents, Pass};

use super::linked_list::{LinkedList, UNCOUNTED, follow};
use crate::draw::{capture_pass, coverage, pixel_buffer, pool_slots};
use crate::{
    Capture, CaptureError, CapturePasses, CaptureRequest, Demand, LfbReader, Usage, words_buffer,
};

/// The linked list of [`LinkedList`] with fragments of 128 bits: a depth key, and a colour and an
/// opacity for each of red, green and blue in halves, as coloured glass needs them. The RBS paper
/// packs fragments into 64 bits, and says of larger ones that "indirect sorting using an index/pointer
/// and depth is likely to be more efficient" (section 3): both captures leave the same, and differ in
/// what their readers give a sort to move, the whole fragment or its depth and its node.
///
/// So that pictures stay those of the oracle, the halves hold what a fragment of 64 bits holds: colour
/// in whole 255ths, and its alpha as the opacity of all three channels. No kernel knows that: each
/// reads all three words and composites channel by channel.
///
/// Buffers: those of [`LinkedList`], with `fragments` of 16 bytes a node.
#[derive(Clone, Copy, Debug)]
pub struct LinkedListWide {
    element: Element,
}

/// A fragment as the pool holds it: halves of red and green, blue and the opacity for red, and the
/// opacity for green and blue, each pair with the first in the low half; and the depth key.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Debug, Pod, Zeroable)]
struct WideFragment {
    halves: [u16; 6],
    depth_key: u32,
}

/// The half of a whole number up to 255.
fn half(number: u8) -> u16 {
    let number = u16::from(number);
    match number.checked_ilog2() {
        None => 0,
        Some(exponent) => {
            let exponent = exponent as u16;
            ((15 + exponent) << 10) | ((number << (10 - exponent)) & 0x3ff)
        }
    }
}

/// The whole number up to 255 that a half is, if it is one.
fn whole(half_bits: u16) -> Option<u8> {
    let exponent = (half_bits >> 10).checked_sub(15).filter(|&exponent| exponent < 8);
    let number = exponent.map_or(0, |e| (0x400 | (half_bits & 0x3ff)) >> (10 - e));
    u8::try_from(number).ok().filter(|&number| half(number) == half_bits)
}

impl From<Fragment> for WideFragment {
    fn from(fragment: Fragment) -> Self {
        let [r, g, b, a] = fragment.rgba8().map(half);
        Self { halves: [r, g, b, a, a, a], depth_key: fragment.depth_key }
    }
}

impl WideFragment {
    /// The same in 64 bits, if they hold it.
    fn narrow(self) -> Option<Fragment> {
        let [r, g, b, a, a_green, a_blue] = self.halves;
        let [r, g, b, alpha] = [whole(r)?, whole(g)?, whole(b)?, whole(a)?];
        let rgba = u32::from_le_bytes([r, g, b, alpha]);
        (a == a_green && a == a_blue).then_some(Fragment { rgba, depth_key: self.depth_key })
    }
}

impl LinkedListWide {
    /// Whole fragments are sorted.
    pub const DIRECT: Self = Self { element: Element::Wide };
    /// Depth and node are sorted, and colours fetched when they are blended.
    pub const INDIRECT: Self = Self { element: Element::Index };
}

impl Capture for LinkedListWide {
    fn name(&self) -> &'static str {
        if self.element == Element::Index { "linked_list128_indirect" } else { "linked_list128" }
    }

    fn summary(&self) -> &'static str {
        if self.element == Element::Index {
            "The same fragments of 128 bits, sorted by depth and index; ties-depth only."
        } else {
            "A linked list a pixel of fragments of 128 bits: colour and opacity by channel in halves."
        }
    }

    fn citation(&self) -> &'static str {
        "Knowles, Leach, Zambetta 2014, section 3 (fragments larger than 64 bits, indirect sorting)"
    }

    fn layout_wgsl(&self) -> Cow<'static, str> {
        if self.element == Element::Index {
            include_str!("linked_list_index_layout.wgsl").into()
        } else {
            include_str!("linked_list_wide_layout.wgsl").into()
        }
    }

    fn element(&self) -> Element {
        self.element
    }

    fn random_access(&self) -> bool {
        false
    }

    fn count_wgsl(&self) -> Cow<'static, str> {
        LinkedList::EACH.count_wgsl()
    }

    fn slots(&self, demand: &Demand) -> u64 {
        demand.histogram.total()
    }

    fn build(&self, request: &CaptureRequest) -> CapturePasses {
        let slots = pool_slots(request.pool_slots);
        let mut buffers = request.geometry.buffers();
        buffers.extend([
            pixel_buffer("heads", request),
            Buffer::new("node_count", 4),
            Buffer::new("nexts", 4 * slots),
            Buffer::new("fragments", 16 * slots),
        ]);
        let mut passes = vec![Pass::clear("clear", "heads"), Pass::clear("clear", "node_count")];
        let counted = if request.counts {
            buffers.push(pixel_buffer("counts", request));
            passes.push(Pass::clear("clear", "counts"));
            include_str!("linked_list_counted.wgsl")
        } else {
            UNCOUNTED
        };
        let fs = [counted, include_str!("linked_list_wide.wgsl")];
        passes.push(capture_pass(request, "linked_list128", &fs));
        CapturePasses { buffers, targets: vec![coverage(request)], passes, lists_at: None }
    }

    fn usage(&self, read: &mut LfbReader) -> Result<Usage, CaptureError> {
        LinkedList::EACH.usage(read)
    }

    fn unpack(&self, read: &mut LfbReader) -> Result<Lfb, CaptureError> {
        let stored = self.usage(read)?.slots.min(pool_slots(read.pool_slots));
        let heads = read.words("heads", read.pixels())?;
        let nexts = read.words("nexts", stored)?;
        let wide: Vec<WideFragment> = read.elements("fragments", stored)?;

        let narrow = |(node, wide): (usize, &WideFragment)| {
            let what =
                || format!("node {node} holds no colour of 255ths and one opacity: {wide:?}");
            wide.narrow().ok_or_else(|| LfbError::Structure { pixel: 0, what: what() })
        };
        let fragments: Vec<_> = wide.iter().enumerate().map(narrow).collect::<Result<_, _>>()?;
        let (offsets, listed) =
            follow("node", &heads, &nexts, |node, listed| listed.push(fragments[node]))?;
        Ok(Lfb::new(read.width_px, read.height_px, offsets, listed)?)
    }

    /// A list is read from its head: the last submitted comes first.
    fn order(&self, submitted: &mut Lfb) {
        LinkedList::EACH.order(submitted);
    }

    fn upload(&self, submitted: &Lfb) -> Vec<Buffer> {
        let mut buffers = LinkedList::EACH.upload(submitted);
        for buffer in &mut buffers {
            if let Contents::Data(bytes) = &buffer.contents
                && buffer.name == "fragments"
            {
                let narrow: Vec<Fragment> = bytemuck::pod_collect_to_vec(bytes);
                let wide: Vec<WideFragment> = narrow.into_iter().map(Into::into).collect();
                *buffer = words_buffer("fragments", bytemuck::cast_slice(&wide));
            }
        }
        buffers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_whole_numbers_and_nothing_else() {
        assert_eq!([half(0), half(1), half(2), half(255)], [0, 0x3c00, 0x4000, 0x5bf8]);
        let numbers: Vec<u8> = (0..=u16::MAX).filter_map(whole).collect();
        assert_eq!(numbers, (0..=255).collect::<Vec<u8>>());
        assert!((0..=255).all(|number| whole(half(number)) == Some(number)));
    }

    #[test]
    fn what_64_bits_do_not_hold_is_refused() {
        let fragment = Fragment::new(0.5, [1, 2, 3, 200]);
        let wide = WideFragment::from(fragment);
        assert_eq!(wide.narrow(), Some(fragment));
        for place in 0..6 {
            let mut other = wide;
            other.halves[place] ^= 1;
            assert_eq!(other.narrow(), None, "{place}");
        }
        // Another opacity for one channel.
        let mut coloured = wide;
        coloured.halves[5] = half(7);
        assert_eq!(coloured.narrow(), None);
    }
}
