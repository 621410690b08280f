//! Is one technique faster than another? Answered by the interval of the ratio, nothing else.

use oit_record::statistics::{self, Comparison};

use crate::{BOOTSTRAP_SEED, CellResult, CompareError};

/// The ratio of two medians and what follows from its interval.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ratio {
    /// The first cell's median over the second's.
    pub ratio: f64,
    /// Lower end of the 95 % bootstrap interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// `Faster` where the whole interval lies below 1, `Slower` where it lies above, else `Same`.
    pub verdict: Comparison,
}

impl Ratio {
    /// The verdict in a word: `faster`, `slower` or `same`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self.verdict {
            Comparison::Faster => "faster",
            Comparison::Slower => "slower",
            Comparison::Same => "same",
        }
    }
}

/// Compares a stage of two cells of one run and one group.
///
/// # Errors
/// Where the cells are of different runs or groups, or one has no time for the stage.
pub fn compare(a: &CellResult, b: &CellResult, stage: &str) -> Result<Ratio, CompareError> {
    if a.run != b.run || a.name.group() != b.name.group() {
        let name = |cell: &CellResult| format!("{} of {}", cell.name.technique, cell.name.group());
        return Err(CompareError::OtherGroup(name(a), name(b)));
    }
    let no_time = |cell: &CellResult| CompareError::NoTime {
        technique: cell.name.technique.clone(),
        stage: stage.to_owned(),
        state: cell.state.name().to_owned(),
    };
    let samples = |cell: &CellResult| -> Result<Vec<f64>, CompareError> {
        let timing = cell.times.get(stage).ok_or_else(|| no_time(cell))?;
        Ok(timing.samples_ns.iter().map(|&ns| ns as f64).collect())
    };
    let (a_ns, b_ns) = (samples(a)?, samples(b)?);
    let compared = statistics::compare(&a_ns, &b_ns, BOOTSTRAP_SEED);
    let (ratio, low, high, verdict) = compared.ok_or_else(|| no_time(b))?;
    Ok(Ratio { ratio, low, high, verdict })
}
