//! What a table or figure must say of the run behind it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use oit_record::{Bandwidth, Event, Record, Run};

use crate::AnalysisError;

/// A run: its name in the tables and what `run.json` says of it.
#[derive(Clone, PartialEq, Debug)]
pub struct RunInfo {
    /// The run folder's name, with as many parents as make it unique among the runs loaded.
    pub name: String,
    /// Where it lies.
    pub folder: PathBuf,
    /// `run.json`.
    pub run: Run,
    /// Whether the run was completed.
    pub finished: bool,
    /// `Counted` events: group, triangles, histogram of fragments a pixel.
    pub counted: Vec<(String, u64, Vec<u64>)>,
    /// Spheres of groups whose scene is of spheres, every object in full detail.
    pub spheres: BTreeMap<String, u64>,
    /// What the device's memory moves, where the experiment asks for work.
    pub bandwidth: Option<Bandwidth>,
}

impl RunInfo {
    /// Names the runs of `records`.
    pub(crate) fn of(records: &[Record]) -> Result<Vec<Self>, AnalysisError> {
        let mut folders = BTreeSet::new();
        for record in records {
            if !folders.insert(&record.folder) {
                return Err(AnalysisError::RunTwice { folder: record.folder.clone() });
            }
        }
        let longest = folders.iter().map(|folder| folder.components().count()).max().unwrap_or(0);
        let unique = (1..longest).find(|&parts| {
            let names: BTreeSet<String> = folders.iter().map(|f| last_parts(f, parts)).collect();
            names.len() == folders.len()
        });
        let parts = unique.unwrap_or(longest);
        Ok(records.iter().map(|record| Self::named(record, parts)).collect())
    }

    fn named(record: &Record, parts: usize) -> Self {
        let counted = record.events.iter().filter_map(|event| match event {
            Event::Counted { group, triangles, histogram, .. } => {
                Some((group.clone(), *triangles, histogram.clone()))
            }
            _ => None,
        });
        let spheres = record.events.iter().filter_map(|event| match event {
            Event::Counted { group, spheres, .. } => Some((group.clone(), (*spheres)?)),
            _ => None,
        });
        let bandwidth = record.events.iter().find_map(|event| match event {
            Event::Bandwidth { measured } => Some(*measured),
            _ => None,
        });
        Self {
            spheres: spheres.collect(),
            name: last_parts(&record.folder, parts),
            folder: record.folder.clone(),
            run: record.run.clone(),
            finished: record.finished(),
            counted: counted.collect(),
            bandwidth,
        }
    }

    /// The device as figures name it, with its backend, since one GPU may be reached by two.
    #[must_use]
    pub fn device(&self) -> String {
        format!("{} ({})", self.run.device.name, self.run.device.backend)
    }

    /// The commit in twelve digits, with `+` where tracked files differed from it.
    #[must_use]
    pub fn commit(&self) -> String {
        let Some(commit) = &self.run.git_commit else { return "no commit".to_owned() };
        let short: String = commit.chars().take(12).collect();
        if self.run.git_dirty == Some(true) { short + "+" } else { short }
    }

    /// The triangles of a group's scene.
    #[must_use]
    pub fn triangles(&self, group: &str) -> Option<u64> {
        let counted = self.counted.iter().find(|(name, _, _)| name == group)?;
        Some(counted.1)
    }

    /// The histogram of a group: `histogram[n]` pixels have `n` fragments.
    #[must_use]
    pub fn histogram(&self, group: &str) -> Option<&[u64]> {
        let counted = self.counted.iter().find(|(name, _, _)| name == group)?;
        Some(&counted.2)
    }

    /// The fragments of all pixels of a group.
    #[must_use]
    pub fn total_fragments(&self, group: &str) -> Option<u64> {
        self.histogram(group).map(total_fragments)
    }
}

/// The fragments of a histogram. A damaged one must not overflow.
pub(crate) fn total_fragments(histogram: &[u64]) -> u64 {
    (0_u64..)
        .zip(histogram)
        .fold(0, |sum, (n, &pixels)| sum.saturating_add(n.saturating_mul(pixels)))
}

fn last_parts(folder: &Path, parts: usize) -> String {
    let all: Vec<String> =
        folder.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    all[all.len().saturating_sub(parts)..].join("/")
}
