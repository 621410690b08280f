//! How many times a scene is drawn.

use oit_capture::{Accuracy, Method, MethodRequest, Size};
use oit_fragments::DepthHistogram;

/// More passes than this are refused: a plan of them would take longer to record than anyone waits.
pub(crate) const MOST: u32 = 1024;

/// The axis of passes: as many as the view needs, or this many.
pub(crate) fn size() -> Size {
    Size { word: "passes", range: 1..=MOST, default: None }
}

/// Passes that peel everything: `layers` of them are peeled at a time. At least one.
pub(crate) fn needed(histogram: &DepthHistogram, layers: u32) -> u32 {
    histogram.peak().div_ceil(layers).max(1)
}

/// How many passes a plan has. One that `stops` does not know how many it needs, and has room for
/// more.
///
/// # Errors
/// Where they are more than [`MOST`].
pub(crate) fn recorded(request: &MethodRequest, layers: u32, stops: bool) -> Result<u32, String> {
    let needed = needed(request.histogram, layers);
    let passes = match request.size {
        Some(passes) => passes,
        None if stops => (needed + 1).next_power_of_two(),
        None => needed,
    };
    if passes > MOST {
        return Err(format!("it takes {passes} passes; a plan has {MOST} at most"));
    }
    Ok(passes)
}

/// What a picture of this many passes is, where passes that are enough make it `complete`.
pub(crate) fn accuracy(
    size: Option<u32>,
    histogram: &DepthHistogram,
    layers: u32,
    complete: Accuracy,
) -> Accuracy {
    let needed = needed(histogram, layers);
    match size {
        Some(passes) if passes < needed => Accuracy::Approximate(format!(
            "{passes} passes peel {} layers, and there are up to {}",
            passes * layers,
            histogram.peak()
        )),
        _ => complete,
    }
}

/// A name with `_stop` where the method stops by itself.
pub(crate) fn stops_name(stops: bool, [all, stop]: [&'static str; 2]) -> &'static str {
    if stops { stop } else { all }
}

/// The passes of a twin.
pub(crate) fn of_twin(method: &dyn Method, size: Option<u32>, peak: u32, layers: u32) -> u32 {
    debug_assert!(method.size().is_some());
    size.unwrap_or_else(|| peak.div_ceil(layers).max(1))
}
