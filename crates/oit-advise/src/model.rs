//! What a technique will take on a view that it was not measured on.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

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

/// A view so many times larger than any measured, in anything that costs depend on, is beyond these.
const BEYOND: f64 = 4.0;
/// How far a fit is taken to be off where it has one scene alone and nothing tells, or is asked for a
/// view beyond those it has.
const UNTOLD: f64 = 1.0;

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
    /// `None` where there is one scene alone, or nothing tells.
    pub off: Option<f64>,
}

/// A time to group and resolve that the caller knows otherwise, as from a device's tuning.
#[derive(Clone, PartialEq, Debug)]
pub struct Told {
    /// Nanoseconds.
    pub ns: f64,
    /// Where it comes from.
    pub from: String,
    /// How far such a time is off at the median, where that is known.
    pub off: Option<f64>,
}

impl Time {
    /// The time with what its parts may be off added: of techniques of about the same predicted time the
    /// one that more is known of comes first, and what was measured needs no addition. Without it, the
    /// best of many predictions is most often the one that is most wrong.
    #[must_use]
    pub fn cautious_ns(&self) -> f64 {
        match &self.basis {
            Basis::Measured { .. } => self.ns,
            Basis::Fitted(parts) => {
                parts.iter().map(|part| part.ns * (1.0 + part.off.unwrap_or(UNTOLD))).sum()
            }
        }
    }
}

/// What a device's measurements say of other views. Fits are made when they are asked for.
#[derive(Debug)]
pub struct Model {
    /// Views, by the place in the evidence.
    views: Vec<View>,
    /// What came before the resolve, by layout: view, schedule, and nanoseconds, a median over the
    /// techniques of the view.
    captures: BTreeMap<String, Vec<(usize, String, f64)>>,
    /// Grouping and resolving, by all but the size of the array, with that size.
    resolves: BTreeMap<String, Vec<(usize, f64, Option<u32>)>>,
    /// Whole frames, by name.
    wholes: BTreeMap<String, Vec<(usize, f64)>>,
    fits: RefCell<BTreeMap<String, Rc<Fit>>>,
}

/// Rows of a fit: features, times, scenes.
#[derive(Default)]
struct Rows {
    features: Vec<Vec<f64>>,
    ns: Vec<f64>,
    scenes: Vec<String>,
}

/// What rows came to.
#[derive(Debug)]
struct Fit {
    /// `None` where there are too few rows.
    coefficients: Option<Vec<f64>>,
    views: usize,
    scenes: Vec<String>,
    /// The largest of each feature.
    most: Vec<f64>,
    off: Option<f64>,
}

/// What the time before a resolve depends on: nothing, the frame, what is covered, fragments,
/// triangles.
fn capture_features(view: &View) -> Vec<f64> {
    let all = [view.pixels(), view.covered(), view.fragments(), view.triangles];
    std::iter::once(1.0).chain(all.map(|value| value as f64)).collect()
}

