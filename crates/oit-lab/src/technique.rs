//! A technique's name: a coordinate, which says what is captured how, which pixels run which program
//! and how they sort; that of a method; or a way of drawing
//! spheres.

use std::fmt;
use std::str::FromStr;

use oit_bma::{Intervals, MOST_INTERVALS};
use oit_capture::{Capture, Method};
use oit_fragments::Ties;
use oit_scene::nearest;
use oit_sort::{ChoiceError, SortChoice};
use oit_spheres::{Variation, VariationError};

use crate::method::{MethodChoice, methods, parse_method};

/// One technique, by its name.
#[derive(Clone)]
pub enum Technique {
    /// It captures fragments and sorts them: a point on every axis.
    Sorted(Sorted),
    /// It is one whole.
    Method(MethodChoice),
    /// It draws spheres, opaque.
    Spheres(Variation),
}

/// A technique that captures fragments, sorts and composites them: a point on every axis. Its name is
/// that point, axis by axis: `capture/schedule/sort/stage/max`, then what is not the default:
/// `ties-depth`, `poolN` or `poolN-drop`, `intervalsA-B-C` or `intervals-optimal`.
#[derive(Clone)]
pub struct Sorted {
    /// How fragments are captured.
    pub capture: &'static dyn Capture,
    /// Which pixels run which program.
    pub schedule: Schedule,
    /// How a pixel's fragments are sorted.
    pub sort: SortChoice,
    /// Where resolve programs run.
    pub stage: Stage,
    /// How many fragments of a pixel they hold.
    pub max_frags: MaxFrags,
    /// What they compare.
    pub ties: Ties,
    /// Its pool of fragments.
    pub pool: Pool,
    /// Its intervals of depth complexity, for schedules that have several.
    pub intervals: IntervalChoice,
}

/// Which intervals of depth complexity have a program each.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub enum IntervalChoice {
    /// Powers of two from 8, as in the papers.
    #[default]
    PowersOfTwo,
    /// Those with these upper bounds, rising. They are cut to `max_frags`, and where they end below
    /// what must be held, one more reaches up to it ([`Intervals::within`]).
    Uppers(Vec<u32>),
    /// Those that cost least on the view by what was measured on the device.
    Optimal,
}

/// The word for the default.
const POWERS_OF_TWO: &str = "powers-of-two";

impl fmt::Display for IntervalChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PowersOfTwo => f.write_str(POWERS_OF_TWO),
            Self::Optimal => f.write_str("optimal"),
            Self::Uppers(uppers) => {
                let uppers: Vec<String> = uppers.iter().map(u32::to_string).collect();
                f.write_str(&uppers.join("-"))
            }
        }
    }
}

/// How large a pool is, and what happens where it is too small.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Pool {
    /// Room at first, in percent of what the view needs.
    pub percent: u32,
    /// What happens where that is too little.
    pub policy: PoolPolicy,
}

/// What happens where a pool is too small.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum PoolPolicy {
    /// A pool of the size that turned out to be needed takes its place, and the frame is rendered
    /// again. A sample is both attempts.
    Grow,
    /// What has no room is left out. Which fragments these are is the capture's affair: those that
    /// arrive last, or the farthest.
    Drop,
}

impl Pool {
    /// All that is needed.
    pub const WHOLE: Self = Self { percent: 100, policy: PoolPolicy::Grow };
}

impl fmt::Display for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let policy = if self.policy == PoolPolicy::Drop { "-drop" } else { "" };
        write!(f, "pool{}{policy}", self.percent)
    }
}

/// Which pixels run which resolve program.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Schedule {
    /// One program for all.
    Base,
    /// One program for all pixels that have fragments: the capture marks them in the stencil.
    BaseStencil,
    /// Backwards memory allocation: one program for each interval of depth complexity. Pixels are
    /// grouped by stencil in the fragment stage, by lists in the compute stage.
    Bma,
    /// The same where the capture counts fragments in the stencil, and intervals are resolved from
    /// the deepest to the shallowest. Fragment stage only, up to 255 fragments.
    BmaStencilCount,
    /// The program of [`Self::Base`] on one interval's pixels after another, grouped as under
    /// [`Self::Bma`]: what the base's one program takes for each interval.
    BaseIntervals,
}

