//! Claims of the papers, and whether they hold on a device. The sentences and rules live in
//! `claims/*.toml`; the code here only evaluates rules.

mod error_of;
mod evidence;
mod measured;
mod paper;
mod rule;
mod verdict;
mod work_of;

pub use crate::series::Varies;
pub use error_of::ErrorOf;
pub use rule::{Bounds, Combine, Finding, MemoryOf, ProgramOf, Rule};
pub use verdict::{Answer, Verdict, csv, markdown, printed, verdicts};
pub use work_of::WorkOf;

use serde::Deserialize;

use crate::FigureError;

/// Where a claim's sentence is from.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClaimKind {
    /// It stands in the text that its file and place name, word for word.
    #[default]
    Quoted,
    /// It is what is said of a method in general, in this project's words; the place names the method's
    /// source, which is not quoted.
    Known,
}

impl ClaimKind {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Quoted => "quoted",
            Self::Known => "known",
        }
    }
}

/// One sentence of a paper, or what is known of a method, made checkable.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Its name.
    pub id: String,
    /// Where its sentence is from.
    #[serde(default)]
    pub kind: ClaimKind,
    /// Where it stands in the paper; the source of the method for what is [`ClaimKind::Known`].
    pub place: String,
    /// The sentence, quoted unless it is [`ClaimKind::Known`].
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
    ("claims/peel.toml", include_str!("../claims/peel.toml")),
    ("claims/approx.toml", include_str!("../claims/approx.toml")),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A claim on a way of drawing that no experiment has would stay untested without a word.
    #[test]
    fn ways_of_drawing_spheres_in_claims_are_in_the_experiment() {
        let experiment = include_str!("../../experiments/spheres-tables.toml");
        // "all" of the experiment's first sweep is this list.
        let named = include_str!("../../crates/oit-spheres/src/named.rs");
        let files = all().unwrap();
        let claims = files.iter().flat_map(|file| &file.claims);
        let mut found = 0;
        for claim in claims {
            for technique in claim.rule.techniques() {
                if technique.starts_with("spheres/") {
                    let quoted = format!("\"{technique}\"");
                    let known = experiment.contains(&quoted) || named.contains(&quoted);
                    assert!(known, "{}: {technique}", claim.id);
                    found += 1;
                }
            }
        }
        assert!(found > 100, "{found} names");
    }
}
