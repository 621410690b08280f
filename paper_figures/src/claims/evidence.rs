//! What rules ask, whoever answers: a device's records, or a paper's own tables.

use analysis::Ratio;

use super::error_of::ErrorOf;
use super::work_of::WorkOf;
use crate::series::Varies;

/// A scene, by its name without parameters, and a view.
pub(super) type View = (String, String);

/// What rules ask.
pub(super) trait Evidence {
    /// The median of a stage in milliseconds.
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String>;

    /// What a technique takes of memory.
    fn memory(&self, technique: &str, view: &View) -> Result<Memory, String>;

    /// An error of a technique's picture.
    fn error(&self, technique: &str, view: &View, of: ErrorOf) -> Result<f64, String>;

    /// Why a technique was refused on a view, if it was.
    fn refused(&self, technique: &str, view: &View) -> Result<Option<String>, String>;

    /// The views of a scene there are, frames of camera paths among them.
    fn views(&self, scene: &str) -> Vec<String>;

    /// The fragments of all pixels of a view.
    fn fragments(&self, view: &View) -> Result<u64, String>;

    /// Two sorts compared on every view of a scene and in every family of techniques there is.
    fn sorts(&self, ask: &SortQuestion) -> Result<Vec<Ratio>, String>;

    /// What is told of a technique's resolve programs on a view, one an interval.
    fn programs(&self, technique: &str, view: &View) -> Result<Vec<Told>, String>;

    /// How much work passes of a technique are, or what that is set against.
    fn work(&self, ask: &WorkQuestion) -> Result<f64, String>;

    /// The fastest of some sorts over the fastest of others, at each depth asked for, where each covered
    /// pixel has the same number of fragments in random order.
    fn best(&self, ask: &BestQuestion) -> Result<Vec<Best>, String>;

    /// A figure of techniques along a series: points that all of them have, three at least.
    fn series(&self, ask: &SeriesQuestion) -> Result<Vec<SeriesPoint>, String>;
}

/// What a technique takes of memory on a view.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Memory {
    /// All buffers and targets, the geometry included; 0 where it is not known.
    pub(super) all_bytes: u64,
    /// The buffer that a resolve reads.
    pub(super) lfb_bytes: Option<u64>,
    /// The same with fragments of 16 bytes, derived.
    pub(super) lfb_bytes_at_16: Option<u64>,
    /// Slots of the pool.
    pub(super) slots: u64,
    /// Pixels of the view.
    pub(super) pixels: u64,
}

/// Which comparisons of two sorts a rule asks for.
pub(super) struct SortQuestion<'a> {
    /// The sort above the line.
    pub(super) sort: &'a str,
    /// The sort below it.
    pub(super) than: &'a str,
    /// The shader stage of both.
    pub(super) shader_stage: &'a str,
    /// The most fragments of both.
    pub(super) max: &'a str,
    /// The scenes, by name without parameters.
    pub(super) scenes: &'a [String],
    /// Peak depths of the views asked for.
    pub(super) depths: std::ops::RangeInclusive<u64>,
}

/// What of a technique is asked for along a series.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Along<'a> {
    /// The median of a stage in milliseconds.
    Time(&'a str),
    /// An error of its picture.
    Error(ErrorOf),
    /// All memory, in bytes.
    Memory,
}

/// Which figures along a series a rule asks for.
pub(super) struct SeriesQuestion<'a> {
    /// The techniques.
    pub(super) techniques: Vec<&'a str>,
    /// The scene by its name without parameters, and the view.
    pub(super) view: &'a View,
    /// What changes.
    pub(super) varies: Varies,
    /// Which figure.
    pub(super) of: Along<'a>,
}

/// One view of a series.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct SeriesPoint {
    /// Where it lies on the axis: fragments of all pixels, or of the deepest.
    pub(super) at: u64,
    /// The figures, in the order of the techniques asked for.
    pub(super) figures: Vec<f64>,
}

/// Which work a rule asks for.
pub(super) struct WorkQuestion<'a> {
    /// The technique.
    pub(super) technique: &'a str,
    /// The view.
    pub(super) view: &'a View,
    /// What is counted, or what it is divided by.
    pub(super) of: WorkOf,
    /// Passes of this stage, of these stages joined by `+`, or of all: [`analysis::TOTAL`].
    pub(super) stage: &'a str,
    /// Of these only passes whose label starts so.
    pub(super) pass: Option<&'a str>,
}

/// What is told of a program.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Told {
    /// The most fragments it holds.
    pub(super) high: u32,
    /// Registers of an invocation.
    pub(super) registers: Option<f64>,
    /// Local memory of an invocation, in bytes.
    pub(super) local_bytes: Option<f64>,
    /// Code, in bytes.
    pub(super) binary_bytes: Option<f64>,
    /// Milliseconds to compile it, where it was in no cache.
    pub(super) compile_ms: Option<f64>,
}

/// Which sorts a rule asks to be compared with which.
pub(super) struct BestQuestion<'a> {
    /// The sorts of which the fastest counts; none for all exact ones that are not in `over`.
    pub(super) sorts: &'a [String],
    /// What they are compared with: the fastest of these.
    pub(super) over: &'a [String],
    /// The capture of both.
    pub(super) capture: &'a str,
    /// The shader stage of both.
    pub(super) shader_stage: &'a str,
    /// Fragments of each covered pixel.
    pub(super) depths: &'a [u64],
}

/// The fastest sort at a depth.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Best {
    /// Fragments of each covered pixel.
    pub(super) depth: u64,
    /// The sort.
    pub(super) sort: String,
    /// Its resolve time over that of what it is compared with, in the same run.
    pub(super) ratio: f64,
}