/// Where resolve programs run.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Stage {
    /// A full-screen pass.
    Fragment,
    /// Compute.
    Compute,
    /// CUDA, on fragments that were captured once and copied (see METHODOLOGY.md).
    Cuda,
}

/// How many fragments of a pixel a resolve program holds.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum MaxFrags {
    /// The next power of two, from 8, that holds the peak depth complexity, as in the papers.
    Peak,
    /// This many: of deeper pixels the rest is left out.
    Exactly(u32),
}

/// Pixels deeper than this are beyond every strategy.
pub const DEEPEST: u32 = 4096;

impl Schedule {
    /// Every schedule, in the order they are listed, with what it does.
    pub const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Base, "base", "one resolve program for all pixels"),
        (
            Self::BaseStencil,
            "base-stencil",
            "one resolve program, in the fragment stage, for all pixels that have fragments: the \
             capture marks them in the stencil",
        ),
        (
            Self::Bma,
            "bma",
            "one resolve program for each interval of depth complexity: bma-stencil masks pixels \
             in the fragment stage, bma-list dispatches lists of pixels in the compute stage",
        ),
        (
            Self::BmaStencilCount,
            "bma-stencil-count",
            "bma in the fragment stage where the capture counts fragments in the stencil and \
             intervals are resolved in descending order; no interval may begin above 255",
        ),
        (
            Self::BaseIntervals,
            "base-intervals",
            "base's one program, with its array for the deepest pixel, on the pixels of one interval \
             after another, grouped as under bma: to time base by intervals, not to be fast",
        ),
    ];

    /// Whether it masks pixels by what the capture leaves in the stencil: then it has the fragment
    /// stage only, and a name in it that is its own.
    #[must_use]
    pub fn masks_what_is_drawn(self) -> bool {
        matches!(self, Self::BaseStencil | Self::BmaStencilCount)
    }

    /// Refuses intervals where it has one program.
    pub(crate) fn admits(self, intervals: &IntervalChoice) -> Result<(), TechniqueError> {
        if self.has_intervals() || *intervals == IntervalChoice::PowersOfTwo {
            return Ok(());
        }
        let name = Self::ALL.iter().find(|(schedule, ..)| *schedule == self);
        let schedule = name.map_or("", |(_, name, _)| *name).to_owned();
        let intervals = format!("intervals {intervals}");
        Err(TechniqueError::NoIntervals { schedule, intervals })
    }

    /// Whether it resolves the pixels of one interval of depth complexity after another.
    #[must_use]
    pub fn has_intervals(self) -> bool {
        matches!(self, Self::Bma | Self::BmaStencilCount | Self::BaseIntervals)
    }

    /// Whether it groups pixels by the counts of a capture: by masks or by lists.
    #[must_use]
    pub fn groups(self) -> bool {
        matches!(self, Self::Bma | Self::BaseIntervals)
    }
}

impl Stage {
    /// Every stage, in the order they are listed.
    pub const ALL: [Self; 3] = [Self::Fragment, Self::Compute, Self::Cuda];

    /// The stages of shaders, which every GPU has.
    pub const SHADERS: [Self; 2] = [Self::Fragment, Self::Compute];

    /// Whether programs of a schedule run in it.
    #[must_use]
    pub fn has(self, schedule: Schedule) -> bool {
        match self {
            Self::Fragment => true,
            Self::Compute => !schedule.masks_what_is_drawn(),
            // It has no stencil, and no list is made for it.
            Self::Cuda => schedule == Schedule::Base,
        }
    }

    /// The word for it in names.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fragment => "fragment",
            Self::Compute => "compute",
            Self::Cuda => "cuda",
        }
    }
}

impl MaxFrags {
    /// The array size for a scene of this peak depth complexity.
    #[must_use]
    pub fn for_peak(self, peak: u32) -> u32 {
        match self {
            Self::Peak => peak.max(8).next_power_of_two(),
            Self::Exactly(n) => n,
        }
    }

