//! The records of one device, as evidence.

use std::collections::BTreeMap;

use analysis::{CellResult, ProgramFigures, RESOLVE, Ratio, State, TOTAL, Tables};

use super::error_of::ErrorOf;
use super::evidence::{
    Along, Best, BestQuestion, Evidence, Memory, SeriesPoint, SeriesQuestion, SortQuestion, Told,
    View, WorkQuestion,
};
use super::work_of::WorkOf;
use crate::data::{Group, all_groups, frames, groups, groups_with, is_view, random_depth};
use crate::figures::lfb_memory::lfb_bytes_at_16;
use crate::series::series;
use crate::technique_names::{coordinates, find, is_floor};

/// The records of one device.
pub(super) struct Measured<'a> {
    tables: &'a Tables,
    device: &'a str,
    /// The groups that speak for the techniques of the rule, all of them together, so that no two
    /// runs are put side by side.
    groups: Vec<Group<'a>>,
    /// The coordinates of those techniques.
    coordinates: Vec<String>,
}

impl<'a> Measured<'a> {
    /// What a device's records hold of some techniques; of those whose work was counted alone, if that
    /// is asked for.
    pub(super) fn new(
        tables: &'a Tables,
        device: &'a str,
        techniques: &[&str],
        counted: bool,
    ) -> Self {
        let coordinates: Vec<String> =
            techniques.iter().flat_map(|technique| coordinates(technique)).collect();
        let mut measured = Self { tables, device, groups: Vec::new(), coordinates };
        measured.groups = measured.groups(|cell| {
            let asked = measured.coordinates.contains(&cell.name.technique);
            asked && (!counted || !cell.work.is_empty())
        });
        measured
    }

    /// The groups of this device that hold any of some cells, frames of camera paths among them.
    fn groups(&self, wanted: impl Fn(&CellResult) -> bool) -> Vec<Group<'a>> {
        let mut groups = groups(self.tables, &wanted);
        groups.extend(frames(self.tables, &wanted));
        groups.retain(|group| group.run.device() == self.device);
        groups
    }

    /// The group of a view. Of several, where the scene has other parameters in each, the first that
    /// has most of the techniques.
    fn group(&self, (scene, view): &View) -> Option<&Group<'a>> {
        let asked = |cell: &&&CellResult| self.coordinates.contains(&cell.name.technique);
        let of_view = self.groups.iter().rev().filter(|group| is_view(group, scene, view));
        of_view.max_by_key(|group| group.cells.iter().filter(asked).count())
    }

    fn cell(&self, technique: &str, place: &View) -> Result<&'a CellResult, String> {
        let (scene, view) = place;
        let group = self.group(place);
        let cell = group.and_then(|group| find(&group.cells, technique));
        let cell = cell.filter(|cell| !cell.times.is_empty());
        cell.ok_or_else(|| not_measured(technique, scene, view))
    }
}

