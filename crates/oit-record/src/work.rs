//! How much work a cell's passes are, and how many bytes its device can move: what the "speed of light"
//! view of a frame is made of (Biomolecular visualisation thesis 2018, Figure 2.1).

use serde::{Deserialize, Serialize};

/// What a device's memory was measured to move, once a run. Each is the best of several repeats.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bandwidth {
    /// Bytes of each of the two buffers that were filled and copied.
    pub buffer_bytes: u64,
    /// Bytes a second of one buffer copied to the other by a compute shader, those read and those
    /// written added up.
    pub copy_bytes_per_s: f64,
    /// Bytes a second written by a compute shader that reads nothing.
    pub fill_bytes_per_s: f64,
    /// The same of a raster pass that writes its colour attachments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attachment: Option<AttachmentBandwidth>,
    /// How often each was timed.
    pub repeats: u32,
}

/// What a raster pass over the whole of its colour attachments was measured to write.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttachmentBandwidth {
    /// Bytes of a pixel in all attachments: 16 each.
    pub bytes_per_px: u64,
    /// Pixels.
    pub pixels: u64,
    /// Bytes a second written.
    pub bytes_per_s: f64,
}

impl Bandwidth {
    /// The most bytes a second that anything was measured to move: what shares are of.
    #[must_use]
    pub fn best_bytes_per_s(&self) -> f64 {
        let attachment = self.attachment.map_or(0.0, |attachment| attachment.bytes_per_s);
        self.copy_bytes_per_s.max(self.fill_bytes_per_s).max(attachment)
    }
}

/// How much work one pass is: what follows from its plan, and what the device counts of it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PassWork {
    /// The stage that its time is charged to.
    pub stage: String,
    /// What it does.
    pub label: String,
    /// What kind of pass it is.
    pub kind: PassKind,
    /// Bytes set to one value: of the buffer that it clears, or of the attachments that are cleared
    /// before it draws. Devices may note that down and write nothing.
    #[serde(default, skip_serializing_if = "is_none")]
    pub cleared_bytes: u64,
    /// Bytes of the colour attachments that one fragment writes.
    #[serde(default, skip_serializing_if = "is_none")]
    pub color_bytes_per_fragment: u64,
    /// Bytes of depth and stencil that one fragment writes.
    #[serde(default, skip_serializing_if = "is_none")]
    pub depth_stencil_bytes_per_fragment: u64,
    /// Invocations of a compute shader, whole workgroups; `None` of an indirect dispatch and of other
    /// passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compute_invocations: Option<u64>,
    /// What the device counts of a raster pass; `None` where it does not count, and of other passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted: Option<RasterCounts>,
}

/// What kind of pass one is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PassKind {
    /// Fills a buffer.
    Clear,
    /// Runs a compute shader.
    Compute,
    /// Draws.
    Raster,
}

impl PassKind {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Compute => "compute",
            Self::Raster => "raster",
        }
    }
}

/// A device's pipeline statistics of one raster pass. A stage may run more often than there are
/// vertices or pixels (whole quads of fragments) or less (vertices used again, fragments rejected
/// early): they are the device's own count.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RasterCounts {
    /// Vertices that were put together; `None` where a backend does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_vertices: Option<u64>,
    /// Primitives that they made, before tessellation and geometry; `None` where a backend does not
    /// tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_primitives: Option<u64>,
    /// Runs of the vertex stage.
    pub vertex_invocations: u64,
    /// Patches that the tessellation control stage ran for; `None` without such a stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tessellation_patches: Option<u64>,
    /// Runs of the tessellation evaluation stage; `None` without such a stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tessellation_invocations: Option<u64>,
    /// Runs of the geometry stage; `None` without such a stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry_invocations: Option<u64>,
    /// Primitives that the geometry stage made; `None` without such a stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry_primitives: Option<u64>,
    /// Primitives that came to be clipped.
    pub clipping_invocations: u64,
    /// Primitives that clipping left.
    pub clipping_primitives: u64,
    /// Runs of the fragment stage.
    pub fragment_invocations: u64,
}

