//! Times along a camera path as lines, before stacked areas of how many pixels are how deep.

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, number};
use crate::canvas::{Anchor, Canvas, Colour, widest};
use crate::style::{GRID, INK, MUTED};

/// A series with a value for each frame.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct FlightSeries {
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// Frame and value, from left to right.
    pub points: Vec<(f64, f64)>,
}

/// Lines before areas, under one heading.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct FlightPanel {
    /// The heading.
    pub title: String,
    /// What the lines are of, beside their axis; empty where there are none.
    pub line_title: String,
    /// The lines, on the axis to the left.
    pub lines: Vec<FlightSeries>,
    /// The areas, each on top of the one before it, on the other axis: the left one where there are
    /// no lines.
    pub areas: Vec<FlightSeries>,
}

/// Panels, two a row, over the same frames.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Flight {
    /// The panels.
    pub panels: Vec<FlightPanel>,
    /// Frames of the whole path.
    pub frames: f64,
}

const PLOT_PX: (f64, f64) = (440.0, 230.0);
const LEFT_PX: f64 = 58.0;
const RIGHT_PX: f64 = 76.0;
const HEAD_PX: f64 = 24.0;
const SCALE_PX: f64 = 46.0;
const LEGEND_STEP_PX: f64 = 17.0;
/// Grid lines over areas: darker than on paper, or they are not seen.
const OVER_AREAS: f64 = 0.72;

impl Flight {
    fn panel_px() -> (f64, f64) {
        (LEFT_PX + PLOT_PX.0 + RIGHT_PX, HEAD_PX + PLOT_PX.1 + SCALE_PX)
    }

    fn columns(&self) -> usize {
        self.panels.len().clamp(1, 2)
    }

    /// Every name in the panels once: lines first, then areas from the top of the stack down.
    fn legend(&self) -> Vec<(&str, Colour, bool)> {
        let lines = self.panels.iter().flat_map(|panel| &panel.lines);
        let areas = self.panels.iter().flat_map(|panel| panel.areas.iter().rev());
        let lines = lines.map(|line| (line.label.as_str(), line.colour, true));
        let all = lines.chain(areas.map(|area| (area.label.as_str(), area.colour, false)));
        let mut legend: Vec<(&str, Colour, bool)> = Vec::new();
        for entry in all {
            if !legend.contains(&entry) {
                legend.push(entry);
            }
        }
        legend
    }

    fn draw_panel(&self, panel: &FlightPanel, canvas: &mut Canvas, (left, top): (f64, f64)) {
        let (plot, plot_top) = (left + LEFT_PX, top + HEAD_PX);
        let (right, bottom) = (plot + PLOT_PX.0, plot_top + PLOT_PX.1);
        canvas.text((plot, top + 8.0), LABEL_PX, INK, Anchor::Start, &panel.title);
        let x_axis = Axis::linear(0.0, self.frames, plot, right);
        let mut below: Vec<f64> = Vec::new();
        let mut stacks: Vec<(Colour, Vec<f64>)> = Vec::new();
        for area in &panel.areas {
            below.resize(below.len().max(area.points.len()), 0.0);
            for (sum, (_, value)) in below.iter_mut().zip(&area.points) {
                *sum += value;
            }
            stacks.push((area.colour, below.clone()));
        }
        let most = below.iter().copied().fold(0.0, f64::max);
        // The axis of the areas ends where they do; that of the lines has room for them.
        let area_axis = Axis::linear(0.0, if most > 0.0 { most } else { 1.0 }, bottom, plot_top);
        let places: Vec<f64> =
            panel.areas.first().map_or(Vec::new(), |a| a.points.iter().map(|p| p.0).collect());
        // The deepest stack first, so that each shallower one covers its part of it.
        for (colour, tops) in stacks.iter().rev() {
            let edge = places.iter().zip(tops).map(|(&x, &y)| (x_axis.at(x), area_axis.at(y)));
            let mut corners: Vec<(f64, f64)> = edge.collect();
            if let (Some(first), Some(last)) = (corners.first().copied(), corners.last().copied()) {
                corners.extend([(last.0, bottom), (first.0, bottom)]);
                canvas.polygon(&corners, *colour);
            }
        }
        for (value, label) in x_axis.ticks() {
            let x = x_axis.at(value);
            canvas.line(&[(x, bottom), (x, bottom + 4.0)], INK, 1.0);
            canvas.text((x, bottom + 13.0), SMALL_PX, INK, Anchor::Middle, &label);
        }
        let middle = f64::midpoint(plot_top, bottom);
        let (area_at, anchor, title_at) = match panel.lines.is_empty() {
            true => (plot - 6.0, Anchor::End, left + 6.0),
            false => (right + 6.0, Anchor::Start, right + 52.0),
        };
        for (value, _) in area_axis.ticks() {
            let y = area_axis.at(value);
            if panel.lines.is_empty() {
                canvas.line(&[(plot, y), (right, y)], GRID, 0.5);
            }
            canvas.text((area_at, y), SMALL_PX, MUTED, anchor, &pixels(value));
        }
        canvas.text_upwards((title_at, middle), SMALL_PX, MUTED, "pixels");
        if !panel.lines.is_empty() {
            let values = panel.lines.iter().flat_map(|line| &line.points).map(|point| point.1);
            let high = values.fold(0.0, f64::max);
            let axis =
                Axis::linear(0.0, if high > 0.0 { high * 1.08 } else { 1.0 }, bottom, plot_top);
            for (value, label) in axis.ticks() {
                let y = axis.at(value);
                canvas.line(&[(plot, y), (right, y)], INK.tint(OVER_AREAS), 0.5);
                canvas.text((plot - 6.0, y), SMALL_PX, INK, Anchor::End, &label);
            }
            canvas.text_upwards((left + 6.0, middle), SMALL_PX, INK, &panel.line_title);
            for line in &panel.lines {
                let path = line.points.iter().map(|&(x, y)| (x_axis.at(x), axis.at(y)));
                canvas.line(&path.collect::<Vec<_>>(), line.colour, 1.8);
            }
        }
        canvas.line(&[(plot, plot_top), (plot, bottom), (right, bottom)], INK, 1.0);
        if !panel.lines.is_empty() {
            canvas.line(&[(right, plot_top), (right, bottom)], MUTED, 1.0);
        }
        let middle = (f64::midpoint(plot, right), bottom + 30.0);
        canvas.text(middle, SMALL_PX, INK, Anchor::Middle, "frame");
    }
}

