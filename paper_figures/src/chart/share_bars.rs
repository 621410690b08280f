//! Bars of shares from nothing to all, in panels, each bar in parts beside one another.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::Axis;
use crate::canvas::{Anchor, Canvas, Colour, text_width, widest};
use crate::style::{GRID, INK};

/// One bar.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ShareBar {
    /// Its name.
    pub label: String,
    /// The share of each of the panel's parts: 0 to 1 together. What is above 1 is not drawn.
    pub shares: Vec<f64>,
    /// What is written beside it.
    pub annotation: String,
}

/// Bars under one heading.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct SharePanel {
    /// The heading.
    pub title: String,
    /// What parts the bars have, with their colours.
    pub parts: Vec<(String, Colour)>,
    /// The bars, top to bottom.
    pub bars: Vec<ShareBar>,
}

/// Panels, one below the other.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ShareBars(pub Vec<SharePanel>);

const BAR_PX: f64 = 20.0;
const PLOT_PX: f64 = 440.0;
const HEAD_PX: f64 = 46.0;
const SCALE_PX: f64 = 40.0;

impl SharePanel {
    fn height(&self) -> f64 {
        HEAD_PX + self.bars.len() as f64 * BAR_PX + SCALE_PX
    }

    fn draw(
        &self,
        canvas: &mut Canvas,
        (left, top): (f64, f64),
        label_px: f64,
    ) -> Result<(), FigureError> {
        let plot = left + label_px;
        canvas.text((left, top + 8.0), LABEL_PX, INK, Anchor::Start, &self.title);
        let mut x = plot;
        for (part, colour) in &self.parts {
            canvas.rectangle((x, top + 22.0), (x + 14.0, top + 34.0), *colour);
            canvas.text((x + 19.0, top + 28.0), SMALL_PX, INK, Anchor::Start, part);
            x += 19.0 + text_width(part, SMALL_PX)? + 16.0;
        }
        let axis = Axis::linear(0.0, 100.0, plot, plot + PLOT_PX);
        let bars_top = top + HEAD_PX;
        let bottom = bars_top + self.bars.len() as f64 * BAR_PX;
        for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
            let x = axis.at(percent);
            canvas.line(&[(x, bars_top), (x, bottom)], GRID, 1.0);
            let label = format!("{percent} %");
            canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
        }
        for (row, bar) in self.bars.iter().enumerate() {
            let y = bars_top + row as f64 * BAR_PX;
            let centre = y + BAR_PX / 2.0;
            canvas.text((plot - 8.0, centre), LABEL_PX, INK, Anchor::End, &bar.label);
            let mut start = 0.0;
            for (share, (_, colour)) in bar.shares.iter().zip(&self.parts) {
                let end = (start + 100.0 * share).min(100.0);
                let (from, to) = (axis.at(start), axis.at(end));
                canvas.rectangle((from, y + 3.0), (to, y + BAR_PX - 3.0), *colour);
                start = end;
            }
            let beside = (plot + PLOT_PX + 10.0, centre);
            canvas.text(beside, SMALL_PX, INK, Anchor::Start, &bar.annotation);
        }
        canvas.line(&[(plot, bars_top), (plot, bottom)], INK, 1.0);
        Ok(())
    }
}

impl ShareBars {
    fn bars(&self) -> impl Iterator<Item = &ShareBar> {
        self.0.iter().flat_map(|panel| &panel.bars)
    }

    fn label_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.bars().map(|bar| bar.label.as_str()), LABEL_PX)? + 10.0)
    }
}

impl Chart for ShareBars {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let beside = widest(self.bars().map(|bar| bar.annotation.as_str()), SMALL_PX)? + 12.0;
        let width = self.label_px()? + PLOT_PX + beside.max(24.0);
        Ok((width, self.0.iter().map(SharePanel::height).sum()))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (label_px, mut y) = (self.label_px()?, top);
        for panel in &self.0 {
            panel.draw(canvas, (left, y), label_px)?;
            y += panel.height();
        }
        Ok(())
    }
}
