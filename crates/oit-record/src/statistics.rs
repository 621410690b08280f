//! Statistics on samples: median, quartiles, and bootstrap intervals.
//!
//! `docs/METHODOLOGY.md` gives the rules; this file is what they mean.

/// What is said of a set of samples.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Summary {
    /// How many samples.
    pub samples: usize,
    /// The median.
    pub median: f64,
    /// The lower quartile.
    pub q1: f64,
    /// The upper quartile.
    pub q3: f64,
    /// The 95 % bootstrap interval of the median.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// How two sets of samples compare.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Comparison {
    /// The first takes less time: the whole interval of the ratio lies below 1.
    Faster,
    /// The first takes more time: the whole interval of the ratio lies above 1.
    Slower,
    /// The interval of the ratio holds 1.
    Same,
}

/// Resamples of a bootstrap: enough that the ends of a 95 % interval move by well under its width.
pub const RESAMPLES: usize = 1000;

/// The value below which `share` of the sorted values lie, linear between neighbours (Hyndman and
/// Fan's type 7). `None` for no values.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64))
}

/// The median of values in any order. `None` for no values.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile(&sorted, 0.5)
}

/// Summarises samples; the bootstrap is seeded, so the same samples give the same summary.
/// `None` for no samples.
#[must_use]
pub fn summarize(values: &[f64], seed: u64) -> Option<Summary> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut rng = SplitMix64(seed);
    let mut medians: Vec<f64> =
        (0..RESAMPLES).filter_map(|_| median(&resample(&sorted, &mut rng))).collect();
    medians.sort_by(f64::total_cmp);
    Some(Summary {
        samples: sorted.len(),
        median: quantile(&sorted, 0.5)?,
        q1: quantile(&sorted, 0.25)?,
        q3: quantile(&sorted, 0.75)?,
        low: quantile(&medians, 0.025)?,
        high: quantile(&medians, 0.975)?,
    })
}

/// The ratio of the medians of `a` to `b` with its 95 % bootstrap interval, and what follows.
/// `None` where either is empty or `b`'s median is zero.
#[must_use]
pub fn compare(a: &[f64], b: &[f64], seed: u64) -> Option<(f64, f64, f64, Comparison)> {
    let ratio = |a: &[f64], b: &[f64]| Some(median(a)? / median(b)?).filter(|r| r.is_finite());
    let middle = ratio(a, b)?;
    let mut rng = SplitMix64(seed);
    let mut ratios: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| ratio(&resample(a, &mut rng), &resample(b, &mut rng)))
        .collect();
    ratios.sort_by(f64::total_cmp);
    let (low, high) = (quantile(&ratios, 0.025)?, quantile(&ratios, 0.975)?);
    let verdict = if high < 1.0 {
        Comparison::Faster
    } else if low > 1.0 {
        Comparison::Slower
    } else {
        Comparison::Same
    };
    Some((middle, low, high, verdict))
}

fn resample(values: &[f64], rng: &mut SplitMix64) -> Vec<f64> {
    values.iter().map(|_| values[rng.below(values.len())]).collect()
}

/// Steele, Lea and Flood's splitmix64: small, seeded, the same everywhere.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `bound`, which is not 0; the bias is under `bound / 2^64`.
    pub fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.next_u64()) * bound as u128) >> 64) as usize
    }

    /// Puts a slice in a random order.
    pub fn shuffle<T>(&mut self, slice: &mut [T]) {
        for end in (1..slice.len()).rev() {
            slice.swap(end, self.below(end + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(quantile(&values, 0.5), Some(2.5));
        assert_eq!(quantile(&values, 0.25), Some(1.75));
        assert_eq!(quantile(&values, 1.0), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(median(&[9.0, 1.0, 5.0]), Some(5.0));
    }

    #[test]
    fn the_interval_holds_the_median_and_is_repeatable() {
        let values: Vec<f64> = (0..25).map(|i| 100.0 + f64::from(i * i % 17)).collect();
        let summary = summarize(&values, 7).unwrap();
        assert!(summary.low <= summary.median && summary.median <= summary.high);
        assert!(summary.q1 < summary.median && summary.median < summary.q3);
        assert_eq!(summarize(&values, 7), Some(summary));
        assert!(summarize(&[], 7).is_none());
    }

    #[test]
    fn faster_needs_the_whole_interval() {
        let slow: Vec<f64> = (0..20).map(|i| 200.0 + f64::from(i % 5)).collect();
        let fast: Vec<f64> = slow.iter().map(|v| v / 2.0).collect();
        let noisy: Vec<f64> = (0..20).map(|i| 104.0 + f64::from(i * 10)).collect();
        assert_eq!(compare(&fast, &slow, 1).unwrap().3, Comparison::Faster);
        assert_eq!(compare(&slow, &fast, 1).unwrap().3, Comparison::Slower);
        assert_eq!(compare(&slow, &noisy, 1).unwrap().3, Comparison::Same);
        assert!(compare(&slow, &[], 1).is_none());
    }

    #[test]
    fn a_shuffle_is_a_permutation() {
        let mut values: Vec<usize> = (0..100).collect();
        SplitMix64(3).shuffle(&mut values);
        assert_ne!(values, (0..100).collect::<Vec<_>>());
        values.sort_unstable();
        assert_eq!(values, (0..100).collect::<Vec<_>>());
    }
}
