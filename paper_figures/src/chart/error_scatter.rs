//! Time against error. Exact pictures have no place on a logarithmic scale of errors: they stand on
//! an axis of their own, left of a gap. The circle around a point is its memory.

use analysis::Technique;

use super::{Chart, LABEL_PX, SMALL_PX};
use crate::FigureError;
use crate::axis::{Axis, number};
use crate::canvas::{Anchor, Canvas, Colour, fitted, text_width};
use crate::style::{GRID, INK, MUTED, marker, method_kind};

/// One technique.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ScatterPoint {
    /// The technique, which gives the marker.
    pub technique: Technique,
    /// Its name.
    pub label: String,
    /// Root mean square error; 0 where the picture is exact.
    pub rmse: f64,
    /// The time, in the panel's unit.
    pub time: f64,
    /// Device memory, which is the area of the circle around the point; 0 where it is not known.
    pub memory_bytes: u64,
    /// Whether no other is both faster and nearer to exact.
    pub front: bool,
}

/// Times of one kind.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ScatterPanel {
    /// Which times.
    pub title: String,
    /// What follows a time where it is written: ` ms`.
    pub unit: &'static str,
    /// Which errors.
    pub errors: &'static str,
    /// The techniques.
    pub points: Vec<ScatterPoint>,
}

/// Panels side by side.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct ErrorScatter(pub Vec<ScatterPanel>);

/// Stands in the legend where the sort does not matter.
const NEUTRAL: &str = "passthrough";
const PANEL_PX: f64 = 470.0;
const PANEL_GAP_PX: f64 = 30.0;
const PLOT_HEIGHT_PX: f64 = 330.0;
const LEFT_PX: f64 = 48.0;
const EXACT_PX: f64 = 70.0;
const HEAD_PX: f64 = 52.0;
const SCALE_PX: f64 = 50.0;
const LIST_STEP_PX: f64 = 16.0;
const LEGEND_STEP_PX: f64 = 20.0;
/// The radius of the largest circle of memory.
const BUBBLE_PX: f64 = 22.0;
const RING: Colour = Colour(0xa8, 0xb4, 0xc4);

/// The radius of a circle whose area is to that of the largest as its memory is.
fn bubble_px(bytes: u64, most_bytes: u64) -> f64 {
    BUBBLE_PX * (bytes as f64 / most_bytes.max(1) as f64).sqrt()
}

/// The outline of a circle: circles that lie on one another are all seen.
fn ring(canvas: &mut Canvas, (x, y): (f64, f64), radius: f64) {
    if radius <= 0.0 {
        return;
    }
    let points = (0..=48).map(|step| {
        let angle = f64::from(step) / 48.0 * std::f64::consts::TAU;
        (x + radius * angle.cos(), y + radius * angle.sin())
    });
    canvas.line(&points.collect::<Vec<_>>(), RING, 1.0);
}

/// A part of the legend: its place from the left, what it stands for, its text.
type Placed = (f64, Technique, String);

impl ScatterPanel {
    fn front(&self) -> Vec<&ScatterPoint> {
        let mut front: Vec<&ScatterPoint> = self.points.iter().filter(|p| p.front).collect();
        front.sort_by(|a, b| a.rmse.total_cmp(&b.rmse).then(a.time.total_cmp(&b.time)));
        front
    }
}

/// What is written above the column of a point: what the technique is truncated to, or the method or
/// the sort that leaves the picture off.
fn column(point: &ScatterPoint) -> &str {
    let technique = &point.technique;
    if technique.is_method() {
        &technique.coordinate
    } else if technique.truncated() {
        &technique.max
    } else {
        &technique.sort
    }
}

