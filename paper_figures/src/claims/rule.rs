//! The kinds of rule, and what each computes. All use medians; only [`Rule::NeverSlower`] rests on
//! intervals, because it asks whether one is slower.

use analysis::TOTAL;
use oit_record::statistics::Comparison;
use serde::Deserialize;

use super::evidence::{Evidence, SortQuestion, View};

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

/// What must be measured. A view is a scene's name without parameters and a view's name, or `*`
/// for every view recorded.
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
    /// The mean of the device memory of one technique over that of another.
    Memory {
        /// The technique above the line.
        technique: String,
        /// The technique below it.
        over: String,
        /// The views.
        views: Vec<View>,
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
        if view == "*" {
            all.extend(evidence.views(scene).into_iter().map(|view| (scene.clone(), view)));
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

/// One figure a view, and these as text.
fn each(
    views: &[View],
    evidence: &dyn Evidence,
    figure: impl Fn(&View) -> Result<f64, String>,
) -> Result<(Vec<f64>, String), String> {
    let views = expanded(views, evidence)?;
    let figures = views.iter().map(figure).collect::<Result<Vec<f64>, String>>()?;
    let parts = views.iter().zip(&figures);
    let parts: Vec<String> =
        parts.map(|((scene, view), figure)| format!("{scene} {view} {figure:.2}")).collect();
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
            Self::Share { technique, .. } | Self::Direction { technique, .. } => vec![technique],
            Self::Synergy { whole, parts, baseline, .. } => {
                parts.iter().chain([whole, baseline]).collect()
            }
            Self::Memory { technique, over, .. } => vec![technique, over],
            Self::NeverSlower { .. } => Vec::new(),
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
            Self::Memory { technique, over, views, bounds } => {
                let (figures, detail) = each(views, evidence, |view| {
                    let (above, below) = (
                        evidence.memory_bytes(technique, view)?,
                        evidence.memory_bytes(over, view)?,
                    );
                    Ok(above as f64 / below as f64)
                })?;
                (Combine::Mean.of(&figures), *bounds, detail)
            }
            Self::NeverSlower { sort, than, shader_stage, scenes, from_depth, to_depth } => {
                let depths = *from_depth..=*to_depth;
                let ask = SortQuestion { sort, than, shader_stage, scenes, depths };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_what_they_say() {
        let bounds = Bounds { above: Some(1.0), at_least: None, at_most: Some(2.0) };
        assert!(!bounds.hold(1.0) && bounds.hold(1.5) && bounds.hold(2.0) && !bounds.hold(2.1));
        assert!(!bounds.hold(f64::NAN));
    }

    #[test]
    fn views_are_combined() {
        let figures = [1.0, 2.0, 6.0];
        assert_eq!(Combine::Mean.of(&figures), 3.0);
        assert_eq!(Combine::Least.of(&figures), 1.0);
        assert_eq!(Combine::Greatest.of(&figures), 6.0);
    }
}