/// A number of pixels as short as it can be said.
fn pixels(value: f64) -> String {
    match value {
        value if value >= 1e6 => format!("{} M", number(value / 1e6)),
        value if value >= 1e4 => format!("{} k", number(value / 1e3)),
        value => number(value),
    }
}

impl Chart for Flight {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let (width, height) = Self::panel_px();
        let legend = self.legend();
        let labels = widest(legend.iter().map(|(label, ..)| *label), SMALL_PX)? + 40.0;
        let columns = self.columns();
        let rows = self.panels.len().div_ceil(columns) as f64;
        let legend_px = legend.len() as f64 * LEGEND_STEP_PX + HEAD_PX;
        Ok((width * columns as f64 + labels, (height * rows).max(legend_px)))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (width, height) = Self::panel_px();
        let columns = self.columns();
        for (index, panel) in self.panels.iter().enumerate() {
            let (column, row) = ((index % columns) as f64, (index / columns) as f64);
            self.draw_panel(panel, canvas, (left + column * width, top + row * height));
        }
        let x = left + width * columns as f64 + 6.0;
        for (row, (label, colour, is_line)) in self.legend().into_iter().enumerate() {
            let y = top + HEAD_PX + (row as f64 + 0.5) * LEGEND_STEP_PX;
            if is_line {
                canvas.line(&[(x, y), (x + 18.0, y)], colour, 2.5);
            } else {
                canvas.rectangle((x, y - 6.0), (x + 18.0, y + 6.0), colour);
            }
            canvas.text((x + 24.0, y), SMALL_PX, INK, Anchor::Start, label);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Item;

    fn series(label: &str, values: [f64; 3]) -> FlightSeries {
        let points = values.iter().enumerate().map(|(frame, &value)| (frame as f64, value));
        FlightSeries { label: label.to_owned(), colour: INK, points: points.collect() }
    }

    fn drawn(lines: Vec<FlightSeries>) -> Canvas {
        let areas = vec![series("shallow", [1.0, 2.0, 1.0]), series("deep", [3.0, 0.0, 1.0])];
        let (title, line_title) = ("a".to_owned(), "ms".to_owned());
        let panels = vec![FlightPanel { title, line_title, lines, areas }];
        let mut canvas = Canvas::new(900.0, 400.0);
        Flight { panels, frames: 3.0 }.draw(&mut canvas, (0.0, 0.0)).unwrap();
        canvas
    }

    #[test]
    fn areas_are_stacked_on_one_another() {
        let canvas = drawn(vec![series("time", [5.0, 6.0, 7.0])]);
        let polygons = canvas.items.iter().filter_map(|item| match item {
            Item::Polygon { points, .. } => Some(points),
            _ => None,
        });
        let polygons: Vec<_> = polygons.collect();
        let bottom = HEAD_PX + PLOT_PX.1;
        let height = |area: usize, frame: usize| (bottom - polygons[area][frame].1) / PLOT_PX.1;
        // The whole stack is drawn first: 4, 2 and 2 of 4; then the lower area: 1, 2 and 1 of 4.
        let heights = [0, 1].map(|area| [0, 1, 2].map(|frame| height(area, frame)));
        assert_eq!(heights, [[1.0, 0.5, 0.5], [0.25, 0.5, 0.25]]);
    }

    #[test]
    fn no_text_lies_on_another() {
        for lines in [vec![], vec![series("time", [5.0, 6.0, 7.0])]] {
            let canvas = drawn(lines);
            let boxes = canvas.text_boxes().unwrap();
            for (index, (a, text)) in boxes.iter().enumerate() {
                for (b, other) in &boxes[index + 1..] {
                    let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                    assert!(apart, "{text} and {other}");
                }
            }
        }
    }
}
