//! What pixels cost: the measured time of a program by the size of its array and the depth of a
//! pixel.

use oit_fragments::DepthHistogram;

use crate::Intervals;

/// One measurement: the time of a pixel of some depth in a program with an array of some size.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CostPoint {
    /// The size of the array, in fragments.
    pub max_frags: u32,
    /// Fragments of the pixel, no more than the array holds.
    pub depth: u32,
    /// Nanoseconds a pixel, of a frame full of such pixels.
    pub ns: f64,
}

/// The cost of one way to sort, from measurements.
///
/// Between measured sizes and depths it is interpolated linearly, in the size `u` and in the share
/// `d / u` that a pixel fills of its array: the corners of a program for up to 24 are those of 16 and
/// 32 that are as full. In the depth it never falls: where a deeper pixel was measured to be cheaper,
/// which is noise, it costs what the shallower one does.
///
/// It goes beyond what was measured in one case: a pixel that fills a smaller share than any that was
/// measured costs what that one does, which is too much rather than too little. A size below the
/// smallest, above the largest, or a share above the greatest has no cost.
#[derive(Clone, PartialEq, Debug)]
pub struct ArrayCost {
    sizes: Vec<Curve>,
}

/// The measurements at one size.
#[derive(Clone, PartialEq, Debug)]
struct Curve {
    max_frags: u32,
    /// The share of the array that is filled, rising, and nanoseconds, not falling.
    points: Vec<(f64, f64)>,
}

/// Why measurements are no cost model.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum BadCost {
    /// A measurement that is none: of no pixel, of one deeper than its array, of no time.
    #[error("no cost: {depth} fragments in an array of {max_frags}, {ns} ns")]
    Point {
        /// The size of the array.
        max_frags: u32,
        /// The depth.
        depth: u32,
        /// The time.
        ns: f64,
    },
    /// A depth was given twice for one size.
    #[error("two costs of {depth} fragments in an array of {max_frags}")]
    Twice {
        /// The size of the array.
        max_frags: u32,
        /// The depth.
        depth: u32,
    },
    /// The cost of an interval is no time.
    #[error("no cost of an interval: {0} ns")]
    Interval(f64),
}

impl ArrayCost {
    /// The cost that these measurements say, in any order.
    ///
    /// # Errors
    /// Where one is no measurement, or there twice.
    pub fn from_points(points: &[CostPoint]) -> Result<Self, BadCost> {
        let mut points = points.to_vec();
        points.sort_by_key(|point| (point.max_frags, point.depth));
        let mut sizes: Vec<Curve> = Vec::new();
        for (place, &CostPoint { max_frags, depth, ns }) in points.iter().enumerate() {
            if !(1..=max_frags).contains(&depth) || !ns.is_finite() || ns < 0.0 {
                return Err(BadCost::Point { max_frags, depth, ns });
            }
            if place > 0
                && (points[place - 1].max_frags, points[place - 1].depth) == (max_frags, depth)
            {
                return Err(BadCost::Twice { max_frags, depth });
            }
            if sizes.last().is_none_or(|curve| curve.max_frags != max_frags) {
                sizes.push(Curve { max_frags, points: Vec::new() });
            }
            let curve = &mut sizes.last_mut().expect("pushed above").points;
            let least = curve.last().map_or(0.0, |(_, ns)| *ns);
            curve.push((f64::from(depth) / f64::from(max_frags), ns.max(least)));
        }
        Ok(Self { sizes })
    }

    /// Nanoseconds of a pixel of `depth` fragments in a program with an array of `max_frags`;
    /// `None` where that was not measured. A pixel deeper than the array costs what a full one does.
    #[must_use]
    pub fn ns(&self, max_frags: u32, depth: u32) -> Option<f64> {
        let share = f64::from(depth.min(max_frags)) / f64::from(max_frags.max(1));
        let above = self.sizes.partition_point(|curve| curve.max_frags < max_frags);
        let upper = self.sizes.get(above)?;
        if upper.max_frags == max_frags {
            return upper.ns(share);
        }
        let lower = &self.sizes[above.checked_sub(1)?];
        let (low, high) = (f64::from(lower.max_frags), f64::from(upper.max_frags));
        let place = (f64::from(max_frags) - low) / (high - low);
        Some(between(lower.ns(share)?, upper.ns(share)?, place))
    }
}

fn between(low: f64, high: f64, place: f64) -> f64 {
    low + (high - low) * place
}

impl Curve {
    fn ns(&self, share: f64) -> Option<f64> {
        let above = self.points.partition_point(|(at, _)| *at < share);
        let &(high_at, high) = self.points.get(above)?;
        let Some(below) = above.checked_sub(1) else { return Some(high) };
        let (low_at, low) = self.points[below];
        Some(between(low, high, (share - low_at) / (high_at - low_at)))
    }
}

/// The cost of a frame's resolve: what each pixel costs in its interval's program, and what an
/// interval costs whatever its pixels are.
#[derive(Clone, PartialEq, Debug)]
pub struct CostModel {
    interval_ns: f64,
    parts: Vec<(Option<u32>, ArrayCost)>,
}

impl CostModel {
    /// A model of a choice of sorts: arrays up to each part's bound have its cost, the first that
    /// admits a size deciding; the bound `None` admits all. `interval_ns` is what one more interval
    /// costs.
    ///
    /// # Errors
    /// Where `interval_ns` is no time.
    pub fn new(interval_ns: f64, parts: Vec<(Option<u32>, ArrayCost)>) -> Result<Self, BadCost> {
        if !interval_ns.is_finite() || interval_ns < 0.0 {
            return Err(BadCost::Interval(interval_ns));
        }
        Ok(Self { interval_ns, parts })
    }

