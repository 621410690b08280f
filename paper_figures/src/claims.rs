//! Claims of the papers, and whether they hold on a device. The sentences and rules live in
//! `claims/*.toml`; the code here only evaluates rules.

mod evidence;
mod measured;
mod paper;
mod rule;
mod verdict;

pub use crate::series::Varies;
pub use rule::{Bounds, Combine, Finding, MemoryOf, ProgramOf, Rule};
pub use verdict::{Answer, Verdict, csv, markdown, printed, verdicts};

use serde::Deserialize;

use crate::FigureError;

/// One sentence of a paper, made checkable.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Its name.
    pub id: String,
    /// Where it stands in the paper.
    pub place: String,
    /// The sentence, quoted.
    pub sentence: String,
    /// The rule in words: how the sentence is read.
    pub reading: String,
    /// What must be measured for it to hold.
    pub rule: Rule,
}

/// The claims of one paper.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// The paper.
    pub paper: String,
    /// Its claims.
    #[serde(rename = "claim")]
    pub claims: Vec<Claim>,
}

/// Every file of claims.
const FILES: &[(&str, &str)] = &[
    ("claims/rbs.toml", include_str!("../claims/rbs.toml")),
    ("claims/bma.toml", include_str!("../claims/bma.toml")),
    ("claims/lfb.toml", include_str!("../claims/lfb.toml")),
    ("claims/spheres.toml", include_str!("../claims/spheres.toml")),
    ("claims/targets.toml", include_str!("../claims/targets.toml")),
];

/// Reads all claims.
///
/// # Errors
/// Where a file does not hold claims.
pub fn all() -> Result<Vec<Claims>, FigureError> {
    let read = |&(file, text): &(&'static str, &str)| {
        toml::from_str(text).map_err(|error| FigureError::Data { file, reason: error.to_string() })
    };
    FILES.iter().map(read).collect()
}
