//! The kinds of chart. Each is data; drawing it adds shapes to a canvas.

mod depth_map;
mod error_scatter;
mod flight;
mod histogram;
mod lines;
mod outcome_table;
mod pictures;
mod ratio_bars;
mod share_bars;
mod stage_bars;
mod table_image;

pub(crate) use depth_map::{DepthMap, DepthMaps, MapScale};
pub(crate) use error_scatter::{ErrorScatter, ScatterPanel, ScatterPoint};
pub(crate) use flight::{Flight, FlightPanel, FlightSeries};
pub(crate) use histogram::{DepthHistogram, HistogramSeries};
pub(crate) use lines::{Line, LinePanel, LinePoint, Lines, Scale};
pub(crate) use outcome_table::{Outcome, OutcomeTable};
pub(crate) use pictures::{Picture, PictureRow, Pictures};
pub(crate) use ratio_bars::{RatioBar, RatioBars, RatioPanel};
pub(crate) use share_bars::{ShareBar, ShareBars, SharePanel};
pub(crate) use stage_bars::{StageBar, StageBars, StagePanel, stage_place};
pub(crate) use table_image::TableImage;

use crate::FigureError;
use crate::canvas::Canvas;

/// A chart that can be drawn on a canvas.
pub trait Chart {
    /// Its width and height in pixels.
    ///
    /// # Errors
    /// Where the font is damaged.
    fn size(&self) -> Result<(f64, f64), FigureError>;

    /// Draws it with its top left corner at a place.
    ///
    /// # Errors
    /// Where the font is damaged.
    fn draw(&self, canvas: &mut Canvas, at: (f64, f64)) -> Result<(), FigureError>;
}

/// Size of labels.
const LABEL_PX: f64 = 12.0;
/// Size of tick labels and annotations.
pub(crate) const SMALL_PX: f64 = 11.0;
