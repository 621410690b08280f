//! The layered fragment buffer as data: every fragment of a frame, by pixel.

use rayon::prelude::*;

use crate::Fragment;

/// Every fragment of a frame, by pixel, row by row from the top left; within a pixel in the order
/// of the capture that made it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Lfb {
    width: u32,
    height: u32,
    /// `offsets[p]..offsets[p + 1]` are the fragments of pixel `p`.
    offsets: Vec<usize>,
    fragments: Vec<Fragment>,
}

/// Why bytes are no layered fragment buffer.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum LfbError {
    /// There must be one more offset than pixels.
    #[error("{width}x{height} pixels need {} offsets, there are {offsets}", *width as usize * *height as usize + 1)]
    OffsetCount {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Offsets given.
        offsets: usize,
    },
    /// Offsets may not fall.
    #[error("the offsets fall at pixel {pixel}")]
    OffsetsFall {
        /// The pixel whose end lies before its start.
        pixel: usize,
    },
    /// The last offset must be the number of fragments.
    #[error("the last offset is {last}, there are {fragments} fragments")]
    Total {
        /// The last offset.
        last: usize,
        /// Fragments given.
        fragments: usize,
    },
    /// A capture's own structure was damaged: a list that runs into itself or out of its pool.
    #[error("pixel {pixel}: {what}")]
    Structure {
        /// The pixel at fault.
        pixel: usize,
        /// What is wrong with it.
        what: String,
    },
}

/// How two buffers differ when each pixel's fragments are taken as a multiset.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct MultisetDifference {
    /// Pixels whose multisets differ.
    pub pixels: u64,
    /// Fragments of the first that the second lacks.
    pub missing: u64,
    /// Fragments of the second that the first lacks.
    pub extra: u64,
}

impl MultisetDifference {
    /// Whether there is no difference.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.pixels == 0
    }
}

impl Lfb {
    /// A buffer from its parts: one offset more than pixels, rising, the last the number of fragments.
    ///
    /// # Errors
    /// Where the parts do not fit together.
    pub fn new(
        width: u32,
        height: u32,
        offsets: Vec<usize>,
        fragments: Vec<Fragment>,
    ) -> Result<Self, LfbError> {
        if offsets.len() != width as usize * height as usize + 1 || offsets[0] != 0 {
            return Err(LfbError::OffsetCount { width, height, offsets: offsets.len() });
        }
        if let Some(pixel) = offsets.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(LfbError::OffsetsFall { pixel });
        }
        let last = offsets[offsets.len() - 1];
        if last != fragments.len() {
            return Err(LfbError::Total { last, fragments: fragments.len() });
        }
        Ok(Self { width, height, offsets, fragments })
    }

    /// A buffer from one list per pixel.
    ///
    /// # Panics
    /// Where there are not `width * height` lists.
    #[must_use]
    pub fn from_lists(width: u32, height: u32, lists: &[Vec<Fragment>]) -> Self {
        assert_eq!(lists.len(), width as usize * height as usize, "one list per pixel");
        let mut offsets = Vec::with_capacity(lists.len() + 1);
        offsets.push(0);
        let mut fragments = Vec::new();
        for list in lists {
            fragments.extend_from_slice(list);
            offsets.push(fragments.len());
        }
        Self { width, height, offsets, fragments }
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.offsets.len() - 1
    }

    /// All fragments, pixel after pixel.
    #[must_use]
    pub fn fragments(&self) -> &[Fragment] {
        &self.fragments
    }

    /// `offsets()[p]..offsets()[p + 1]` are the fragments of pixel `p`.
    #[must_use]
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// The fragments of one pixel.
    #[must_use]
    #[inline]
    pub fn pixel(&self, pixel: usize) -> &[Fragment] {
        &self.fragments[self.offsets[pixel]..self.offsets[pixel + 1]]
    }

    /// Puts each pixel's fragments, in place, into another order.
    pub fn reorder(&mut self, mut order: impl FnMut(&mut [Fragment])) {
        for pair in self.offsets.windows(2) {
            order(&mut self.fragments[pair[0]..pair[1]]);
        }
    }

    /// Fragments of each pixel, in order.
    pub fn counts(&self) -> impl Iterator<Item = u32> + '_ {
        self.offsets.windows(2).map(|pair| (pair[1] - pair[0]) as u32)
    }

    /// How many pixels have how many fragments.
    #[must_use]
    pub fn histogram(&self) -> DepthHistogram {
        DepthHistogram::from_counts(self.counts())
    }

    /// Compares pixel by pixel as multisets: the order within a pixel is of no account.
    ///
    /// # Panics
    /// Where the two differ in size.
    #[must_use]
    pub fn multiset_difference(&self, other: &Self) -> MultisetDifference {
        assert_eq!((self.width, self.height), (other.width, other.height), "buffers of one size");
        let pixels = (0..self.pixels()).into_par_iter().with_min_len(256);
        let differences =
            pixels.map_init(Default::default, |(a, b): &mut (Vec<_>, Vec<_>), pixel| {
                if self.pixel(pixel) == other.pixel(pixel) {
                    return MultisetDifference::default();
                }
                for (keys, lfb) in [(&mut *a, self), (&mut *b, other)] {
                    keys.clear();
                    keys.extend(lfb.pixel(pixel).iter().map(|f| f.key()));
                    keys.sort_unstable();
                }
                let shared = shared(a, b);
                let (missing, extra) = (a.len() as u64 - shared, b.len() as u64 - shared);
                MultisetDifference { pixels: u64::from(missing + extra > 0), missing, extra }
            });
        differences.reduce(MultisetDifference::default, |a, b| MultisetDifference {
            pixels: a.pixels + b.pixels,
            missing: a.missing + b.missing,
            extra: a.extra + b.extra,
        })
    }
}