impl RasterCounts {
    /// Runs of the stages before the rasteriser: vertex, tessellation and geometry.
    #[must_use]
    pub fn pre_raster_invocations(&self) -> u64 {
        let others =
            [self.tessellation_patches, self.tessellation_invocations, self.geometry_invocations];
        others.into_iter().flatten().fold(self.vertex_invocations, u64::saturating_add)
    }
}

impl PassWork {
    /// The most bytes that the fragments of the pass write to its attachments: each of them all. What
    /// shaders write to buffers is in no count. `None` of a raster pass that is not counted; 0 of a
    /// pass that draws nothing.
    #[must_use]
    pub fn attachment_bytes_at_most(&self) -> Option<u64> {
        if self.kind != PassKind::Raster {
            return Some(0);
        }
        let of_fragment =
            self.color_bytes_per_fragment.saturating_add(self.depth_stencil_bytes_per_fragment);
        Some(self.counted?.fragment_invocations.saturating_mul(of_fragment))
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_none(bytes: &u64) -> bool {
    *bytes == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(counted: Option<RasterCounts>) -> PassWork {
        PassWork {
            stage: "capture".to_owned(),
            label: "capture: draw".to_owned(),
            kind: PassKind::Raster,
            cleared_bytes: 64,
            color_bytes_per_fragment: 16,
            depth_stencil_bytes_per_fragment: 4,
            compute_invocations: None,
            counted,
        }
    }

    #[test]
    fn what_is_not_counted_is_not_zero() {
        assert_eq!(raster(None).attachment_bytes_at_most(), None);
        let counts = RasterCounts { fragment_invocations: 7, ..RasterCounts::default() };
        assert_eq!(raster(Some(counts)).attachment_bytes_at_most(), Some(140));
        let damaged = RasterCounts { fragment_invocations: u64::MAX, ..counts };
        assert_eq!(raster(Some(damaged)).attachment_bytes_at_most(), Some(u64::MAX));
        let compute = PassWork { kind: PassKind::Compute, ..raster(None) };
        assert_eq!(compute.attachment_bytes_at_most(), Some(0));
    }

    #[test]
    fn what_is_none_is_not_written() {
        let clear = PassWork {
            stage: "clear".to_owned(),
            label: "clear heads".to_owned(),
            kind: PassKind::Clear,
            cleared_bytes: 32,
            color_bytes_per_fragment: 0,
            depth_stencil_bytes_per_fragment: 0,
            compute_invocations: None,
            counted: None,
        };
        let json = r#"{"stage":"clear","label":"clear heads","kind":"clear","cleared_bytes":32}"#;
        assert_eq!(serde_json::to_string(&clear).unwrap(), json);
        assert_eq!(serde_json::from_str::<PassWork>(json).unwrap(), clear);
        let counts = RasterCounts {
            vertex_invocations: 3,
            geometry_invocations: Some(2),
            fragment_invocations: 9,
            ..RasterCounts::default()
        };
        assert_eq!(counts.pre_raster_invocations(), 5);
        let counted = raster(Some(counts));
        let json = serde_json::to_string(&counted).unwrap();
        assert_eq!(serde_json::from_str::<PassWork>(&json).unwrap(), counted);
    }

    #[test]
    fn the_best_of_what_was_measured_counts() {
        let mut bandwidth = Bandwidth {
            buffer_bytes: 1 << 20,
            copy_bytes_per_s: 3e9,
            fill_bytes_per_s: 2e9,
            attachment: None,
            repeats: 3,
        };
        assert_eq!(bandwidth.best_bytes_per_s(), 3e9);
        let attachment = AttachmentBandwidth { bytes_per_px: 64, pixels: 4, bytes_per_s: 5e9 };
        bandwidth.attachment = Some(attachment);
        assert_eq!(bandwidth.best_bytes_per_s(), 5e9);
    }
}
