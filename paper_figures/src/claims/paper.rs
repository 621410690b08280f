//! The papers' own tables, as evidence: Table 2 of the register-based block sort paper, Table 20.1 of
//! the layered fragment buffer chapter, Tables 1 and 2 of the backwards memory allocation paper, and the
//! tables of the thesis on biomolecular scenes.

use analysis::{RESOLVE, Ratio, TOTAL};

use super::error_of::ErrorOf;
use super::evidence::{
    Best, BestQuestion, Evidence, Memory, SeriesPoint, SeriesQuestion, SortQuestion, Told, View,
    WorkQuestion,
};
use crate::FigureError;
use crate::figures::{bma_views, lfb_views, rbs_views, spheres_views};
use crate::published::{self, Published};

/// The tables that a rule can be applied to.
pub(super) struct Paper {
    rbs: Published,
    lfb: Published,
    bma_intervals: Published,
    bma: Published,
    spheres: Vec<Published>,
}

impl Paper {
    pub(super) fn read() -> Result<Self, FigureError> {
        let (rbs, lfb) = (published::table("rbs-table-2")?, published::table("lfb-table-20.1")?);
        let (bma_intervals, bma) =
            (published::table("bma-table-1")?, published::table("bma-table-2")?);
        let spheres = spheres_views::TABLES.iter().map(|known| published::table(known.published));
        let spheres = spheres.collect::<Result<_, _>>()?;
        Ok(Self { rbs, lfb, bma_intervals, bma, spheres })
    }

    fn rbs_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Option<f64> {
        let known = rbs_views::VIEWS.iter().find(|(_, s, v)| s == scene && v == view)?;
        let quantity = rbs_views::QUANTITIES.iter().find(|(_, known)| *known == stage)?;
        self.rbs.value(technique, known.0, quantity.0)
    }

    /// Of intervals Table 1 has speed-ups only: the time of OIT stands as 1.
    fn bma_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Option<f64> {
        let known = bma_views::VIEWS.iter().find(|known| known.is(scene, view))?;
        let (name, max) = technique.rsplit_once(' ')?;
        if let Some(interval) = stage.strip_prefix("resolve[").and_then(|s| s.strip_suffix(']')) {
            let quantity = &self.bma_intervals.quantities[0];
            let speedup = self.bma_intervals.value(interval, known.paper, quantity)?;
            return match (name, max) {
                ("OIT-intervals", "peak") => Some(1.0),
                ("BMA-OIT", "peak") => Some(1.0 / speedup),
                _ => None,
            };
        }
        let of_max = |column: &&&str| known.allocation(&self.bma, column).as_deref() == Some(max);
        let column = bma_views::ALLOCATIONS.iter().find(of_max).filter(|_| stage == TOTAL)?;
        self.bma.value(&format!("{name} (ms)"), known.paper, column)
    }

    /// The chapter's programs are those of `base-stencil` in the fragment stage: with insertion sort,
    /// and, as far as its steps tell them apart, unsorted.
    fn lfb_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Option<f64> {
        let known = lfb_views::VIEWS.iter().find(|known| known.is(scene, view))?;
        let (schedule, shader_stage) = lfb_views::AS_PUBLISHED;
        let of_sort = |sort: &str| {
            let mut layouts = lfb_views::LAYOUTS.iter();
            let coordinate =
                |capture: &str| format!("{capture}/{schedule}/{sort}/{shader_stage}/peak");
            layouts.find(|(_, capture)| coordinate(capture) == technique).map(|(name, _)| *name)
        };
        let value = |step: &str, layout: &str| self.lfb.value(step, known.paper, layout);
        if let Some(layout) = of_sort("insertion") {
            return match stage {
                TOTAL => value("Total", layout),
                RESOLVE => Some(
                    value("Read & blend fragments", layout)? + value("Sort in shader", layout)?,
                ),
                "clear" => value("Zero tables or pointers", layout),
                "count" => value("Fragment count render", layout),
                "scan" => value("Compute prefix sums", layout),
                "capture" => value("Main LFB render", layout),
                _ => None,
            };
        }
        let layout = of_sort("unsorted").filter(|_| stage == RESOLVE)?;
        value("Read & blend fragments", layout)
    }
}

