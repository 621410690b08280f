use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use crate::nearest;

/// Something wrong in a file that a person wrote: where, and what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The file, as it was named by the caller.
    pub path: PathBuf,
    /// Line, counted from 1. None for a value that came from outside the file (an override).
    pub line: Option<usize>,
    /// What is wrong there.
    pub problem: Problem,
}

/// What is wrong at a place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Problem {
    /// A word that names nothing known.
    Unknown {
        /// What the word should have named: "key", "generator", "parameter".
        what: &'static str,
        /// The offending word.
        word: String,
        /// Every word that is valid in that place.
        valid: Vec<String>,
    },
    /// Anything else, in one sentence: a wrong type, a value out of range, a missing key.
    Invalid(String),
}

impl Problem {
    /// An unknown word among the valid ones.
    pub fn unknown<'a>(
        what: &'static str,
        word: &str,
        valid: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let valid = valid.into_iter().map(str::to_owned).collect();
        Self::Unknown { what, word: word.to_owned(), valid }
    }
}

fn quoted(words: &[String]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { what, word, valid } => {
                write!(f, "unknown {what} `{word}`")?;
                let near = nearest(word, valid.iter().map(String::as_str));
                match (near.is_empty(), valid.is_empty()) {
                    (false, _) => write!(f, ", the nearest valid: {}", quoted(&near)),
                    (true, false) => write!(f, ", valid: {}", quoted(valid)),
                    (true, true) => write!(f, ", none is valid here"),
                }
            }
            Self::Invalid(sentence) => f.write_str(sentence),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path.display(), self.problem),
            None => write!(f, "{}: override: {}", self.path.display(), self.problem),
        }
    }
}

impl std::error::Error for Fault {}

impl Fault {
    /// A fault at a byte range of `text`, the contents of the file at `path`.
    pub fn at(path: &Path, text: &str, span: Range<usize>, problem: Problem) -> Self {
        let line = 1 + text.bytes().take(span.start).filter(|byte| *byte == b'\n').count();
        Self { path: path.to_owned(), line: Some(line), problem }
    }
}

/// Reads a TOML document into `T`, naming file, line and word of the first thing wrong with it.
///
/// # Errors
/// [`Problem::Unknown`] for a key that `T` denies (`#[serde(deny_unknown_fields)]`),
/// [`Problem::Invalid`] for bad syntax, a wrong type or a missing key.
pub fn parse_toml<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, Fault> {
    toml::from_str(text).map_err(|error| {
        let message = error.message();
        let problem =
            unknown_key(message).unwrap_or_else(|| Problem::Invalid(message.replace('\n', " ")));
        Fault::at(path, text, error.span().unwrap_or(0..0), problem)
    })
}

/// The word and the valid ones, out of the two forms in which serde and toml report unknown keys:
/// "unknown field `x`, expected one of `a`, `b`" (or "unknown variant") and, for a key of an enum's
/// variant, "unexpected keys in table: x, available keys: a, b".
fn unknown_key(message: &str) -> Option<Problem> {
    if let Some(lists) = message.strip_prefix("unexpected keys in table: ") {
        let (unexpected, valid) = lists.split_once(", available keys: ")?;
        return Some(Problem::unknown("key", unexpected.split(", ").next()?, valid.split(", ")));
    }
    if message.starts_with("unknown field `") || message.starts_with("unknown variant `") {
        let mut words = message.split('`').skip(1).step_by(2);
        return Some(Problem::unknown("key", words.next()?, words));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only its keys matter")]
    struct Sample {
        layers: u32,
        size: f32,
    }

    fn fault(text: &str) -> String {
        parse_toml::<Sample>(Path::new("x.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn names_line_word_and_neighbours() {
        assert_eq!(
            fault("size = 1.0\nlayrs = 2\n"),
            "x.toml:2: unknown key `layrs`, the nearest valid: `layers`"
        );
        assert_eq!(
            fault("size = 1.0\nlayers = 2\nteapot = 1\n"),
            "x.toml:3: unknown key `teapot`, valid: `layers`, `size`"
        );
        assert_eq!(
            fault("size = 1.0\nlayers = \"2\"\n"),
            "x.toml:2: invalid type: string \"2\", expected u32"
        );
        assert!(fault("size = 1.0\n").contains("missing field `layers`"));
        assert!(fault("size = 1.0\nlayers = = 2\n").starts_with("x.toml:2: "));
    }
}
