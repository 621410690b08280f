//! Where the numbers of a rule come from: a device's records, or a paper's own table.

use analysis::{CellResult, Ratio, Tables};

use crate::FigureError;
use crate::data::{Group, groups, view_of};
use crate::figures::rbs_views::{QUANTITIES, VIEWS};
use crate::published::{self, Published};
use crate::technique_names::{coordinates, find};

/// A scene, by its name without parameters, and a view.
pub(super) type View = (String, String);

/// What rules ask.
pub(super) trait Evidence {
    /// The median of a stage in milliseconds.
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String>;

    /// All device memory of a technique.
    fn memory_bytes(&self, technique: &str, view: &View) -> Result<u64, String>;

    /// The views of a scene there are.
    fn views(&self, scene: &str) -> Vec<String>;

    /// Two sorts compared on every view of a scene and in every family of techniques there is.
    fn sorts(&self, ask: &SortQuestion) -> Result<Vec<Ratio>, String>;
}

/// Which comparisons of two sorts a rule asks for.
pub(super) struct SortQuestion<'a> {
    /// The sort above the line.
    pub(super) sort: &'a str,
    /// The sort below it.
    pub(super) than: &'a str,
    /// The shader stage of both.
    pub(super) shader_stage: &'a str,
    /// The scenes, by name without parameters.
    pub(super) scenes: &'a [String],
    /// Peak depths of the views asked for.
    pub(super) depths: std::ops::RangeInclusive<u64>,
}

/// The records of one device.
pub(super) struct Measured<'a> {
    tables: &'a Tables,
    device: &'a str,
    /// The groups that speak for the techniques of the rule, all of them together, so that no two
    /// runs are put side by side.
    groups: Vec<Group<'a>>,
}

impl<'a> Measured<'a> {
    /// What a device's records hold of some techniques.
    pub(super) fn new(tables: &'a Tables, device: &'a str, techniques: &[&str]) -> Self {
        let coordinates: Vec<String> =
            techniques.iter().flat_map(|technique| coordinates(technique)).collect();
        let mut measured = Self { tables, device, groups: Vec::new() };
        measured.groups = measured.groups(|cell| coordinates.contains(&cell.name.technique));
        measured
    }

    /// The groups of this device that hold any of some cells.
    fn groups(&self, wanted: impl Fn(&CellResult) -> bool) -> Vec<Group<'a>> {
        let mut groups = groups(self.tables, wanted);
        groups.retain(|group| group.run.device() == self.device);
        groups
    }

    fn cell(&self, technique: &str, (scene, view): &View) -> Result<&'a CellResult, String> {
        let group = view_of(&self.groups, scene, view);
        let cell = group.and_then(|group| find(&group.cells, technique));
        let cell = cell.filter(|cell| !cell.times.is_empty());
        cell.ok_or_else(|| format!("no charted {technique} on {scene}, {view}"))
    }
}

impl Evidence for Measured<'_> {
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String> {
        let ms = self.cell(technique, view)?.median_ms(stage).filter(|&ms| ms > 0.0);
        ms.ok_or_else(|| format!("{technique} has no time for {stage}"))
    }

    fn memory_bytes(&self, technique: &str, view: &View) -> Result<u64, String> {
        let verification = self.cell(technique, view)?.verification.as_ref();
        let bytes = verification.map_or(0, |verification| verification.memory_bytes);
        Some(bytes).filter(|&bytes| bytes > 0).ok_or_else(|| "no device memory recorded".to_owned())
    }

    fn views(&self, scene: &str) -> Vec<String> {
        let of_scene =
            self.groups.iter().filter(|group| analysis::scene_name(group.scene) == scene);
        let mut views: Vec<String> = of_scene.map(|group| group.view.to_owned()).collect();
        views.sort();
        views.dedup();
        views
    }

    fn sorts(&self, ask: &SortQuestion) -> Result<Vec<Ratio>, String> {
        let of_family = |cell: &CellResult| {
            let technique = &cell.technique;
            ask.scenes.iter().any(|scene| scene == analysis::scene_name(&cell.name.scene))
                && technique.shader_stage == ask.shader_stage
                && (technique.max == "peak" && technique.whole_pool())
                && [ask.sort, ask.than].contains(&technique.sort.as_str())
        };
        let mut ratios = Vec::new();
        for group in self.groups(of_family) {
            let peak = group
                .run
                .histogram(&group.name())
                .and_then(|histogram| histogram.iter().rposition(|&pixels| pixels > 0));
            if !peak.is_some_and(|peak| ask.depths.contains(&(peak as u64))) {
                continue;
            }
            let cells = || group.cells.iter().filter(|cell| of_family(cell));
            for own in cells().filter(|cell| cell.technique.sort == ask.sort) {
                let same = |other: &&&CellResult| {
                    other.technique.sort == ask.than
                        && other.technique.capture == own.technique.capture
                        && other.technique.schedule == own.technique.schedule
                        && other.technique.ties == own.technique.ties
                };
                for other in cells().filter(same) {
                    ratios.extend(analysis::compare(own, other, analysis::RESOLVE).ok());
                }
            }
        }
        Ok(ratios)
    }
}

/// Table 2 of the register-based block sort paper.
pub(super) struct Paper(Published);

impl Paper {
    pub(super) fn read() -> Result<Self, FigureError> {
        Ok(Self(published::table("rbs-table-2")?))
    }
}

impl Evidence for Paper {
    fn time_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Result<f64, String> {
        let missing = || "not in RBS 2014, Table 2".to_owned();
        let known = VIEWS.iter().find(|(_, s, v)| s == scene && v == view).ok_or_else(missing)?;
        let quantity = QUANTITIES.iter().find(|(_, known)| *known == stage).ok_or_else(missing)?;
        self.0.value(technique, known.0, quantity.0).ok_or_else(missing)
    }

    fn memory_bytes(&self, _: &str, _: &View) -> Result<u64, String> {
        Err("no memory is published".to_owned())
    }

    fn views(&self, _: &str) -> Vec<String> {
        Vec::new()
    }

    fn sorts(&self, _: &SortQuestion) -> Result<Vec<Ratio>, String> {
        Err("no samples are published".to_owned())
    }
}