impl Paper {
    /// The thesis has sums of stages nowhere: those are made of its columns.
    fn spheres_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Option<f64> {
        let mut found = spheres_views::TABLES.iter().zip(&self.spheres);
        found.find_map(|(table, published)| {
            let on = table.is_on(scene, view);
            let value = |stage: &str| table.value(published, technique, stage);
            on.then(|| stage.split('+').map(value).sum::<Option<f64>>()).flatten()
        })
    }
}

impl Evidence for Paper {
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String> {
        let ms = self.rbs_ms(technique, view, stage);
        let ms = ms.or_else(|| self.lfb_ms(technique, view, stage));
        let ms = ms.or_else(|| self.bma_ms(technique, view, stage));
        let ms = ms.or_else(|| self.spheres_ms(technique, view, stage));
        ms.ok_or_else(|| "in no table of the papers".to_owned())
    }

    fn memory(&self, _: &str, _: &View) -> Result<Memory, String> {
        Err("no memory is published".to_owned())
    }

    fn error(&self, _: &str, _: &View, _: ErrorOf) -> Result<f64, String> {
        Err("no error of a picture is published".to_owned())
    }

    fn refused(&self, _: &str, _: &View) -> Result<Option<String>, String> {
        Err("in no table of the papers".to_owned())
    }

    fn views(&self, _: &str) -> Vec<String> {
        Vec::new()
    }

    fn fragments(&self, _: &View) -> Result<u64, String> {
        Err("no counts are used".to_owned())
    }

    fn sorts(&self, _: &SortQuestion) -> Result<Vec<Ratio>, String> {
        Err("no samples are published".to_owned())
    }

    fn programs(&self, _: &str, _: &View) -> Result<Vec<Told>, String> {
        Err("nothing is published of programs".to_owned())
    }

    fn work(&self, _: &WorkQuestion) -> Result<f64, String> {
        Err("no counts of work are published".to_owned())
    }

    fn best(&self, _: &BestQuestion) -> Result<Vec<Best>, String> {
        Err("no time at one depth is published".to_owned())
    }

    fn series(&self, _: &SeriesQuestion) -> Result<Vec<SeriesPoint>, String> {
        Err("no series is published as numbers".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_backwards_memory_allocation_are_found() {
        let paper = Paper::read().unwrap();
        let view = |scene: &str| (scene.to_owned(), "bma".to_owned());
        let ms = |technique: &str, scene: &str, stage: &str| {
            paper.time_ms(technique, &view(scene), stage).ok()
        };
        assert_eq!(ms("OIT max128", "atrium", TOTAL), Some(53.8));
        assert_eq!(ms("BMA-OIT max512", "powerplant", TOTAL), Some(206.0));
        let (oit, bma) = ("OIT-intervals peak", "BMA-OIT peak");
        let ratio =
            ms(oit, "smoke", "resolve[64]").unwrap() / ms(bma, "smoke", "resolve[64]").unwrap();
        assert!((ratio - 2.32).abs() < 1e-9);
        // Not in the paper: another size, another stage, an interval without pixels.
        assert_eq!(ms("OIT max512", "atrium", TOTAL), None);
        assert_eq!(ms("OIT compute max128", "atrium", TOTAL), None);
        assert_eq!(ms("OIT max128", "atrium", RESOLVE), None);
        assert_eq!(ms(bma, "atrium", "resolve[128]"), None);
    }

    #[test]
    fn the_chapter_s_steps_are_found() {
        let paper = Paper::read().unwrap();
        let dragon = ("dragon".to_owned(), "front".to_owned());
        let ms = |technique: &str, stage: &str| paper.time_ms(technique, &dragon, stage).ok();
        assert_eq!(ms("linearized/base-stencil/insertion/fragment/peak", TOTAL), Some(22.07));
        assert_eq!(ms("linked_list/base-stencil/unsorted/fragment/peak", RESOLVE), Some(10.16));
        let resolve = ms("linearized/base-stencil/insertion/fragment/peak", RESOLVE).unwrap();
        assert!((resolve - 9.82).abs() < 1e-9);
        // The linked list counts nothing, and the chapter has no compute stage.
        assert_eq!(ms("linked_list/base-stencil/insertion/fragment/peak", "count"), None);
        assert_eq!(ms("linked_list/base-stencil/insertion/compute/peak", TOTAL), None);
    }
}
