//! Tuning files: what was measured on a device, for techniques that leave a choice to it. A file a
//! device and backend, written by `oit tune`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use oit_bma::{ArrayCost, CostPoint};
use oit_record::{DeviceInfo, Run};
use oit_scene::{Fault, Problem, parse_toml};
use oit_sort::SortPart;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::technique::DEEPEST;

/// The version of the format. A file of another one is refused: its costs may mean something else.
pub const TUNING_VERSION: u32 = 1;

/// A larger file is no tuning file: one has a few kilobytes.
const MOST_BYTES: u64 = 1 << 22;

/// What was measured on one device through one backend.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuning {
    /// [`TUNING_VERSION`] of the writer.
    pub version: u32,
    /// The device, as its driver names it.
    pub device: String,
    /// The backend.
    pub backend: String,
    /// The fastest strategies: what `auto` stands for.
    #[serde(default, rename = "fastest", skip_serializing_if = "Vec::is_empty")]
    pub fastest: Vec<Fastest>,
    /// What intervals cost.
    #[serde(default, rename = "interval", skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<IntervalCost>,
    /// What pixels cost.
    #[serde(default, rename = "pixel", skip_serializing_if = "Vec::is_empty")]
    pub pixels: Vec<PixelCost>,
}

/// The run that numbers are from.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FromRun {
    /// The experiment.
    pub experiment: String,
    /// Its profile.
    pub profile: String,
    /// When the run was started, UTC.
    pub started: String,
    /// The commit of the program that ran it, with `+` where sources differed from it.
    pub commit: String,
    /// The driver.
    pub driver: String,
}

/// The fastest strategy for each size of array, for one capture in one stage.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fastest {
    /// The capture.
    pub capture: String,
    /// The stage in which programs run.
    pub stage: String,
    /// The tie rule.
    pub ties: String,
    /// `[max_frags, strategy and store, nanoseconds a pixel]`, sizes rising. A size between two has
    /// the strategy of the larger.
    pub sizes: Vec<(u32, String, f64)>,
    /// Where the numbers are from.
    pub run: FromRun,
}

/// What one more interval costs, for one capture and schedule.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntervalCost {
    /// The capture.
    pub capture: String,
    /// The schedule, by the name in coordinates: `bma-stencil`, `bma-list`.
    pub schedule: String,
    /// Pixels of the frame it was measured on.
    pub frame_px: u64,
    /// Nanoseconds of an interval without pixels.
    pub interval_ns: f64,
    /// Nanoseconds to group pixels, less those of the intervals.
    pub grouping_ns: f64,
    /// Where the numbers are from.
    pub run: FromRun,
}

/// What a pixel costs, for one capture in one stage, sorted by one strategy.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelCost {
    /// The capture.
    pub capture: String,
    /// The stage in which programs run.
    pub stage: String,
    /// The tie rule.
    pub ties: String,
    /// Strategy and store.
    pub sort: String,
    /// `[max_frags, fragments, nanoseconds a pixel]`.
    pub points: Vec<(u32, u32, f64)>,
    /// Where the numbers are from.
    pub run: FromRun,
}

/// Why a tuning file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TuningError {
    /// The file system refused.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        error: io::Error,
    },
    /// A mistake in the file.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// It is larger than any tuning file.
    #[error("{}: {bytes} bytes are no tuning file", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// It was written by another version of this program.
    #[error("{}: version {found}, this program reads version {TUNING_VERSION}; make it again with `oit tune`", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
}

impl FromRun {
    /// The run a record is of.
    #[must_use]
    pub fn run(run: &Run) -> Self {
        let commit = run.git_commit.clone().unwrap_or_default();
        let dirty = if run.git_dirty == Some(true) { "+" } else { "" };
        Self {
            experiment: run.experiment.clone(),
            profile: run.profile.clone(),
            started: run.started.clone(),
            commit: commit + dirty,
            driver: run.device.driver.clone(),
        }
    }
}