/// The same, and for each schedule what it adds to the others: what counting, marking and the like
/// cost by the frame and by fragments. The geometry costs all the same.
fn scheduled_features(view: &View, schedule: &str, schedules: &[String]) -> Vec<f64> {
    let mut features = capture_features(view);
    let own = [1.0, features[1], features[3]];
    for other in schedules {
        features.extend(own.map(|value| if other == schedule { value } else { 0.0 }));
    }
    features
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

    /// The fit of the rows of all scenes but one.
    fn coefficients(&self, but: Option<&str>) -> Option<Vec<f64>> {
        let kept = |place: &usize| but.is_none_or(|scene| self.scenes[*place] != scene);
        let kept: Vec<usize> = (0..self.ns.len()).filter(kept).collect();
        if kept.len() < LEAST_VIEWS {
            return None;
        }
        let rows: Vec<Vec<f64>> = kept.iter().map(|&place| self.features[place].clone()).collect();
        let ns: Vec<f64> = kept.iter().map(|&place| self.ns[place]).collect();
        Some(non_negative(&rows, &ns))
    }

    fn fit(&self) -> Fit {
        let mut scenes = self.scenes.clone();
        scenes.sort_unstable();
        scenes.dedup();
        // A scene counts once, however many views it has.
        let off = |scene: &String| {
            let without = self.coefficients(Some(scene))?;
            let own = (0..self.ns.len()).filter(|&place| self.scenes[place] == *scene);
            let off = own.map(|place| {
                (predict(&self.features[place], &without) / self.ns[place] - 1.0).abs()
            });
            median(&off.collect::<Vec<f64>>())
        };
        let width = self.features.first().map_or(0, Vec::len);
        let most = |at: usize| self.features.iter().map(|row| row[at]).fold(0.0, f64::max);
        Fit {
            coefficients: self.coefficients(None),
            views: self.ns.len(),
            off: median(&scenes.iter().filter_map(off).collect::<Vec<f64>>()),
            scenes,
            most: (0..width).map(most).collect(),
        }
    }
}

impl Fit {
    fn part(&self, what: String, features: &[f64]) -> Result<Part, String> {
        let Some(coefficients) = &self.coefficients else {
            return Err(format!("{what}: measured on {} views", self.views));
        };
        let beyond = features.iter().zip(&self.most).any(|(value, most)| *value > BEYOND * most);
        let ns = predict(features, coefficients);
        let mut from = format!("{} views of {}", self.views, self.scenes.join(", "));
        let mut off = self.off;
        if beyond {
            from += ", all of them far smaller";
            off = off.map(|off| off.max(UNTOLD));
        }
        Ok(Part { what, ns, from, off })
    }
}

impl Model {
    /// The model of a device's evidence.
    #[must_use]
    pub fn of(evidence: &Evidence) -> Self {
        let mut captures: BTreeMap<(String, String), BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
        let mut resolves: BTreeMap<String, Vec<(usize, f64, Option<u32>)>> = BTreeMap::new();
        let mut wholes: BTreeMap<String, Vec<(usize, f64)>> = BTreeMap::new();
        for Measured { view, technique, total_ns, resolve_ns, .. } in &evidence.cells {
            wholes.entry(technique.clone()).or_default().push((*view, *total_ns));
            let (Family::Sorted { capture, schedule, resolve, most }, Some(resolve_ns)) =
                (Family::of(technique), resolve_ns)
            else {
                continue;
            };
            let rest = (total_ns - resolve_ns).max(0.0);
            captures.entry((capture, schedule)).or_default().entry(*view).or_default().push(rest);
            resolves.entry(resolve).or_default().push((*view, *resolve_ns, most));
        }
        let mut by_layout: BTreeMap<String, Vec<(usize, String, f64)>> = BTreeMap::new();
        for ((capture, schedule), views) in captures {
            let middle =
                |(view, ns): (usize, Vec<f64>)| Some((view, schedule.clone(), median(&ns)?));
            by_layout.entry(capture).or_default().extend(views.into_iter().filter_map(middle));
        }
        let (views, fits) = (evidence.views.clone(), RefCell::default());
        Self { views, captures: by_layout, resolves, wholes, fits }
    }

    fn fit(&self, key: String, rows: impl FnOnce() -> Rows) -> Rc<Fit> {
        if let Some(fit) = self.fits.borrow().get(&key) {
            return Rc::clone(fit);
        }
        let fit = Rc::new(rows().fit());
        self.fits.borrow_mut().insert(key, Rc::clone(&fit));
        fit
    }

