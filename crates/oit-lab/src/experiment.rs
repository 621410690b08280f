//! Experiment files: axes that expand to cells.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use oit_capture::CAPTURES;
use oit_fragments::Ties;
use oit_record::Cell;
use oit_scene::{Fault, Problem, SceneEntry, SceneError, parse_toml};
use oit_sort::SortChoice;
use serde::Deserialize;
use toml::Spanned;

use crate::engine::FrameSize;
use crate::technique::{
    MaxFrags, Pool, Schedule, Stage, Technique, TechniqueError, parse_capture, parse_max_frags,
    parse_pool, parse_schedule, parse_stage, parse_ties,
};

/// Values that replace a scene's parameters.
pub type Overrides = BTreeMap<String, toml::Value>;

/// An experiment: what is compared, and why.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Its name, the file's without its ending.
    pub name: String,
    /// Prose: what it shows.
    pub about: String,
    /// The paper, table or figure it reproduces.
    pub source: String,
    /// The file, whole.
    pub toml: String,
    /// The file's path.
    pub path: PathBuf,
    /// Seed of the order in which samples are taken.
    pub seed: u64,
    profiles: Profiles,
    sweeps: Vec<SweepFile>,
}

/// How much of an experiment is run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ProfileName {
    /// Small enough for two processor cores and no GPU.
    Quick,
    /// As in the papers.
    Full,
}

impl ProfileName {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Profiles {
    quick: Profile,
    full: Profile,
}

/// How an experiment is run in one profile.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Pixels a row, and rows.
    pub resolution: [u32; 2],
    /// Samples of each cell.
    pub samples: u32,
    /// Milliseconds that a view's techniques are run for, at least, before the first sample.
    pub warmup_ms: u64,
    /// Seconds after which a step of a cell is given up as hung.
    pub timeout_s: u64,
    /// Scene parameters of this profile, by scene.
    #[serde(default)]
    pub scene: BTreeMap<Spanned<String>, Overrides>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExperimentFile {
    about: String,
    source: String,
    #[serde(default)]
    seed: u64,
    profile: Profiles,
    sweep: Vec<SweepFile>,
}

/// One block of axes: every combination of them is a cell.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    /// Techniques by name or alias, beside those of the axes.
    #[serde(default)]
    techniques: Vec<Spanned<String>>,
    #[serde(default)]
    captures: Vec<Spanned<String>>,
    #[serde(default)]
    schedules: Vec<Spanned<String>>,
    #[serde(default)]
    sorts: Vec<Spanned<String>>,
    #[serde(default)]
    stages: Vec<Spanned<String>>,
    #[serde(default)]
    max_frags: Vec<Spanned<toml::Value>>,
    #[serde(default)]
    ties: Vec<Spanned<String>>,
    #[serde(default)]
    pools: Vec<Spanned<toml::Value>>,
    views: Vec<Spanned<String>>,
    /// Scene parameters of this block, for all its scenes: one table, or several, each of them a
    /// scene of its own.
    #[serde(default)]
    scene: SceneParameters,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum SceneParameters {
    One(Overrides),
    Several(Vec<Overrides>),
}

impl Default for SceneParameters {
    fn default() -> Self {
        Self::One(Overrides::new())
    }
}

impl SceneParameters {
    fn each(&self) -> &[Overrides] {
        match self {
            Self::One(overrides) => std::slice::from_ref(overrides),
            Self::Several(several) => several,
        }
    }
}

/// One cell that an experiment asks for.
#[derive(Clone, Debug)]
pub struct PlannedCell {
    /// What it is called in records.
    pub cell: Cell,
    /// Its technique.
    pub technique: Technique,
    /// Its scene's file.
    pub scene: PathBuf,
    /// The scene's parameters that differ from its file.
    pub overrides: Overrides,
    /// The frame's size.
    pub size: FrameSize,
}

impl PlannedCell {
    /// The cell in one line, `technique scene:view@size`: what `--only` is matched with and what
    /// progress is told by.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} {}", self.cell.technique, self.cell.group())
    }
}