    /// Nanoseconds of one more interval.
    #[must_use]
    pub fn interval_ns(&self) -> f64 {
        self.interval_ns
    }

    /// Nanoseconds of a pixel, as [`ArrayCost::ns`].
    #[must_use]
    pub fn pixel_ns(&self, max_frags: u32, depth: u32) -> Option<f64> {
        let admits =
            |(most, _): &&(Option<u32>, ArrayCost)| most.is_none_or(|most| max_frags <= most);
        self.parts.iter().find(admits)?.1.ns(max_frags, depth)
    }

    /// The smallest array of at least `least` and at most `most` that has a cost for pixels that
    /// fill it.
    pub(crate) fn smallest(&self, least: u32, most: u32) -> Option<u32> {
        (least.max(1)..=most).find(|&size| self.pixel_ns(size, size).is_some())
    }

    /// The largest array that was measured.
    pub(crate) fn largest(&self) -> u32 {
        let last = |(_, cost): &(Option<u32>, ArrayCost)| Some(cost.sizes.last()?.max_frags);
        self.parts.iter().filter_map(last).max().unwrap_or(0)
    }

    /// Nanoseconds of all pixels and intervals of a view; `None` where one of its pixels has no cost.
    #[must_use]
    pub fn total_ns(&self, histogram: &DepthHistogram, intervals: &Intervals) -> Option<f64> {
        let bounds: Vec<u32> = intervals.iter().map(|interval| interval.high).collect();
        let mut ns = self.interval_ns * bounds.len() as f64;
        for (depth, &pixels) in (0u32..).zip(&histogram.pixels) {
            if let Some(place) = intervals.index(depth).filter(|_| pixels > 0) {
                ns += pixels as f64 * self.pixel_ns(bounds[place], depth)?;
            }
        }
        Some(ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(points: &[(u32, u32, f64)]) -> Result<ArrayCost, BadCost> {
        let point = |&(max_frags, depth, ns): &(u32, u32, f64)| CostPoint { max_frags, depth, ns };
        ArrayCost::from_points(&points.iter().map(point).collect::<Vec<_>>())
    }

    #[test]
    fn costs_lie_between_those_measured() {
        let cost = cost(&[(32, 32, 40.0), (16, 4, 8.0), (16, 16, 20.0), (32, 8, 16.0)]).unwrap();
        assert_eq!(cost.ns(16, 16), Some(20.0));
        assert_eq!(cost.ns(16, 10), Some(14.0));
        // As full: halfway between 16 of 16 and 32 of 32.
        assert_eq!(cost.ns(24, 24), Some(30.0));
        assert_eq!(cost.ns(24, 6), Some(12.0));
        // Deeper than the array is as a full one; less full than measured is as the least.
        assert_eq!(cost.ns(16, 99), Some(20.0));
        assert_eq!(cost.ns(16, 1), Some(8.0));
    }

    #[test]
    fn nothing_is_said_of_what_was_not_measured() {
        let cost = cost(&[(8, 8, 1.0), (16, 8, 2.0)]).unwrap();
        for (size, depth) in [(7, 7), (17, 1), (16, 9), (12, 7), (0, 0)] {
            assert_eq!(cost.ns(size, depth), None, "{size} {depth}");
        }
        assert_eq!(cost.ns(12, 6), Some(1.5), "an array of 8 costs no less than a full one");
        assert_eq!(ArrayCost::from_points(&[]).unwrap().ns(8, 8), None);
    }

    #[test]
    fn a_deeper_pixel_is_never_cheaper() {
        let cost = cost(&[(8, 2, 5.0), (8, 4, 3.0), (8, 8, 9.0), (32, 8, 50.0), (32, 32, 20.0)]);
        let cost = cost.unwrap();
        for size in 8..=32 {
            let all: Vec<f64> = (1..=size).filter_map(|depth| cost.ns(size, depth)).collect();
            assert_eq!(all.len(), size as usize);
            assert!(all.is_sorted(), "{size}: {all:?}");
        }
    }

    #[test]
    fn what_is_no_measurement_is_refused() {
        for bad in [(8, 0, 1.0), (8, 9, 1.0), (8, 8, -1.0), (8, 8, f64::NAN)] {
            assert!(matches!(cost(&[bad]), Err(BadCost::Point { .. })), "{bad:?}");
        }
        assert!(matches!(cost(&[(8, 4, 1.0), (8, 4, 1.0)]), Err(BadCost::Twice { .. })));
        for bad in [-1.0, f64::INFINITY] {
            assert!(CostModel::new(bad, Vec::new()).is_err());
        }
    }

    #[test]
    fn a_choice_of_sorts_costs_what_its_parts_do() {
        let parts = vec![
            (Some(16), cost(&[(8, 8, 1.0), (64, 64, 64.0)]).unwrap()),
            (None, cost(&[(8, 8, 7.0), (64, 64, 7.0)]).unwrap()),
        ];
        let model = CostModel::new(10.0, parts).unwrap();
        assert_eq!((model.pixel_ns(8, 8), model.pixel_ns(17, 17)), (Some(1.0), Some(7.0)));
        let histogram = DepthHistogram::from_counts([0, 8, 8, 64]);
        let intervals = Intervals::from_uppers(vec![8, 64]).unwrap();
        assert_eq!(model.total_ns(&histogram, &intervals), Some(20.0 + 2.0 + 7.0));
        let intervals = Intervals::from_uppers(vec![8, 65]).unwrap();
        assert_eq!(model.total_ns(&histogram, &intervals), None);
    }
}