    /// What a technique takes on a view, from its parts on other views.
    ///
    /// # Errors
    /// Why it cannot be said, in words.
    pub fn predict(
        &self,
        technique: &str,
        view: &View,
        told: Option<&Told>,
    ) -> Result<Time, String> {
        let parts = match Family::of(technique) {
            Family::Whole => vec![self.whole(technique, view)?],
            Family::Sorted { capture, schedule, resolve, most } => vec![
                self.capture(&capture, &schedule, view)?,
                match told {
                    Some(Told { ns, from, off }) => Part {
                        what: "group and resolve".into(),
                        ns: *ns,
                        from: from.clone(),
                        off: *off,
                    },
                    None => self.resolve(&resolve, most, view)?,
                },
            ],
        };
        let ns = parts.iter().map(|part| part.ns).sum();
        Ok(Time { ns, basis: Basis::Fitted(parts) })
    }

    fn whole(&self, technique: &str, view: &View) -> Result<Part, String> {
        let fit = self.fit(format!("whole {technique}"), || {
            let mut rows = Rows::default();
            for &(place, ns) in self.wholes.get(technique).map_or(&[][..], Vec::as_slice) {
                rows.push(&self.views[place], whole_features(&self.views[place]), ns);
            }
            rows
        });
        fit.part("the whole frame".into(), &whole_features(view))
    }

    fn capture(&self, layout: &str, schedule: &str, view: &View) -> Result<Part, String> {
        let known = self.captures.get(layout).map_or(&[][..], Vec::as_slice);
        let what = format!("capture of {layout}");
        let here = |of: &&(usize, String, f64)| self.views[of.0].same(view);
        // Other techniques may have captured this very view so.
        let own = known.iter().rev().filter(here).find(|(_, of, _)| of == schedule);
        if let Some(&(_, _, ns)) = own {
            return Ok(Part { what, ns, from: "this view, measured".into(), off: Some(0.0) });
        }
        let mut schedules: Vec<String> = known.iter().map(|(_, of, _)| of.clone()).collect();
        schedules.sort_unstable();
        schedules.dedup();
        if schedules.iter().all(|of| of != schedule) {
            return Err(format!("{what} with {schedule}: measured on no view"));
        }
        let fit = self.fit(format!("capture {layout}"), || {
            let mut rows = Rows::default();
            for (place, of, ns) in known {
                let view = &self.views[*place];
                rows.push(view, scheduled_features(view, of, &schedules), *ns);
            }
            rows
        });
        let part = fit.part(what, &scheduled_features(view, schedule, &schedules))?;
        // Or have captured it in the same layout for another schedule: then the fit tells the
        // difference alone.
        let Some((_, other, ns)) = known.iter().rev().find(here) else { return Ok(part) };
        let features = scheduled_features(view, other, &schedules);
        let fitted = predict(&features, fit.coefficients.as_deref().unwrap_or_default());
        if fitted <= 0.0 {
            return Ok(part);
        }
        let from = format!("this view with {other}, measured, times what {} change", part.from);
        let off = part.off.map(|off| off / 2.0);
        Ok(Part { ns: part.ns / fitted * ns, from, off, ..part })
    }

    fn resolve(&self, name: &str, most: Option<u32>, view: &View) -> Result<Part, String> {
        let rows = || {
            let mut rows = Rows::default();
            for &(place, ns, most) in self.resolves.get(name).map_or(&[][..], Vec::as_slice) {
                rows.push(&self.views[place], resolve_features(&self.views[place], most), ns);
            }
            rows
        };
        let fit = self.fit(format!("resolve {name}"), rows);
        let mut features = resolve_features(view, most);
        let depths = features.split_off(3);
        features.extend(seen(&depths, fit.most.get(3..).unwrap_or_default())?);
        fit.part("group and resolve".into(), &features)
    }
}

/// Fragments by depth, those of depths that no row has taken for those of the nearest that some has.
///
/// # Errors
/// Where these are many.
fn seen(depths: &[f64], most: &[f64]) -> Result<Vec<f64>, String> {
    let known: Vec<bool> =
        (0..depths.len()).map(|place| most.get(place).is_some_and(|most| *most > 0.0)).collect();
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
