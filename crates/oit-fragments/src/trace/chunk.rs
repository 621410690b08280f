//! One chunk's payload: the fragments of consecutive pixels, predicted, split into planes, deflated.

use std::ops::Range;

use crate::deflate::{Wrapper, deflate, inflate};
use crate::{Fragment, Lfb};

/// Pixels of a chunk at most.
pub(super) const MAX_PIXELS: usize = 1 << 16;

/// Fragments of a chunk at most, unless it is one pixel.
pub(super) const MAX_FRAGMENTS: usize = 1 << 18;

/// Fragments by which the form of a chunk is chosen.
const SAMPLE: usize = 1 << 13;

/// Deflate's level. The 117.8 M fragments of a hairball take 3.67, 2.74 and 2.71 bytes each at levels
/// 1, 3 and 6, and level 6 takes more than twice as long as level 3.
const LEVEL: u32 = 3;

/// How a chunk's fragments are predicted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Form {
    /// From the pixels before, else from nothing.
    carried: bool,
    /// Whether red and blue are taken relative to green.
    relative: bool,
}

impl Form {
    const ALL: [Self; 4] = [
        Self { carried: false, relative: false },
        Self { carried: false, relative: true },
        Self { carried: true, relative: false },
        Self { carried: true, relative: true },
    ];

    /// As it stands in the file.
    pub(super) fn bits(self) -> u32 {
        u32::from(self.carried) | u32::from(self.relative) << 1
    }

    /// From the file, if there is such a form.
    pub(super) fn from_bits(bits: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.bits() == bits)
    }
}

/// Bytes of the planes.
pub(super) fn planes_len(pixels: u64, fragments: u64) -> u64 {
    4 * pixels + 8 * fragments
}

/// The most bytes that the planes of this length deflate to; deflate adds less than this where it
/// cannot compress.
pub(super) fn max_packed_len(planes_len: u64) -> u64 {
    planes_len + planes_len / 8 + 256
}

/// A chunk ready to be written.
pub(super) struct Packed {
    pub(super) form: Form,
    pub(super) payload: Vec<u8>,
}

/// Splits the pixels of a buffer into chunks.
pub(super) fn ranges(lfb: &Lfb) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut start = 0;
    let offsets = lfb.offsets();
    for pixel in 0..lfb.pixels() {
        let full = pixel - start == MAX_PIXELS
            || (pixel > start && offsets[pixel + 1] - offsets[start] > MAX_FRAGMENTS);
        if full {
            ranges.push(start..pixel);
            start = pixel;
        }
    }
    if start < lfb.pixels() {
        ranges.push(start..lfb.pixels());
    }
    ranges
}

/// Packs the pixels of one range, in the form that suits the beginning of them best.
pub(super) fn pack(lfb: &Lfb, range: Range<usize>) -> Packed {
    let offsets = lfb.offsets();
    let sampled = offsets[range.start..range.end]
        .partition_point(|&offset| offset < offsets[range.start] + SAMPLE);
    let sample = range.start..range.start + sampled;
    let form = Form::ALL
        .into_iter()
        .min_by_key(|&form| deflate(&planes(lfb, sample.clone(), form), 1, Wrapper::None).len())
        .expect("there are forms");
    Packed { form, payload: deflate(&planes(lfb, range, form), LEVEL, Wrapper::None) }
}

