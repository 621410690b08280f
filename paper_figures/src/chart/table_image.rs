//! Tables as pictures, in the manner of the papers: rules above and below, marked entries on green.

use super::Chart;
use crate::FigureError;
use crate::canvas::{Anchor, Canvas, text_width, widest};
use crate::output::Table;
use crate::style::{GRID, INK, MARKED, MUTED};

/// Tables, one below the other.
#[derive(Clone, Debug)]
pub(crate) struct TableImage(pub Vec<Table>);

const TEXT_PX: f64 = 12.0;
const HEADING_PX: f64 = 14.0;
const ROW_PX: f64 = 21.0;
const GAP_PX: f64 = 14.0;
const BETWEEN_PX: f64 = 22.0;

fn heads(table: &Table) -> Vec<Vec<&str>> {
    table.columns.iter().map(|head| head.split('\n').collect()).collect()
}

fn levels(table: &Table) -> usize {
    heads(table).iter().map(Vec::len).max().unwrap_or(1)
}

/// A head is at the bottom of its column: a head of one line stands in the last line.
fn head_at<'a>(head: &[&'a str], level: usize, levels: usize) -> &'a str {
    (level + head.len()).checked_sub(levels).and_then(|line| head.get(line)).copied().unwrap_or("")
}

/// Whether a column's entries are text and not numbers: they start at its left edge.
fn is_text(table: &Table, column: usize) -> bool {
    let entries = table.rows.iter().filter_map(|row| row.get(column));
    let mut texts = entries.map(|value| value.text.as_str());
    column == 0 || texts.any(|text| text.chars().filter(char::is_ascii_alphabetic).count() > 3)
}

/// The width of every column. A joined head that is wider than its columns widens them.
fn widths(table: &Table) -> Result<Vec<f64>, FigureError> {
    let (heads, levels) = (heads(table), levels(table));
    let mut widths = Vec::new();
    for (column, head) in heads.iter().enumerate() {
        let entries = table.rows.iter().filter_map(|row| row.get(column));
        let texts = entries.map(|value| value.text.as_str());
        let lowest = head.last().copied().unwrap_or("");
        widths.push(widest(texts.chain([lowest]), TEXT_PX)? + GAP_PX);
    }
    for level in 0..levels.saturating_sub(1) {
        for (start, end, text) in spans(&heads, level, levels) {
            let (have, need) =
                (widths[start..end].iter().sum::<f64>(), text_width(text, TEXT_PX)? + GAP_PX);
            let more = ((need - have) / (end - start) as f64).max(0.0);
            widths[start..end].iter_mut().for_each(|width| *width += more);
        }
    }
    Ok(widths)
}

/// Neighbouring columns with the same head at a level (and at the levels above it).
fn spans<'a>(heads: &[Vec<&'a str>], level: usize, levels: usize) -> Vec<(usize, usize, &'a str)> {
    let key = |column: usize| -> Vec<&str> {
        (0..=level).map(|above| head_at(&heads[column], above, levels)).collect()
    };
    let mut spans = Vec::new();
    let mut start = 0;
    for column in 1..=heads.len() {
        let lowest = level + 1 == levels;
        if column == heads.len() || lowest || key(column) != key(start) {
            spans.push((start, column, head_at(&heads[start], level, levels)));
            start = column;
        }
    }
    spans
}

fn height(table: &Table) -> f64 {
    let heading = if table.heading.is_empty() { 0.0 } else { ROW_PX * 1.2 };
    heading + (levels(table) + table.rows.len()) as f64 * ROW_PX
}

impl TableImage {
    fn draw_table(table: &Table, canvas: &mut Canvas, at: (f64, f64)) -> Result<(), FigureError> {
        let (widths, heads, levels) = (widths(table)?, heads(table), levels(table));
        let lefts: Vec<f64> = widths
            .iter()
            .scan(at.0, |x, width| {
                let left = *x;
                *x += width;
                Some(left)
            })
            .collect();
        let right = lefts.last().zip(widths.last()).map_or(at.0, |(left, width)| left + width);
        let mut y = at.1;
        if !table.heading.is_empty() {
            canvas.text((at.0, y + ROW_PX / 2.0), HEADING_PX, INK, Anchor::Start, &table.heading);
            y += ROW_PX * 1.2;
        }
        canvas.line(&[(at.0, y), (right, y)], INK, 1.5);
        for level in 0..levels {
            for (start, end, text) in spans(&heads, level, levels) {
                let (from, to) = (lefts[start], lefts[end - 1] + widths[end - 1]);
                let middle = y + ROW_PX / 2.0;
                if end - start > 1 && !text.is_empty() {
                    let x = f64::midpoint(from, to);
                    canvas.text((x, middle), TEXT_PX, INK, Anchor::Middle, text);
                    canvas.line(&[(from + 4.0, y + ROW_PX), (to - 4.0, y + ROW_PX)], MUTED, 0.5);
                } else if is_text(table, start) {
                    canvas.text((from + 2.0, middle), TEXT_PX, INK, Anchor::Start, text);
                } else {
                    canvas.text((to - 6.0, middle), TEXT_PX, INK, Anchor::End, text);
                }
            }
            y += ROW_PX;
        }
        canvas.line(&[(at.0, y), (right, y)], INK, 1.0);
        for (index, row) in table.rows.iter().enumerate() {
            if index > 0 {
                canvas.line(&[(at.0, y), (right, y)], GRID, 0.5);
            }
            for (column, value) in row.iter().enumerate().take(widths.len()) {
                let (from, to) = (lefts[column], lefts[column] + widths[column]);
                if value.marked {
                    canvas.rectangle((from + 4.0, y + 2.0), (to - 1.0, y + ROW_PX - 2.0), MARKED);
                }
                let middle = y + ROW_PX / 2.0;
                if is_text(table, column) {
                    canvas.text((from + 2.0, middle), TEXT_PX, INK, Anchor::Start, &value.text);
                } else {
                    canvas.text((to - 6.0, middle), TEXT_PX, INK, Anchor::End, &value.text);
                }
            }
            y += ROW_PX;
        }
        canvas.line(&[(at.0, y), (right, y)], INK, 1.5);
        Ok(())
    }
}

impl Chart for TableImage {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let mut width: f64 = 0.0;
        for table in &self.0 {
            let heading = text_width(&table.heading, HEADING_PX)?;
            width = width.max(widths(table)?.iter().sum::<f64>()).max(heading);
        }
        let heights: f64 = self.0.iter().map(height).sum();
        Ok((width, heights + self.0.len().saturating_sub(1) as f64 * BETWEEN_PX))
    }

    fn draw(&self, canvas: &mut Canvas, at: (f64, f64)) -> Result<(), FigureError> {
        let mut y = at.1;
        for table in &self.0 {
            Self::draw_table(table, canvas, (at.0, y))?;
            y += height(table) + BETWEEN_PX;
        }
        Ok(())
    }
}