impl Fastest {
    fn key(&self) -> (&str, &str, &str) {
        (&self.capture, &self.stage, &self.ties)
    }

    fn check(&self) -> Result<(), String> {
        let rises = self.sizes.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if self.sizes.is_empty() || !rises {
            return Err("sizes that do not rise, or none".into());
        }
        for (max_frags, sort, ns) in &self.sizes {
            let part: SortPart = sort.parse().map_err(|error| format!("{error}"))?;
            if part.most.is_some() || part.strategy.limit().is_some_and(|most| most < *max_frags) {
                return Err(format!("{sort} does not hold {max_frags} fragments"));
            }
            if !(1..=DEEPEST).contains(max_frags) || !is_time(*ns) {
                return Err(format!("no time of {max_frags} fragments: {ns} ns"));
            }
        }
        Ok(())
    }
}

impl IntervalCost {
    fn key(&self) -> (&str, &str) {
        (&self.capture, &self.schedule)
    }

    fn check(&self) -> Result<(), String> {
        if self.frame_px == 0 || !is_time(self.interval_ns) || !is_time(self.grouping_ns) {
            let Self { frame_px, interval_ns, grouping_ns, .. } = self;
            return Err(format!(
                "no times: {interval_ns} and {grouping_ns} ns of {frame_px} pixels"
            ));
        }
        Ok(())
    }
}

impl PixelCost {
    fn key(&self) -> (&str, &str, &str, &str) {
        (&self.capture, &self.stage, &self.ties, &self.sort)
    }

    fn check(&self) -> Result<(), String> {
        let part: SortPart = self.sort.parse().map_err(|error| format!("{error}"))?;
        if part.to_string() != self.sort || part.most.is_some() {
            return Err(format!("{:?} is no strategy with its store", self.sort));
        }
        if let Some((size, ..)) = self.points.iter().find(|(size, ..)| *size > DEEPEST) {
            return Err(format!("an array of {size}: techniques hold up to {DEEPEST}"));
        }
        self.cost().map(|_| ())
    }

    /// The same as a cost to ask.
    pub(crate) fn cost(&self) -> Result<ArrayCost, String> {
        let point = |&(max_frags, depth, ns): &(u32, u32, f64)| CostPoint { max_frags, depth, ns };
        let points: Vec<CostPoint> = self.points.iter().map(point).collect();
        ArrayCost::from_points(&points).map_err(|error| error.to_string())
    }
}

fn is_time(ns: f64) -> bool {
    ns.is_finite() && ns >= 0.0
}

/// Where a device's tuning file lies in a folder.
#[must_use]
pub fn tuning_path(folder: &Path, device: &str, backend: &str) -> PathBuf {
    let name = format!("{device} {backend}").to_ascii_lowercase();
    let words: Vec<&str> =
        name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    folder.join(words.join("-") + ".toml")
}

impl Tuning {
    /// A tuning of nothing.
    #[must_use]
    pub fn of(device: &DeviceInfo) -> Self {
        let (device, backend) = (device.name.clone(), device.backend.clone());
        Self { version: TUNING_VERSION, device, backend, ..Self::default() }
    }

    /// Reads a tuning file.
    ///
    /// # Errors
    /// Where it cannot be read, is of another version, or holds what cannot have been measured; with
    /// the line.
    pub fn load(path: &Path) -> Result<Self, TuningError> {
        let io_error = |error| TuningError::Io { path: path.to_owned(), error };
        let bytes = fs::metadata(path).map_err(io_error)?.len();
        if bytes > MOST_BYTES {
            return Err(TuningError::TooLarge { path: path.to_owned(), bytes });
        }
        Self::parse(path, &fs::read_to_string(path).map_err(io_error)?)
    }

