//! Experiment files: axes that expand to cells.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use oit_capture::CAPTURES;
use oit_fragments::Ties;
use oit_record::Cell;
use oit_scene::{
    Fault, Problem, SceneEntry, SceneError, frame_view, no_such_frame, parse_toml, split_frame_view,
};
use oit_sort::SortChoice;
use oit_spheres::{VARIATIONS, Variation, cross_product};
use serde::Deserialize;
use toml::Spanned;

use crate::engine::FrameSize;
use crate::method::{MethodChoice, methods, parse_method};
use crate::technique::{
    IntervalChoice, MaxFrags, Pool, Schedule, Sorted, Stage, Technique, TechniqueError,
    parse_capture, parse_intervals, parse_max_frags, parse_pool, parse_schedule, parse_stage,
    parse_ties, unknown,
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
    /// Both.
    pub const ALL: [Self; 2] = [Self::Quick, Self::Full];

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
    /// Whether structural similarity and FLIP of approximate pictures are recorded. FLIP takes a second
    /// or more of a cell at 1920x1080.
    #[serde(default)]
    pub perceptual: bool,
    /// How often a frame is run again after it was compared, to see whether its picture stays
    /// ([`oit_record::Stability`]). Where it is not given a frame is repeated once, and neither hashes
    /// nor changes from view to view are recorded.
    #[serde(default)]
    pub repeats: Option<u32>,
    /// Whether pictures are kept of cells that break ([`oit_record::Verification::breaks`]), with the
    /// right ones.
    #[serde(default)]
    pub keep_breaks: bool,
    /// Whether the device's bandwidth is measured, and the work of each cell's passes counted. On frames
    /// of camera paths that is done where they are verified in full.
    #[serde(default)]
    pub work: bool,
    /// How frames of camera paths are run.
    #[serde(default)]
    pub path: PathProfile,
    /// Scene parameters of this profile, by scene.
    #[serde(default)]
    pub scene: BTreeMap<Spanned<String>, Overrides>,
}

/// How the frames of a camera path are run in one profile.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathProfile {
    /// The most frames that `path@*` stands for, evenly spaced; all of them where not given.
    pub frames: Option<u32>,
    /// Milliseconds that a frame's techniques are run for, at least, where the frame before it was
    /// of the same path; `warmup_ms` where not given.
    pub warmup_ms: Option<u64>,
    /// Of the frames that one `path@*` stands for, every so manieth is verified in full, the first
    /// among them, and the others by their pictures; every one is in full where not given.
    pub full_every: Option<u32>,
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
    /// The profiles that run this block; both where none is named.
    #[serde(default)]
    profiles: Vec<Spanned<String>>,
    /// Techniques by name or alias, beside those of the axes.
    #[serde(default)]
    techniques: Vec<Spanned<String>>,
    /// Methods by name, `all` for every one in its default size. The axes are not theirs.
    #[serde(default)]
    methods: Vec<Spanned<String>>,
    /// Ways of drawing spheres by name: `all` for those of the thesis's tables and those past it. A `*`
    /// stands for every value of an axis.
    #[serde(default)]
    spheres: Vec<Spanned<String>>,
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
    /// Words, and arrays of upper bounds.
    #[serde(default)]
    intervals: Vec<Spanned<toml::Value>>,
    views: Vec<Spanned<String>>,
    /// Whether pictures of these cells are kept beside the record.
    #[serde(default)]
    keep_images: bool,
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
    /// The camera path whose frame the view is, if it is one.
    pub camera_path: Option<String>,
    /// Whether the fragments are compared too, and not only the picture.
    pub in_full: bool,
    /// Whether its pictures are kept beside the record.
    pub keep_images: bool,
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

    /// The values of an axis of words, numbers and lists of numbers.
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
            // A list is written as it is in a technique's name.
            toml::Value::Array(list) => {
                let list: Vec<String> = list.iter().map(toml::Value::to_string).collect();
                self.technique(word, parse(&list.join("-")))
            }
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
            if profile.repeats.is_some_and(|repeats| !(1..=1000).contains(&repeats)) {
                return Err(invalid("a profile's `repeats` lie between 1 and 1000"));
            }
            if profile.path.frames == Some(0) || profile.path.full_every == Some(0) {
                return Err(invalid("`path.frames` and `path.full_every` are above 0"));
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
        name: ProfileName,
        scenes: &[SceneEntry],
    ) -> Result<Vec<PlannedCell>, ExperimentError> {
        let place = Place { path: &self.path, text: &self.toml };
        let profile = self.profile(name);
        for word in profile.scene.keys() {
            scene(&place, word, word.get_ref(), scenes)?;
        }
        let [width_px, height_px] = profile.resolution;
        let size = FrameSize { width_px, height_px };
        let mut cells: Vec<PlannedCell> = Vec::new();
        let mut known = BTreeSet::new();
        for sweep in &self.sweeps {
            let profiles =
                place.axis(&sweep.profiles, &ProfileName::ALL, &ProfileName::ALL, |text| {
                    let found = ProfileName::ALL.into_iter().find(|profile| profile.name() == text);
                    found.ok_or_else(|| {
                        unknown("profile", text, ProfileName::ALL.map(ProfileName::name))
                    })
                })?;
            let techniques = sweep.techniques(&place)?;
            let views_now: &[_] = if profiles.contains(&name) { &sweep.views } else { &[] };
            for word in views_now {
                for MeantView { entry, view, camera_path, in_full } in
                    views(&place, word, scenes, &profile.path)?
                {
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
                                    camera_path: camera_path.clone(),
                                    in_full,
                                    keep_images: sweep.keep_images,
                                });
                            } else if sweep.keep_images {
                                let same = cells.iter_mut().find(|known| known.cell == cell);
                                same.into_iter().for_each(|known| known.keep_images = true);
                            }
                        }
                    }
                }
            }
        }
        // Cells of one view from several blocks come together, in the order views first appear.
        let mut order: HashMap<String, usize> = HashMap::new();
        for cell in &cells {
            let next = order.len();
            order.entry(cell.cell.group()).or_insert(next);
        }
        cells.sort_by_cached_key(|cell| order.get(&cell.cell.group()).copied());
        Ok(cells)
    }
}

