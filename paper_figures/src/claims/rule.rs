//! The kinds of rule, and what each computes. All use medians; only [`Rule::NeverSlower`] rests on
//! intervals, because it asks whether one is slower.

use analysis::{RESOLVE, TOTAL};
use oit_record::statistics::Comparison;
use serde::Deserialize;

use super::error_of::ErrorOf;
use super::evidence::{
    Along, BestQuestion, Evidence, Memory, SeriesPoint, SeriesQuestion, SortQuestion, Told, View,
    WorkQuestion,
};
use super::work_of::WorkOf;
use crate::axis::{number, three_digits};
use crate::series::{Fit, Varies, passes};

/// How the figures of several views become one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Combine {
    /// Their arithmetic mean, as the papers average speed-ups.
    Mean,
    /// The least.
    Least,
    /// The greatest.
    Greatest,
}

/// Between what the figure must lie.
#[derive(Clone, Copy, PartialEq, Debug, Default, Deserialize)]
pub struct Bounds {
    /// More than this.
    pub above: Option<f64>,
    /// This or more.
    pub at_least: Option<f64>,
    /// This or less.
    pub at_most: Option<f64>,
}

/// Which memory is compared.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MemoryOf {
    /// The buffer that a resolve reads.
    Buffer,
    /// The same if fragments had 16 bytes: derived, not measured.
    BufferAt16,
    /// All buffers and targets, the geometry included.
    All,
}

/// Which figure of a program is compared.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProgramOf {
    /// Registers of an invocation.
    Registers,
    /// Local memory of an invocation, in bytes.
    LocalBytes,
    /// Code, in bytes.
    BinaryBytes,
    /// Milliseconds to compile it, not from a cache.
    CompileMs,
}