    /// Whether pixels of this depth lose fragments.
    #[must_use]
    pub fn truncates(self, peak: u32) -> bool {
        self.for_peak(peak) < peak
    }
}

impl fmt::Display for MaxFrags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Peak => f.write_str("peak"),
            Self::Exactly(n) => write!(f, "max{n}"),
        }
    }
}

/// The papers' names for techniques. Their programs run in the fragment stage or in CUDA, and compare
/// depth.
pub const ALIASES: &[(&str, &str)] = &[
    ("BASE-IS", "linked_list/base/insertion/fragment/peak/ties-depth"),
    ("BASE-IMS", "linked_list/base/insertion_merge/fragment/peak/ties-depth"),
    ("BASE-RBS-L", "linked_list/base/rbs/fragment/peak/ties-depth"),
    ("RBS-G", "linked_list/base/rbs-global/fragment/peak/ties-depth"),
    ("BMA-IS", "linked_list/bma-stencil/insertion/fragment/peak/ties-depth"),
    ("BMA-IMS", "linked_list/bma-stencil/insertion_merge/fragment/peak/ties-depth"),
    ("BMA-RBS-L", "linked_list/bma-stencil/rbs/fragment/peak/ties-depth"),
    // Of the BMA paper, with its own bounds between insertion and merge sort (section 4).
    ("OIT", "linked_list/base/insertion_merge64/fragment/peak/ties-depth"),
    ("BMA-OIT", "linked_list/bma-stencil/insertion@16+merge/fragment/peak/ties-depth"),
    ("CUDA-IS", "linked_list/base/insertion/cuda/peak/ties-depth"),
    ("CUDA-IMS", "linked_list/base/insertion_merge/cuda/peak/ties-depth"),
    ("CUDA-RBS-L", "linked_list/base/rbs/cuda/peak/ties-depth"),
];

impl Sorted {
    /// Its schedule as names have it: with how pixels are grouped in its stage.
    #[must_use]
    pub fn schedule_name(&self) -> &'static str {
        match (self.schedule, self.stage) {
            (Schedule::Base, _) => "base",
            (Schedule::BaseIntervals, _) => "base-intervals",
            (Schedule::BaseStencil, _) => "base-stencil",
            (Schedule::BmaStencilCount, _) => "bma-stencil-count",
            (Schedule::Bma, Stage::Fragment) => "bma-stencil",
            (Schedule::Bma, Stage::Compute | Stage::Cuda) => "bma-list",
        }
    }
}

impl fmt::Display for Sorted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let schedule = self.schedule_name();
        let stage = self.stage.name();
        write!(f, "{}/{schedule}/{}/{stage}/{}", self.capture.name(), self.sort, self.max_frags)?;
        if self.ties == Ties::Depth {
            f.write_str("/ties-depth")?;
        }
        if self.pool != Pool::WHOLE {
            write!(f, "/{}", self.pool)?;
        }
        match &self.intervals {
            IntervalChoice::PowersOfTwo => Ok(()),
            IntervalChoice::Optimal => f.write_str("/intervals-optimal"),
            uppers @ IntervalChoice::Uppers(_) => write!(f, "/intervals{uppers}"),
        }
    }
}

impl fmt::Debug for Sorted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Technique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sorted(sorted) => sorted.fmt(f),
            Self::Method(choice) => choice.fmt(f),
            Self::Spheres(variation) => variation.fmt(f),
        }
    }
}

impl fmt::Debug for Technique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<Sorted> for Technique {
    fn from(sorted: Sorted) -> Self {
        Self::Sorted(sorted)
    }
}

impl From<MethodChoice> for Technique {
    fn from(choice: MethodChoice) -> Self {
        Self::Method(choice)
    }
}

