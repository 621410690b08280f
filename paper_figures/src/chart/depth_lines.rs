//! Times against depth complexity, both on logarithmic scales: one line a sort, labelled at its end.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, number};
use crate::canvas::{Anchor, Canvas, Colour, widest};
use crate::style::{GRID, INK};

/// Depth, and the median milliseconds with the ends of their 95 % interval.
pub(crate) type DepthPoint = (u64, [f64; 3]);

/// One sort.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthLine {
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// By rising depth.
    pub points: Vec<(u64, [f64; 3])>,
}

/// Lines under one heading.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthPanel {
    /// The heading.
    pub title: String,
    /// The lines.
    pub lines: Vec<DepthLine>,
}

/// Panels, two a row, on the same scales.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct DepthLines(pub Vec<DepthPanel>);

const PLOT_PX: (f64, f64) = (300.0, 260.0);
const LEFT_PX: f64 = 50.0;
const HEAD_PX: f64 = 26.0;
const SCALE_PX: f64 = 54.0;
const LABEL_STEP_PX: f64 = 14.0;

impl DepthLines {
    fn lines(&self) -> impl Iterator<Item = &DepthLine> {
        self.0.iter().flat_map(|panel| &panel.lines)
    }

    fn panel_px(&self) -> Result<(f64, f64), FigureError> {
        let labels = widest(self.lines().map(|line| line.label.as_str()), SMALL_PX)?;
        Ok((LEFT_PX + PLOT_PX.0 + labels + 30.0, HEAD_PX + PLOT_PX.1 + SCALE_PX))
    }

    fn depths(&self) -> Vec<u64> {
        let points = self.lines().flat_map(|line| &line.points);
        let mut depths: Vec<u64> = points.map(|(depth, _)| *depth).collect();
        depths.sort_unstable();
        depths.dedup();
        depths
    }

    fn draw_panel(&self, panel: &DepthPanel, canvas: &mut Canvas, (left, top): (f64, f64)) {
        let (plot, plot_top) = (left + LEFT_PX, top + HEAD_PX);
        let (right, bottom) = (plot + PLOT_PX.0, plot_top + PLOT_PX.1);
        canvas.text((left, top + 8.0), LABEL_PX, INK, Anchor::Start, &panel.title);
        let depths = self.depths();
        let ends = depths.first().zip(depths.last()).unwrap_or((&1, &2));
        let x_axis = Axis::log(*ends.0 as f64, *ends.1 as f64, plot + 8.0, right - 4.0);
        let times = || self.lines().flat_map(|line| &line.points).map(|(_, ms)| ms);
        let lowest = times().map(|ms| ms[1]).fold(f64::INFINITY, f64::min);
        let highest = times().map(|ms| ms[2]).fold(0.0, f64::max);
        let y_axis = Axis::log(lowest / 1.2, highest * 1.2, bottom, plot_top);
        for &depth in &depths {
            let x = x_axis.at(depth as f64);
            canvas.line(&[(x, plot_top), (x, bottom)], GRID, 1.0);
            canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &depth.to_string());
        }
        for (value, _) in y_axis.ticks() {
            let y = y_axis.at(value);
            canvas.line(&[(plot, y), (right, y)], GRID, 1.0);
            canvas.text((plot - 6.0, y), SMALL_PX, INK, Anchor::End, &number(value));
        }
        canvas.line(&[(plot, plot_top), (plot, bottom), (right, bottom)], INK, 1.0);
        let middle = (f64::midpoint(plot, right), bottom + 30.0);
        let title = "fragments of every pixel";
        canvas.text(middle, SMALL_PX, INK, Anchor::Middle, title);

        let mut labels: Vec<(f64, &DepthLine)> = Vec::new();
        for line in &panel.lines {
            let place = |&(depth, ms): &DepthPoint| {
                let x = x_axis.at(depth as f64);
                (x, ms.map(|ms| y_axis.at(ms)))
            };
            let places: Vec<(f64, [f64; 3])> = line.points.iter().map(place).collect();
            let path: Vec<(f64, f64)> = places.iter().map(|&(x, [y, _, _])| (x, y)).collect();
            canvas.line(&path, line.colour, 2.0);
            for &(x, [y, low, high]) in &places {
                canvas.line(&[(x, low), (x, high)], line.colour, 1.0);
                canvas.circle((x, y), 3.0, line.colour);
            }
            if let Some(&(_, y)) = path.last() {
                labels.push((y, line));
            }
        }
        // Labels stand where their lines end, moved down where the one above needs the room, and
        // up again where that would push them off the panel.
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut free = plot_top;
        for (y, _) in &mut labels {
            *y = y.max(free);
            free = *y + LABEL_STEP_PX;
        }
        let mut free = bottom;
        for (y, _) in labels.iter_mut().rev() {
            *y = y.min(free);
            free = *y - LABEL_STEP_PX;
        }
        for (y, line) in labels {
            let end = line.points.last().map_or(right, |(depth, _)| x_axis.at(*depth as f64));
            let own = line.points.last().map_or(y, |(_, ms)| y_axis.at(ms[0]));
            canvas.line(&[(end + 4.0, own), (right + 6.0, y)], line.colour, 0.5);
            canvas.text((right + 9.0, y), SMALL_PX, INK, Anchor::Start, &line.label);
        }
    }
}

impl Chart for DepthLines {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let (width, height) = self.panel_px()?;
        let columns = self.0.len().min(2) as f64;
        Ok((width * columns, height * self.0.len().div_ceil(2) as f64))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (width, height) = self.panel_px()?;
        for (index, panel) in self.0.iter().enumerate() {
            let (column, row) = ((index % 2) as f64, (index / 2) as f64);
            self.draw_panel(panel, canvas, (left + column * width, top + row * height));
        }
        Ok(())
    }
}