impl ErrorScatter {
    /// The parts of the legend: one marker a sort, one a schedule, one a stage.
    fn legend(&self) -> Vec<Vec<(Technique, String)>> {
        let points = || self.0.iter().flat_map(|panel| &panel.points);
        let kinds = |part: fn(&Technique) -> &str| {
            let parts = points().map(|point| part(&point.technique));
            // Methods have none of these parts.
            let mut names: Vec<&str> = parts.filter(|name| !name.is_empty()).collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        // Parts that a line of the legend does not tell apart are drawn neutrally.
        let neutral = |schedule: &str, sort: &str, stage: &str| Technique {
            schedule: schedule.to_owned(),
            sort: sort.to_owned(),
            shader_stage: stage.to_owned(),
            ..Technique::default()
        };
        let sorts = kinds(|technique| &technique.sort);
        let schedules = kinds(|technique| &technique.schedule);
        let stages = kinds(|technique| &technique.shader_stage);
        let methods = kinds(|technique| &technique.method);
        let mut lines = vec![
            sorts.iter().map(|sort| (neutral("base", sort, ""), (*sort).to_owned())).collect(),
            schedules
                .iter()
                .map(|schedule| (neutral(schedule, NEUTRAL, ""), (*schedule).to_owned()))
                .chain(stages.iter().map(|stage| {
                    let what =
                        if *stage == "compute" { "hollow: compute" } else { "filled: fragment" };
                    (neutral("base", NEUTRAL, stage), format!("{what} stage"))
                }))
                .collect(),
        ];
        let of_kind =
            |kind: &&str| Technique { method: (*kind).to_owned(), ..Technique::default() };
        let mut kinds: Vec<&str> = methods.iter().map(|method| method_kind(method)).collect();
        kinds.dedup();
        lines.push(kinds.iter().map(|kind| (of_kind(kind), (*kind).to_owned())).collect());
        lines.retain(|line: &Vec<_>| !line.is_empty());
        lines
    }

    /// The same with each part's place from the left, in lines as long as the panels are wide.
    fn legend_lines(&self) -> Result<Vec<Vec<Placed>>, FigureError> {
        let width = self.0.len().max(1) as f64 * (PANEL_PX + PANEL_GAP_PX) - PANEL_GAP_PX;
        let mut lines = Vec::new();
        for parts in self.legend() {
            let (mut line, mut x) = (Vec::new(), 6.0);
            for (technique, text) in parts {
                let end = x + 10.0 + text_width(&text, SMALL_PX)?;
                if end > width && !line.is_empty() {
                    lines.push(std::mem::take(&mut line));
                    x = 6.0;
                }
                let next = x + 30.0 + text_width(&text, SMALL_PX)?;
                line.push((x, technique, text));
                x = next;
            }
            lines.push(line);
        }
        Ok(lines)
    }

    /// The most memory of any point: the largest circle.
    fn most_bytes(&self) -> u64 {
        let points = self.0.iter().flat_map(|panel| &panel.points);
        points.map(|point| point.memory_bytes).max().unwrap_or(0)
    }

    fn draw_panel(
        panel: &ScatterPanel,
        most_bytes: u64,
        canvas: &mut Canvas,
        (left, top): (f64, f64),
    ) -> Result<(), FigureError> {
        let (plot, right) = (left + LEFT_PX, left + PANEL_PX);
        let (plot_top, bottom) = (top + HEAD_PX, top + HEAD_PX + PLOT_HEIGHT_PX);
        canvas.text((left, top + 8.0), LABEL_PX, INK, Anchor::Start, &panel.title);
        let times = || panel.points.iter().map(|point| point.time);
        let (fastest, slowest) =
            (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
        // A fifth of the height is left below the fastest, for the numbers of the front.
        let span = (slowest * 1.3 / fastest).max(2.0);
        let y_axis = Axis::log(fastest / span.powf(0.25), fastest * span, bottom, plot_top);
        let errors = || panel.points.iter().map(|point| point.rmse).filter(|&rmse| rmse > 0.0);
        let smallest = errors().fold(f64::INFINITY, f64::min).min(0.1);
        let largest = errors().fold(0.0, f64::max).max(smallest * 10.0);
        let (exact, split) = (plot + EXACT_PX / 2.0, plot + EXACT_PX);
        let x_axis = Axis::log(smallest / 1.6, largest * 1.6, split + 12.0, right);

        for (value, label) in y_axis.ticks() {
            let y = y_axis.at(value);
            canvas.line(&[(plot, y), (split, y)], GRID, 1.0);
            canvas.line(&[(split + 12.0, y), (right, y)], GRID, 1.0);
            canvas.text((plot - 6.0, y), SMALL_PX, INK, Anchor::End, &label);
        }
        let mut last_label = f64::NEG_INFINITY;
        for (value, label) in x_axis.ticks() {
            let x = x_axis.at(value);
            canvas.line(&[(x, plot_top), (x, bottom)], GRID, 1.0);
            if x - last_label > 40.0 {
                canvas.text((x, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, &label);
                last_label = x;
            }
        }
        canvas.text((exact, bottom + 12.0), SMALL_PX, INK, Anchor::Middle, "0 (exact)");
        canvas.line(&[(plot, plot_top), (plot, bottom), (split, bottom)], INK, 1.0);
        canvas.line(&[(split + 12.0, bottom), (right, bottom)], INK, 1.0);
        // Two strokes where the axis is broken.
        for x in [split, split + 12.0] {
            canvas.line(&[(x - 3.0, bottom + 5.0), (x + 3.0, bottom - 5.0)], INK, 1.0);
        }
        let middle = f64::midpoint(plot, right);
        canvas.text((middle, bottom + 32.0), SMALL_PX, INK, Anchor::Middle, panel.errors);

        let place = |point: &ScatterPoint| {
            let x = if point.rmse == 0.0 { exact } else { x_axis.at(point.rmse) };
            (x, y_axis.at(point.time))
        };
        for point in &panel.points {
            ring(canvas, place(point), bubble_px(point.memory_bytes, most_bytes));
        }
        let front = panel.front();
        let path: Vec<(f64, f64)> = front.iter().map(|point| place(point)).collect();
        canvas.line(&path, MUTED, 1.0);
        for point in &panel.points {
            marker(canvas, &point.technique, place(point), 4.5);
        }
        // The number of a point stands at its lower left, below those of its neighbours.
        let mut numbers: Vec<(f64, f64)> = Vec::new();
        for (index, point) in front.iter().enumerate() {
            let (x, mut y) = place(point);
            let x = x - 12.0;
            y += 9.0;
            while numbers
                .iter()
                .any(|other| (other.0 - x).abs() < 14.0 && (other.1 - y).abs() < 11.0)
            {
                y += 2.0;
            }
            numbers.push((x, y));
            let number = format!("{}", index + 1);
            canvas.text((x, y), SMALL_PX, INK, Anchor::Middle, &number);
        }
        // What the columns of points are, written above them, in two lines where they are close.
        let mut columns: Vec<(f64, &str)> = Vec::new();
        for point in panel.points.iter().filter(|point| point.rmse > 0.0) {
            if !columns.iter().any(|(_, name)| *name == column(point)) {
                columns.push((place(point).0, column(point)));
            }
        }
        columns.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ends = [f64::NEG_INFINITY; 2];
        for (x, name) in columns {
            let half = text_width(name, SMALL_PX)? / 2.0 + 3.0;
            let Some(line) = ends.iter().position(|&end| x - half > end) else { continue };
            ends[line] = x + half;
            let y = plot_top - 8.0 - line as f64 * 13.0;
            canvas.text((x, y), SMALL_PX, MUTED, Anchor::Middle, name);
        }
        let list = bottom + SCALE_PX;
        let heading = "Front: no other is both faster and nearer to exact";
        canvas.text((left, list), SMALL_PX, MUTED, Anchor::Start, heading);
        for (index, point) in front.iter().enumerate() {
            let rmse = if point.rmse == 0.0 { "exact".to_owned() } else { number(point.rmse) };
            let time = format!("{}{}", crate::axis::three_digits(point.time), panel.unit);
            let line = format!("{}  {}: {time}, {rmse}", index + 1, point.label);
            let line = fitted(&line, SMALL_PX, PANEL_PX - 16.0)?;
            let y = list + (index + 1) as f64 * LIST_STEP_PX;
            marker(canvas, &point.technique, (left + 5.0, y), 4.0);
            canvas.text((left + 16.0, y), SMALL_PX, INK, Anchor::Start, &line);
        }
        Ok(())
    }
}

impl Chart for ErrorScatter {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let panels = self.0.len() as f64;
        let width = panels * PANEL_PX + (panels - 1.0).max(0.0) * PANEL_GAP_PX;
        let longest = self.0.iter().map(|panel| panel.front().len()).max().unwrap_or(0) as f64;
        let list = (longest + 1.0) * LIST_STEP_PX;
        let lines = self.legend_lines()?.len() + usize::from(self.most_bytes() > 0);
        let legend = lines as f64 * LEGEND_STEP_PX + 8.0;
        Ok((width, legend + HEAD_PX + PLOT_HEIGHT_PX + SCALE_PX + list))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let mut y = top;
        for line in self.legend_lines()? {
            for (x, technique, text) in line {
                marker(canvas, &technique, (left + x, y + 8.0), 4.5);
                canvas.text((left + x + 10.0, y + 8.0), SMALL_PX, INK, Anchor::Start, &text);
            }
            y += LEGEND_STEP_PX;
        }
        let most = self.most_bytes();
        if most > 0 {
            let (x, mib) = (left + 14.0, most as f64 / f64::from(1 << 20));
            ring(canvas, (x, y + 8.0), 7.0);
            let mib = crate::axis::three_digits(mib);
            let text = format!("circles: device memory by area; the largest is {mib} MiB");
            canvas.text((x + 14.0, y + 8.0), SMALL_PX, INK, Anchor::Start, &text);
            y += LEGEND_STEP_PX;
        }
        for (index, panel) in self.0.iter().enumerate() {
            let x = left + index as f64 * (PANEL_PX + PANEL_GAP_PX);
            Self::draw_panel(panel, self.most_bytes(), canvas, (x, y + 8.0))?;
        }
        Ok(())
    }
}
