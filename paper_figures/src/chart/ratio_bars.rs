//! Bars of ratios from 1 to either side on a logarithmic scale, with their intervals.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::Axis;
use crate::canvas::{Anchor, Canvas, Colour, widest};
use crate::style::{GRID, INK, MUTED, PAPER};

/// One ratio.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct RatioBar {
    /// What is compared.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// The ratio, and the ends of its 95 % interval.
    pub ratio: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// What is written beside it.
    pub annotation: String,
}

/// Ratios under one heading.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct RatioPanel {
    /// The heading.
    pub title: String,
    /// The bars, top to bottom.
    pub bars: Vec<RatioBar>,
}

/// Panels of ratios on one scale.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct RatioBars {
    /// What the scale shows.
    pub axis_title: String,
    /// What it means to lie left of 1, and right of it.
    pub sides: (String, String),
    /// The panels, top to bottom.
    pub panels: Vec<RatioPanel>,
}

const BAR_PX: f64 = 20.0;
const HEADING_PX: f64 = 26.0;
const PLOT_PX: f64 = 440.0;
const SCALE_PX: f64 = 56.0;

impl RatioBars {
    fn bars(&self) -> impl Iterator<Item = &RatioBar> {
        self.panels.iter().flat_map(|panel| &panel.bars)
    }

    fn label_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.bars().map(|bar| bar.label.as_str()), LABEL_PX)? + 10.0)
    }

    fn annotation_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.bars().map(|bar| bar.annotation.as_str()), SMALL_PX)? + 12.0)
    }

    fn axis(&self, left: f64) -> Axis {
        let lowest = self.bars().map(|bar| bar.low).fold(0.5, f64::min);
        let highest = self.bars().map(|bar| bar.high).fold(2.0, f64::max);
        Axis::log(lowest / 1.1, highest * 1.1, left, left + PLOT_PX)
    }
}

impl Chart for RatioBars {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let rows = self.bars().count() as f64 * BAR_PX;
        let headings = self.panels.len() as f64 * HEADING_PX;
        Ok((self.label_px()? + PLOT_PX + self.annotation_px()?, rows + headings + SCALE_PX))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let plot = left + self.label_px()?;
        let axis = self.axis(plot);
        let bottom = top + self.size()?.1 - SCALE_PX;
        let mut last_label = f64::NEG_INFINITY;
        for (value, label) in axis.ticks() {
            let x = axis.at(value);
            canvas.line(&[(x, top), (x, bottom)], GRID, 1.0);
            if x - last_label > 34.0 {
                canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
                last_label = x;
            }
        }
        let one = axis.at(1.0);
        let middle = plot + PLOT_PX / 2.0;
        canvas.text((middle, bottom + 46.0), LABEL_PX, INK, Anchor::Middle, &self.axis_title);
        canvas.text((plot, bottom + 29.0), SMALL_PX, MUTED, Anchor::Start, &self.sides.0);
        let right = plot + PLOT_PX;
        canvas.text((right, bottom + 29.0), SMALL_PX, MUTED, Anchor::End, &self.sides.1);
        let mut y = top;
        for panel in &self.panels {
            let at = (left, y + HEADING_PX / 2.0 + 2.0);
            canvas.text(at, LABEL_PX, MUTED, Anchor::Start, &panel.title);
            y += HEADING_PX;
            for bar in &panel.bars {
                let centre = y + BAR_PX / 2.0;
                let end = axis.at(bar.ratio);
                canvas.rectangle((one, y + 3.0), (end, y + BAR_PX - 3.0), bar.colour);
                let (low, high) = (axis.at(bar.low), axis.at(bar.high));
                // A white edge keeps the whisker apart from a dark bar.
                for (colour, width) in [(PAPER, 3.5), (INK, 1.5)] {
                    canvas.line(&[(low, centre), (high, centre)], colour, width);
                    for x in [low, high] {
                        canvas.line(&[(x, centre - 4.0), (x, centre + 4.0)], colour, width);
                    }
                }
                canvas.text((plot - 8.0, centre), LABEL_PX, INK, Anchor::End, &bar.label);
                let beside = plot + PLOT_PX + 10.0;
                canvas.text((beside, centre), SMALL_PX, INK, Anchor::Start, &bar.annotation);
                y += BAR_PX;
            }
        }
        canvas.line(&[(one, top), (one, bottom)], INK, 1.5);
        Ok(())
    }
}