/// Why a text names no technique.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum TechniqueError {
    /// A word of the name is not known on its axis.
    #[error("no {axis} is called {word:?}; there is {}", .valid.join(", "))]
    Unknown {
        /// The axis.
        axis: &'static str,
        /// The word.
        word: String,
        /// The nearest valid words, or all.
        valid: Vec<String>,
    },
    /// The name has too few or too many parts.
    #[error(
        "{0:?} is not of the form \
         capture/schedule/sort/stage/max[/ties-depth][/poolN[-drop]][/intervalsA-B-C]"
    )]
    Form(String),
    /// What stands for intervals is no list of bounds.
    #[error(
        "no intervals are called {word:?} ({why}); there is {POWERS_OF_TWO}, optimal, and upper \
         bounds that rise, as 4-12-40"
    )]
    Intervals {
        /// What stands there.
        word: String,
        /// What is wrong with it.
        why: String,
    },
    /// What stands after a method's name is not its size.
    #[error("{name} has no size {word:?}: {expected}")]
    Size {
        /// The method.
        name: &'static str,
        /// What stands there.
        word: String,
        /// What may stand there.
        expected: String,
    },
    /// Intervals for a schedule that has but one program.
    #[error("{schedule} has one program for all pixels: {intervals} has no meaning with it")]
    NoIntervals {
        /// The schedule.
        schedule: String,
        /// The intervals asked for.
        intervals: String,
    },
    /// The sort names no strategy, or no store of it.
    #[error(transparent)]
    Sort(#[from] ChoiceError),
    /// No way of drawing spheres.
    #[error(transparent)]
    Spheres(#[from] VariationError),
    /// A schedule and a stage that do not go together.
    #[error("{schedule} runs in the {needs} stage, not in the {stage} stage")]
    Stage {
        /// The schedule.
        schedule: String,
        /// Its stage.
        needs: &'static str,
        /// The stage given.
        stage: &'static str,
    },
}

/// An error for a word that is not on an axis, with the nearest words that are.
pub(crate) fn unknown<'a>(
    axis: &'static str,
    word: &str,
    valid: impl IntoIterator<Item = &'a str>,
) -> TechniqueError {
    let valid: Vec<&str> = valid.into_iter().collect();
    let mut near = nearest(word, valid.iter().copied());
    if near.is_empty() {
        near = valid.iter().map(|&word| word.to_owned()).collect();
    }
    TechniqueError::Unknown { axis, word: word.to_owned(), valid: near }
}

/// The stage of this name.
///
/// # Errors
/// Where there is none.
pub fn parse_stage(text: &str) -> Result<Stage, TechniqueError> {
    let found = Stage::ALL.into_iter().find(|stage| stage.name() == text);
    found.ok_or_else(|| unknown("stage", text, Stage::ALL.map(Stage::name)))
}

/// The tie rule of this name.
///
/// # Errors
/// Where there is none.
pub fn parse_ties(text: &str) -> Result<Ties, TechniqueError> {
    let found = Ties::ALL.into_iter().find(|ties| ties.name() == text);
    found.ok_or_else(|| unknown("tie rule", text, Ties::ALL.map(Ties::name)))
}

/// The capture of this name.
///
/// # Errors
/// Where there is none.
pub fn parse_capture(text: &str) -> Result<&'static dyn Capture, TechniqueError> {
    oit_capture::capture(text).map_err(|_| {
        unknown("capture", text, oit_capture::CAPTURES.iter().map(|capture| capture.name()))
    })
}

/// The schedule of this name.
///
/// # Errors
/// Where there is none.
pub fn parse_schedule(text: &str) -> Result<Schedule, TechniqueError> {
    let found = Schedule::ALL.iter().find(|(_, name, _)| *name == text);
    found
        .map(|(schedule, ..)| *schedule)
        .ok_or_else(|| unknown("schedule", text, Schedule::ALL.iter().map(|(_, name, _)| *name)))
}

/// `peak`, `maxN` or `N`.
///
/// # Errors
/// Where the text is neither, or the number is 0 or above [`DEEPEST`].
pub fn parse_max_frags(text: &str) -> Result<MaxFrags, TechniqueError> {
    if text == "peak" {
        return Ok(MaxFrags::Peak);
    }
    match text.strip_prefix("max").unwrap_or(text).parse::<u32>() {
        Ok(n) if (1..=DEEPEST).contains(&n) => Ok(MaxFrags::Exactly(n)),
        _ => Err(unknown("max_frags", text, ["peak", "max8", "max16", "max32", "max4096"])),
    }
}