/// Why an experiment cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A mistake in the file.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// The scenes cannot be listed.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// The place of a word in an experiment file, for errors.
struct Place<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Place<'_> {
    fn fault<T>(&self, word: &Spanned<T>, problem: Problem) -> Fault {
        Fault::at(self.path, self.text, word.span(), problem)
    }

    fn technique<T, W>(
        &self,
        word: &Spanned<W>,
        parsed: Result<T, TechniqueError>,
    ) -> Result<T, Fault> {
        parsed.map_err(|error| self.fault(word, Problem::Invalid(error.to_string())))
    }

    /// The values of one axis: each word parsed, `all` standing for every value; a default where
    /// the axis is not given.
    fn axis<T: Clone>(
        &self,
        words: &[Spanned<String>],
        default: &[T],
        all: &[T],
        parse: impl Fn(&str) -> Result<T, TechniqueError>,
    ) -> Result<Vec<T>, Fault> {
        if words.is_empty() {
            return Ok(default.to_vec());
        }
        let mut values = Vec::new();
        for word in words {
            if word.get_ref() == "all" {
                values.extend_from_slice(all);
            } else {
                values.push(self.technique(word, parse(word.get_ref()))?);
            }
        }
        Ok(values)
    }

    /// The values of an axis of words and numbers.
    fn numbers<T>(
        &self,
        words: &[Spanned<toml::Value>],
        default: T,
        parse: impl Fn(&str) -> Result<T, TechniqueError>,
    ) -> Result<Vec<T>, Fault> {
        if words.is_empty() {
            return Ok(vec![default]);
        }
        let parsed = words.iter().map(|word| match word.get_ref() {
            toml::Value::String(text) => self.technique(word, parse(text)),
            other => self.technique(word, parse(&other.to_string())),
        });
        parsed.collect()
    }
}

impl Experiment {
    /// Reads an experiment file.
    ///
    /// # Errors
    /// Where it cannot be read, or holds a key or type that is not of the format.
    pub fn load(path: &Path) -> Result<Self, ExperimentError> {
        let io_error = |source| ExperimentError::Io { path: path.to_owned(), source };
        Ok(Self::parse(path, std::fs::read_to_string(path).map_err(io_error)?)?)
    }

    /// An experiment from its text; `path` names it in errors and gives it its name.
    ///
    /// # Errors
    /// Where the text holds a key or type that is not of the format.
    pub fn parse(path: &Path, toml: String) -> Result<Self, Fault> {
        let file: ExperimentFile = parse_toml(path, &toml)?;
        for profile in [&file.profile.quick, &file.profile.full] {
            let invalid = |what: &str| Fault {
                path: path.to_owned(),
                line: None,
                problem: Problem::Invalid(what.into()),
            };
            if profile.resolution.iter().any(|&n| n == 0 || n > 16384) {
                return Err(invalid("a profile's resolution lies between 1 and 16384"));
            }
            if profile.samples == 0 || profile.timeout_s == 0 {
                return Err(invalid("a profile needs samples and a timeout_s above 0"));
            }
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self {
            name,
            about: file.about,
            source: file.source,
            path: path.to_owned(),
            seed: file.seed,
            profiles: file.profile,
            sweeps: file.sweep,
            toml,
        })
    }

    /// One of its profiles.
    #[must_use]
    pub fn profile(&self, name: ProfileName) -> &Profile {
        match name {
            ProfileName::Quick => &self.profiles.quick,
            ProfileName::Full => &self.profiles.full,
        }
    }

    /// Its cells, each once, those of one view together.
    ///
    /// # Errors
    /// Where a word names nothing: a technique, a value of an axis, a scene, a view.
    pub fn cells(
        &self,
        profile: ProfileName,
        scenes: &[SceneEntry],
    ) -> Result<Vec<PlannedCell>, ExperimentError> {
        let place = Place { path: &self.path, text: &self.toml };
        let profile = self.profile(profile);
        for name in profile.scene.keys() {
            scene(&place, name, name.get_ref(), scenes)?;
        }
        let [width_px, height_px] = profile.resolution;
        let size = FrameSize { width_px, height_px };
        let mut cells: Vec<PlannedCell> = Vec::new();
        let mut known = BTreeSet::new();
        for sweep in &self.sweeps {
            let techniques = sweep.techniques(&place)?;
            for word in &sweep.views {
                for (entry, view) in views(&place, word, scenes)? {
                    let named =
                        profile.scene.iter().find(|(name, _)| *name.get_ref() == entry.name);
                    for parameters in sweep.scene.each() {
                        let mut overrides = named.map_or_else(Overrides::new, |(_, o)| o.clone());
                        overrides.extend(parameters.clone());
                        for technique in &techniques {
                            let cell = Cell {
                                technique: technique.to_string(),
                                scene: scene_name(&entry.name, &overrides),
                                view: view.clone(),
                                width_px,
                                height_px,
                            };
                            if known.insert(cell.clone()) {
                                cells.push(PlannedCell {
                                    cell,
                                    technique: technique.clone(),
                                    scene: entry.path.clone(),
                                    overrides: overrides.clone(),
                                    size,
                                });
                            }
                        }
                    }
                }
            }
        }
        // Cells of one view from several blocks come together, in the order views first appear.
        let mut order: Vec<String> = Vec::new();
        for cell in &cells {
            let group = cell.cell.group();
            if !order.contains(&group) {
                order.push(group);
            }
        }
        cells.sort_by_key(|cell| order.iter().position(|group| *group == cell.cell.group()));
        Ok(cells)
    }
}

