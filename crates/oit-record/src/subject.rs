//! What a comparison says of the sort it is about, in `subject.json` beside the run.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::RecordError;

/// The file's name in a run folder.
const FILE: &str = "subject.json";

/// The sort that is compared with others: what it is, and whether it sorts.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Subject {
    /// As in technique coordinates: one strategy, or several joined by `+`.
    pub sort: String,
    /// The device that its kernels ran on.
    pub device: String,
    /// Its strategies.
    pub parts: Vec<SubjectPart>,
}

/// One strategy of a subject.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubjectPart {
    /// The strategy.
    pub name: String,
    /// What it does, in a sentence.
    pub summary: String,
    /// Where it comes from.
    pub citation: String,
    /// The store compared.
    pub store: String,
    /// All its stores.
    pub stores: Vec<String>,
    /// The most fragments of a pixel that it is run for in that store; `None` without limit.
    pub limit: Option<u32>,
    /// Whether it sorts, before anything was timed.
    pub conformance: Conformance,
}

/// How a strategy's kernels, or its CPU twin, did on the lists that all sorts are tested on.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conformance {
    /// What was compared with what.
    pub compared: String,
    /// Programs up to this many fragments were run; 0 for none.
    pub up_to: u32,
    /// Programs run.
    pub programs: u32,
    /// Lists of fragments that were sorted, over all programs.
    pub lists: u64,
    /// What the device lacks for larger programs than those up to `up_to`.
    pub lacking: Option<String>,
    /// The first list that was sorted wrongly; nothing is run after it.
    pub wrong: Option<String>,
}

impl Subject {
    /// The first that is wrong, with its strategy.
    #[must_use]
    pub fn wrong(&self) -> Option<(&str, &str)> {
        let mut parts = self.parts.iter();
        parts.find_map(|part| Some((part.name.as_str(), part.conformance.wrong.as_deref()?)))
    }

    /// Writes it into a run folder, which need not be there yet.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RecordError> {
        let path = folder.join(FILE);
        let io = |error| RecordError::Io { path: path.clone(), error };
        let text = serde_json::to_string_pretty(self).map_err(|error| RecordError::Parse {
            path: path.clone(),
            line: 1,
            error,
        })?;
        fs::create_dir_all(folder).map_err(io)?;
        fs::write(&path, text + "\n").map_err(io)
    }

    /// That of a run folder, if it has one.
    ///
    /// # Errors
    /// Where it cannot be read, or is damaged.
    pub fn read(folder: &Path) -> Result<Option<Self>, RecordError> {
        let path = folder.join(FILE);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(RecordError::Io { path, error }),
        };
        let parsed = serde_json::from_str(&text);
        parsed.map(Some).map_err(|error| RecordError::Parse { path, line: error.line(), error })
    }
}