/// The fastest sort of a group over what it is compared with, one a schedule.
fn best_of(group: &Group, depth: u64, ask: &BestQuestion) -> Vec<Best> {
    let mut schedules: BTreeMap<&str, Vec<&CellResult>> = BTreeMap::new();
    for cell in group.cells.iter().copied() {
        let technique = &cell.technique;
        let asked = technique.capture == ask.capture
            && technique.shader_stage == ask.shader_stage
            && technique.max == "peak"
            && technique.ties == "total"
            && technique.whole_pool()
            && technique.powers_of_two();
        if asked && cell.median_ms(RESOLVE).is_some_and(|ms| ms > 0.0) {
            schedules.entry(&technique.schedule).or_default().push(cell);
        }
    }
    let is_over = |cell: &CellResult| ask.over.contains(&cell.technique.sort);
    let competes = |cell: &CellResult| match ask.sorts {
        [] => !is_over(cell) && !is_floor(&cell.technique.sort),
        sorts => sorts.contains(&cell.technique.sort),
    };
    let least = |cells: &[&CellResult], which: &dyn Fn(&CellResult) -> bool| {
        let times = cells
            .iter()
            .filter(|cell| which(cell))
            .filter_map(|cell| Some((cell.median_ms(RESOLVE)?, cell.technique.sort.clone())));
        times.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let best = |cells: Vec<&CellResult>| {
        let ((own, sort), (over, _)) = (least(&cells, &competes)?, least(&cells, &is_over)?);
        Some(Best { depth, sort, ratio: own / over })
    };
    schedules.into_values().filter_map(best).collect()
}

/// An error of a cell's picture, where it was recorded.
fn error_of(cell: &CellResult, of: ErrorOf) -> Option<f64> {
    let pixels = f64::from(cell.name.width_px) * f64::from(cell.name.height_px);
    of.of(cell.verification.as_ref()?, pixels)
}

fn not_measured(technique: &str, scene: &str, view: &str) -> String {
    format!("not measured yet: no charted {technique} on {scene}, {view}")
}

impl Evidence for Measured<'_> {
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String> {
        let ms = self.cell(technique, view)?.median_ms(stage).filter(|&ms| ms > 0.0);
        ms.ok_or_else(|| format!("{technique} has no time for {stage}"))
    }

    fn memory(&self, technique: &str, view: &View) -> Result<Memory, String> {
        let cell = self.cell(technique, view)?;
        let said = cell.verification.as_ref().ok_or_else(|| "no memory recorded".to_owned())?;
        Ok(Memory {
            all_bytes: said.memory_bytes,
            lfb_bytes: said.lfb_bytes,
            lfb_bytes_at_16: lfb_bytes_at_16(said),
            slots: said.pool_final,
            pixels: u64::from(cell.name.width_px) * u64::from(cell.name.height_px),
        })
    }

    fn error(&self, technique: &str, view: &View, of: ErrorOf) -> Result<f64, String> {
        error_of(self.cell(technique, view)?, of)
            .ok_or_else(|| format!("{technique}: this error was not recorded"))
    }

    fn refused(&self, technique: &str, place: &View) -> Result<Option<String>, String> {
        let (scene, view) = place;
        let group = self.group(place);
        let cell = group.and_then(|group| find(&group.cells, technique));
        match cell {
            Some(cell) if cell.state == State::Skipped => {
                Ok(Some(cell.reason.clone().unwrap_or_default()))
            }
            Some(cell) if !cell.times.is_empty() => Ok(None),
            _ => Err(not_measured(technique, scene, view)),
        }
    }

    fn fragments(&self, place: &View) -> Result<u64, String> {
        let (scene, view) = place;
        let group = self.group(place);
        let total = group.and_then(|group| group.run.total_fragments(&group.name()));
        total.ok_or_else(|| format!("no count of {scene}, {view}"))
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
                && technique.max == ask.max
                && technique.whole_pool()
                && technique.powers_of_two()
                && [ask.sort, ask.than].contains(&technique.sort.as_str())
        };
        let has_both = |group: &Group| {
            [ask.sort, ask.than].iter().all(|&sort| {
                let timed = |cell: &&CellResult| of_family(cell) && !cell.times.is_empty();
                group.cells.iter().copied().filter(timed).any(|cell| cell.technique.sort == sort)
            })
        };
        let mut groups = groups_with(self.tables, of_family, has_both);
        groups.retain(|group| group.run.device() == self.device);
        let mut ratios = Vec::new();
        for group in groups {
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

    fn programs(&self, technique: &str, view: &View) -> Result<Vec<Told>, String> {
        let cell = self.cell(technique, view)?;
        let told = cell.programs.iter().map(|program| {
            let figures = ProgramFigures::of(program, &cell.technique.shader_stage);
            let number = |figure: Option<u64>| figure.map(|figure| figure as f64);
            let compile_ns = program.compile_ns.filter(|_| program.from_cache != Some(true));
            Told {
                high: program.high,
                registers: number(figures.registers),
                local_bytes: number(figures.local_bytes),
                binary_bytes: number(figures.binary_bytes),
                compile_ms: compile_ns.map(|ns| ns as f64 / 1e6),
            }
        });
        Ok(told.collect())
    }

    fn work(&self, ask: &WorkQuestion) -> Result<f64, String> {
        let WorkQuestion { technique, view, of, stage, pass } = *ask;
        let cell = self.cell(technique, view)?;
        let group = self.group(view).ok_or_else(|| not_measured(technique, &view.0, &view.1))?;
        let moved = |bytes_per_s: Option<f64>| {
            if pass.is_some() {
                return Err("passes of a stage are not timed apart".to_owned());
            }
            let seconds = self.time_ms(technique, view, stage)? / 1e3;
            let bytes_per_s = bytes_per_s.ok_or_else(|| "no bandwidth was measured".to_owned())?;
            Ok(bytes_per_s * seconds)
        };
        let counted = |count: Option<u64>| {
            count.map(|count| count as f64).ok_or_else(|| format!("no count of {}", view.0))
        };
        let bandwidth = group.run.bandwidth.as_ref();
        match of {
            WorkOf::Pixels => {
                Ok((u64::from(cell.name.width_px) * u64::from(cell.name.height_px)) as f64)
            }
            WorkOf::Triangles => counted(group.run.triangles(&group.name())),
            WorkOf::Spheres => counted(group.run.spheres.get(&group.name()).copied()),
            WorkOf::Fragments => counted(group.run.total_fragments(&group.name())),
            WorkOf::Layers => {
                let histogram = group.run.histogram(&group.name());
                let deepest = histogram.and_then(|pixels| pixels.iter().rposition(|&px| px > 0));
                counted(deepest.map(|deepest| deepest as u64))
            }
            WorkOf::BandwidthBytes => moved(bandwidth.map(oit_record::Bandwidth::best_bytes_per_s)),
            WorkOf::AttachmentBandwidthBytes => {
                moved(bandwidth.and_then(|told| Some(told.attachment?.bytes_per_s)))
            }
            _ => {
                let of_stage = |name: &str| stage == TOTAL || stage.split('+').any(|s| s == name);
                let asked = cell.work.iter().filter(|one| {
                    of_stage(&one.stage) && pass.is_none_or(|label| one.label.starts_with(label))
                });
                let asked: Vec<_> = asked.collect();
                if asked.is_empty() {
                    return Err(format!("{technique}: no work recorded of {stage}"));
                }
                let count = of.of(asked).map(|count| count as f64);
                count.ok_or_else(|| format!("{technique}: not all of {stage} was counted"))
            }
        }
    }

    fn best(&self, ask: &BestQuestion) -> Result<Vec<Best>, String> {
        let mut found: BTreeMap<u64, Vec<(bool, Best)>> = BTreeMap::new();
        for group in all_groups(self.tables) {
            let Some(depth) = random_depth(&group) else { continue };
            if group.run.device() == self.device && ask.depths.contains(&depth) {
                let full = group.run.run.profile == "full";
                let own = found.entry(depth).or_default();
                own.extend(best_of(&group, depth, ask).into_iter().map(|best| (full, best)));
            }
        }
        let best = |depth: &u64| {
            let mut all = found.remove(depth).unwrap_or_default();
            // The quick profile speaks where there is no other.
            let any_full = all.iter().any(|(full, _)| *full);
            all.retain(|(full, _)| *full == any_full);
            let all = all.into_iter().map(|(_, best)| best);
            all.min_by(|a, b| a.ratio.total_cmp(&b.ratio)).ok_or_else(|| {
                let BestQuestion { capture, shader_stage, .. } = ask;
                let over = ask.over.join(" or ");
                format!(
                    "{depth} random fragments, {capture}, {shader_stage}: no sort beside {over}"
                )
            })
        };
        ask.depths.iter().map(best).collect()
    }

    fn series(&self, ask: &SeriesQuestion) -> Result<Vec<SeriesPoint>, String> {
        let (scene, view) = ask.view;
        let wanted = |cell: &CellResult| {
            let named = |technique: &&str| coordinates(technique).contains(&cell.name.technique);
            cell.name.view == *view && ask.techniques.iter().any(named)
        };
        let mut longest: Vec<SeriesPoint> = Vec::new();
        for points in series(self.tables, scene, ask.varies, wanted) {
            let own = points.iter().filter(|point| point.group.run.device() == self.device);
            let point = |point: &crate::series::Point| {
                let figure = |technique: &&str| {
                    let cell = find(&point.group.cells, technique)?;
                    let charted = Some(cell).filter(|cell| !cell.times.is_empty())?;
                    match ask.of {
                        Along::Time(stage) => charted.median_ms(stage).filter(|&ms| ms > 0.0),
                        Along::Error(of) => error_of(charted, of),
                        Along::Memory => {
                            let bytes = charted.verification.as_ref()?.memory_bytes;
                            Some(bytes as f64).filter(|&bytes| bytes > 0.0)
                        }
                    }
                };
                let figures = ask.techniques.iter().map(figure).collect::<Option<Vec<f64>>>()?;
                Some(SeriesPoint { at: ask.varies.at(point), figures })
            };
            let own: Vec<SeriesPoint> = own.filter_map(point).collect();
            if own.len() > longest.len() {
                longest = own;
            }
        }
        if longest.len() < 3 {
            let techniques = ask.techniques.join(", ");
            return Err(format!("no series of {scene}, {view} with {techniques}"));
        }
        Ok(longest)
    }
}
