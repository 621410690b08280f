//! What rules on errors and memory compute from figures.

use crate::series::Fit;

/// The exponent of the power of sizes that errors follow best: the slope of a line through logarithms.
///
/// # Errors
/// Where there are fewer than three sizes, or an error is 0.
pub(super) fn exponent(points: &[(f64, f64)]) -> Result<f64, String> {
    if let Some((size, _)) = points.iter().find(|(size, error)| *size <= 0.0 || *error <= 0.0) {
        return Err(format!("no logarithm at size {size}: it or its error is 0"));
    }
    let logarithms: Vec<(f64, f64)> =
        points.iter().map(|(size, error)| (size.ln(), error.ln())).collect();
    let fit = Fit::of(&logarithms).ok_or_else(|| "fewer than three sizes".to_owned())?;
    Ok(fit.slope)
}

/// Of errors along a series by rising place, the first place that is beyond a bound; infinite where
/// none is.
pub(super) fn lost_from(points: &[(u64, f64)], beyond: f64) -> f64 {
    // What is not a number is beyond every bound.
    let lost = points.iter().find(|(_, error)| error.is_nan() || *error > beyond);
    lost.map_or(f64::INFINITY, |(at, _)| *at as f64)
}

/// The greatest of figures above 0 over the least.
pub(super) fn growth(figures: &[f64]) -> f64 {
    let least = figures.iter().copied().fold(f64::INFINITY, f64::min);
    figures.iter().copied().fold(0.0, f64::max) / least
}
