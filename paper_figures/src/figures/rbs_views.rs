//! What Tables 1 to 3 of the register-based block sort paper share: their views, and which techniques
//! stand in their rows.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, RESOLVE, TOTAL, Tables, scene_name};
use oit_record::Verdict;

use crate::data::{self, Group, by_device, groups_with, view_of};
use crate::output::Stamp;
use crate::technique_names::{ALIASES, find};

/// The paper's name of a view, and the scene and view here.
pub(crate) const VIEWS: [(&str, &str, &str); 9] = [
    ("power plant V1", "powerplant", "rbs-v1"),
    ("power plant V2", "powerplant", "rbs-v2"),
    ("power plant V3", "powerplant", "rbs-v3"),
    ("atrium V1", "atrium", "rbs-v1"),
    ("atrium V2", "atrium", "rbs-v2"),
    ("hairball Fwd", "hairball", "inside-front"),
    ("hairball Rev", "hairball", "inside-back"),
    ("planes Fwd", "planes", "front"),
    ("planes Rev", "planes", "back"),
];

/// The views of one table: side by side all nine would be too wide to read.
const SIDE_BY_SIDE: usize = 5;

/// The paper's quantities, and the stages that they are here.
pub(crate) const QUANTITIES: [(&str, &str); 2] = [("T", TOTAL), ("R", RESOLVE)];

/// One device's views, those it has.
pub(super) struct Device<'a> {
    /// The device.
    pub(super) name: String,
    /// Resolution and profile.
    pub(super) conditions: String,
    views: BTreeMap<&'static str, Group<'a>>,
    /// The other coordinates measured with exact pictures: compute stage, networks, total order.
    pub(super) others: Vec<String>,
}

/// Exact, of linked lists as in the paper, with arrays that hold the peak.
fn wanted(cell: &CellResult) -> bool {
    let view = |(_, scene, view): &(&str, &str, &str)| {
        scene_name(&cell.name.scene) == *scene && cell.name.view == *view
    };
    let technique = &cell.technique;
    VIEWS.iter().any(view)
        && cell.verification.as_ref().is_some_and(|v| v.verdict == Verdict::Exact)
        && (technique.capture == "linked_list" && technique.max == "peak")
        && technique.whole_pool()
        && technique.powers_of_two()
}

/// Whether a run has a technique of the paper on a view: others do not speak for it.
fn is_of_the_paper(group: &Group) -> bool {
    ALIASES.iter().any(|(alias, _)| find(&group.cells, alias).is_some())
}

/// Every device that has one of the views.
pub(super) fn devices(tables: &Tables) -> Vec<Device<'_>> {
    let mut devices = Vec::new();
    for (name, groups) in by_device(groups_with(tables, wanted, is_of_the_paper)) {
        let views: BTreeMap<&str, Group> = VIEWS
            .iter()
            .filter_map(|&(paper, scene, view)| {
                Some((paper, view_of(&groups, scene, view)?.clone()))
            })
            .collect();
        let conditions: BTreeSet<String> = views
            .values()
            .map(|group| {
                let profile = &group.run.run.profile;
                format!("{} × {} px, {profile} profile", group.width_px, group.height_px)
            })
            .collect();
        let mut others = BTreeSet::new();
        for group in views.values() {
            let named = ALIASES.iter().filter_map(|(alias, _)| find(&group.cells, alias));
            let named: Vec<&str> = named.map(|cell| cell.name.technique.as_str()).collect();
            let rest = group.cells.iter().filter(|cell| wanted(cell));
            let rest = rest.map(|cell| cell.name.technique.as_str());
            others.extend(rest.filter(|technique| !named.contains(technique)).map(str::to_owned));
        }
        let conditions = conditions.into_iter().collect::<Vec<_>>().join("; ");
        devices.push(Device { name, conditions, views, others: others.into_iter().collect() });
    }
    devices
}

impl<'a> Device<'a> {
    /// The group measured for a view of the paper.
    pub(super) fn group(&self, view: &str) -> Option<&Group<'a>> {
        self.views.get(view)
    }

    /// The cell of a technique, by the paper's name or coordinate, in a view of the paper.
    pub(super) fn cell(&self, technique: &str, view: &str) -> Option<&'a CellResult> {
        find(&self.group(view)?.cells, technique)
    }

    /// What must be said of a row: why numbers of ours are missing, and which tie rule was run.
    pub(super) fn note(&self, technique: &str) -> String {
        let known = technique.contains('/') || ALIASES.iter().any(|(alias, _)| *alias == technique);
        let cells: Vec<(&str, &CellResult)> = VIEWS
            .iter()
            .filter_map(|(view, _, _)| Some((*view, self.cell(technique, view)?)))
            .collect();
        if !known || cells.is_empty() {
            return "not measured yet".to_owned();
        }
        let mut notes = Vec::new();
        let total_order = |cell: &CellResult| cell.technique.ties == "total";
        if !technique.contains('/') && cells.iter().any(|(_, cell)| total_order(cell)) {
            notes.push("total order".to_owned());
        }
        for (view, cell) in cells {
            if cell.times.is_empty() {
                notes.push(format!("{view}: {}", cell.state.name()));
            }
        }
        notes.join("; ")
    }

    /// The views that it has, by the paper's names, as many at a time as stand side by side.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Vec<&'static str>> {
        let names = |views: &[(&'static str, &str, &str)]| {
            let names = views.iter().map(|(name, _, _)| *name);
            names.filter(|name| self.views.contains_key(name)).collect::<Vec<_>>()
        };
        VIEWS.chunks(SIDE_BY_SIDE).map(names).filter(|names| !names.is_empty())
    }

    /// The stamps of the runs behind the views.
    pub(super) fn stamps(&self) -> impl Iterator<Item = Stamp> + '_ {
        self.views.values().map(|group| Stamp::of(group.run))
    }
}

/// What a row of a table for programs says of a cell, after what it is: picture, state, origin.
pub(super) fn provenance(group: &data::Group, cell: Option<&CellResult>) -> Vec<String> {
    let state = cell.map_or("not measured", |cell| cell.state.name());
    let reason = cell.and_then(|cell| cell.reason.clone()).unwrap_or_default();
    vec![
        group.scene.to_owned(),
        group.view.to_owned(),
        group.width_px.to_string(),
        group.height_px.to_string(),
        state.to_owned(),
        reason,
        group.run.name.clone(),
        group.run.commit(),
    ]
}

/// The columns of [`provenance`].
pub(super) const PROVENANCE: [&str; 8] =
    ["scene", "view", "width_px", "height_px", "state", "reason", "run", "commit"];
