//! Intervals of depth complexity: which pixels are resolved by which program.

use std::fmt;

/// The most intervals of a technique: each has a program, and a list with room for all pixels.
pub const MOST_INTERVALS: usize = 64;

/// Intervals of fragments per pixel, shallow to deep; together they hold every count from 1 up.
///
/// The last one also takes pixels deeper than its upper bound: its program keeps the first
/// `upper` fragments and leaves the rest (BMA paper, section 3).
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Intervals {
    uppers: Vec<u32>,
}

/// One interval: pixels with `low..=high` fragments.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Interval {
    /// The fewest fragments.
    pub low: u32,
    /// The most fragments, the array size of its program.
    pub high: u32,
}

/// Why a list of bounds is no list of intervals.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BadIntervals(String);

impl fmt::Display for BadIntervals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadIntervals {}

impl Intervals {
    /// The paper's choice: 1-8, 9-16, 17-32 and so on in powers of two, up to one that holds
    /// `peak`. A peak of 0 gives the first interval alone.
    #[must_use]
    pub fn powers_of_two(peak: u32) -> Self {
        let mut uppers = vec![8];
        while uppers[uppers.len() - 1] < peak {
            uppers.push(uppers[uppers.len() - 1].saturating_mul(2));
        }
        Self { uppers }
    }

    /// Intervals with these upper bounds.
    ///
    /// # Errors
    /// Where there is none, one is 0, or they do not rise.
    pub fn from_uppers(uppers: Vec<u32>) -> Result<Self, BadIntervals> {
        match uppers.windows(2).find(|pair| pair[0] >= pair[1]) {
            _ if uppers.is_empty() => Err(BadIntervals("no interval".into())),
            _ if uppers[0] == 0 => Err(BadIntervals("an interval that ends at 0".into())),
            Some(pair) => Err(BadIntervals(format!("{} does not rise to {}", pair[0], pair[1]))),
            None => Ok(Self { uppers }),
        }
    }

    /// Intervals with these upper bounds, made to end where they should: bounds above `max_frags` are
    /// cut to it, those behind the first that reaches `needed` are left out, and where none does,
    /// `max_frags` (which is no less than `needed`) is the last.
    ///
    /// # Errors
    /// As [`Intervals::from_uppers`], of the bounds given; where `max_frags` is 0.
    pub fn within(uppers: &[u32], needed: u32, max_frags: u32) -> Result<Self, BadIntervals> {
        let mut uppers = Self::from_uppers(uppers.to_vec())?.uppers;
        if let Some(last) = uppers.iter().position(|&upper| upper >= needed.min(max_frags)) {
            uppers.truncate(last + 1);
            uppers[last] = uppers[last].min(max_frags);
        } else {
            uppers.push(max_frags);
        }
        Self::from_uppers(uppers)
    }

    /// Each interval, shallow to deep.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Interval> + '_ {
        self.uppers.iter().enumerate().map(|(i, &high)| {
            let low = if i == 0 { 1 } else { self.uppers[i - 1] + 1 };
            Interval { low, high }
        })
    }

    /// How many there are.
    #[expect(clippy::len_without_is_empty, reason = "there is always one")]
    #[must_use]
    pub fn len(&self) -> usize {
        self.uppers.len()
    }

    /// The deepest array any of their programs has.
    #[must_use]
    pub fn deepest(&self) -> u32 {
        self.uppers[self.uppers.len() - 1]
    }

    /// The place of the interval that takes pixels with this many fragments; `None` for 0.
    #[must_use]
    pub fn index(&self, fragments: u32) -> Option<usize> {
        let place = self.uppers.partition_point(|&high| high < fragments);
        (fragments > 0).then(|| place.min(self.uppers.len() - 1))
    }

    /// The CPU twin of the grouping passes: the pixels of each interval, in order.
    #[must_use]
    pub fn group(&self, counts: impl IntoIterator<Item = u32>) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.uppers.len()];
        for (pixel, count) in counts.into_iter().enumerate() {
            if let Some(place) = self.index(count) {
                lists[place].push(pixel as u32);
            }
        }
        lists
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_hold_the_peak() {
        let bounds = |peak| Intervals::powers_of_two(peak).uppers;
        assert_eq!(bounds(0), [8]);
        assert_eq!(bounds(8), [8]);
        assert_eq!(bounds(9), [8, 16]);
        assert_eq!(bounds(128), [8, 16, 32, 64, 128]);
        assert_eq!(bounds(129), [8, 16, 32, 64, 128, 256]);
    }

    #[test]
    fn every_count_has_one_interval() {
        let intervals = Intervals::from_uppers(vec![3, 8, 20]).unwrap();
        let ranges: Vec<_> = intervals.iter().map(|i| (i.low, i.high)).collect();
        assert_eq!(ranges, [(1, 3), (4, 8), (9, 20)]);
        assert_eq!(intervals.index(0), None);
        for count in 1..40 {
            let holds = |i: Interval| (i.low..=i.high).contains(&count);
            let place = intervals.iter().position(holds).unwrap_or(2);
            assert_eq!(intervals.index(count), Some(place), "{count}");
        }
    }

    #[test]
    fn given_bounds_end_where_they_should() {
        let within = |uppers: &[u32], needed, max_frags| {
            Intervals::within(uppers, needed, max_frags).map(|intervals| intervals.uppers)
        };
        let given = [4, 12, 40];
        assert_eq!(within(&given, 46, 64), Ok(vec![4, 12, 40, 64]));
        assert_eq!(within(&given, 40, 64), Ok(vec![4, 12, 40]));
        assert_eq!(within(&given, 30, 32), Ok(vec![4, 12, 32]));
        assert_eq!(within(&given, 12, 16), Ok(vec![4, 12]));
        assert_eq!(within(&given, 0, 8), Ok(vec![4]));
        assert_eq!(within(&[4096], 16, 16), Ok(vec![16]));
        assert!(within(&[8, 4], 4, 8).is_err() && within(&given, 0, 0).is_err());
    }

    #[test]
    fn bounds_must_rise() {
        for bad in [vec![], vec![0, 4], vec![8, 8], vec![8, 4]] {
            assert!(Intervals::from_uppers(bad).is_err());
        }
    }

    #[test]
    fn grouping_puts_each_covered_pixel_in_one_list() {
        let lists = Intervals::powers_of_two(20).group([0, 8, 9, 1, 40, 16]);
        assert_eq!(lists, [vec![1, 3], vec![2, 5], vec![4]]);
    }
}
