//! Views on which many layouts were measured with the same resolve: what the figures of layouts
//! share.

use analysis::{CellResult, Tables};

use crate::data::{Group, groups};
use crate::style::layout_place;

/// Schedule, sort and stage with which layouts are compared: the chapter's program, the floor of
/// reading, and what is fastest today.
const RESOLVES: [(&str, &str, &str); 3] = [
    ("base", "insertion", "fragment"),
    ("base", "passthrough", "compute"),
    ("bma-list", "network+rbs", "compute"),
];

/// The layout that others are compared with.
pub(super) const REFERENCE: &str = "linearized";

/// Fewer layouts are no comparison of layouts.
const LEAST_LAYOUTS: usize = 3;
/// With one resolve alone layouts were run for something else: to be verified, or starved.
const LEAST_RESOLVES: usize = 2;

/// A view and its layouts.
pub(super) struct LayoutView<'a> {
    /// The view.
    pub(super) group: Group<'a>,
    /// The resolves measured, each with charted cells by layout.
    pub(super) resolves: Vec<Resolve<'a>>,
}

/// Layouts with one resolve.
pub(super) struct Resolve<'a> {
    /// `schedule/sort/stage`.
    pub(super) name: String,
    /// The sort.
    pub(super) sort: &'static str,
    /// The charted cells, one a layout, in the order of the layouts.
    pub(super) cells: Vec<&'a CellResult>,
}

impl<'a> Resolve<'a> {
    /// The cell of the layout that others are compared with.
    pub(super) fn reference(&self) -> Option<&'a CellResult> {
        self.cells.iter().copied().find(|cell| cell.technique.capture == REFERENCE)
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    let resolve =
        (technique.schedule.as_str(), technique.sort.as_str(), technique.shader_stage.as_str());
    RESOLVES.contains(&resolve)
        && technique.max == "peak"
        && technique.ties == "total"
        && technique.whole_pool()
        && technique.powers_of_two()
}

fn layouts(group: Group<'_>) -> LayoutView<'_> {
    let resolves = RESOLVES.iter().map(|&(schedule, sort, stage)| {
        let same = |cell: &&CellResult| {
            let t = &cell.technique;
            wanted(cell)
                && !cell.times.is_empty()
                && (t.schedule.as_str(), t.sort.as_str(), t.shader_stage.as_str())
                    == (schedule, sort, stage)
        };
        let mut cells: Vec<&CellResult> = group.cells.iter().copied().filter(same).collect();
        cells.sort_by_key(|cell| (layout_place(&cell.technique.capture), cell.name.clone()));
        Resolve { name: format!("{schedule}/{sort}/{stage}"), sort, cells }
    });
    let resolves = resolves.filter(|resolve| resolve.cells.len() >= LEAST_LAYOUTS).collect();
    LayoutView { resolves, group }
}

/// Every device's views with three layouts or more in two resolves or more.
pub(super) fn views(tables: &Tables) -> Vec<LayoutView<'_>> {
    let views = groups(tables, wanted).into_iter().map(layouts);
    views.filter(|view| view.resolves.len() >= LEAST_RESOLVES).collect()
}
