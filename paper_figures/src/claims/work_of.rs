//! What a rule can ask of the work of passes, and what that is set against.

use oit_record::{PassKind, PassWork, RasterCounts};
use serde::Deserialize;

/// Counted work, or what it is divided by. Counts are the device's own pipeline statistics; devices count
/// by rules of their own.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkOf {
    /// Raster passes in which any primitive came to be clipped: not those that were called off.
    Passes,
    /// Runs of the vertex stage.
    VertexInvocations,
    /// Patches that were tessellated.
    Patches,
    /// Runs of the tessellation evaluation stage.
    TessellationInvocations,
    /// Runs of the geometry stage.
    GeometryInvocations,
    /// Runs of all stages before the rasteriser.
    PreRasterInvocations,
    /// Primitives that came to be clipped.
    Primitives,
    /// Primitives that clipping left.
    PrimitivesInView,
    /// Runs of the fragment stage.
    FragmentInvocations,
    /// Runs of the stages before the rasteriser, of the fragment stage and of compute shaders.
    Invocations,
    /// The most bytes that fragments write to attachments.
    AttachmentBytes,
    /// Pixels of the frame.
    Pixels,
    /// Triangles of the scene.
    Triangles,
    /// Spheres of the scene, every object in full detail.
    Spheres,
    /// Fragments of the deepest pixel.
    Layers,
    /// Fragments of all pixels, as counted by a pass of their own.
    Fragments,
    /// Bytes that the device's memory was measured to move at best, in the median of the stage's time.
    BandwidthBytes,
    /// Bytes that drawing was measured to write to attachments, in the median of the stage's time.
    AttachmentBandwidthBytes,
}

impl WorkOf {
    /// What some passes are together; `None` where a part was not counted, and of what no pass tells.
    pub(super) fn of<'a>(self, passes: impl IntoIterator<Item = &'a PassWork>) -> Option<u64> {
        let parts = passes.into_iter().map(|pass| self.of_pass(pass));
        parts.sum::<Option<u64>>()
    }

    fn of_pass(self, pass: &PassWork) -> Option<u64> {
        let raster = |count: fn(&RasterCounts) -> u64| match pass.kind {
            PassKind::Raster => pass.counted.as_ref().map(count),
            PassKind::Clear | PassKind::Compute => Some(0),
        };
        // A count of a stage that a pass does not have is 0.
        match self {
            Self::Passes => raster(|told| u64::from(told.clipping_invocations > 0)),
            Self::VertexInvocations => raster(|told| told.vertex_invocations),
            Self::Patches => raster(|told| told.tessellation_patches.unwrap_or(0)),
            Self::TessellationInvocations => {
                raster(|told| told.tessellation_invocations.unwrap_or(0))
            }
            Self::GeometryInvocations => raster(|told| told.geometry_invocations.unwrap_or(0)),
            Self::PreRasterInvocations => raster(RasterCounts::pre_raster_invocations),
            Self::Primitives => raster(|told| told.clipping_invocations),
            Self::PrimitivesInView => raster(|told| told.clipping_primitives),
            Self::FragmentInvocations => raster(|told| told.fragment_invocations),
            Self::Invocations => match pass.kind {
                PassKind::Compute => pass.compute_invocations,
                PassKind::Clear | PassKind::Raster => {
                    raster(|told| told.pre_raster_invocations() + told.fragment_invocations)
                }
            },
            Self::AttachmentBytes => pass.attachment_bytes_at_most(),
            Self::Pixels
            | Self::Triangles
            | Self::Spheres
            | Self::Layers
            | Self::Fragments
            | Self::BandwidthBytes
            | Self::AttachmentBandwidthBytes => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(kind: PassKind, counted: Option<RasterCounts>) -> PassWork {
        PassWork {
            stage: "draw".to_owned(),
            label: "made up".to_owned(),
            kind,
            cleared_bytes: 8,
            color_bytes_per_fragment: 16,
            depth_stencil_bytes_per_fragment: 4,
            compute_invocations: (kind == PassKind::Compute).then_some(512),
            counted,
        }
    }

    #[test]
    fn passes_are_added_up_and_what_is_not_counted_is_no_zero() {
        let counts = RasterCounts {
            vertex_invocations: 2,
            tessellation_patches: Some(2),
            tessellation_invocations: Some(9),
            geometry_invocations: Some(9),
            clipping_invocations: 7,
            clipping_primitives: 5,
            fragment_invocations: 100,
            ..RasterCounts::default()
        };
        // Called off: nothing is drawn.
        let off = RasterCounts::default();
        let full_screen = RasterCounts {
            vertex_invocations: 3,
            clipping_invocations: 1,
            clipping_primitives: 1,
            fragment_invocations: 50,
            ..RasterCounts::default()
        };
        let raster = |counts| pass(PassKind::Raster, Some(counts));
        let passes =
            [raster(counts), raster(off), raster(full_screen), pass(PassKind::Compute, None)];
        let of = |of: WorkOf| of.of(&passes);
        assert_eq!(of(WorkOf::Passes), Some(2));
        assert_eq!(of(WorkOf::VertexInvocations), Some(5));
        assert_eq!(of(WorkOf::Patches), Some(2));
        assert_eq!(of(WorkOf::TessellationInvocations), Some(9));
        assert_eq!(of(WorkOf::GeometryInvocations), Some(9));
        assert_eq!(of(WorkOf::PreRasterInvocations), Some(2 + 2 + 9 + 9 + 3));
        assert_eq!(of(WorkOf::Primitives), Some(8));
        assert_eq!(of(WorkOf::PrimitivesInView), Some(6));
        assert_eq!(of(WorkOf::FragmentInvocations), Some(150));
        assert_eq!(of(WorkOf::Invocations), Some(25 + 150 + 512));
        assert_eq!(of(WorkOf::AttachmentBytes), Some(150 * 20));
        assert_eq!(of(WorkOf::Pixels), None);
        // A pass that a device does not count, and a dispatch whose size it does not know.
        let unknown = [raster(counts), pass(PassKind::Raster, None)];
        assert_eq!(WorkOf::FragmentInvocations.of(&unknown), None);
        let indirect = PassWork { compute_invocations: None, ..pass(PassKind::Compute, None) };
        assert_eq!(WorkOf::Invocations.of([&indirect]), None);
        assert_eq!(WorkOf::FragmentInvocations.of([&indirect]), Some(0));
    }
}