/// How many of their keys two sorted lists share.
fn shared(a: &[u64], b: &[u64]) -> u64 {
    let (mut i, mut j, mut shared) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        match a[i].cmp(&b[j]) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => j += 1,
            std::cmp::Ordering::Equal => {
                i += 1;
                j += 1;
                shared += 1;
            }
        }
    }
    shared
}

/// How many pixels have how many fragments: what intervals, pools and array sizes are chosen from.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct DepthHistogram {
    /// `pixels[n]` is the number of pixels with `n` fragments; empty where there is no pixel.
    pub pixels: Vec<u64>,
}

impl DepthHistogram {
    /// Counts the counts.
    pub fn from_counts(counts: impl IntoIterator<Item = u32>) -> Self {
        let mut pixels = Vec::new();
        for count in counts {
            let count = count as usize;
            if count >= pixels.len() {
                pixels.resize(count + 1, 0);
            }
            pixels[count] += 1;
        }
        Self { pixels }
    }

    /// Fragments in all.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.pixels.iter().enumerate().map(|(n, pixels)| n as u64 * pixels).sum()
    }

    /// The most fragments on one pixel: the peak depth complexity.
    #[must_use]
    pub fn peak(&self) -> u32 {
        self.pixels.iter().rposition(|&pixels| pixels > 0).unwrap_or(0) as u32
    }

    /// Pixels with at least one fragment.
    #[must_use]
    pub fn covered(&self) -> u64 {
        self.pixels.iter().skip(1).sum()
    }

    /// The largest cap under which all pixels fit a pool of so many slots, a slot for each fragment
    /// up to the cap; `u32::MAX` where they fit without one.
    #[must_use]
    pub fn cap_for(&self, slots: u64) -> u32 {
        let mut deeper: u64 = self.pixels.iter().sum();
        let mut kept = 0u64;
        for (cap, pixels) in (0..).zip(&self.pixels) {
            deeper -= pixels;
            // One more for each pixel with more than `cap`.
            kept = kept.saturating_add(deeper);
            if kept > slots {
                return cap;
            }
        }
        u32::MAX
    }

    /// Pixels whose count lies in `low..=high`.
    #[must_use]
    pub fn pixels_in(&self, low: u32, high: u32) -> u64 {
        let end = (high as usize + 1).min(self.pixels.len());
        self.pixels.get(low as usize..end).map_or(0, |range| range.iter().sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fragment(depth: f32, red: u8) -> Fragment {
        Fragment::new(depth, [red, 0, 0, 255])
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let f = fragment(0.5, 1);
        assert!(matches!(
            Lfb::new(2, 1, vec![0, 1], vec![f]),
            Err(LfbError::OffsetCount { offsets: 2, .. })
        ));
        assert_eq!(Lfb::new(2, 1, vec![0, 2, 1], vec![f]), Err(LfbError::OffsetsFall { pixel: 1 }));
        assert_eq!(
            Lfb::new(2, 1, vec![0, 1, 2], vec![f]),
            Err(LfbError::Total { last: 2, fragments: 1 })
        );
    }

    #[test]
    fn difference_counts_multiplicity_not_order() {
        let (a, b) = (fragment(0.1, 1), fragment(0.2, 2));
        let one = Lfb::from_lists(2, 1, &[vec![a, a, b], vec![a]]);
        let same = Lfb::from_lists(2, 1, &[vec![b, a, a], vec![a]]);
        let other = Lfb::from_lists(2, 1, &[vec![b, b, a], vec![a]]);
        assert!(one.multiset_difference(&same).is_none());
        assert_eq!(
            one.multiset_difference(&other),
            MultisetDifference { pixels: 1, missing: 1, extra: 1 }
        );
    }

    #[test]
    fn histogram_knows_total_peak_and_cover() {
        let histogram = DepthHistogram::from_counts([0, 3, 3, 1, 0]);
        assert_eq!((histogram.total(), histogram.peak(), histogram.covered()), (7, 3, 3));
        assert_eq!((histogram.pixels_in(1, 8), histogram.pixels_in(4, 9)), (3, 0));
        assert_eq!(DepthHistogram::default().peak(), 0);
    }

    #[test]
    fn the_cap_is_the_largest_that_fits() {
        let counts = [0, 3, 3, 1, 0, 9, 2];
        let histogram = DepthHistogram::from_counts(counts);
        let kept = |cap: u32| counts.iter().map(|&count| u64::from(count.min(cap))).sum::<u64>();
        for slots in 0..histogram.total() {
            let cap = histogram.cap_for(slots);
            assert!(kept(cap) <= slots && kept(cap + 1) > slots, "{cap} for {slots}");
        }
        for slots in [histogram.total(), 100, u64::MAX] {
            assert_eq!(histogram.cap_for(slots), u32::MAX);
        }
        assert_eq!(DepthHistogram::default().cap_for(0), u32::MAX);
    }
}