/// The counts and fragments of a chunk.
///
/// # Errors
/// What is wrong with the payload.
pub(super) fn unpack(
    form: Form,
    payload: &[u8],
    pixels: usize,
    fragments: usize,
) -> Result<(Vec<u32>, Vec<Fragment>), String> {
    let len = planes_len(pixels as u64, fragments as u64) as usize;
    let bytes = inflate(payload, len, Wrapper::None)?;
    let (counts_bytes, bytes) = bytes.split_at(4 * pixels);

    let mut counts = Vec::with_capacity(pixels);
    let mut last = 0u32;
    let mut sum = 0u64;
    for pixel in 0..pixels {
        last = last.wrapping_add(unfold(gather(counts_bytes, pixels, pixel)));
        sum += u64::from(last);
        counts.push(last);
    }
    if sum != fragments as u64 {
        return Err(format!("its pixels have {sum} fragments, its record says {fragments}"));
    }

    let mut done: Vec<Fragment> = Vec::with_capacity(fragments);
    let (depths, colours) = bytes.split_at(4 * fragments);
    let mut before = Before::default();
    for &count in &counts {
        let start = done.len();
        for rank in 0..count as usize {
            let i = start + rank;
            let predicted = before.predict(form, &done, start, rank);
            let difference = unfold(gather(depths, fragments, i));
            let mut rgba = form.relative(predicted.rgba8());
            for (channel, value) in rgba.iter_mut().enumerate() {
                *value = value.wrapping_add(unfold8(colours[channel * fragments + i]));
            }
            done.push(Fragment {
                rgba: u32::from_le_bytes(form.absolute(rgba)),
                depth_key: predicted.depth_key.wrapping_add(difference),
            });
        }
        before.next(count as usize);
    }
    Ok((counts, done))
}

/// The planes of the pixels of a range, before they are deflated.
fn planes(lfb: &Lfb, range: Range<usize>, form: Form) -> Vec<u8> {
    let pixels = range.len();
    let offsets = &lfb.offsets()[range.start..=range.end];
    let own = &lfb.fragments()[offsets[0]..offsets[pixels]];
    let fragments = own.len();
    let mut bytes = vec![0; planes_len(pixels as u64, fragments as u64) as usize];
    let (counts, rest) = bytes.split_at_mut(4 * pixels);
    let (depths, colours) = rest.split_at_mut(4 * fragments);
    let mut last = 0u32;
    let mut before = Before::default();
    for (pixel, ends) in offsets.windows(2).enumerate() {
        let count = (ends[1] - ends[0]) as u32;
        scatter(counts, pixels, pixel, fold(count.wrapping_sub(last)));
        last = count;
        let start = ends[0] - offsets[0];
        for rank in 0..count as usize {
            let i = start + rank;
            let predicted = before.predict(form, own, start, rank);
            let difference = own[i].depth_key.wrapping_sub(predicted.depth_key);
            scatter(depths, fragments, i, fold(difference));
            let from = form.relative(predicted.rgba8());
            for (channel, value) in form.relative(own[i].rgba8()).into_iter().enumerate() {
                colours[channel * fragments + i] = fold8(value.wrapping_sub(from[channel]));
            }
        }
        before.next(count as usize);
    }
    bytes
}

/// The counts of the two pixels before the one at hand.
#[derive(Default)]
struct Before {
    one: usize,
    two: usize,
}

impl Before {
    /// What the fragment at this rank of the pixel that starts at `start` is predicted to be, from
    /// the fragments before it.
    #[inline]
    fn predict(&self, form: Form, fragments: &[Fragment], start: usize, rank: usize) -> Fragment {
        if !form.carried {
            Fragment::default()
        } else if rank < self.one {
            let left = fragments[start - self.one + rank];
            if rank >= self.two {
                return left;
            }
            let further = fragments[start - self.one - self.two + rank];
            let step = left.depth_key.wrapping_sub(further.depth_key);
            Fragment { rgba: left.rgba, depth_key: left.depth_key.wrapping_add(step) }
        } else if start + rank > 0 {
            fragments[start + rank - 1]
        } else {
            Fragment::default()
        }
    }

    fn next(&mut self, count: usize) {
        (self.one, self.two) = (count, self.one);
    }
}

impl Form {
    fn relative(self, [r, g, b, a]: [u8; 4]) -> [u8; 4] {
        if self.relative { [r.wrapping_sub(g), g, b.wrapping_sub(g), a] } else { [r, g, b, a] }
    }

    fn absolute(self, [r, g, b, a]: [u8; 4]) -> [u8; 4] {
        if self.relative { [r.wrapping_add(g), g, b.wrapping_add(g), a] } else { [r, g, b, a] }
    }
}

