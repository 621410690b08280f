//! Non-negative least squares.

/// Sweeps over all coefficients, at most. Features that are nearly the same take many.
const SWEEPS: usize = 3000;
/// A sweep that moves the prediction by less than this share of the largest is the last.
const STILL: f64 = 1e-10;

/// The coefficients, none below 0, for which the sums of `features` times them are nearest to the
/// measured, relative to these: the squares of `1 - predicted / measured` are the least. Costs add
/// up, so none is negative; and a small frame counts as much as a large one.
///
/// By descent along one coefficient after another, from 0. Rows that are not above 0 are left out, and
/// a feature that is 0 in all rows has the coefficient 0.
#[must_use]
pub(crate) fn non_negative(features: &[Vec<f64>], measured: &[f64]) -> Vec<f64> {
    let width = features.first().map_or(0, Vec::len);
    let rows: Vec<Vec<f64>> = features
        .iter()
        .zip(measured)
        .filter(|(_, ns)| ns.is_finite() && **ns > 0.0)
        .map(|(row, ns)| row.iter().map(|value| value / ns).collect())
        .collect();
    let dot = |a: usize, b: usize| -> f64 { rows.iter().map(|row| row[a] * row[b]).sum() };
    // Features of unlike size: each is scaled to a length of 1.
    let lengths: Vec<f64> = (0..width).map(|a| dot(a, a).sqrt()).collect();
    let scale = |a: usize| if lengths[a] > 0.0 { 1.0 / lengths[a] } else { 0.0 };
    let gram: Vec<Vec<f64>> =
        (0..width).map(|a| (0..width).map(|b| dot(a, b) * scale(a) * scale(b)).collect()).collect();
    let target: Vec<f64> =
        (0..width).map(|a| rows.iter().map(|row| row[a]).sum::<f64>() * scale(a)).collect();
    let mut x = vec![0.0; width];
    for _ in 0..SWEEPS {
        let mut moved = 0.0_f64;
        for a in (0..width).filter(|&a| lengths[a] > 0.0) {
            let others: f64 = (0..width).filter(|&b| b != a).map(|b| gram[a][b] * x[b]).sum();
            let better = (target[a] - others).max(0.0);
            moved = moved.max((better - x[a]).abs());
            x[a] = better;
        }
        if moved < STILL * x.iter().fold(f64::MIN_POSITIVE, |most, v| most.max(*v)) {
            break;
        }
    }
    x.iter().enumerate().map(|(a, value)| value * scale(a)).collect()
}

/// The sum of features times their coefficients.
#[must_use]
pub(crate) fn predict(features: &[f64], coefficients: &[f64]) -> f64 {
    features.iter().zip(coefficients).map(|(value, by)| value * by).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_follows_a_law_gives_the_law() {
        let rows: Vec<Vec<f64>> =
            [(1.0, 5.0), (2.0, 1.0), (3.0, 9.0)].map(|(a, b)| vec![1.0, a, b]).to_vec();
        let law = |row: &Vec<f64>| 100.0 + 20.0 * row[1] + 3.0 * row[2];
        let times: Vec<f64> = rows.iter().map(law).collect();
        let found = non_negative(&rows, &times);
        for (found, expected) in found.iter().zip([100.0, 20.0, 3.0]) {
            assert!((found - expected).abs() < 1e-3 * expected, "{found} {expected}");
        }
    }

    #[test]
    fn a_cost_is_never_negative() {
        // The line through these falls; the best that does not is flat.
        let rows = [vec![1.0, 1.0], vec![1.0, 2.0], vec![1.0, 3.0]];
        let found = non_negative(&rows, &[3.0, 2.0, 1.0]);
        assert!(found[1] == 0.0 && found[0] > 1.0 && found[0] < 3.0, "{found:?}");
    }

    #[test]
    fn what_says_nothing_is_left_out() {
        assert_eq!(non_negative(&[], &[]), Vec::<f64>::new());
        let rows = [vec![0.0, 2.0], vec![0.0, 4.0], vec![5.0, 5.0]];
        let found = non_negative(&rows, &[6.0, 12.0, 0.0]);
        assert_eq!(found[0], 0.0);
        assert!((found[1] - 3.0).abs() < 1e-9);
    }

    proptest! {
        /// No single coefficient can be changed for the better.
        #[test]
        fn it_is_the_best(values in prop::collection::vec((1u32..100, 1u32..100, 1u32..1000), 3..12)) {
            let rows: Vec<Vec<f64>> =
                values.iter().map(|&(a, b, _)| vec![1.0, f64::from(a), f64::from(b)]).collect();
            let times: Vec<f64> = values.iter().map(|&(.., ns)| f64::from(ns)).collect();
            let off = |x: &[f64]| -> f64 {
                rows.iter().zip(&times).map(|(row, ns)| (1.0 - predict(row, x) / ns).powi(2)).sum()
            };
            let found = non_negative(&rows, &times);
            let least = off(&found);
            for a in 0..3 {
                for by in [0.9, 1.1, 0.0] {
                    let mut other = found.clone();
                    other[a] *= by;
                    prop_assert!(off(&other) >= least - 1e-6, "{found:?}");
                }
                let mut other = found.clone();
                other[a] += 0.01;
                prop_assert!(off(&other) >= least - 1e-6, "{found:?}");
            }
        }
    }
}
