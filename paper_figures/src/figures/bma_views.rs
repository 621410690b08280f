//! The three scenes of the backwards memory allocation paper, and what its figures share.

use std::collections::BTreeMap;

use analysis::{CellResult, Tables};

use crate::data::{Group, by_device, groups, view_of};
use crate::published::Published;
use crate::technique_names::find;

/// A scene of the paper.
pub(crate) struct BmaView {
    /// The paper's name.
    pub(crate) paper: &'static str,
    /// The scene here.
    pub(crate) scene: &'static str,
    /// The view here.
    pub(crate) view: &'static str,
}

/// The paper's scenes, in its order.
pub(crate) const VIEWS: [BmaView; 3] = [
    BmaView { paper: "Atrium", scene: "atrium", view: "bma" },
    BmaView { paper: "Smoke", scene: "smoke", view: "bma" },
    BmaView { paper: "Power Plant", scene: "powerplant", view: "bma" },
];

/// The columns of Table 2: the array that the view needs as the paper has it, and twice that.
pub(crate) const ALLOCATIONS: [&str; 2] = ["smaller", "larger"];

/// The shader stages of this project, and what follows the paper's name of a technique in them.
pub(super) const STAGES: [(&str, &str); 2] = [("fragment", ""), ("compute", " compute")];

/// Of the scenes, those not of this project.
pub(super) const OUR_SCENES: &str = "Our atrium, smoke and power plant are generated and not the \
    paper's files: compare ratios, not times.";

impl BmaView {
    /// Whether a scene, by its name without parameters, and a view are this one.
    pub(crate) fn is(&self, scene: &str, view: &str) -> bool {
        (self.scene, self.view) == (scene, view)
    }

    /// Its array size in a column of Table 2, as techniques are named by it.
    pub(crate) fn allocation(&self, table_2: &Published, column: &str) -> Option<String> {
        Some(format!("max{}", table_2.value("Max Alloc", self.paper, column)?))
    }
}

/// Whether a cell is on one of the paper's views.
pub(super) fn on_a_view(cell: &CellResult) -> bool {
    let scene = analysis::scene_name(&cell.name.scene);
    VIEWS.iter().any(|view| view.is(scene, &cell.name.view))
}

/// The paper's views of each device: groups that hold cells that are wanted, by the paper's name.
pub(super) fn devices<'a>(
    tables: &'a Tables,
    wanted: impl Fn(&CellResult) -> bool,
) -> Vec<(String, BTreeMap<&'static str, Group<'a>>)> {
    let found = groups(tables, |cell| on_a_view(cell) && wanted(cell));
    let devices = by_device(found).into_iter().map(|(device, groups)| {
        let named = VIEWS.iter().filter_map(|view| {
            Some((view.paper, view_of(&groups, view.scene, view.view)?.clone()))
        });
        (device, named.collect())
    });
    devices.collect()
}

/// Resolution and profile of some groups.
pub(super) fn conditions(groups: &BTreeMap<&str, Group>) -> String {
    let all = groups.values().map(|group| {
        let profile = &group.run.run.profile;
        format!("{} × {} px, {profile} profile", group.width_px, group.height_px)
    });
    let all: std::collections::BTreeSet<String> = all.collect();
    all.into_iter().collect::<Vec<String>>().join("; ")
}

/// The charted cell of a technique, by name.
pub(super) fn charted<'a>(group: &Group<'a>, technique: &str) -> Option<&'a CellResult> {
    find(&group.cells, technique).filter(|cell| !cell.times.is_empty())
}
