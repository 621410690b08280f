//! What a technique will take on a view that it was not measured on.

use std::collections::BTreeMap;

use oit_record::statistics::median;

use crate::evidence::{Evidence, Measured, View, scene_name};
use crate::fit::{non_negative, predict};
use crate::technique::Family;

/// Depths where a resolve's cost by fragment changes: up to each the fragments of pixels are a
/// feature of their own, and above the last.
const DEPTHS: [u32; 5] = [8, 16, 32, 64, 128];
/// Fragments in pixels of depths without any measurement may be this share of all: they are taken for
/// those of the nearest depths that have some.
const UNSEEN: f64 = 0.01;
/// Fewer views say nothing of another.
const LEAST_VIEWS: usize = 2;

/// A predicted or measured time of a whole frame.
#[derive(Clone, PartialEq, Debug)]
pub struct Time {
    /// Nanoseconds.
    pub ns: f64,
    /// What it rests on.
    pub basis: Basis,
}

/// What a time rests on.
#[derive(Clone, PartialEq, Debug)]
pub enum Basis {
    /// It was measured on this very view, in this run.
    Measured {
        /// The run.
        run: String,
    },
    /// It is the sum of parts that were fitted to measurements.
    Fitted(Vec<Part>),
}

/// One part of a predicted time.
#[derive(Clone, PartialEq, Debug)]
pub struct Part {
    /// What it is of.
    pub what: String,
    /// Nanoseconds.
    pub ns: f64,
    /// Where it comes from.
    pub from: String,
    /// How far the same fit is off on scenes that it is not shown, at the median: 0.2 is a fifth.
    /// `None` where there is one scene alone, or none was fitted.
    pub off: Option<f64>,
}

/// A time to group and resolve that the caller knows otherwise, as from a device's tuning.
#[derive(Clone, PartialEq, Debug)]
pub struct Told {
    /// Nanoseconds.
    pub ns: f64,
    /// Where it comes from.
    pub from: String,
}

/// What a device's measurements say of other views.
#[derive(Clone, Debug)]
pub struct Model {
    /// Views, by the place in the evidence.
    views: Vec<View>,
    /// What came before the resolve, by layout and schedule: view and nanoseconds, a median over the
    /// techniques of the view.
    captures: BTreeMap<String, Vec<(usize, f64)>>,
    /// Grouping and resolving, by all but the size of the array, with that size.
    resolves: BTreeMap<String, Vec<(usize, f64, Option<u32>)>>,
    /// Whole frames, by name.
    wholes: BTreeMap<String, Vec<(usize, f64)>>,
}

/// Rows of a fit: features, times, scenes.
#[derive(Default)]
struct Rows {
    features: Vec<Vec<f64>>,
    ns: Vec<f64>,
    scenes: Vec<String>,
}

/// What the time before a resolve depends on: nothing, the frame, what is covered, fragments,
/// triangles.
fn capture_features(view: &View) -> Vec<f64> {
    let all = [view.pixels(), view.covered(), view.fragments(), view.triangles];
    std::iter::once(1.0).chain(all.map(|value| value as f64)).collect()
}

/// What a method's time depends on: as a capture's, and these once for each layer of the deepest pixel,
/// as for peeling.
fn whole_features(view: &View) -> Vec<f64> {
    let mut features = capture_features(view);
    let peak = f64::from(view.peak());
    let layers: Vec<f64> = [1, 2, 3, 4].map(|at| features[at] * peak).to_vec();
    features.extend(layers);
    features
}

/// Fragments by the depth of their pixels, as a program meets them that holds so many of each.
fn by_depth(view: &View, most: Option<u32>) -> Vec<f64> {
    let mut sums = vec![0.0; DEPTHS.len() + 1];
    for (depth, &pixels) in (0_u32..).zip(&view.histogram).skip(1) {
        let depth = depth.min(most.unwrap_or(u32::MAX));
        let place = DEPTHS.partition_point(|&bound| bound < depth);
        sums[place] += f64::from(depth) * pixels as f64;
    }
    sums
}

/// What grouping and resolving depend on: nothing, the frame, what is covered, fragments by depth.
fn resolve_features(view: &View, most: Option<u32>) -> Vec<f64> {
    let mut features = vec![1.0, view.pixels() as f64, view.covered() as f64];
    features.extend(by_depth(view, most));
    features
}

impl Rows {
    fn push(&mut self, view: &View, features: Vec<f64>, ns: f64) {
        self.features.push(features);
        self.ns.push(ns);
        self.scenes.push(scene_name(&view.scene).to_owned());
    }

    /// Nanoseconds at some features, from the rows of all scenes but one.
    fn at(&self, features: &[f64], but: Option<&str>) -> Option<f64> {
        let kept = |place: &usize| but.is_none_or(|scene| self.scenes[*place] != scene);
        let kept: Vec<usize> = (0..self.ns.len()).filter(kept).collect();
        if kept.len() < LEAST_VIEWS {
            return None;
        }
        let rows: Vec<Vec<f64>> = kept.iter().map(|&place| self.features[place].clone()).collect();
        let ns: Vec<f64> = kept.iter().map(|&place| self.ns[place]).collect();
        Some(predict(features, &non_negative(&rows, &ns)))
    }

    fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = self.scenes.iter().map(String::as_str).collect();
        scenes.sort_unstable();
        scenes.dedup();
        scenes
    }

    /// How far predictions are off where a view's scene is left out, at the median.
    fn off(&self) -> Option<f64> {
        let off = |place: usize| {
            let ns = self.at(&self.features[place], Some(&self.scenes[place]))?;
            Some((ns / self.ns[place] - 1.0).abs())
        };
        median(&(0..self.ns.len()).filter_map(off).collect::<Vec<f64>>())
    }

    fn part(&self, what: String, features: &[f64], with_off: bool) -> Result<Part, String> {
        let Some(ns) = self.at(features, None) else {
            return Err(format!("{what} was measured on {} views", self.ns.len()));
        };
        let from = format!("{} views of {}", self.ns.len(), self.scenes().join(", "));
        let off = if with_off { self.off() } else { None };
        Ok(Part { what, ns, from, off })
    }
}

impl Model {
    /// The model of a device's evidence.
    #[must_use]
    pub fn of(evidence: &Evidence) -> Self {
        let mut captures: BTreeMap<String, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
        let mut resolves: BTreeMap<String, Vec<(usize, f64, Option<u32>)>> = BTreeMap::new();
        let mut wholes: BTreeMap<String, Vec<(usize, f64)>> = BTreeMap::new();
        for Measured { view, technique, total_ns, resolve_ns, .. } in &evidence.cells {
            wholes.entry(technique.clone()).or_default().push((*view, *total_ns));
            let (Family::Sorted { capture, resolve, most }, Some(resolve_ns)) =
                (Family::of(technique), resolve_ns)
            else {
                continue;
            };
            let rest = (total_ns - resolve_ns).max(0.0);
            captures.entry(capture).or_default().entry(*view).or_default().push(rest);
            resolves.entry(resolve).or_default().push((*view, *resolve_ns, most));
        }
        let middle = |(view, ns): (usize, Vec<f64>)| Some((view, median(&ns)?));
        let captures = captures
            .into_iter()
            .map(|(name, views)| (name, views.into_iter().filter_map(middle).collect()))
            .collect();
        Self { views: evidence.views.clone(), captures, resolves, wholes }
    }

    /// What a technique takes on a view, from its parts on other views. With `with_off` each part says
    /// how far off its fit is.
    ///
    /// # Errors
    /// Why it cannot be said, in words.
    pub fn predict(
        &self,
        technique: &str,
        view: &View,
        told: Option<&Told>,
        with_off: bool,
    ) -> Result<Time, String> {
        let parts = match Family::of(technique) {
            Family::Whole => vec![self.whole(technique, view, with_off)?],
            Family::Sorted { capture, resolve, most } => vec![
                self.capture(&capture, view, with_off)?,
                match told {
                    Some(Told { ns, from }) => Part {
                        what: "group and resolve".into(),
                        ns: *ns,
                        from: from.clone(),
                        off: None,
                    },
                    None => self.resolve(&resolve, most, view, with_off)?,
                },
            ],
        };
        let ns = parts.iter().map(|part| part.ns).sum();
        Ok(Time { ns, basis: Basis::Fitted(parts) })
    }

    fn whole(&self, technique: &str, view: &View, with_off: bool) -> Result<Part, String> {
        let mut rows = Rows::default();
        for &(place, ns) in self.wholes.get(technique).map_or(&[][..], Vec::as_slice) {
            rows.push(&self.views[place], whole_features(&self.views[place]), ns);
        }
        rows.part("the whole frame".into(), &whole_features(view), with_off)
    }

    fn capture(&self, name: &str, view: &View, with_off: bool) -> Result<Part, String> {
        let known = self.captures.get(name).map_or(&[][..], Vec::as_slice);
        let what = format!("capture of {name}");
        // Other techniques may have captured this very view so.
        if let Some(&(_, ns)) = known.iter().rev().find(|(place, _)| self.views[*place].same(view)) {
            return Ok(Part { what, ns, from: "measured on this view".into(), off: None });
        }
        let mut rows = Rows::default();
        for &(place, ns) in known {
            rows.push(&self.views[place], capture_features(&self.views[place]), ns);
        }
        rows.part(what, &capture_features(view), with_off)
    }

    fn resolve(
        &self,
        name: &str,
        most: Option<u32>,
        view: &View,
        with_off: bool,
    ) -> Result<Part, String> {
        let mut rows = Rows::default();
        for &(place, ns, most) in self.resolves.get(name).map_or(&[][..], Vec::as_slice) {
            rows.push(&self.views[place], resolve_features(&self.views[place], most), ns);
        }
        let mut features = resolve_features(view, most);
        let depths = features.split_off(3);
        features.extend(seen(&depths, &rows)?);
        rows.part("group and resolve".into(), &features, with_off)
    }
}

/// Fragments by depth, those of depths that no row has taken for those of the nearest that some has.
///
/// # Errors
/// Where these are many.
fn seen(depths: &[f64], rows: &Rows) -> Result<Vec<f64>, String> {
    let known: Vec<bool> = (0..depths.len())
        .map(|place| rows.features.iter().any(|row| row[3 + place] > 0.0))
        .collect();
    let mut taken = depths.to_vec();
    let mut unseen = 0.0;
    for place in (0..depths.len()).filter(|&place| !known[place]) {
        let moved = std::mem::take(&mut taken[place]);
        unseen += moved;
        let nearest = (0..depths.len())
            .filter(|&other| known[other])
            .min_by_key(|&other| (other.abs_diff(place), other < place));
        if let Some(nearest) = nearest {
            taken[nearest] += moved;
        }
    }
    let all: f64 = depths.iter().sum();
    if unseen > UNSEEN * all {
        let percent = 100.0 * unseen / all;
        return Err(format!(
            "{percent:.0} % of the fragments lie in pixels of depths that its resolve was not \
             measured at"
        ));
    }
    Ok(taken)
}
