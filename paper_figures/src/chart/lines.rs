//! Lines through medians with their intervals, labelled at their ends, in panels.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, number};
use crate::canvas::{Anchor, Canvas, Colour, text_width, widest};
use crate::style::{GRID, INK, MUTED, PAPER};

/// One point.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct LinePoint {
    /// Its place on the horizontal axis.
    pub x: f64,
    /// The median and the ends of its 95 % interval; all the same where there is none.
    pub y: [f64; 3],
    /// Whether its dot is hollow.
    pub hollow: bool,
}

/// One line.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Line {
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// From left to right.
    pub points: Vec<LinePoint>,
}

/// An axis: what it is of, and what it holds.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Scale {
    /// What is measured along it.
    pub title: String,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// Whether it is logarithmic.
    pub log: bool,
    /// Whether it falls from left to right.
    pub falling: bool,
    /// The values to mark; empty for round ones.
    pub ticks: Vec<f64>,
}

impl Scale {
    /// From 0 to a little more than the greatest of some values.
    pub(crate) fn from_zero(title: &str, values: impl Iterator<Item = f64>) -> Self {
        let high = values.fold(0.0, f64::max);
        let high = if high > 0.0 { high * 1.05 } else { 1.0 };
        Self {
            title: title.to_owned(),
            low: 0.0,
            high,
            log: false,
            falling: false,
            ticks: Vec::new(),
        }
    }

    /// Logarithmic, with room at both ends.
    pub(crate) fn logarithmic(title: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        let low = values.clone().fold(f64::INFINITY, f64::min) / 1.2;
        let (title, high) = (title.to_owned(), values.fold(0.0, f64::max) * 1.2);
        Self { title, low, high, log: true, falling: false, ticks: Vec::new() }
    }

    fn axis(&self, from_px: f64, to_px: f64) -> Axis {
        let make = if self.log { Axis::log } else { Axis::linear };
        if self.falling {
            make(self.low, self.high, to_px, from_px)
        } else {
            make(self.low, self.high, from_px, to_px)
        }
    }

    fn marks(&self, axis: &Axis) -> Vec<f64> {
        if self.ticks.is_empty() {
            axis.ticks().into_iter().map(|(value, _)| value).collect()
        } else {
            self.ticks.clone()
        }
    }
}

/// Lines under one heading.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct LinePanel {
    /// The heading.
    pub title: String,
    /// The horizontal axis.
    pub x: Scale,
    /// The vertical axis; its title stands below the heading, where it says something else.
    pub y: Scale,
    /// A value of y with a line of its own across the panel.
    pub across: Option<f64>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// Panels, two a row.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Lines(pub Vec<LinePanel>);

const PLOT_WIDTH_PX: f64 = 300.0;
const PLOT_HEIGHT_PX: f64 = 260.0;
const LEFT_PX: f64 = 50.0;
const HEAD_PX: f64 = 40.0;
const SCALE_PX: f64 = 54.0;
const LABEL_STEP_PX: f64 = 14.0;

impl Lines {
    /// The height of the plots: more where a panel has more lines than fit beside it.
    fn plot_px(&self) -> f64 {
        let most = self.0.iter().map(|panel| panel.lines.len()).max().unwrap_or(0);
        PLOT_HEIGHT_PX.max(most as f64 * LABEL_STEP_PX)
    }

    fn panel_px(&self) -> Result<(f64, f64), FigureError> {
        let lines = self.0.iter().flat_map(|panel| &panel.lines);
        let labels = widest(lines.map(|line| line.label.as_str()), SMALL_PX)?;
        let titles = widest(self.0.iter().map(|panel| panel.title.as_str()), LABEL_PX)?;
        let width = (LEFT_PX + PLOT_WIDTH_PX + labels + 40.0).max(titles + 20.0);
        Ok((width, HEAD_PX + self.plot_px() + SCALE_PX))
    }

    fn draw_panel(
        &self,
        panel: &LinePanel,
        canvas: &mut Canvas,
        (left, top): (f64, f64),
    ) -> Result<(), FigureError> {
        let (plot, plot_top) = (left + LEFT_PX, top + HEAD_PX);
        let (right, bottom) = (plot + PLOT_WIDTH_PX, plot_top + self.plot_px());
        canvas.text((left, top + 8.0), LABEL_PX, INK, Anchor::Start, &panel.title);
        if panel.y.title != panel.title {
            canvas.text((left, top + 24.0), SMALL_PX, MUTED, Anchor::Start, &panel.y.title);
        }
        let x_axis = panel.x.axis(plot + 8.0, right - 4.0);
        let y_axis = panel.y.axis(bottom, plot_top);
        let marks = panel.x.marks(&x_axis).into_iter().map(|value| (x_axis.at(value), value));
        let mut marks: Vec<(f64, f64)> = marks.collect();
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut free = f64::NEG_INFINITY;
        for (x, value) in marks {
            let label = number(value);
            canvas.line(&[(x, plot_top), (x, bottom)], GRID, 1.0);
            let half = text_width(&label, SMALL_PX)? / 2.0;
            if x - half > free {
                canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
                free = x + half + 4.0;
            }
        }
        for value in panel.y.marks(&y_axis) {
            let y = y_axis.at(value);
            canvas.line(&[(plot, y), (right, y)], GRID, 1.0);
            canvas.text((plot - 6.0, y), SMALL_PX, INK, Anchor::End, &number(value));
        }
        if let Some(value) = panel.across {
            let y = y_axis.at(value);
            canvas.line(&[(plot, y), (right, y)], MUTED, 1.0);
        }
        canvas.line(&[(plot, plot_top), (plot, bottom), (right, bottom)], INK, 1.0);
        let middle = (f64::midpoint(plot, right), bottom + 30.0);
        canvas.text(middle, SMALL_PX, INK, Anchor::Middle, &panel.x.title);

        let mut labels: Vec<(f64, &Line)> = Vec::new();
        for line in &panel.lines {
            let place = |point: &LinePoint| (x_axis.at(point.x), point.y.map(|y| y_axis.at(y)));
            let path: Vec<(f64, f64)> =
                line.points.iter().map(place).map(|(x, [y, _, _])| (x, y)).collect();
            canvas.line(&path, line.colour, 2.0);
            for point in &line.points {
                let (x, [y, low, high]) = place(point);
                canvas.line(&[(x, low), (x, high)], line.colour, 1.0);
                canvas.circle((x, y), 3.5, line.colour);
                if point.hollow {
                    canvas.circle((x, y), 2.0, PAPER);
                }
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
            let Some(last) = line.points.last() else { continue };
            let (end, own) = (x_axis.at(last.x), y_axis.at(last.y[0]));
            canvas.line(&[(end + 4.0, own), (right + 8.0, y)], line.colour, 0.5);
            canvas.line(&[(right + 8.0, y), (right + 18.0, y)], line.colour, 2.5);
            canvas.text((right + 22.0, y), SMALL_PX, INK, Anchor::Start, &line.label);
        }
        Ok(())
    }
}

impl Chart for Lines {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let (width, height) = self.panel_px()?;
        let columns = self.0.len().min(2) as f64;
        Ok((width * columns, height * self.0.len().div_ceil(2) as f64))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (width, height) = self.panel_px()?;
        for (index, panel) in self.0.iter().enumerate() {
            let (column, row) = ((index % 2) as f64, (index / 2) as f64);
            self.draw_panel(panel, canvas, (left + column * width, top + row * height))?;
        }
        Ok(())
    }
}