impl SweepFile {
    fn techniques(&self, place: &Place) -> Result<Vec<Technique>, Fault> {
        let mut techniques = Vec::new();
        for word in &self.techniques {
            techniques.push(place.technique(word, word.get_ref().parse())?);
        }
        if self.sorts.is_empty() {
            let axes = [&self.captures, &self.schedules, &self.stages, &self.ties];
            if let Some(word) = axes.iter().find_map(|axis| axis.first()) {
                let problem = Problem::Invalid("axes need `sorts` to make techniques".into());
                return Err(place.fault(word, problem));
            }
            return Ok(techniques);
        }
        let all = CAPTURES.to_vec();
        let captures = place.axis(&self.captures, &all[..1], &all, parse_capture)?;
        let all = Schedule::ALL.map(|(schedule, ..)| schedule);
        let schedules = place.axis(&self.schedules, &all[..1], &all, parse_schedule)?;
        let stages = place.axis(&self.stages, &Stage::SHADERS, &Stage::ALL, parse_stage)?;
        let ties = place.axis(&self.ties, &[Ties::Total], &Ties::ALL, parse_ties)?;
        let parse_sort = |text: &str| Ok(text.parse()?);
        let sorts = place.axis(&self.sorts, &[], &SortChoice::all(), parse_sort)?;
        let sizes = place.numbers(&self.max_frags, MaxFrags::Peak, parse_max_frags)?;
        let pools = place.numbers(&self.pools, Pool::WHOLE, parse_pool)?;
        // A schedule that is named runs in every stage that is named.
        for word in &self.schedules {
            let Ok(schedule) = parse_schedule(word.get_ref()) else { continue };
            let lacking = |stage: &&Stage| !stage.has(schedule);
            if let Some(stage) = stages.iter().find(lacking) {
                let (schedule, stage, needs) = (
                    word.get_ref().clone(),
                    stage.name(),
                    if schedule.masks_what_is_drawn() { "fragment" } else { "compute" },
                );
                return place
                    .technique(word, Err(TechniqueError::Stage { schedule, needs, stage }));
            }
        }
        for &capture in &captures {
            for &schedule in &schedules {
                for sort in &sorts {
                    for &stage in &stages {
                        // Of `all` schedules those that the stage has.
                        if !stage.has(schedule) {
                            continue;
                        }
                        for &max_frags in &sizes {
                            for &ties in &ties {
                                for &pool in &pools {
                                    techniques.push(Technique {
                                        capture,
                                        schedule,
                                        sort: sort.clone(),
                                        stage,
                                        max_frags,
                                        ties,
                                        pool,
                                    });
                                }
                            }
                        }
                    }
                }
            }
        }
        Ok(techniques)
    }
}

fn scene<'a, T>(
    place: &Place,
    word: &Spanned<T>,
    name: &str,
    scenes: &'a [SceneEntry],
) -> Result<&'a SceneEntry, Fault> {
    scenes.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let names = scenes.iter().map(|entry| entry.name.as_str());
        place.fault(word, Problem::unknown("scene", name, names))
    })
}

/// `scene:view`, `scene:*`, or `scene` for all its views.
fn views<'a>(
    place: &Place,
    word: &Spanned<String>,
    scenes: &'a [SceneEntry],
) -> Result<Vec<(&'a SceneEntry, String)>, Fault> {
    let (name, view) = word.get_ref().split_once(':').unwrap_or((word.get_ref(), "*"));
    let entry = scene(place, word, name, scenes)?;
    if view == "*" {
        return Ok(entry.views.iter().map(|view| (entry, view.clone())).collect());
    }
    if entry.views.iter().any(|known| known == view) {
        return Ok(vec![(entry, view.to_owned())]);
    }
    let names = entry.views.iter().map(String::as_str);
    Err(place.fault(word, Problem::unknown("view", view, names)))
}

/// A scene as records name it: with the parameters that differ from its file.
#[must_use]
pub fn scene_name(scene: &str, overrides: &Overrides) -> String {
    if overrides.is_empty() {
        return scene.to_owned();
    }
    let values: Vec<String> =
        overrides.iter().map(|(key, value)| format!("{key}={value}")).collect();
    format!("{scene}{{{}}}", values.join(","))
}

/// The experiment files of a folder, sorted by name.
///
/// # Errors
/// Where the folder or a file cannot be read.
pub fn list_experiments(folder: &Path) -> Result<Vec<Experiment>, ExperimentError> {
    let io_error = |source| ExperimentError::Io { path: folder.to_owned(), source };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            paths.push(path);
        }
    }
    paths.sort();
    paths.iter().map(|path| Experiment::load(path)).collect()
}
