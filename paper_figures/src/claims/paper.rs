//! The papers' own tables, as evidence: Table 2 of the register-based block sort paper, and Table 20.1
//! of the layered fragment buffer chapter.

use analysis::{RESOLVE, Ratio, TOTAL};

use super::evidence::{Evidence, Memory, SeriesPoint, SeriesQuestion, SortQuestion, View};
use crate::FigureError;
use crate::figures::{lfb_views, rbs_views};
use crate::published::{self, Published};

/// The tables that a rule can be applied to.
pub(super) struct Paper {
    rbs: Published,
    lfb: Published,
}

impl Paper {
    pub(super) fn read() -> Result<Self, FigureError> {
        let (rbs, lfb) = (published::table("rbs-table-2")?, published::table("lfb-table-20.1")?);
        Ok(Self { rbs, lfb })
    }

    fn rbs_ms(&self, technique: &str, (scene, view): &View, stage: &str) -> Option<f64> {
        let known = rbs_views::VIEWS.iter().find(|(_, s, v)| s == scene && v == view)?;
        let quantity = rbs_views::QUANTITIES.iter().find(|(_, known)| *known == stage)?;
        self.rbs.value(technique, known.0, quantity.0)
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

impl Evidence for Paper {
    fn time_ms(&self, technique: &str, view: &View, stage: &str) -> Result<f64, String> {
        let ms = self.rbs_ms(technique, view, stage);
        let ms = ms.or_else(|| self.lfb_ms(technique, view, stage));
        ms.ok_or_else(|| "in no table of the papers".to_owned())
    }

    fn memory(&self, _: &str, _: &View) -> Result<Memory, String> {
        Err("no memory is published".to_owned())
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

    fn series(&self, _: &SeriesQuestion) -> Result<Vec<SeriesPoint>, String> {
        Err("no series is published as numbers".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
