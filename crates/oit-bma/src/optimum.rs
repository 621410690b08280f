//! The best intervals for a view (BMA paper, section 3: "exhaustively optimizing these intervals for
//! specific views").

use oit_fragments::DepthHistogram;

use crate::{CostModel, Intervals, MOST_INTERVALS};

/// Why a view has no best intervals.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum NoOptimum {
    /// No measured array holds the deepest pixel.
    #[error("{peak} fragments on a pixel, and costs are known for arrays of up to {largest}")]
    TooDeep {
        /// The peak depth complexity.
        peak: u32,
        /// The largest array measured.
        largest: u32,
    },
    /// Some pixel has no cost in any array that holds it.
    #[error("no cost is known for some pixels of up to {peak} fragments")]
    Unknown {
        /// The peak depth complexity.
        peak: u32,
    },
}

/// The intervals that cost least on a view, exactly: of all sets of up to [`MOST_INTERVALS`] upper
/// bounds that end at the peak. Where the array for the peak has no known cost, the last bound is the
/// next larger one that has. Of sets that cost the same it is one with the fewest bounds.
///
/// Dynamic programming over depths: for the depths up to `x` in `k` intervals the best is that of some
/// `y` below `x` in `k - 1`, and one for `y + 1` to `x`. Takes time in peak² × `MOST_INTERVALS` and
/// memory in peak × `MOST_INTERVALS`.
///
/// # Errors
/// Where costs are not known for arrays as large as the peak, or for some pixel.
pub fn optimal_intervals(
    histogram: &DepthHistogram,
    model: &CostModel,
) -> Result<Intervals, NoOptimum> {
    best(histogram, model, MOST_INTERVALS)
}

/// The cheapest way to take the depths up to one in some number of intervals.
#[derive(Clone, Copy)]
struct Best {
    ns: f64,
    /// The depth up to which the intervals before the last take.
    before: usize,
}

