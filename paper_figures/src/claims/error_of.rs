//! The figures by which a picture is compared with the oracle's.

use oit_record::{Verdict, Verification};
use serde::Deserialize;

/// Which error of a picture. Of one found exact all are those of equal pictures: what is left of them is
/// rounding, and where layers are told apart by depth alone, pixels without one right answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOf {
    /// Pixels with a colour channel off by more than 1/255, in percent.
    WrongPercent,
    /// The largest error of a colour channel.
    MaxError,
    /// The root mean square error of the colour channels.
    Rmse,
    /// The peak signal-to-noise ratio in decibels: higher is better.
    PsnrDb,
    /// The largest error of alpha.
    MaxAlphaError,
    /// Structural similarity, over black: higher is better, 1 for equal pictures.
    Ssim,
    /// The mean of FLIP, over black.
    Flip,
}

impl ErrorOf {
    /// The figure of a picture of so many pixels; `None` where it was not recorded.
    #[must_use]
    pub(crate) fn of(self, said: &Verification, pixels: f64) -> Option<f64> {
        let exact = said.verdict == Verdict::Exact;
        match self {
            Self::PsnrDb if exact => Some(f64::INFINITY),
            Self::Ssim if exact => Some(1.0),
            _ if exact => Some(0.0),
            Self::WrongPercent => Some(100.0 * said.wrong_px as f64 / pixels),
            Self::MaxError => Some(said.max_error),
            Self::Rmse => Some(said.rmse),
            Self::PsnrDb => Some(-20.0 * said.rmse.log10()),
            Self::MaxAlphaError => Some(said.max_alpha_error),
            Self::Ssim => said.ssim,
            Self::Flip => said.flip,
        }
    }
}
