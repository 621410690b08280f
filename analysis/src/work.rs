//! The work of a cell's passes, added up by stage.

use oit_record::{PassKind, PassWork, RasterCounts};

/// What passes are together. A sum with a part that is not known is `None`, never less than it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WorkSum {
    /// Runs of the stages before the rasteriser.
    pub vertex_invocations: Option<u64>,
    /// Primitives that came to be clipped.
    pub primitives: Option<u64>,
    /// Runs of the fragment stage.
    pub fragment_invocations: Option<u64>,
    /// Invocations of compute shaders; `None` where a dispatch is indirect.
    pub compute_invocations: Option<u64>,
    /// The most bytes that fragments write to attachments; what shaders write to buffers is not in it.
    pub attachment_bytes_at_most: Option<u64>,
    /// Bytes that are cleared.
    pub cleared_bytes: u64,
}

impl WorkSum {
    /// The sum of some passes.
    #[must_use]
    pub fn of<'a>(passes: impl IntoIterator<Item = &'a PassWork>) -> Self {
        let add = |sum: Option<u64>, part: Option<u64>| Some(sum?.saturating_add(part?));
        let mut sum = Self {
            vertex_invocations: Some(0),
            primitives: Some(0),
            fragment_invocations: Some(0),
            compute_invocations: Some(0),
            attachment_bytes_at_most: Some(0),
            cleared_bytes: 0,
        };
        for pass in passes {
            sum.cleared_bytes = sum.cleared_bytes.saturating_add(pass.cleared_bytes);
            match pass.kind {
                PassKind::Clear => {}
                PassKind::Compute => {
                    sum.compute_invocations =
                        add(sum.compute_invocations, pass.compute_invocations);
                }
                PassKind::Raster => {
                    let counted = |of: fn(&RasterCounts) -> u64| pass.counted.as_ref().map(of);
                    sum.vertex_invocations =
                        add(sum.vertex_invocations, counted(RasterCounts::pre_raster_invocations));
                    sum.primitives = add(sum.primitives, counted(|told| told.clipping_invocations));
                    sum.fragment_invocations =
                        add(sum.fragment_invocations, counted(|told| told.fragment_invocations));
                    sum.attachment_bytes_at_most =
                        add(sum.attachment_bytes_at_most, pass.attachment_bytes_at_most());
                }
            }
        }
        sum
    }

    /// The sum of each stage, in the order in which stages first run.
    #[must_use]
    pub fn by_stage(passes: &[PassWork]) -> Vec<(&str, Self)> {
        let mut stages: Vec<&str> = Vec::new();
        for pass in passes {
            if !stages.contains(&pass.stage.as_str()) {
                stages.push(&pass.stage);
            }
        }
        let of = |stage| Self::of(passes.iter().filter(move |pass| pass.stage == stage));
        stages.into_iter().map(|stage| (stage, of(stage))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(stage: &str, kind: PassKind, fragments: Option<u64>) -> PassWork {
        PassWork {
            stage: stage.to_owned(),
            label: "made up".to_owned(),
            kind,
            cleared_bytes: 8,
            color_bytes_per_fragment: 16,
            depth_stencil_bytes_per_fragment: 4,
            compute_invocations: None,
            counted: fragments.map(|fragment_invocations| RasterCounts {
                vertex_invocations: 3,
                geometry_invocations: Some(1),
                clipping_invocations: 2,
                fragment_invocations,
                ..RasterCounts::default()
            }),
        }
    }

    #[test]
    fn stages_that_recur_are_one_sum() {
        let passes = [
            pass("peel", PassKind::Raster, Some(10)),
            pass("clear", PassKind::Clear, None),
            pass("peel", PassKind::Raster, Some(5)),
        ];
        let [("peel", peel), ("clear", clear)] = WorkSum::by_stage(&passes)[..] else {
            panic!("other stages");
        };
        assert_eq!((peel.vertex_invocations, peel.primitives), (Some(8), Some(4)));
        assert_eq!(peel.fragment_invocations, Some(15));
        assert_eq!((peel.attachment_bytes_at_most, peel.cleared_bytes), (Some(300), 16));
        assert_eq!((clear.fragment_invocations, clear.compute_invocations), (Some(0), Some(0)));
    }

    #[test]
    fn a_part_that_is_not_known_makes_the_sum_unknown() {
        let sum = WorkSum::of(&[
            pass("peel", PassKind::Raster, Some(10)),
            pass("peel", PassKind::Raster, None),
            pass("group", PassKind::Compute, None),
        ]);
        assert_eq!((sum.fragment_invocations, sum.compute_invocations), (None, None));
        assert_eq!((sum.attachment_bytes_at_most, sum.cleared_bytes), (None, 24));
    }
}
