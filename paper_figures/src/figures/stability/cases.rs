//! The cases of a stability experiment: views of scenes with their parameters, and what is taken from
//! techniques.

use std::collections::BTreeMap;

use analysis::{CellResult, RunInfo, Technique, path_frame, scene_name, scene_parameters};

use super::rule::Kind;

/// A case: cells of one view, or of a camera path's frames, with the same pool and arrays.
pub(super) struct Case<'a> {
    /// The head of its column, in lines: the scene first.
    pub(super) head: Vec<String>,
    /// What it is about.
    pub(super) kind: Kind,
    /// Its cells.
    pub(super) cells: Vec<&'a CellResult>,
}

impl Case<'_> {
    /// The head in one line.
    pub(super) fn title(&self) -> String {
        self.head.join(", ")
    }
}

/// A technique without its pool and the size of its arrays, which are cases.
pub(super) fn row_name(technique: &Technique) -> String {
    if technique.is_method() || technique.capture.is_empty() {
        return technique.coordinate.clone();
    }
    let Technique { capture, schedule, sort, shader_stage, .. } = technique;
    let mut name = format!("{capture}/{schedule}/{sort}/{shader_stage}");
    if technique.ties != "total" {
        name += &format!("/ties-{}", technique.ties);
    }
    if !technique.powers_of_two() {
        name += &format!("/intervals-{}", technique.intervals);
    }
    name
}

/// What of a technique makes a case of its own.
fn options(technique: &Technique) -> Vec<String> {
    let mut options = Vec::new();
    if technique.is_method() || technique.capture.is_empty() {
        return options;
    }
    if technique.truncated() {
        options.push(format!("arrays of {}", technique.max.trim_start_matches("max")));
    }
    if !technique.whole_pool() {
        let drops = technique.pool_policy == "drop";
        let policy = if drops { "drops" } else { "grows" };
        options.push(format!("pool {} %, {policy}", technique.pool_percent));
    }
    options
}

/// The view, or the camera path of which it is a frame.
fn view_of(view: &str) -> String {
    path_frame(view).map_or_else(|| view.to_owned(), |(path, _)| format!("{path}, frames"))
}

/// What cells of one case share: scene, view or path, and options.
type Key<'a> = (&'a str, String, Vec<String>);

/// The cases of a run, those of one scene together, in the order of the run.
pub(super) fn cases<'a>(run: &RunInfo, cells: &[&'a CellResult]) -> Vec<Case<'a>> {
    let mut found: Vec<(Key, Vec<&CellResult>)> = Vec::new();
    for &cell in cells {
        let options = options(&cell.technique);
        let key: Key = (&cell.name.scene, view_of(&cell.name.view), options);
        match found.iter_mut().find(|(known, _)| *known == key) {
            Some((_, own)) => own.push(cell),
            None => found.push((key, vec![cell])),
        }
    }
    // Parameters that all cases of a scene share say nothing of a case.
    let keys: Vec<Key> = found.iter().map(|(key, _)| key.clone()).collect();
    let mut order: Vec<&str> = Vec::new();
    for (scene, ..) in &keys {
        let name = scene_name(scene);
        if !order.contains(&name) {
            order.push(name);
        }
    }
    found.sort_by_key(|((scene, ..), _)| order.iter().position(|name| *name == scene_name(scene)));
    let case = |(key, cells): (Key, Vec<&'a CellResult>)| {
        let own = keys.iter().filter(|(scene, ..)| scene_name(scene) == scene_name(key.0));
        let own: Vec<&Key> = own.collect();
        let kind = kind(run, key.0, &cells);
        Case { head: head(&key, &own), kind, cells }
    };
    found.into_iter().map(case).collect()
}

/// The head of a case among those of its scene.
fn head((scene, view, options): &Key, all: &[&Key]) -> Vec<String> {
    let mut lines = vec![scene_name(scene).to_owned()];
    if all.iter().any(|(_, other, _)| other != view) || view.ends_with("frames") {
        lines.push(view.clone());
    }
    let others: Vec<BTreeMap<&str, &str>> =
        all.iter().map(|(scene, ..)| scene_parameters(scene)).collect();
    for (name, value) in scene_parameters(scene) {
        if others.iter().any(|other| other.get(name) != Some(&value)) {
            lines.push(format!("{name} {}", value.trim_matches('"')));
        }
    }
    lines.extend(options.iter().cloned());
    if lines.len() == 1 {
        lines.push("as it is".to_owned());
    }
    lines
}

/// What a case is about.
fn kind(run: &RunInfo, scene: &str, cells: &[&CellResult]) -> Kind {
    let Some(cell) = cells.first() else { return Kind::Frame };
    let parameters = scene_parameters(scene);
    if path_frame(&cell.name.view).is_some() {
        return Kind::Path;
    }
    if parameters.contains_key("shuffle") {
        return Kind::Shuffled;
    }
    if scene_name(scene) == DAMAGED {
        // A damaged triangle must not be drawn: the frame's depths are those of the mesh without.
        let whole = run.counted.iter().find(|(group, ..)| {
            let scene = group.split(':').next().unwrap_or("");
            scene_name(scene) == DAMAGED
                && scene_parameters(scene).get("kind").is_some_and(|kind| kind.contains("removed"))
        });
        let own = run.histogram(&cell.name.group());
        let drawn = whole.is_some_and(|(_, _, whole)| own.is_some_and(|own| own != whole));
        return Kind::Damaged { drawn };
    }
    Kind::Frame
}

/// The scene of damaged meshes.
const DAMAGED: &str = "nonfinite";