impl SweepFile {
    fn techniques(&self, place: &Place) -> Result<Vec<Technique>, Fault> {
        let mut techniques = Vec::new();
        for word in &self.techniques {
            techniques.push(place.technique(word, word.get_ref().parse())?);
        }
        let all: Vec<MethodChoice> = methods().map(MethodChoice::new).collect();
        let methods = place.axis(&self.methods, &[], &all, parse_method)?;
        techniques.extend(methods.into_iter().map(Technique::Method));
        for word in &self.spheres {
            match word.get_ref().as_str() {
                "all" => techniques.extend(VARIATIONS.iter().map(|name| {
                    Technique::Spheres(name.parse().expect("the registry's names are names"))
                })),
                name if name.contains('*') => {
                    let like = |variation: &Variation| matches(name, &variation.to_string());
                    let before = techniques.len();
                    techniques.extend(cross_product().filter(like).map(Technique::Spheres));
                    if techniques.len() == before {
                        let problem = "no way of drawing spheres is called like this".into();
                        return Err(place.fault(word, Problem::Invalid(problem)));
                    }
                }
                name => techniques.push(place.technique(word, name.parse())?),
            }
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
        let intervals =
            place.numbers(&self.intervals, IntervalChoice::PowersOfTwo, parse_intervals)?;
        let one_program = self.schedules.iter().filter(|word| word.get_ref() != "all");
        let one_program = one_program.filter_map(|word| parse_schedule(word.get_ref()).ok());
        for schedule in one_program.chain(self.schedules.is_empty().then_some(schedules[0])) {
            for (word, choice) in self.intervals.iter().zip(&intervals) {
                place.technique(word, schedule.admits(choice))?;
            }
        }
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
                                    // Of `all` schedules those that have intervals.
                                    let intervals =
                                        intervals.iter().filter(|i| schedule.admits(i).is_ok());
                                    techniques.extend(intervals.map(|intervals| {
                                        Technique::Sorted(Sorted {
                                            capture,
                                            schedule,
                                            sort: sort.clone(),
                                            stage,
                                            max_frags,
                                            ties,
                                            pool,
                                            intervals: intervals.clone(),
                                        })
                                    }));
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

/// Whether a name is like a pattern: word by word, where `*` stands for any word.
fn matches(pattern: &str, name: &str) -> bool {
    let same = |(a, b): (&str, &str)| a == "*" || a == b;
    pattern.split('/').count() == name.split('/').count()
        && pattern.split('/').zip(name.split('/')).all(same)
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

/// A view that a word of an experiment means.
struct MeantView<'a> {
    entry: &'a SceneEntry,
    view: String,
    camera_path: Option<String>,
    in_full: bool,
}

/// `scene:view`, `scene:*`, or `scene` for all its views; of a camera path `scene:path@7` for a
/// frame, `scene:path@*` for all, and `scene:path@*/10` for ten of them, evenly spaced.
fn views<'a>(
    place: &Place,
    word: &Spanned<String>,
    scenes: &'a [SceneEntry],
    profile: &PathProfile,
) -> Result<Vec<MeantView<'a>>, Fault> {
    let (name, view) = word.get_ref().split_once(':').unwrap_or((word.get_ref(), "*"));
    let entry = scene(place, word, name, scenes)?;
    let named =
        |view: &str| MeantView { entry, view: view.to_owned(), camera_path: None, in_full: true };
    if view == "*" {
        return Ok(entry.views.iter().map(|view| named(view)).collect());
    }
    if entry.views.iter().any(|known| known == view) {
        return Ok(vec![named(view)]);
    }
    let of_path = |wanted: &str| entry.paths.iter().find(|path| path.name == wanted);
    let frame_of = |path: &str, frame: u32, in_full: bool| MeantView {
        entry,
        view: frame_view(path, frame),
        camera_path: Some(path.to_owned()),
        in_full,
    };
    if let Some((wanted, frame)) = split_frame_view(view)
        && let Some(path) = of_path(wanted)
    {
        if frame >= path.frames {
            return Err(place.fault(word, no_such_frame(wanted, path.frames, frame)));
        }
        return Ok(vec![frame_of(wanted, frame, true)]);
    }
    if let Some((wanted, share)) = view.split_once("@*")
        && let Some(path) = of_path(wanted)
    {
        let asked = match share.strip_prefix('/').map(str::parse) {
            None if share.is_empty() => path.frames,
            Some(Ok(count)) if count > 0 => count,
            _ => {
                let sentence = format!("after `{wanted}@*` comes nothing, or `/` and a number");
                return Err(place.fault(word, Problem::Invalid(sentence)));
            }
        };
        let count = asked.min(profile.frames.unwrap_or(u32::MAX)).min(path.frames);
        let every = profile.full_every.unwrap_or(1);
        // In 64 bits: frames and counts are at most ten thousand each, but need not stay so.
        let frame = |index: u32| u64::from(index) * u64::from(path.frames) / u64::from(count);
        let frames = (0..count).map(|index| (index, frame(index) as u32));
        return Ok(frames.map(|(i, frame)| frame_of(wanted, frame, i % every == 0)).collect());
    }
    let frames = entry.paths.iter().map(|path| format!("{}@*", path.name));
    let frames: Vec<String> = frames.collect();
    let names = entry.views.iter().chain(&frames).map(String::as_str);
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