/// `N` or `N-drop`: percent of what a view needs.
///
/// # Errors
/// Where the text is neither, or the number is 0.
pub fn parse_pool(text: &str) -> Result<Pool, TechniqueError> {
    let (number, policy) = match text.strip_suffix("-drop") {
        Some(number) => (number, PoolPolicy::Drop),
        None => (text, PoolPolicy::Grow),
    };
    match number.parse() {
        Ok(percent @ 1..) => Ok(Pool { percent, policy }),
        _ => Err(unknown("pool", text, ["100", "50", "50-drop"])),
    }
}

/// `powers-of-two`, `optimal`, or upper bounds joined by `-`.
///
/// # Errors
/// Where the text is none of them: bounds that do not rise, that are 0 or above [`DEEPEST`], or more
/// than [`MOST_INTERVALS`].
pub fn parse_intervals(text: &str) -> Result<IntervalChoice, TechniqueError> {
    let bad = |why: String| TechniqueError::Intervals { word: text.to_owned(), why };
    match text {
        POWERS_OF_TWO => return Ok(IntervalChoice::PowersOfTwo),
        "optimal" => return Ok(IntervalChoice::Optimal),
        _ => {}
    }
    let mut uppers = Vec::new();
    for word in text.split('-') {
        let upper = word.parse::<u32>().ok().filter(|_| !word.starts_with('+'));
        match upper {
            Some(upper @ 0..=DEEPEST) => uppers.push(upper),
            Some(upper) => return Err(bad(format!("{upper} is above {DEEPEST}"))),
            None => return Err(bad(format!("{word:?} is no number"))),
        }
        if uppers.len() > MOST_INTERVALS {
            return Err(bad(format!("there are more than {MOST_INTERVALS}")));
        }
    }
    Intervals::from_uppers(uppers.clone()).map_err(|error| bad(error.to_string()))?;
    Ok(IntervalChoice::Uppers(uppers))
}

impl FromStr for Technique {
    type Err = TechniqueError;

    fn from_str(text: &str) -> Result<Self, TechniqueError> {
        if ALIASES.iter().any(|(alias, _)| *alias == text) {
            return Ok(Self::Sorted(text.parse()?));
        }
        if text.starts_with(oit_spheres::PREFIX) {
            return Ok(Self::Spheres(text.parse()?));
        }
        // A coordinate has five parts at least. One that lacks some begins with a capture all the same.
        let mut parts = text.split('/');
        let first = parts.next().unwrap_or_default();
        if parts.count() > 1 || oit_capture::capture(first).is_ok() {
            return Ok(Self::Sorted(text.parse()?));
        }
        if methods().all(|method| method.name() != first) && first == text {
            let aliases = ALIASES.iter().map(|(alias, _)| *alias);
            let valid = methods().map(Method::name).chain(aliases);
            return Err(unknown("method or alias", first, valid));
        }
        Ok(Self::Method(parse_method(text)?))
    }
}

impl FromStr for Sorted {
    type Err = TechniqueError;

