//! What a trace says of itself.

use serde::{Deserialize, Serialize};

use super::TraceError;
use crate::Lfb;

/// The order in which a trace has the fragments of a pixel.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FragmentOrder {
    /// The order in which their triangles were submitted, as the CPU rasteriser gives it.
    Submission,
    /// Whatever order the capture met them in, as on a GPU, where it may differ from run to run.
    #[default]
    Unspecified,
}

/// What a trace holds and where it comes from: its header.
///
/// [`TraceInfo::new`] fills in what the buffer itself says; the rest is for whoever captured it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceInfo {
    /// The scene, by name.
    pub scene: String,
    /// The view of it, by name.
    pub view: String,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Fragments in all.
    pub fragments: u64,
    /// The most fragments on one pixel.
    pub peak: u32,
    /// The order of the fragments of a pixel.
    pub order: FragmentOrder,
    /// The capture method, by name.
    pub capture: String,
    /// The device, by name.
    pub device: String,
    /// The version of the program.
    pub oit_version: String,
    /// The commit the program was built from, where known.
    pub git_commit: Option<String>,
    /// When it was captured: UTC, RFC 3339.
    pub created: String,
}

impl TraceInfo {
    /// The header of this buffer, with nothing said of where it comes from.
    #[must_use]
    pub fn new(lfb: &Lfb) -> Self {
        let histogram = lfb.histogram();
        Self {
            scene: String::new(),
            view: String::new(),
            width_px: lfb.width(),
            height_px: lfb.height(),
            fragments: histogram.total(),
            peak: histogram.peak(),
            order: FragmentOrder::default(),
            capture: String::new(),
            device: String::new(),
            oit_version: String::new(),
            git_commit: None,
            created: String::new(),
        }
    }

    /// Checks the sizes against a buffer's.
    pub(super) fn check(&self, lfb: &Lfb) -> Result<(), TraceError> {
        let peak = lfb.offsets().windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        let sizes = [
            ("width_px", self.width_px.into(), lfb.width().into()),
            ("height_px", self.height_px.into(), lfb.height().into()),
            ("fragments", self.fragments, lfb.fragments().len() as u64),
            ("peak", self.peak.into(), peak as u64),
        ];
        for (what, header, lfb) in sizes {
            if header != lfb {
                return Err(TraceError::Mismatch { what, header, lfb });
            }
        }
        Ok(())
    }
}
