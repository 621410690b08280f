//! How many pixels have how many fragments, on a logarithmic scale.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, number};
use crate::canvas::{Anchor, Canvas, Colour, widest};
use crate::style::{GRID, INK};

/// One view.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct HistogramSeries {
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// `pixels[n]` pixels have `n` fragments.
    pub pixels: Vec<u64>,
}

/// Views over one another.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthHistogram(pub Vec<HistogramSeries>);

const PLOT_PX: (f64, f64) = (640.0, 320.0);
const LEFT_PX: f64 = 70.0;
const SCALE_PX: f64 = 48.0;
const LABEL_STEP_PX: f64 = 17.0;

impl DepthHistogram {
    fn label_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.0.iter().map(|series| series.label.as_str()), LABEL_PX)? + 34.0)
    }
}

impl Chart for DepthHistogram {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let legend = self.0.len() as f64 * LABEL_STEP_PX;
        Ok((LEFT_PX + PLOT_PX.0 + self.label_px()?, PLOT_PX.1.max(legend) + SCALE_PX))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (plot, bottom) = (left + LEFT_PX, top + PLOT_PX.1);
        let deepest = self.0.iter().map(|series| series.pixels.len()).max().unwrap_or(1);
        let most = self.0.iter().flat_map(|s| s.pixels.iter().skip(1)).max().copied().unwrap_or(1);
        let x_axis = Axis::linear(0.0, deepest as f64, plot, plot + PLOT_PX.0);
        let y_axis = Axis::log(0.8, (most as f64 * 1.5).max(10.0), bottom, top);
        for (value, label) in x_axis.ticks() {
            let x = x_axis.at(value);
            canvas.line(&[(x, top), (x, bottom)], GRID, 1.0);
            canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
        }
        let mut last_label = f64::INFINITY;
        for (value, label) in y_axis.ticks() {
            let y = y_axis.at(value);
            canvas.line(&[(plot, y), (plot + PLOT_PX.0, y)], GRID, 1.0);
            if last_label - y > 16.0 {
                let label = if value >= 1e6 { format!("{} M", number(value / 1e6)) } else { label };
                canvas.text((plot - 6.0, y), SMALL_PX, INK, Anchor::End, &label);
                last_label = y;
            }
        }
        canvas.text_upwards((left + 10.0, top + PLOT_PX.1 / 2.0), LABEL_PX, INK, "pixels");
        let title = "fragments of a pixel (pixels without any are left out)";
        let middle = (plot + PLOT_PX.0 / 2.0, bottom + 36.0);
        canvas.text(middle, LABEL_PX, INK, Anchor::Middle, title);
        for (row, series) in self.0.iter().enumerate() {
            // What is drawn later is smaller, so that two views of the same depths both show.
            let size = (self.0.len() - 1 - row).min(3) as f64;
            // A line breaks where no pixel has that many fragments: a logarithm has no zero.
            let mut run: Vec<(f64, f64)> = Vec::new();
            for (depth, &pixels) in series.pixels.iter().enumerate().skip(1) {
                let x = x_axis.at(depth as f64);
                if pixels > 0 {
                    run.push((x, y_axis.at(pixels as f64)));
                    continue;
                }
                draw_run(canvas, &mut run, series.colour, size);
            }
            draw_run(canvas, &mut run, series.colour, size);
            let (x, y) = (plot + PLOT_PX.0 + 10.0, top + (row as f64 + 0.5) * LABEL_STEP_PX);
            canvas.line(&[(x, y), (x + 16.0, y)], series.colour, 2.5);
            canvas.text((x + 22.0, y), LABEL_PX, INK, Anchor::Start, &series.label);
        }
        canvas.line(&[(plot, top), (plot, bottom), (plot + PLOT_PX.0, bottom)], INK, 1.0);
        Ok(())
    }
}

/// Draws and empties a run of neighbouring depths. A single one is a dot.
fn draw_run(canvas: &mut Canvas, run: &mut Vec<(f64, f64)>, colour: Colour, size: f64) {
    match run.as_slice() {
        [] => {}
        [dot] => canvas.circle(*dot, 2.5 + size, colour),
        line => canvas.line(line, colour, 1.5 + size),
    }
    run.clear();
}
