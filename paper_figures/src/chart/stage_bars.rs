//! Stacked bars of stage times. What comes before the resolve is grey, the darker the later; the
//! resolve has the colour of the technique's sort.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, three_digits};
use crate::canvas::{Anchor, Canvas, Colour, text_width, widest};
use crate::style::{GRID, INK, sort_colour};

/// One technique.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StageBar {
    /// Its name.
    pub label: String,
    /// Its sort, which gives the colour of its resolve.
    pub sort: String,
    /// Stages in the order they run, with their median milliseconds.
    pub stages: Vec<(String, f64)>,
    /// The median of the whole, in milliseconds.
    pub total_ms: f64,
}

/// Bars of one view.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct StageBars(pub Vec<StageBar>);

const BAR_PX: f64 = 20.0;
const PLOT_PX: f64 = 480.0;
const LEGEND_PX: f64 = 30.0;
const SCALE_PX: f64 = 46.0;

/// The colour of a stage.
#[must_use]
pub(super) fn stage_colour(stage: &str, sort: &str) -> Colour {
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

impl StageBars {
    fn label_px(&self) -> Result<f64, FigureError> {
        Ok(widest(self.0.iter().map(|bar| bar.label.as_str()), LABEL_PX)? + 10.0)
    }

    fn stages(&self) -> Vec<&str> {
        let mut stages: Vec<&str> = Vec::new();
        for (stage, _) in self.0.iter().flat_map(|bar| &bar.stages) {
            if !stages.contains(&stage.as_str()) {
                stages.push(stage);
            }
        }
        stages.sort_by_key(|stage| stage_place(stage));
        stages
    }
}

/// Where a stage stands in the order they run; stages that are not known come last.
pub(crate) fn stage_place(stage: &str) -> usize {
    let order = ["clear", "count", "scan", "capture", "group", "resolve"];
    order.iter().position(|known| *known == stage).unwrap_or(order.len())
}

impl Chart for StageBars {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let height = LEGEND_PX + self.0.len() as f64 * BAR_PX + SCALE_PX;
        Ok((self.label_px()? + PLOT_PX + 60.0, height))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let plot = left + self.label_px()?;
        let longest = self
            .0
            .iter()
            .map(|bar| bar.stages.iter().map(|(_, ms)| ms).sum::<f64>().max(bar.total_ms));
        let axis = Axis::linear(0.0, longest.fold(0.0, f64::max) * 1.02, plot, plot + PLOT_PX);
        let mut x = plot;
        for stage in self.stages() {
            // Any bar will do: the legend shows how group and resolve differ, not whose they are.
            let sort = self.0.first().map_or("", |bar| bar.sort.as_str());
            let colour = stage_colour(stage, sort);
            canvas.rectangle((x, top + 2.0), (x + 14.0, top + 14.0), colour);
            canvas.text((x + 19.0, top + 8.0), SMALL_PX, INK, Anchor::Start, stage);
            x += 19.0 + text_width(stage, SMALL_PX)? + 16.0;
        }
        let bars_top = top + LEGEND_PX;
        let bottom = bars_top + self.0.len() as f64 * BAR_PX;
        for (value, label) in axis.ticks() {
            let x = axis.at(value);
            canvas.line(&[(x, bars_top), (x, bottom)], GRID, 1.0);
            canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
        }
        let middle = plot + PLOT_PX / 2.0;
        let title = "median of each stage, ms";
        canvas.text((middle, bottom + 34.0), LABEL_PX, INK, Anchor::Middle, title);
        for (row, bar) in self.0.iter().enumerate() {
            let y = bars_top + row as f64 * BAR_PX;
            let centre = y + BAR_PX / 2.0;
            canvas.text((plot - 8.0, centre), LABEL_PX, INK, Anchor::End, &bar.label);
            let mut start = 0.0;
            for (stage, ms) in &bar.stages {
                let (from, to) = (axis.at(start), axis.at(start + ms));
                let colour = stage_colour(stage, &bar.sort);
                canvas.rectangle((from, y + 3.0), (to, y + BAR_PX - 3.0), colour);
                start += ms;
            }
            let beside = (axis.at(start) + 6.0, centre);
            canvas.text(beside, SMALL_PX, INK, Anchor::Start, &three_digits(bar.total_ms));
        }
        canvas.line(&[(plot, bars_top), (plot, bottom)], INK, 1.0);
        Ok(())
    }
}