/// A difference as an unsigned number that is small where the difference is, of either sign.
fn fold(difference: u32) -> u32 {
    (difference << 1) ^ ((difference as i32) >> 31) as u32
}

fn unfold(folded: u32) -> u32 {
    (folded >> 1) ^ (folded & 1).wrapping_neg()
}

fn fold8(difference: u8) -> u8 {
    (difference << 1) ^ ((difference as i8) >> 7) as u8
}

fn unfold8(folded: u8) -> u8 {
    (folded >> 1) ^ (folded & 1).wrapping_neg()
}

/// Puts a value's bytes into four planes, the highest first.
#[inline]
fn scatter(planes: &mut [u8], len: usize, i: usize, value: u32) {
    for (plane, byte) in value.to_be_bytes().into_iter().enumerate() {
        planes[plane * len + i] = byte;
    }
}

#[inline]
fn gather(planes: &[u8], len: usize, i: usize) -> u32 {
    u32::from_be_bytes([0, 1, 2, 3].map(|plane| planes[plane * len + i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_is_undone_and_keeps_small_differences_small() {
        for difference in [0, 1, 2, 0x7fff_ffff, 0x8000_0000, u32::MAX] {
            assert_eq!(unfold(fold(difference)), difference);
        }
        assert_eq!([0u32, 0u32.wrapping_sub(1), 1, 0u32.wrapping_sub(2)].map(fold), [0, 1, 2, 3]);
        for difference in 0..=u8::MAX {
            assert_eq!(unfold8(fold8(difference)), difference);
        }
    }

    #[test]
    fn every_form_is_undone() {
        let fragment = |i: u32| Fragment {
            rgba: i.wrapping_mul(2_654_435_761),
            depth_key: i.wrapping_mul(0x9E37_79B9).rotate_left(7),
        };
        let lists: Vec<Vec<Fragment>> =
            (0..30).map(|p| (0..(p * 7) % 5).map(|i| fragment(10 * p + i)).collect()).collect();
        let lfb = Lfb::from_lists(6, 5, &lists);
        for form in Form::ALL {
            assert_eq!(Form::from_bits(form.bits()), Some(form));
            let payload = deflate(&planes(&lfb, 0..30, form), 6, Wrapper::None);
            let total = lfb.fragments().len();
            let (counts, fragments) = unpack(form, &payload, 30, total).unwrap();
            assert_eq!(counts, lfb.counts().collect::<Vec<_>>());
            assert_eq!(fragments, lfb.fragments());
            // As many bytes, but shared out otherwise.
            assert!(unpack(form, &payload, 28, total + 1).unwrap_err().contains("record says"));
        }
        assert_eq!(Form::from_bits(4), None);
    }

    #[test]
    fn chunks_keep_to_their_limits_and_a_deeper_pixel_stands_alone() {
        let f = Fragment::default();
        let deep = MAX_FRAGMENTS + 1;
        let lfb = Lfb::from_lists(4, 1, &[vec![f], vec![f; deep], vec![f; 2], vec![]]);
        assert_eq!(ranges(&lfb), [0..1, 1..2, 2..4]);
        let wide = Lfb::from_lists(70_000, 1, &vec![vec![]; 70_000]);
        assert_eq!(ranges(&wide), [0..MAX_PIXELS, MAX_PIXELS..70_000]);
        assert_eq!(ranges(&Lfb::from_lists(0, 3, &[])), []);
    }

    #[test]
    fn what_cannot_be_compressed_stays_within_its_bound() {
        let mut state = 1u64;
        let mut bytes = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 56) as u8
        };
        for len in [0usize, 1, 100, 1_000_000] {
            let random: Vec<u8> = (0..len).map(|_| bytes()).collect();
            let packed = deflate(&random, LEVEL, Wrapper::None);
            assert!(packed.len() as u64 <= max_packed_len(len as u64), "{len}: {}", packed.len());
        }
    }
}