    fn from_str(text: &str) -> Result<Self, TechniqueError> {
        if let Some((_, name)) = ALIASES.iter().find(|(alias, _)| *alias == text) {
            return name.parse();
        }
        let parts: Vec<&str> = text.split('/').collect();
        let [capture, schedule, sort, stage, max_frags, rest @ ..] = parts.as_slice() else {
            return Err(TechniqueError::Form(text.to_owned()));
        };
        let stage = parse_stage(stage)?;
        let schedule = match (*schedule, stage) {
            ("bma-stencil", Stage::Fragment) | ("bma-list", Stage::Compute) => Schedule::Bma,
            ("base-stencil", Stage::Fragment) => Schedule::BaseStencil,
            ("bma-stencil-count", Stage::Fragment) => Schedule::BmaStencilCount,
            (
                "base-stencil" | "bma-stencil" | "bma-stencil-count",
                Stage::Compute | Stage::Cuda,
            )
            | ("bma-list", Stage::Fragment | Stage::Cuda) => {
                let needs = if *schedule == "bma-list" { "compute" } else { "fragment" };
                let (schedule, stage) = ((*schedule).to_owned(), stage.name());
                return Err(TechniqueError::Stage { schedule, needs, stage });
            }
            ("base", _) => Schedule::Base,
            ("base-intervals", _) => Schedule::BaseIntervals,
            (other, _) => {
                let valid = [
                    "base",
                    "base-stencil",
                    "base-intervals",
                    "bma-stencil",
                    "bma-stencil-count",
                    "bma-list",
                ];
                return Err(unknown("schedule", other, valid));
            }
        };
        let mut technique = Self {
            capture: parse_capture(capture)?,
            schedule,
            sort: sort.parse()?,
            stage,
            max_frags: parse_max_frags(max_frags)?,
            ties: Ties::Total,
            pool: Pool::WHOLE,
            intervals: IntervalChoice::PowersOfTwo,
        };
        for part in rest {
            if *part == "ties-depth" {
                technique.ties = Ties::Depth;
            } else if let Some(word) = part.strip_prefix("intervals") {
                // `intervals4-12-40`, `intervals-optimal`.
                let word = word.strip_prefix('-').unwrap_or(word);
                technique.intervals = parse_intervals(word)?;
                technique.schedule.admits(&technique.intervals)?;
            } else if let Ok(pool) = parse_pool(part.strip_prefix("pool").unwrap_or(part)) {
                technique.pool = pool;
            } else {
                return Err(TechniqueError::Form(text.to_owned()));
            }
        }
        Ok(technique)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_techniques_go_both_ways() {
        for name in [
            "linked_list/base/insertion/fragment/peak",
            "linked_list/bma-stencil/rbs/fragment/max512",
            "linearized/bma-list/network+rbs/compute/peak/ties-depth",
            "linked_list/bma-list/insertion-workgroup+merge/compute/peak",
            "linearized/base/passthrough/compute/max8/pool50",
            "linearized/base-stencil/insertion/fragment/peak/ties-depth/pool100-drop",
            "linked_list/bma-stencil-count/rbs/fragment/peak",
            "linked_list/bma-list/insertion@16+merge@64+rbs/compute/peak/intervals4-12-40",
            "linked_list/bma-stencil/auto/fragment/max64/ties-depth/pool50/intervals-optimal",
            "linked_list/base/auto/compute/peak",
            "linked_list/base-intervals/merge/fragment/max512/ties-depth",
            "linked_list/base-intervals/merge/compute/peak",
            "linearized/base/network+rbs/cuda/max128",
        ] {
            assert_eq!(name.parse::<Technique>().unwrap().to_string(), name);
        }
        for (alias, name) in ALIASES {
            assert_eq!(alias.parse::<Technique>().unwrap().to_string(), *name);
        }
    }

    #[test]
    fn methods_have_names_too() {
        for method in methods() {
            let name = method.name();
            let technique: Technique = name.parse().unwrap();
            let Technique::Method(choice) = &technique else { panic!("{name} is a coordinate") };
            assert_eq!((choice.method.name(), choice.size), (name, None));
            assert_eq!(technique.to_string(), name);
            // A coordinate's first word is never a method's.
            assert!(oit_capture::capture(name).is_err(), "{name}");
            assert_eq!(methods().filter(|other| other.name() == name).count(), 1, "{name}");
            if let Some(size) = method.size() {
                for n in [*size.range.start(), *size.range.end()] {
                    let sized = format!("{name}/{}{n}", size.word);
                    assert_eq!(sized.parse::<Technique>().unwrap().to_string(), sized);
                }
            }
        }
    }

    #[test]
    fn a_mistake_in_a_method_is_named() {
        let error = |text: &str| text.parse::<Technique>().unwrap_err().to_string();
        let cases = [
            ("dual_pel", "no method or alias is called \"dual_pel\"; there is dual_peel"),
            ("dual_pel/passes4", "no method is called \"dual_pel\"; there is dual_peel"),
            ("dual_peel/pases4", "dual_peel has no size \"pases4\": it is passesN"),
            ("dual_peel/passes", "no size \"passes\": it is passesN, N from 1 to 1024"),
            ("dual_peel/passes0", "N from 1 to 1024"),
            ("dual_peel/passes1025", "N from 1 to 1024"),
            ("dual_peel/passes+4", "N from 1 to 1024"),
            ("dual_peel/passes04", "N from 1 to 1024"),
            ("dual_peel/passes99999999999", "N from 1 to 1024"),
            ("hybrid/passes4", "hybrid has no size \"passes4\": it is kN, N from 1 to 256"),
            ("weighted/k8", "weighted has no size \"k8\": it has none"),
            ("dual_peel/passes4/x", "capture/schedule/sort/stage/max"),
            ("BMA-RBS", "BMA-RBS-L"),
            ("", "no method or alias is called \"\""),
        ];
        for (text, expected) in cases {
            let said = error(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
    }

    #[test]
    fn a_wrong_word_is_named_with_its_nearest() {
        let error = |text: &str| text.parse::<Technique>().unwrap_err().to_string();
        let text = error("linked_lst/base/insertion/fragment/peak");
        assert!(text.contains("\"linked_lst\"") && text.contains("linked_list"), "{text}");
        let text = error("linked_list/base/insertoin/fragment/peak");
        assert!(text.contains("\"insertoin\"") && text.contains("insertion"), "{text}");
        let text = error("linked_list/bma-list/rbs/fragment/peak");
        assert!(text.contains("compute stage"), "{text}");
        let text = error("linked_list/base-stencil/rbs/compute/peak");
        assert!(text.contains("fragment stage"), "{text}");
        let text = error("linked_list/bma-list/rbs/cuda/peak");
        assert!(text.contains("bma-list runs in the compute stage, not in the cuda"), "{text}");
        let text = error("linked_list/bma-stencil/rbs/cuda/peak");
        assert!(text.contains("fragment stage, not in the cuda"), "{text}");
        let text = error("linked_list/base/rbs/compute/peak/pool0-drop");
        assert!(text.contains("pool0-drop"), "{text}");
        let text = error("linked_list/base/rbs/fragment/max0");
        assert!(text.contains("max0"), "{text}");
        assert!(error("linked_list/base").contains("capture/schedule/sort"));
        let bma = |word: &str| error(&format!("linked_list/bma-list/rbs/compute/peak/{word}"));
        let cases = [
            ("intervals8-4", "8 does not rise to 4"),
            ("intervals0-4", "ends at 0"),
            ("intervals4-x", "\"x\" is no number"),
            ("intervals", "no number"),
            ("intervals-optimum", "\"optimum\" is no number"),
            ("intervals8-5000", "above 4096"),
        ];
        for (word, why) in cases {
            let text = bma(word);
            assert!(text.contains(why) && text.contains("4-12-40"), "{word}: {text}");
        }
        let many: Vec<String> = (1..=65).map(|bound| bound.to_string()).collect();
        assert!(bma(&format!("intervals{}", many.join("-"))).contains("more than 64"));
        for schedule in ["base", "base-stencil"] {
            let text = error(&format!("linked_list/{schedule}/rbs/fragment/peak/intervals4-12"));
            assert!(text.contains(&format!("{schedule} has one program")), "{text}");
            assert!(text.contains("4-12"), "{text}");
        }
    }

    #[test]
    fn the_default_intervals_are_not_written() {
        let name = "linked_list/bma-list/rbs/compute/peak";
        let said: Technique = format!("{name}/intervals-powers-of-two").parse().unwrap();
        assert_eq!(said.to_string(), name);
    }

    #[test]
    fn the_array_holds_the_peak_or_what_was_asked() {
        assert_eq!(MaxFrags::Peak.for_peak(128), 128);
        assert_eq!(MaxFrags::Peak.for_peak(129), 256);
        assert_eq!(MaxFrags::Peak.for_peak(3), 8);
        assert!(MaxFrags::Exactly(8).truncates(9) && !MaxFrags::Exactly(8).truncates(8));
    }
}