    /// A tuning file from its text; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Tuning::load`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, TuningError> {
        /// What every version has.
        #[derive(Deserialize)]
        struct Version {
            version: i64,
        }
        let Version { version: found } = parse_toml(path, text)?;
        if found != i64::from(TUNING_VERSION) {
            return Err(TuningError::Version { path: path.to_owned(), found });
        }
        let tuning: Self = parse_toml(path, text)?;
        match tuning.check() {
            Ok(()) => Ok(tuning),
            Err((list, place, what)) => {
                Err(Fault { line: line(text, list, place), ..fault(path, what) }.into())
            }
        }
    }

    /// What is wrong, and in which entry of which list.
    fn check(&self) -> Result<(), (&'static str, usize, String)> {
        fn each<T>(
            list: &'static str,
            entries: &[T],
            same: impl Fn(&T, &T) -> bool,
            check: impl Fn(&T) -> Result<(), String>,
        ) -> Result<(), (&'static str, usize, String)> {
            for (place, entry) in entries.iter().enumerate() {
                check(entry).map_err(|what| (list, place, what))?;
                if entries[..place].iter().any(|other| same(other, entry)) {
                    return Err((list, place, "the same is there before".into()));
                }
            }
            Ok(())
        }
        each("fastest", &self.fastest, |a, b| a.key() == b.key(), Fastest::check)?;
        each("interval", &self.intervals, |a, b| a.key() == b.key(), IntervalCost::check)?;
        each("pixel", &self.pixels, |a, b| a.key() == b.key(), PixelCost::check)
    }

    /// The file's text.
    #[must_use]
    pub fn text(&self) -> String {
        let head =
            "# Measured on the device; written by `oit tune`. docs/METHODOLOGY.md says how.\n";
        head.to_owned() + &toml::to_string(self).expect("numbers and words are TOML")
    }

    /// Takes over what a newer tuning of the same device has, and keeps the rest.
    pub fn update(&mut self, newer: Self) {
        for entry in newer.fastest {
            self.fastest.retain(|old| old.key() != entry.key());
            self.fastest.push(entry);
        }
        for entry in newer.intervals {
            self.intervals.retain(|old| old.key() != entry.key());
            self.intervals.push(entry);
        }
        for entry in newer.pixels {
            self.pixels.retain(|old| old.key() != entry.key());
            self.pixels.push(entry);
        }
        self.fastest.sort_by(|a, b| a.key().cmp(&b.key()));
        self.intervals.sort_by(|a, b| a.key().cmp(&b.key()));
        self.pixels.sort_by(|a, b| a.key().cmp(&b.key()));
    }
}

fn fault(path: &Path, what: String) -> Fault {
    Fault { path: path.to_owned(), line: None, problem: Problem::Invalid(what) }
}

