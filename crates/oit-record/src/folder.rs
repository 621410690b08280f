//! Run folders: writing one event at a time, and reading back what is there, also after a kill.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Event, Run, SCHEMA_VERSION};

/// Why a run folder cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file system refused.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        error: io::Error,
    },
    /// A line is not what this schema says.
    #[error("{}:{line}: {error}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        error: serde_json::Error,
    },
    /// The record was written by another version of the schema.
    #[error("{}: schema version {found}, this program reads version {SCHEMA_VERSION}", path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// The version it has.
        found: u64,
    },
    /// An event names a cell that the run does not have.
    #[error("{}:{line}: cell {cell} of a run with {cells} cells", path.display())]
    NoSuchCell {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The cell named.
        cell: usize,
        /// How many there are.
        cells: usize,
    },
    /// A new run would overwrite one that is there.
    #[error("{} holds a run already: resume it (--resume) or name another folder", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
}

fn io_error(path: &Path) -> impl FnOnce(io::Error) -> RecordError + '_ {
    move |error| RecordError::Io { path: path.to_owned(), error }
}

/// A run and all its events.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    /// Where it lies.
    pub folder: PathBuf,
    /// `run.json`.
    pub run: Run,
    /// `events.jsonl`.
    pub events: Vec<Event>,
}

impl Record {
    /// Reads a run folder. A last line without its line feed is what a kill leaves of an event that
    /// was being written: it is no event, and is left out.
    ///
    /// # Errors
    /// Where a file is missing, damaged, or of another schema version.
    pub fn read(folder: &Path) -> Result<Self, RecordError> {
        let path = folder.join("run.json");
        let text = fs::read_to_string(&path).map_err(io_error(&path))?;
        let parse_error = |error| RecordError::Parse { path: path.clone(), line: 1, error };
        let value: serde_json::Value = serde_json::from_str(&text).map_err(parse_error)?;
        let found = value.get("schema").and_then(serde_json::Value::as_u64).unwrap_or(0);
        if found != u64::from(SCHEMA_VERSION) {
            return Err(RecordError::Schema { path, found });
        }
        let run: Run = serde_json::from_value(value).map_err(parse_error)?;
        let path = folder.join("events.jsonl");
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(RecordError::Io { path, error }),
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut events = Vec::new();
        for (index, line) in text[..whole].lines().enumerate() {
            let event: Event = serde_json::from_str(line).map_err(|error| RecordError::Parse {
                path: path.clone(),
                line: index + 1,
                error,
            })?;
            match event.cell() {
                Some(cell) if cell >= run.cells.len() => {
                    let cells = run.cells.len();
                    return Err(RecordError::NoSuchCell { path, line: index + 1, cell, cells });
                }
                _ => events.push(event),
            }
        }
        Ok(Self { folder: folder.to_owned(), run, events })
    }

    /// Every run folder at or below `root`, sorted by path.
    ///
    /// # Errors
    /// Where a folder or a record cannot be read.
    pub fn read_all(root: &Path) -> Result<Vec<Self>, RecordError> {
        if root.join("run.json").exists() {
            return Ok(vec![Self::read(root)?]);
        }
        let mut folders = Vec::new();
        for entry in fs::read_dir(root).map_err(io_error(root))? {
            let path = entry.map_err(io_error(root))?.path();
            if path.is_dir() {
                folders.push(path);
            }
        }
        folders.sort();
        let mut records = Vec::new();
        for folder in folders {
            records.extend(Self::read_all(&folder)?);
        }
        Ok(records)
    }

    /// Whether the run was completed.
    #[must_use]
    pub fn finished(&self) -> bool {
        self.events.iter().any(|event| matches!(event, Event::Finished { .. }))
    }
}

/// An open run folder that events are appended to.
#[derive(Debug)]
pub struct RunWriter {
    path: PathBuf,
    file: File,
}

impl RunWriter {
    /// Starts a run folder: writes `run.json` and an empty `events.jsonl`.
    ///
    /// # Errors
    /// Where the folder cannot be written, or holds a run already.
    pub fn create(folder: &Path, run: &Run) -> Result<Self, RecordError> {
        fs::create_dir_all(folder).map_err(io_error(folder))?;
        let run_path = folder.join("run.json");
        if run_path.exists() {
            return Err(RecordError::Exists { path: folder.to_owned() });
        }
        let text = serde_json::to_string_pretty(run).map_err(|error| RecordError::Parse {
            path: run_path.clone(),
            line: 1,
            error,
        })?;
        // The events file first: a folder with a `run.json` is then always a whole one.
        let path = folder.join("events.jsonl");
        let file = File::create(&path).map_err(io_error(&path))?;
        let partial = folder.join("run.json.partial");
        fs::write(&partial, text + "\n").map_err(io_error(&partial))?;
        fs::rename(&partial, &run_path).map_err(io_error(&run_path))?;
        Ok(Self { path, file })
    }

    /// Opens a run folder to go on with it, and drops what a kill left of a last line.
    ///
    /// # Errors
    /// Where it cannot be read or written.
    pub fn resume(folder: &Path) -> Result<(Self, Record), RecordError> {
        let record = Record::read(folder)?;
        let path = folder.join("events.jsonl");
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(RecordError::Io { path, error }),
        };
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        let open = OpenOptions::new().create(true).append(true).open(&path);
        let file = open.map_err(io_error(&path))?;
        file.set_len(whole as u64).map_err(io_error(&path))?;
        Ok((Self { path, file }, record))
    }

    /// Appends one event, in one write of one whole line.
    ///
    /// # Errors
    /// Where the disk is full or gone. What was appended before is intact.
    pub fn append(&mut self, event: &Event) -> Result<(), RecordError> {
        let mut line = serde_json::to_vec(event).map_err(|error| RecordError::Parse {
            path: self.path.clone(),
            line: 0,
            error,
        })?;
        line.push(b'\n');
        self.file.write_all(&line).map_err(io_error(&self.path))
    }
}
