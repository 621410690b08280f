//! Stacked bars of stage times, in panels. What comes before the resolve is grey, the darker the
//! later; the resolve has the colour of the panel's sort.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::Axis;
use crate::canvas::{Anchor, Canvas, Colour, text_width, widest};
use crate::style::{GRID, INK, sort_colour};

/// One bar.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StageBar {
    /// Its name.
    pub label: String,
    /// Stages in the order they run, with their median milliseconds.
    pub stages: Vec<(String, f64)>,
    /// What is written beside it.
    pub annotation: String,
}

/// Bars on one scale.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StagePanel {
    /// The heading.
    pub title: String,
    /// The sort, which gives the colour of the resolve.
    pub sort: String,
    /// The bars.
    pub bars: Vec<StageBar>,
}

/// Panels, one below the other, each on a scale of its own.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StageBars(pub Vec<StagePanel>);

const BAR_PX: f64 = 20.0;
const PLOT_PX: f64 = 480.0;
const HEAD_PX: f64 = 46.0;
const SCALE_PX: f64 = 48.0;

/// The colour of a stage.
#[must_use]
fn stage_colour(stage: &str, sort: &str) -> Colour {
    let grey = |level: u8| Colour(level, level, level);
    match stage {
        "clear" => grey(0xe0),
        "count" => grey(0xc4),
        "scan" => grey(0xa4),
        "capture" => grey(0x80),
        "group" => sort_colour(sort).tint(0.6),
        "resolve" => sort_colour(sort),
        _ => grey(0x40),
    }
}

/// Where a stage stands in the order they run; stages that are not known come last.
pub(crate) fn stage_place(stage: &str) -> usize {
    let order = ["clear", "count", "scan", "capture", "group", "resolve"];
    order.iter().position(|known| *known == stage).unwrap_or(order.len())
}

impl StagePanel {
    fn stages(&self) -> Vec<&str> {
        let mut stages: Vec<&str> = Vec::new();
        for (stage, _) in self.bars.iter().flat_map(|bar| &bar.stages) {
            if !stages.contains(&stage.as_str()) {
                stages.push(stage);
            }
        }
        stages.sort_by_key(|stage| stage_place(stage));
        stages
    }

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
        let length = |bar: &StageBar| bar.stages.iter().map(|(_, ms)| ms).sum::<f64>();
        let longest = self.bars.iter().map(length).fold(0.0, f64::max);
        let axis = Axis::linear(0.0, longest * 1.02, plot, plot + PLOT_PX);
        let mut x = plot;
        for stage in self.stages() {
            let (high, low) = (top + 22.0, top + 34.0);
            canvas.rectangle((x, high), (x + 14.0, low), stage_colour(stage, &self.sort));
            canvas.text((x + 19.0, top + 28.0), SMALL_PX, INK, Anchor::Start, stage);
            x += 19.0 + text_width(stage, SMALL_PX)? + 16.0;
        }
        let bars_top = top + HEAD_PX;
        let bottom = bars_top + self.bars.len() as f64 * BAR_PX;
        for (value, label) in axis.ticks() {
            let x = axis.at(value);
            canvas.line(&[(x, bars_top), (x, bottom)], GRID, 1.0);
            canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
        }
        for (row, bar) in self.bars.iter().enumerate() {
            let y = bars_top + row as f64 * BAR_PX;
            let centre = y + BAR_PX / 2.0;
            canvas.text((plot - 8.0, centre), LABEL_PX, INK, Anchor::End, &bar.label);
            let mut start = 0.0;
            for (stage, ms) in &bar.stages {
                let (from, to) = (axis.at(start), axis.at(start + ms));
                let colour = stage_colour(stage, &self.sort);
                canvas.rectangle((from, y + 3.0), (to, y + BAR_PX - 3.0), colour);
                start += ms;
            }
            let beside = (axis.at(start) + 6.0, centre);
            canvas.text(beside, SMALL_PX, INK, Anchor::Start, &bar.annotation);
        }
        canvas.line(&[(plot, bars_top), (plot, bottom)], INK, 1.0);
        Ok(())
    }
}

impl StageBars {
    fn bars(&self) -> impl Iterator<Item = &StageBar> {
        self.0.iter().flat_map(|panel| &panel.bars)
    }

    fn label_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.bars().map(|bar| bar.label.as_str()), LABEL_PX)? + 10.0)
    }
}

impl Chart for StageBars {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let beside = widest(self.bars().map(|bar| bar.annotation.as_str()), SMALL_PX)? + 12.0;
        let width = self.label_px()? + PLOT_PX + beside;
        Ok((width, self.0.iter().map(StagePanel::height).sum()))
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