/// The line of an entry of a list, from 1.
fn line(text: &str, list: &str, place: usize) -> Option<usize> {
    #[derive(Deserialize)]
    struct Places {
        #[serde(default)]
        fastest: Vec<Spanned<IgnoredAny>>,
        #[serde(default)]
        interval: Vec<Spanned<IgnoredAny>>,
        #[serde(default)]
        pixel: Vec<Spanned<IgnoredAny>>,
    }
    let places: Places = toml::from_str(text).ok()?;
    let entries = match list {
        "fastest" => places.fastest,
        "interval" => places.interval,
        _ => places.pixel,
    };
    let start = entries.get(place)?.span().start;
    Some(1 + text.bytes().take(start).filter(|byte| *byte == b'\n').count())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from() -> FromRun {
        FromRun { experiment: "a".into(), profile: "full".into(), ..FromRun::default() }
    }

    fn tuning() -> Tuning {
        let words = |capture: &str| (capture.to_owned(), "compute".to_owned(), "total".to_owned());
        let (capture, stage, ties) = words("linked_list");
        let sizes = vec![(8, "network".to_owned(), 0.5), (128, "rbs".to_owned(), 3.25)];
        let fastest = Fastest { capture, stage, ties, sizes, run: from() };
        let (capture, stage, ties) = words("linked_list");
        let points = vec![(8, 1, 0.25), (8, 8, 1.0)];
        let pixel = PixelCost { capture, stage, ties, sort: "rbs".into(), points, run: from() };
        let interval = IntervalCost {
            capture: "linked_list".into(),
            schedule: "bma-list".into(),
            frame_px: 100,
            interval_ns: 4000.0,
            grouping_ns: 10.5,
            run: from(),
        };
        Tuning {
            version: TUNING_VERSION,
            device: "A device".into(),
            backend: "vulkan".into(),
            fastest: vec![fastest],
            intervals: vec![interval],
            pixels: vec![pixel],
        }
    }

    fn error(text: &str) -> String {
        Tuning::parse(Path::new("x.toml"), text).expect_err("a mistake").to_string()
    }

    #[test]
    fn a_file_reads_back() {
        let text = tuning().text();
        assert_eq!(Tuning::parse(Path::new("x.toml"), &text).expect("undamaged"), tuning());
        let path = tuning_path(Path::new("t"), "NVIDIA H200 (2)", "vulkan");
        assert_eq!(path, Path::new("t/nvidia-h200-2-vulkan.toml"));
    }

    #[test]
    fn newer_numbers_take_the_place_of_older_ones() {
        let mut all = tuning();
        let mut newer = tuning();
        newer.fastest[0].capture = "linearized".into();
        newer.pixels[0].points[0].2 = 0.125;
        newer.intervals.clear();
        all.update(newer);
        assert_eq!((all.fastest.len(), all.intervals.len(), all.pixels.len()), (2, 1, 1));
        assert_eq!(all.pixels[0].points[0].2, 0.125);
    }

    #[test]
    fn what_cannot_have_been_measured_is_named_with_its_line() {
        let good = tuning().text();
        let line = |word: &str| 1 + good.lines().position(|l| l.starts_with(word)).expect(word);
        let cases = [
            ("version = 1", "version = 2", "version 2"),
            ("0.25", "-0.25", "-0.25 ns"),
            ("[8, 1, 0.25]", "[8, 9, 0.25]", "9 fragments in an array of 8"),
            ("[8, 1, 0.25]", "[8, 8, 0.25]", "two costs"),
            ("[8, 1, 0.25]", "[9999, 1, 0.25]", "9999"),
            ("sort = \"rbs\"", "sort = \"rbs@8\"", "rbs@8"),
            ("sort = \"rbs\"", "sort = \"rsb\"", "rbs"),
            ("\"network\"", "\"netwrok\"", "network"),
            ("[128, \"rbs\"", "[128, \"network\"", "does not hold 128"),
            ("[128, \"rbs\"", "[8, \"rbs\"", "do not rise"),
            ("interval_ns = 4000.0", "interval_ns = nan", "no times"),
            ("frame_px = 100", "frame_px = -1", "-1"),
            ("backend", "backnd", "backend"),
        ];
        for (from, to, word) in cases {
            assert!(good.contains(from), "{from} in {good}");
            let text = error(&good.replacen(from, to, 1));
            assert!(text.contains("x.toml") && text.contains(word), "{from} to {to}: {text}");
        }
        let text = error(&good.replacen("0.25", "-0.25", 1));
        assert!(text.starts_with(&format!("x.toml:{}:", line("[[pixel]]"))), "{text}");
        let twice = format!("{good}{}", &good[good.find("[[pixel]]").expect("there")..]);
        assert!(error(&twice).contains("before"));
        assert!(error("").contains("version"));
        assert!(error("version = \u{0}").contains("x.toml:1"));
    }

    #[test]
    fn a_huge_file_is_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.toml");
        fs::File::create(&path).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
        let error = Tuning::load(&path).expect_err("too large").to_string();
        assert!(error.contains("no tuning file"), "{error}");
    }
}
