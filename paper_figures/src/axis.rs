//! A scale from values to pixels, linear or logarithmic, and its ticks.

use plotters::coord::ranged1d::{BoldPoints, Ranged};
use plotters::coord::types::RangedCoordf64;

/// A scale.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    log: bool,
    from_px: f64,
    to_px: f64,
}

impl Axis {
    /// A linear scale from `low` at `from_px` to `high` at `to_px`.
    #[must_use]
    pub(crate) fn linear(low: f64, high: f64, from_px: f64, to_px: f64) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        Self { low, high, log: false, from_px, to_px }
    }

    /// A logarithmic scale that holds `low` and `high`, which are above 0.
    #[must_use]
    pub(crate) fn log(low: f64, high: f64, from_px: f64, to_px: f64) -> Self {
        let low = low.max(f64::MIN_POSITIVE);
        let high = if high > low { high } else { low * 10.0 };
        Self { low, high, log: true, from_px, to_px }
    }

    /// Where a value lies; values off the scale lie at its ends.
    #[must_use]
    pub(crate) fn at(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.max(self.low) / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.from_px + share.clamp(0.0, 1.0) * (self.to_px - self.from_px)
    }

    /// Powers of ten within the scale, with their twofold and fivefold where there is room.
    fn decades(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let multiples: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let step = ((last - first) / 8).max(1) as usize;
        let powers = (first..=last).step_by(step).map(|power| 10f64.powi(power));
        let all = powers.flat_map(|power| multiples.iter().map(move |m| m * power));
        // A hair of slack, as powers of ten are not exact.
        all.filter(|v| (self.low * 0.999_999..=self.high * 1.000_001).contains(v)).collect()
    }

    /// Values to mark, with their labels.
    #[must_use]
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let linear = || RangedCoordf64::from(self.low..self.high).key_points(BoldPoints(7));
        let mut values = if self.log { self.decades() } else { linear() };
        // A range within a decade may hold none of the round numbers.
        if values.len() < 3 {
            values = linear();
        }
        values.into_iter().map(|value| (value, number(value))).collect()
    }
}

/// A number as short as it can be said: `0.2`, `12`, `1e-5`.
#[must_use]
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}

/// Milliseconds to three digits: `0.0123`, `1.23`, `12.3`, `123`.
#[must_use]
pub(crate) fn three_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value);
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_and_ticks() {
        let axis = Axis::log(0.1, 10.0, 0.0, 100.0);
        assert!((axis.at(1.0) - 50.0).abs() < 1e-9);
        assert_eq!(axis.at(1000.0), 100.0);
        let labels: Vec<String> = axis.ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        let labels = Axis::log(30.0, 90.0, 0.0, 100.0).ticks();
        assert!(labels.len() >= 3 && labels.iter().all(|(value, _)| (30.0..=90.0).contains(value)));
        let axis = Axis::linear(0.0, 50.0, 100.0, 0.0);
        assert_eq!(axis.at(25.0), 50.0);
        assert_eq!(axis.ticks().last().map(|(value, _)| *value), Some(50.0));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(0.5), "0.5");
        assert_eq!(number(1e-5), "1e-5");
        assert_eq!(three_digits(0.012_34), "0.0123");
        assert_eq!(three_digits(12.345), "12.3");
        assert_eq!(three_digits(530.4), "530");
    }
}
