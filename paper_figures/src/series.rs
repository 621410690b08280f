//! Views of one scene that differ in a few of its parameters: what figures draw along an axis.

use std::collections::BTreeMap;

use analysis::{CellResult, Tables, scene_name, scene_parameters};
use serde::Deserialize;

use crate::data::{Group, groups};

/// What changes from view to view of a series.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Varies {
    /// The part of the view that is covered, and with it the number of fragments; not the depth.
    Size,
    /// The depth, and with it the number of fragments; not the part covered.
    Depth,
    /// Depth against size, so that the number of fragments stays.
    DepthAtSameTotal,
}

/// One view of a series.
#[derive(Clone, Debug)]
pub(crate) struct Point<'a> {
    /// Its cells.
    pub group: Group<'a>,
    /// Fragments of all pixels.
    pub total: u64,
    /// Fragments of the deepest pixel.
    pub depth: u64,
    /// Pixels with fragments.
    pub covered_px: u64,
}

/// Fewer views are no series: a line through two points is always straight.
const LEAST_POINTS: usize = 3;
/// How far totals or coverage that stay the same may be apart: a rim of pixels more or less.
const SAME: f64 = 1.25;

impl Varies {
    /// The scene's parameters that may differ, of `grid` and of `stack`.
    fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Size => &["size"],
            Self::Depth => &["layers", "count"],
            Self::DepthAtSameTotal => &["layers", "size", "tessellation"],
        }
    }

    /// Where a point lies on the axis.
    pub(crate) fn at(self, point: &Point) -> u64 {
        match self {
            Self::Size => point.total,
            Self::Depth | Self::DepthAtSameTotal => point.depth,
        }
    }

    /// What must stay the same.
    fn constant(self, point: &Point) -> u64 {
        match self {
            Self::Size => point.depth,
            Self::Depth => point.covered_px,
            Self::DepthAtSameTotal => point.total,
        }
    }
}

fn point(group: Group<'_>) -> Option<Point<'_>> {
    let name = group.name();
    let (total, histogram) = (group.run.total_fragments(&name)?, group.run.histogram(&name)?);
    let depth = histogram.iter().rposition(|&pixels| pixels > 0)? as u64;
    let covered_px = histogram.iter().skip(1).fold(0_u64, |sum, &px| sum.saturating_add(px));
    Some(Point { group, total, depth, covered_px })
}

/// Run, view, resolution and all parameters that may not differ: what views of a series share.
type Key<'a> = (String, &'a str, [u32; 2], Vec<(&'a str, &'a str)>);

/// The series of a scene that hold cells that are wanted, each from one run, one a device, view and
/// set of other parameters, by rising place on the axis.
pub(crate) fn series<'a>(
    tables: &'a Tables,
    scene: &str,
    varies: Varies,
    wanted: impl Fn(&CellResult) -> bool,
) -> Vec<Vec<Point<'a>>> {
    let mut found: BTreeMap<Key, Vec<Point>> = BTreeMap::new();
    let of_scene = |cell: &CellResult| scene_name(&cell.name.scene) == scene && wanted(cell);
    for group in groups(tables, of_scene) {
        let others = scene_parameters(group.scene).into_iter();
        let others = others.filter(|(name, _)| !varies.parameters().contains(name)).collect();
        let key = (group.run.name.clone(), group.view, [group.width_px, group.height_px], others);
        found.entry(key).or_default().extend(point(group));
    }
    let mut all: Vec<Vec<Point>> = found.into_values().collect();
    for points in &mut all {
        points.sort_by_key(|point| varies.at(point));
        points.dedup_by_key(|point| varies.at(point));
    }
    all.retain(|points| {
        let constant = points.iter().map(|point| varies.constant(point) as f64);
        let least = constant.clone().fold(f64::INFINITY, f64::min);
        points.len() >= LEAST_POINTS && constant.fold(0.0, f64::max) <= least * SAME
    });
    all
}

/// A straight line through points, by least squares.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Fit {
    /// How much y rises with x.
    pub slope: f64,
    /// y where x is 0.
    pub intercept: f64,
    /// The share of the variance of y that the line explains.
    pub r_squared: f64,
}

impl Fit {
    /// The line through points; `None` for fewer than three, or where x or y does not vary.
    #[must_use]
    pub(crate) fn of(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|point| point.0), mean(|point| point.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|point| of(point.0 - x, point.1 - y)).sum()
        };
        let (xx, xy, yy) = (sum(&|dx, _| dx * dx), sum(&|dx, dy| dx * dy), sum(&|_, dy| dy * dy));
        if points.len() < LEAST_POINTS || xx <= 0.0 || yy <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        Some(Self { slope, intercept: y - slope * x, r_squared: xy * xy / (xx * yy) })
    }

    /// The line's y.
    #[must_use]
    pub(crate) fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }
}

/// Where shares, by rising x, pass a bound and stay above it: linear between the two points around
/// it, the first x where all are above. `None` where the last is not.
#[must_use]
pub(crate) fn passes(shares: &[(f64, f64)], bound: f64) -> Option<f64> {
    let &(first, _) =
        shares.first().filter(|_| shares.last().is_some_and(|last| last.1 > bound))?;
    let Some(below) = shares.iter().rposition(|(_, share)| *share <= bound) else {
        return Some(first);
    };
    let ((x0, y0), (x1, y1)) = (shares[below], shares[below + 1]);
    Some(x0 + (x1 - x0) * (bound - y0) / (y1 - y0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted() {
        let straight = Fit::of(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).unwrap();
        assert!((straight.slope - 2.0).abs() < 1e-12 && (straight.at(0.0) - 3.0).abs() < 1e-12);
        assert!((straight.r_squared - 1.0).abs() < 1e-12);
        let bent = Fit::of(&[(0.0, 0.0), (1.0, 3.0), (2.0, 0.0)]).unwrap();
        assert!((bent.slope).abs() < 1e-12 && bent.r_squared < 1e-12);
        let noisy = Fit::of(&[(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]).unwrap();
        assert!((noisy.r_squared - 0.25).abs() < 1e-12, "{noisy:?}");
        assert_eq!(Fit::of(&[(0.0, 0.0), (1.0, 1.0)]), None);
        assert_eq!(Fit::of(&[(1.0, 0.0), (1.0, 1.0), (1.0, 2.0)]), None);
    }

    #[test]
    fn a_bound_is_passed_for_good() {
        assert_eq!(passes(&[(10.0, 0.2), (20.0, 0.4), (40.0, 0.6)], 0.5), Some(30.0));
        // Above, below again, then above: the last time counts.
        assert_eq!(passes(&[(1.0, 0.6), (2.0, 0.4), (4.0, 0.6)], 0.5), Some(3.0));
        assert_eq!(passes(&[(8.0, 0.6), (9.0, 0.7)], 0.5), Some(8.0));
        assert_eq!(passes(&[(1.0, 0.6), (2.0, 0.5)], 0.5), None);
        assert_eq!(passes(&[], 0.5), None);
    }
}