fn best(
    histogram: &DepthHistogram,
    model: &CostModel,
    most: usize,
) -> Result<Intervals, NoOptimum> {
    let peak = histogram.peak();
    let largest = model.largest();
    let last = model.smallest(peak, largest).ok_or(NoOptimum::TooDeep { peak, largest })?;
    let depths = peak as usize;
    let unknown = Best { ns: f64::INFINITY, before: 0 };
    // ways[k][x]: depths 1 to x in k intervals.
    let mut ways = vec![vec![unknown; depths + 1]; most + 1];
    ways[0][0].ns = 0.0;
    for end in 1..=depths {
        let size = if end == depths { last } else { end as u32 };
        let mut ns = model.interval_ns();
        for before in (0..end).rev() {
            let pixels = histogram.pixels[before + 1];
            if pixels > 0 {
                match model.pixel_ns(size, before as u32 + 1) {
                    Some(pixel_ns) => ns += pixels as f64 * pixel_ns,
                    None => break,
                }
            }
            for intervals in 1..=most {
                let with = ways[intervals - 1][before].ns + ns;
                let way = &mut ways[intervals][end];
                if with < way.ns {
                    *way = Best { ns: with, before };
                }
            }
        }
    }
    if depths == 0 {
        return Ok(Intervals::from_uppers(vec![last]).expect("one bound of at least 1"));
    }
    let cost = |&intervals: &usize| ways[intervals][depths].ns;
    let fewest = (1..=most).min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let Some(fewest) = fewest.filter(|intervals| cost(intervals).is_finite()) else {
        return Err(NoOptimum::Unknown { peak });
    };
    let mut uppers = vec![last];
    let mut end = depths;
    for intervals in (2..=fewest).rev() {
        end = ways[intervals][end].before;
        uppers.push(end as u32);
    }
    uppers.reverse();
    Ok(Intervals::from_uppers(uppers).expect("each begins after the one before"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ArrayCost, CostPoint};
    use proptest::prelude::*;

    /// A cost for every size and depth up to `size`, by a function.
    fn model(interval_ns: f64, size: u32, ns: impl Fn(u32, u32) -> f64) -> CostModel {
        let sizes = 1..=size;
        let points: Vec<CostPoint> = sizes
            .flat_map(|max_frags| (1..=max_frags).map(move |depth| (max_frags, depth)))
            .map(|(max_frags, depth)| CostPoint { max_frags, depth, ns: ns(max_frags, depth) })
            .collect();
        let cost = ArrayCost::from_points(&points).expect("measurements");
        CostModel::new(interval_ns, vec![(None, cost)]).expect("a cost")
    }

    fn uppers(intervals: &Intervals) -> Vec<u32> {
        intervals.iter().map(|interval| interval.high).collect()
    }

    #[test]
    fn intervals_cost_what_they_save() {
        let histogram = DepthHistogram::from_counts([1, 1, 1, 2, 9]);
        // Nothing for an interval: each depth its own array.
        let free = model(0.0, 9, |size, _| f64::from(size));
        assert_eq!(uppers(&optimal_intervals(&histogram, &free).unwrap()), [1, 2, 9]);
        // More for an interval than all pixels together.
        let dear = model(1e6, 9, |size, _| f64::from(size));
        assert_eq!(uppers(&optimal_intervals(&histogram, &dear).unwrap()), [9]);
        // Three pixels save a cost of 8 each: worth an interval of 20, and the fourth is not.
        let some = model(20.0, 9, |size, _| f64::from(size));
        assert_eq!(uppers(&optimal_intervals(&histogram, &some).unwrap()), [2, 9]);
    }

    #[test]
    fn arrays_are_of_known_cost() {
        let point = |size: u32| CostPoint { max_frags: size, depth: size, ns: f64::from(size) };
        let cost = ArrayCost::from_points(&[point(4), point(8)]).unwrap();
        let model = CostModel::new(0.0, vec![(None, cost)]).unwrap();
        let best = |counts: &[u32]| {
            let histogram = DepthHistogram::from_counts(counts.iter().copied());
            optimal_intervals(&histogram, &model).map(|intervals| uppers(&intervals))
        };
        assert_eq!(best(&[1, 2]), Ok(vec![4]));
        assert_eq!(best(&[]), Ok(vec![4]));
        assert_eq!(best(&[1, 4, 6]), Ok(vec![4, 6]));
        assert_eq!(best(&[9]), Err(NoOptimum::TooDeep { peak: 9, largest: 8 }));
    }

    /// The least that any set of up to `most` bounds costs.
    fn exhaustive(histogram: &DepthHistogram, model: &CostModel, most: usize) -> f64 {
        let peak = histogram.peak().max(1);
        let sets = 0u32..1 << (peak - 1);
        let costs = sets.filter(|set| (set.count_ones() as usize) < most).filter_map(|set| {
            let mut bounds: Vec<u32> =
                (1..peak).filter(|bound| set >> (bound - 1) & 1 == 1).collect();
            bounds.push(peak);
            model.total_ns(histogram, &Intervals::from_uppers(bounds).expect("rising"))
        });
        costs.fold(f64::INFINITY, f64::min)
    }

    proptest! {
        /// Whatever costs were measured, no set of bounds is cheaper.
        #[test]
        fn no_set_of_bounds_is_cheaper(
            counts in prop::collection::vec(0u32..=10, 1..40),
            interval in 0u32..60,
            ns in prop::collection::vec(0u32..50, 110),
            most in 1usize..12,
        ) {
            let histogram = DepthHistogram::from_counts(counts);
            let of = |size: u32, depth: u32| f64::from(ns[(size * 10 + depth - 1) as usize % 110]);
            let model = model(f64::from(interval), 10, of);
            let found = best(&histogram, &model, most).unwrap();
            prop_assert!(found.len() <= most);
            prop_assert_eq!(found.deepest(), histogram.peak().max(1));
            let cost = model.total_ns(&histogram, &found).unwrap();
            let least = exhaustive(&histogram, &model, most);
            prop_assert!((cost - least).abs() < 1e-9 * least.max(1.0), "{:?}: {} {}", found, cost, least);
        }
    }
}