/// What must be measured. A view is a scene's name, without parameters or with them, and a view's name, or `*`
/// for every view recorded, or `path@*` for every frame recorded of a camera path.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Rule {
    /// The time of the fastest of `over` over the technique's own.
    Speedup {
        /// The technique that is claimed to be faster.
        technique: String,
        /// What it is compared with: on each view the fastest of these.
        over: Vec<String>,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The time of a stage over the total.
    Share {
        /// The technique.
        technique: String,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The time of a technique on the slower of two views over that on the faster. Which of them is
    /// the slower depends on the order in which lists are read, and is no part of the claims.
    Direction {
        /// The technique.
        technique: String,
        /// The stage.
        stage: String,
        /// The two views.
        views: (View, View),
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The share of views on which a technique is nearly the fastest.
    Fastest {
        /// The technique.
        technique: String,
        /// The others.
        among: Vec<String>,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// How many times the fastest's time still counts.
        within: f64,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The mean speed-up of a whole over the product of those of its parts, which must be above 1.
    Synergy {
        /// The whole.
        whole: String,
        /// Its parts.
        parts: Vec<String>,
        /// What speed-ups are measured against.
        baseline: String,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The memory of one technique over the most of others.
    Memory {
        /// The technique above the line.
        technique: String,
        /// The techniques below it: on each view the one that takes most.
        over: Vec<String>,
        /// Which memory.
        of: MemoryOf,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The tables of a buffer, which is all of it but the slots of its pool: in MiB, on views of
    /// 1920 x 1080 pixels only, or over those of another technique. The greatest of the views.
    Tables {
        /// The technique, and the bytes of a slot with all that belongs to it.
        technique: (String, u64),
        /// The other, if it is compared with one.
        over: Option<(String, u64)>,
        /// The views.
        views: Vec<View>,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The speed-up of a technique over another on one view over that on another view.
    Contrast {
        /// The technique that is claimed to be faster.
        technique: String,
        /// What it is compared with.
        over: String,
        /// The stage.
        stage: String,
        /// The view where it should gain more, and the other.
        views: (View, View),
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The least R squared of straight lines through the times of some techniques along a series.
    Linear {
        /// The techniques.
        techniques: Vec<String>,
        /// The scene and view.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// The stage.
        stage: String,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The time of the fastest of `over` over the technique's own, along a series.
    SeriesSpeedup {
        /// The technique that is claimed to be faster.
        technique: String,
        /// What it is compared with: at each point the fastest of these.
        over: Vec<String>,
        /// The scene and view.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// The stage.
        stage: String,
        /// How points are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// Sorting takes more than half of the total from some depth on, and not up to another. Sorting
    /// is what a technique takes more than its floor. The figure is the depth from which it does,
    /// interpolated; infinite where it never does.
    Dominant {
        /// The technique that sorts.
        technique: String,
        /// The same without a sort.
        floor: String,
        /// The scene and view.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// At this depth and more it must.
        from: u64,
        /// At this depth and less it must not.
        until: u64,
    },
    /// The time of a technique on views over what a straight line through a series has for as many
    /// fragments: the greatest factor, whichever of them is the greater.
    LikeSeries {
        /// The technique.
        technique: String,
        /// The scene and view of the series.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// The stage.
        stage: String,
        /// The views compared with it.
        views: Vec<View>,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The resolve time of one sort over that of another, all else equal, on all views of some
    /// scenes.
    SortRatio {
        /// The sort above the line.
        sort: String,
        /// The sort below it.
        than: String,
        /// The shader stage of both.
        shader_stage: String,
        /// The most fragments of both: `peak` or `maxN`.
        max: String,
        /// The scenes.
        scenes: Vec<String>,
        /// How they are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// What a stage of a technique takes over what another of its stages saves against another
    /// technique; infinite where it saves nothing.
    Repaid {
        /// The technique.
        technique: String,
        /// The other.
        over: String,
        /// The stage that costs.
        cost: String,
        /// The stage that is to be faster than the other's.
        saved: String,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The time of a stage, in milliseconds.
    Time {
        /// The technique.
        technique: String,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The share of wrong pixels of a technique's picture, in percent.
    WrongPixels {
        /// The technique.
        technique: String,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// An error of a technique's picture, or that over the least of others'; infinite where theirs is 0
    /// and its own is not, and 1 where both are.
    Error {
        /// The technique.
        technique: String,
        /// The others, if it is compared with any.
        #[serde(default)]
        over: Vec<String>,
        /// Which error.
        of: ErrorOf,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// An error of a technique's picture on one view over that on another.
    ErrorContrast {
        /// The technique.
        technique: String,
        /// Which error.
        of: ErrorOf,
        /// The view where it should be the greater, and the other.
        views: (View, View),
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The exponent of the power of a size that a method's error follows: -0.5 for an error that falls
    /// with the square root.
    ErrorExponent {
        /// The method in three sizes or more, and the number of each.
        sizes: Vec<(String, f64)>,
        /// Which error.
        of: ErrorOf,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The first place along a series at which an error of a technique's picture is beyond a bound;
    /// infinite where it is at none.
    LostFrom {
        /// The technique.
        technique: String,
        /// Which error.
        of: ErrorOf,
        /// The bound.
        beyond: f64,
        /// The scene and view.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// The bounds of the place.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// All memory of techniques along a series: the greatest over the least, the geometry included.
    MemoryGrowth {
        /// The techniques.
        techniques: Vec<String>,
        /// The scene and view.
        view: View,
        /// What changes along the series.
        varies: Varies,
        /// How techniques are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// A technique is refused on a view on which another runs. The figure is 1 where it is, else 0.
    Refused {
        /// The technique.
        technique: String,
        /// What runs.
        beside: String,
        /// The view.
        view: View,
    },
    /// The combined speed-up of a technique over that of the best of others, each against the same
    /// baseline: where a technique stands in a table of average or best speed-ups.
    Standing {
        /// The technique.
        technique: String,
        /// The others.
        among: Vec<String>,
        /// What speed-ups are measured against.
        baseline: String,
        /// The stage.
        stage: String,
        /// The views.
        views: Vec<View>,
        /// How the speed-ups of views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The time that is no resolve and no grouping, which is that of the capture: of the technique
    /// that takes most over that of the one that takes least.
    Rest {
        /// The techniques.
        techniques: Vec<String>,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The greatest figure of a technique's resolve programs, or that over another technique's.
    Programs {
        /// The technique.
        technique: String,
        /// The other, if it is compared with one.
        over: Option<String>,
        /// Which figure.
        of: ProgramOf,
        /// Only programs that hold up to so many fragments.
        up_to: Option<u32>,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// Counted work of a technique's passes, or that over another technique's. Where it is divided by
    /// something (`per`), that is done first, for each technique by its own.
    Work {
        /// The technique.
        technique: String,
        /// The other, if it is compared with one.
        over: Option<String>,
        /// What is counted.
        of: WorkOf,
        /// What it is divided by.
        per: Option<WorkOf>,
        /// The stage of the passes, stages joined by `+`, or `total` for all.
        stage: String,
        /// Only passes whose label starts so.
        pass: Option<String>,
        /// The views.
        views: Vec<View>,
        /// How views are combined.
        combine: Combine,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// The resolve time of the fastest of some sorts over that of the fastest of others, all else
    /// equal and in one run, where each covered pixel has the same number of fragments in random
    /// order of depth. The greatest of the depths.
    BestSort {
        /// The sorts; all exact ones that are not in `over` where none is named.
        #[serde(default)]
        sorts: Vec<String>,
        /// What they are compared with.
        over: Vec<String>,
        /// The capture of both.
        capture: String,
        /// The shader stage of both.
        shader_stage: String,
        /// Fragments of each covered pixel. All must have been measured.
        depths: Vec<u64>,
        /// The bounds.
        #[serde(flatten)]
        bounds: Bounds,
    },
    /// One sort is slower than another, all else equal, on no view of some scenes whose peak depth
    /// is within a range.
    NeverSlower {
        /// The sort.
        sort: String,
        /// The other.
        than: String,
        /// The shader stage of both.
        shader_stage: String,
        /// The scenes.
        scenes: Vec<String>,
        /// The least peak depth.
        from_depth: u64,
        /// The greatest.
        to_depth: u64,
    },
}

/// What a rule found.
#[derive(Clone, PartialEq, Debug)]
pub struct Finding {
    /// The figure that decides.
    pub figure: f64,
    /// Whether it is within the bounds.
    pub holds: bool,
    /// The figures it is made of.
    pub detail: String,
}

/// Pixels of the chapter's resolution.
const FULL_HD_PX: f64 = 1920.0 * 1080.0;

impl MemoryOf {
    fn bytes(self, memory: &Memory) -> Option<u64> {
        let bytes = match self {
            Self::Buffer => memory.lfb_bytes,
            Self::BufferAt16 => memory.lfb_bytes_at_16,
            Self::All => Some(memory.all_bytes),
        };
        bytes.filter(|&bytes| bytes > 0)
    }
}

impl ProgramOf {
    fn told(self, program: &Told) -> Option<f64> {
        match self {
            Self::Registers => program.registers,
            Self::LocalBytes => program.local_bytes,
            Self::BinaryBytes => program.binary_bytes,
            Self::CompileMs => program.compile_ms,
        }
    }

    /// The greatest of a technique's programs for up to so many fragments. All of them must be told of.
    fn greatest(
        self,
        (technique, up_to): (&str, Option<u32>),
        view: &View,
        evidence: &dyn Evidence,
    ) -> Result<f64, String> {
        let programs = evidence.programs(technique, view)?;
        let meant = programs.iter().filter(|one| up_to.is_none_or(|most| one.high <= most));
        let figures = meant.map(|program| self.told(program)).collect::<Option<Vec<f64>>>();
        let figures = figures.filter(|figures| !figures.is_empty());
        let figures =
            figures.ok_or_else(|| format!("nothing is told of the programs of {technique}"))?;
        Ok(Combine::Greatest.of(&figures))
    }
}

/// The capture of a coordinate.
fn capture_of(technique: &str) -> &str {
    technique.split('/').next().unwrap_or(technique)
}

/// The straight line through a technique's times along a series.
fn line(
    technique: &str,
    view: &View,
    varies: Varies,
    stage: &str,
    evidence: &dyn Evidence,
) -> Result<Fit, String> {
    let ask = SeriesQuestion { techniques: vec![technique], view, varies, of: Along::Time(stage) };
    let points = evidence.series(&ask)?;
    let points = points.iter().map(|point| (point.at as f64, point.figures[0]));
    let points: Vec<(f64, f64)> = points.collect();
    Fit::of(&points).ok_or_else(|| format!("no line through the times of {technique}"))
}

/// Whether sorting takes more than half of the total, at points with the time of a sort and of none.
fn dominant(points: &[SeriesPoint], from: u64, until: u64) -> Result<Finding, String> {
    let share = |point: &SeriesPoint| match point.figures[..] {
        [sorted, floor] => Some((point.at as f64, (sorted - floor) / sorted)),
        _ => None,
    };
    let shares: Vec<(f64, f64)> = points.iter().filter_map(share).collect();
    let deep = || shares.iter().filter(|(depth, _)| *depth >= from as f64);
    let shallow = || shares.iter().filter(|(depth, _)| *depth <= until as f64);
    if deep().next().is_none() || shallow().next().is_none() {
        return Err(format!("no depth of {from} and more, or none of {until} and less"));
    }
    let holds = deep().all(|(_, share)| *share > 0.5) && shallow().all(|(_, share)| *share <= 0.5);
    let parts: Vec<String> =
        shares.iter().map(|(depth, share)| format!("{depth} {share:.2}")).collect();
    let figure = passes(&shares, 0.5).unwrap_or(f64::INFINITY);
    Ok(Finding {
        figure,
        holds,
        detail: format!("share of sorting at depth: {}", parts.join(", ")),
    })
}

/// One amount of work over another, which is that of a technique.
fn divided(technique: &str, own: f64, other: f64) -> Result<f64, String> {
    if other > 0.0 { Ok(own / other) } else { Err(format!("{technique} has none")) }
}

/// One error over another.
fn over_error(own: f64, other: f64) -> f64 {
    match own == other {
        true => 1.0,
        false => own / other,
    }
}

impl Bounds {
    fn hold(&self, figure: f64) -> bool {
        self.above.is_none_or(|bound| figure > bound)
            && self.at_least.is_none_or(|bound| figure >= bound)
            && self.at_most.is_none_or(|bound| figure <= bound)
    }
}

impl Combine {
    fn of(self, figures: &[f64]) -> f64 {
        match self {
            Self::Mean => figures.iter().sum::<f64>() / figures.len() as f64,
            Self::Least => figures.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Greatest => figures.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

/// The views meant, every `*` replaced by the views there are.
fn expanded(views: &[View], evidence: &dyn Evidence) -> Result<Vec<View>, String> {
    let mut all = Vec::new();
    for (scene, view) in views {
        let path = view.strip_suffix("@*");
        if view == "*" || path.is_some() {
            // A star stands for views, or for the frames of one path.
            let meant = |view: &String| analysis::path_frame(view).map(|(path, _)| path) == path;
            let meant = evidence.views(scene).into_iter().filter(meant);
            all.extend(meant.map(|view| (scene.clone(), view)));
        } else {
            all.push((scene.clone(), view.clone()));
        }
    }
    if all.is_empty() {
        let scenes: Vec<&str> = views.iter().map(|(scene, _)| scene.as_str()).collect();
        return Err(format!("no view of {} recorded", scenes.join(", ")));
    }
    Ok(all)
}

/// More views than this are told of by their least, greatest and mean figure.
const MOST_TOLD: usize = 16;

/// One figure a view, and these as text.
fn each(
    views: &[View],
    evidence: &dyn Evidence,
    figure: impl Fn(&View) -> Result<f64, String>,
) -> Result<(Vec<f64>, String), String> {
    each_in(|figure| format!("{figure:.2}"), views, evidence, figure)
}

/// The same with figures written so.
fn each_in(
    text: impl Fn(f64) -> String,
    views: &[View],
    evidence: &dyn Evidence,
    figure: impl Fn(&View) -> Result<f64, String>,
) -> Result<(Vec<f64>, String), String> {
    let views = expanded(views, evidence)?;
    let figures = views.iter().map(figure).collect::<Result<Vec<f64>, String>>()?;
    if views.len() > MOST_TOLD {
        let (least, most) = (Combine::Least.of(&figures), Combine::Greatest.of(&figures));
        let mean = Combine::Mean.of(&figures);
        let [least, most, mean] = [least, most, mean].map(text);
        let detail = format!("{least} to {most}, mean {mean}, on {} views", views.len());
        return Ok((figures, detail));
    }
    let parts = views.iter().zip(&figures);
    let parts: Vec<String> =
        parts.map(|((scene, view), figure)| format!("{scene} {view} {}", text(*figure))).collect();
    Ok((figures, parts.join(", ")))
}

fn fastest_ms(
    techniques: &[String],
    view: &View,
    stage: &str,
    evidence: &dyn Evidence,
) -> Result<f64, String> {
    let times = techniques.iter().map(|technique| evidence.time_ms(technique, view, stage));
    Ok(times.collect::<Result<Vec<f64>, String>>()?.into_iter().fold(f64::INFINITY, f64::min))
}

impl Rule {
    /// The techniques whose own times it asks for.
    pub(super) fn techniques(&self) -> Vec<&str> {
        let named: Vec<&String> = match self {
            Self::Speedup { technique, over, .. } => over.iter().chain([technique]).collect(),
            Self::Fastest { technique, among, .. } => among.iter().chain([technique]).collect(),
            Self::Share { technique, .. }
            | Self::Time { technique, .. }
            | Self::Direction { technique, .. } => vec![technique],
            Self::Synergy { whole, parts, baseline, .. } => {
                parts.iter().chain([whole, baseline]).collect()
            }
            Self::Memory { technique, over, .. } => over.iter().chain([technique]).collect(),
            Self::Tables { technique, over, .. } => {
                over.iter().map(|(over, _)| over).chain([&technique.0]).collect()
            }
            Self::Contrast { technique, over, .. } => vec![technique, over],
            Self::Error { technique, over, .. } => over.iter().chain([technique]).collect(),
            Self::ErrorContrast { technique, .. } => vec![technique],
            Self::ErrorExponent { sizes, .. } => sizes.iter().map(|(name, _)| name).collect(),
            Self::LikeSeries { technique, .. } | Self::WrongPixels { technique, .. } => {
                vec![technique]
            }
            Self::Repaid { technique, over, .. } => vec![technique, over],
            Self::Standing { technique, among, baseline, .. } => {
                among.iter().chain([technique, baseline]).collect()
            }
            Self::Rest { techniques, .. } => techniques.iter().collect(),
            Self::Programs { technique, over, .. } | Self::Work { technique, over, .. } => {
                over.iter().chain([technique]).collect()
            }
            Self::Refused { technique, beside, .. } => vec![technique, beside],
            // These find their cells themselves.
            Self::NeverSlower { .. }
            | Self::SortRatio { .. }
            | Self::BestSort { .. }
            | Self::Linear { .. }
            | Self::SeriesSpeedup { .. }
            | Self::LostFrom { .. }
            | Self::MemoryGrowth { .. }
            | Self::Dominant { .. } => Vec::new(),
        };
        named.into_iter().map(String::as_str).collect()
    }

    /// What the rule computes from evidence; the reason where the evidence lacks something.
    pub(super) fn finding(&self, evidence: &dyn Evidence) -> Result<Finding, String> {
        let time =
            |technique: &str, view: &View, stage: &str| evidence.time_ms(technique, view, stage);
        let (figure, bounds, detail) = match self {
            Self::Speedup { technique, over, stage, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    Ok(fastest_ms(over, view, stage, evidence)? / time(technique, view, stage)?)
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Share { technique, stage, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    Ok(time(technique, view, stage)? / time(technique, view, TOTAL)?)
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Time { technique, stage, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| time(technique, view, stage))?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Direction { technique, stage, views: (first, second), bounds } => {
                let (a, b) = (time(technique, first, stage)?, time(technique, second, stage)?);
                let detail = format!("{} {a:.3} ms, {} {b:.3} ms", first.1, second.1);
                (a.max(b) / a.min(b), *bounds, detail)
            }
            Self::Fastest { technique, among, stage, views, within, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    Ok(time(technique, view, stage)? / fastest_ms(among, view, stage, evidence)?)
                })?;
                let near = figures.iter().filter(|ratio| *ratio <= within).count();
                let detail = format!("time over the fastest other: {detail}");
                (near as f64 / figures.len() as f64, *bounds, detail)
            }
            Self::Synergy { whole, parts, baseline, stage, views, bounds } => {
                let mean = |technique: &str| -> Result<f64, String> {
                    let (figures, _) = each(views, evidence, |view| {
                        Ok(time(baseline, view, stage)? / time(technique, view, stage)?)
                    })?;
                    Ok(Combine::Mean.of(&figures))
                };
                let whole = mean(whole)?;
                let parts = parts.iter().map(|part| mean(part)).collect::<Result<Vec<f64>, _>>()?;
                let product: f64 = parts.iter().product();
                let parts: Vec<String> = parts.iter().map(|part| format!("{part:.2}")).collect();
                (whole / product, *bounds, format!("{whole:.2} against {}", parts.join(" × ")))
            }
            Self::Memory { technique, over, of, views, combine, bounds } => {
                let bytes = |technique: &str, view: &View| {
                    let memory = evidence.memory(technique, view)?;
                    of.bytes(&memory).ok_or_else(|| format!("{technique} does not say its memory"))
                };
                let (figures, detail) = each(views, evidence, |view| {
                    let below = over.iter().map(|technique| bytes(technique, view));
                    let below = below.collect::<Result<Vec<u64>, String>>()?;
                    let most = below.into_iter().max().unwrap_or(0);
                    Ok(bytes(technique, view)? as f64 / most as f64)
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Tables { technique, over, views, bounds } => {
                let tables = |(technique, slot): &(String, u64), view: &View| {
                    let memory = evidence.memory(technique, view)?;
                    let pool = memory.slots.checked_mul(*slot);
                    let tables = memory.lfb_bytes.zip(pool).and_then(|(all, p)| all.checked_sub(p));
                    let tables =
                        tables.ok_or_else(|| format!("{technique} does not say its tables"))?;
                    Ok::<_, String>((tables as f64, memory.pixels as f64))
                };
                let (figures, detail) = each(views, evidence, |view| {
                    let (own, pixels) = tables(technique, view)?;
                    let Some(over) = over else {
                        // Padded tables do not grow with the view.
                        return match pixels == FULL_HD_PX {
                            true => Ok(own / f64::from(1 << 20)),
                            false => Err(format!("{pixels} pixels, not 1920 x 1080")),
                        };
                    };
                    Ok(own / tables(over, view)?.0)
                })?;
                (Combine::Greatest.of(&figures), *bounds, detail)
            }
            Self::Contrast { technique, over, stage, views: (first, second), bounds } => {
                let speedup = |view: &View| -> Result<f64, String> {
                    Ok(time(over, view, stage)? / time(technique, view, stage)?)
                };
                let (a, b) = (speedup(first)?, speedup(second)?);
                let detail = format!("{} {a:.2}, {} {b:.2}", first.0, second.0);
                (a / b, *bounds, detail)
            }
            Self::Linear { techniques, view, varies, stage, bounds } => {
                let mut figures = Vec::new();
                for technique in techniques {
                    figures.push(line(technique, view, *varies, stage, evidence)?.r_squared);
                }
                let parts = techniques.iter().zip(&figures);
                let parts = parts.map(|(name, r)| format!("{} {r:.4}", capture_of(name)));
                let detail = parts.collect::<Vec<String>>().join(", ");
                (Combine::Least.of(&figures), *bounds, detail)
            }
            Self::SeriesSpeedup { technique, over, view, varies, stage, combine, bounds } => {
                let techniques = [technique].into_iter().chain(over).map(String::as_str).collect();
                let of = Along::Time(stage);
                let points =
                    evidence.series(&SeriesQuestion { techniques, view, varies: *varies, of })?;
                let ratio = |point: &SeriesPoint| {
                    let (own, others) = point.figures.split_first()?;
                    Some(others.iter().copied().fold(f64::INFINITY, f64::min) / own)
                };
                let figures: Vec<f64> = points.iter().filter_map(ratio).collect();
                let parts = points.iter().zip(&figures);
                let parts = parts.map(|(point, ratio)| format!("{} {ratio:.2}", point.at));
                let detail = parts.collect::<Vec<String>>().join(", ");
                (combine.of(&figures), *bounds, detail)
            }
            Self::Dominant { technique, floor, view, varies, from, until } => {
                let techniques = vec![technique.as_str(), floor.as_str()];
                let of = Along::Time(TOTAL);
                let ask = SeriesQuestion { techniques, view, varies: *varies, of };
                return dominant(&evidence.series(&ask)?, *from, *until);
            }
            Self::LikeSeries { technique, view, varies, stage, views, bounds } => {
                let line = line(technique, view, *varies, stage, evidence)?;
                let (figures, detail) = each(views, evidence, |view| {
                    Ok(time(technique, view, stage)? / line.at(evidence.fragments(view)? as f64))
                })?;
                let factors: Vec<f64> = figures
                    .iter()
                    .map(|ratio| if *ratio > 0.0 { ratio.max(1.0 / ratio) } else { f64::INFINITY })
                    .collect();
                (Combine::Greatest.of(&factors), *bounds, format!("time over the line: {detail}"))
            }
            Self::SortRatio { sort, than, shader_stage, max, scenes, combine, bounds } => {
                let ask =
                    SortQuestion { sort, than, shader_stage, max, scenes, depths: 0..=u64::MAX };
                let figures: Vec<f64> = evidence.sorts(&ask)?.iter().map(|r| r.ratio).collect();
                if figures.is_empty() {
                    let scenes = scenes.join(" or ");
                    return Err(format!("no view of {scenes} with {sort} and {than}, {max}"));
                }
                let (least, most) = (Combine::Least.of(&figures), Combine::Greatest.of(&figures));
                let detail = format!("{least:.2} to {most:.2} in {} comparisons", figures.len());
                (combine.of(&figures), *bounds, detail)
            }
            Self::Repaid { technique, over, cost, saved, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    let spent = time(technique, view, cost)?;
                    let gain = time(over, view, saved)? - time(technique, view, saved)?;
                    Ok(if gain > 0.0 { spent / gain } else { f64::INFINITY })
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::WrongPixels { technique, views, combine, bounds } => {
                let wrong = |view: &View| evidence.error(technique, view, ErrorOf::WrongPercent);
                let (figures, detail) = each(views, evidence, wrong)?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Error { technique, over, of, views, combine, bounds } => {
                let (figures, detail) = each_in(number, views, evidence, |view| {
                    let own = evidence.error(technique, view, *of)?;
                    let others = over.iter().map(|other| evidence.error(other, view, *of));
                    let others = others.collect::<Result<Vec<f64>, String>>()?;
                    Ok(match over.is_empty() {
                        true => own,
                        false => over_error(own, Combine::Least.of(&others)),
                    })
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::ErrorContrast { technique, of, views: (first, second), bounds } => {
                let a = evidence.error(technique, first, *of)?;
                let b = evidence.error(technique, second, *of)?;
                let detail = format!(
                    "{} {} {}, {} {} {}",
                    first.0,
                    first.1,
                    number(a),
                    second.0,
                    second.1,
                    number(b)
                );
                (over_error(a, b), *bounds, detail)
            }
            Self::ErrorExponent { sizes, of, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    let point = |(technique, size): &(String, f64)| {
                        Ok((*size, evidence.error(technique, view, *of)?))
                    };
                    let points = sizes.iter().map(point).collect::<Result<Vec<_>, String>>()?;
                    errors::exponent(&points)
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::LostFrom { technique, of, beyond, view, varies, bounds } => {
                let (techniques, of) = (vec![technique.as_str()], Along::Error(*of));
                let ask = SeriesQuestion { techniques, view, varies: *varies, of };
                let points = evidence.series(&ask)?;
                let points: Vec<(u64, f64)> =
                    points.iter().map(|point| (point.at, point.figures[0])).collect();
                let parts = points.iter().map(|(at, error)| format!("{at} {}", number(*error)));
                let detail = format!("at {}", parts.collect::<Vec<String>>().join(", "));
                (errors::lost_from(&points, *beyond), *bounds, detail)
            }
            Self::MemoryGrowth { techniques, view, varies, combine, bounds } => {
                let mut figures = Vec::new();
                for technique in techniques {
                    let (one, of) = (vec![technique.as_str()], Along::Memory);
                    let ask = SeriesQuestion { techniques: one, view, varies: *varies, of };
                    let points = evidence.series(&ask)?;
                    let bytes: Vec<f64> = points.iter().map(|point| point.figures[0]).collect();
                    figures.push(errors::growth(&bytes));
                }
                let parts = techniques.iter().zip(&figures);
                let parts = parts.map(|(name, growth)| format!("{name} {growth:.2}"));
                let detail = parts.collect::<Vec<String>>().join(", ");
                (combine.of(&figures), *bounds, detail)
            }
            Self::Refused { technique, beside, view } => {
                if let Some(reason) = evidence.refused(beside, view)? {
                    return Err(format!("{beside} is refused as well: {reason}"));
                }
                let reason = evidence.refused(technique, view)?;
                let holds = reason.is_some();
                let detail = reason.unwrap_or_else(|| "it runs".to_owned());
                return Ok(Finding { figure: f64::from(u8::from(holds)), holds, detail });
            }
            Self::Standing { technique, among, baseline, stage, views, combine, bounds } => {
                let speedup = |technique: &str| -> Result<f64, String> {
                    let (figures, _) = each(views, evidence, |view| {
                        Ok(time(baseline, view, stage)? / time(technique, view, stage)?)
                    })?;
                    Ok(combine.of(&figures))
                };
                let own = speedup(technique)?;
                let others = among.iter().map(|other| Ok((speedup(other)?, other)));
                let others = others.collect::<Result<Vec<_>, String>>()?;
                let best = others.iter().max_by(|a, b| a.0.total_cmp(&b.0));
                let (best, name) = best.ok_or_else(|| "nothing to compare with".to_owned())?;
                (
                    own / best,
                    *bounds,
                    format!("{own:.2}, the best of the others {best:.2} ({name})"),
                )
            }
            Self::Rest { techniques, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    let rest = |technique: &String| {
                        Ok(time(technique, view, TOTAL)? - time(technique, view, RESOLVE)?)
                    };
                    let rests =
                        techniques.iter().map(rest).collect::<Result<Vec<f64>, String>>()?;
                    let least = Combine::Least.of(&rests);
                    if least > 0.0 {
                        Ok(Combine::Greatest.of(&rests) / least)
                    } else {
                        Err("no time but that of the resolve".to_owned())
                    }
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Programs { technique, over, of, up_to, views, combine, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    let own = of.greatest((technique, *up_to), view, evidence)?;
                    let Some(over) = over else { return Ok(own) };
                    match of.greatest((over, *up_to), view, evidence)? {
                        below if below > 0.0 => Ok(own / below),
                        _ => Err(format!("{over} takes none")),
                    }
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::Work { technique, over, of, per, stage, pass, views, combine, bounds } => {
                let pass = pass.as_deref();
                let amount = |technique: &str, view: &View| {
                    let count =
                        |of| evidence.work(&WorkQuestion { technique, view, of, stage, pass });
                    match per {
                        Some(per) => divided(technique, count(*of)?, count(*per)?),
                        None => count(*of),
                    }
                };
                let (figures, detail) = each_in(three_digits, views, evidence, |view| {
                    let own = amount(technique, view)?;
                    let Some(over) = over else { return Ok(own) };
                    divided(over, own, amount(over, view)?)
                })?;
                (combine.of(&figures), *bounds, detail)
            }
            Self::BestSort { sorts, over, capture, shader_stage, depths, bounds } => {
                let best =
                    evidence.best(&BestQuestion { sorts, over, capture, shader_stage, depths })?;
                let figures: Vec<f64> = best.iter().map(|best| best.ratio).collect();
                let parts = best.iter();
                let parts = parts.map(|one| format!("{} {} {:.2}", one.depth, one.sort, one.ratio));
                let detail = parts.collect::<Vec<String>>().join(", ");
                (Combine::Greatest.of(&figures), *bounds, detail)
            }
            Self::NeverSlower { sort, than, shader_stage, scenes, from_depth, to_depth } => {
                let depths = *from_depth..=*to_depth;
                let ask = SortQuestion { sort, than, shader_stage, max: "peak", scenes, depths };
                let ratios = evidence.sorts(&ask)?;
                let worst = ratios.iter().map(|ratio| ratio.ratio).fold(f64::NAN, f64::max);
                if worst.is_nan() {
                    return Err(format!(
                        "no view of {} of {from_depth} to {to_depth} fragments with {sort} and {than}",
                        scenes.join(" or ")
                    ));
                }
                let slower = ratios.iter().filter(|r| r.verdict == Comparison::Slower).count();
                let detail = format!("slower in {slower} of {} comparisons", ratios.len());
                return Ok(Finding { figure: worst, holds: slower == 0, detail });
            }
        };
        Ok(Finding { figure, holds: bounds.hold(figure), detail })
    }
}

mod errors;
#[cfg(test)]
mod tests;
