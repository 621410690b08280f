//! A table of outcomes: what became of each thing in each case, on a colour that says how bad it is.

use super::Chart;
use crate::FigureError;
use crate::canvas::{Anchor, Canvas, Colour, text_width, widest};
use crate::style::{INK, MUTED};

/// One outcome.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Outcome {
    /// The words.
    pub text: String,
    /// What is behind them; nothing where there is no outcome.
    pub colour: Option<Colour>,
}

/// Outcomes by row and column.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct OutcomeTable {
    /// The head of the first column.
    pub rows_are: String,
    /// The heads of the others, in lines. Neighbours with the same first line share it.
    pub columns: Vec<Vec<String>>,
    /// The rows: what each is of, and one outcome a column.
    pub rows: Vec<(String, Vec<Outcome>)>,
}

const TEXT_PX: f64 = 11.0;
const ROW_PX: f64 = 18.0;
const HEAD_PX: f64 = 15.0;
const GAP_PX: f64 = 14.0;

impl OutcomeTable {
    fn head_lines(&self) -> usize {
        self.columns.iter().map(Vec::len).max().unwrap_or(0).max(1)
    }

    /// Runs of columns that share their first line: from, to, the line.
    fn shared(&self) -> Vec<(usize, usize, &str)> {
        let mut runs: Vec<(usize, usize, &str)> = Vec::new();
        for (place, head) in self.columns.iter().enumerate() {
            let first = head.first().map_or("", String::as_str);
            match runs.last_mut() {
                Some((_, to, line)) if *line == first => *to = place + 1,
                _ => runs.push((place, place + 1, first)),
            }
        }
        runs
    }

    /// The width of the first column, and those of the others.
    fn widths(&self) -> Result<(f64, Vec<f64>), FigureError> {
        let names = self.rows.iter().map(|(name, _)| name.as_str());
        let first = widest(names.chain([self.rows_are.as_str()]), TEXT_PX)? + GAP_PX;
        let mut widths = Vec::new();
        for (place, head) in self.columns.iter().enumerate() {
            let texts = self.rows.iter().filter_map(|(_, outcomes)| outcomes.get(place));
            let texts = texts.map(|outcome| outcome.text.as_str());
            let heads = head.iter().skip(1).map(String::as_str);
            widths.push(widest(texts.chain(heads), TEXT_PX)? + GAP_PX);
        }
        for (from, to, line) in self.shared() {
            let have: f64 = widths[from..to].iter().sum();
            let more = (text_width(line, TEXT_PX)? + GAP_PX - have).max(0.0) / (to - from) as f64;
            widths[from..to].iter_mut().for_each(|width| *width += more);
        }
        Ok((first, widths))
    }
}

impl Chart for OutcomeTable {
    fn size(&self) -> Result<(f64, f64), FigureError> {
        let (first, widths) = self.widths()?;
        let height = self.head_lines() as f64 * HEAD_PX + 6.0 + self.rows.len() as f64 * ROW_PX;
        Ok((first + widths.iter().sum::<f64>(), height))
    }

    fn draw(&self, canvas: &mut Canvas, (left, top): (f64, f64)) -> Result<(), FigureError> {
        let (first, widths) = self.widths()?;
        let lefts: Vec<f64> = widths
            .iter()
            .scan(left + first, |x, width| {
                *x += width;
                Some(*x - width)
            })
            .collect();
        let right = left + first + widths.iter().sum::<f64>();
        let body = top + self.head_lines() as f64 * HEAD_PX + 6.0;
        canvas.line(&[(left, top), (right, top)], INK, 1.5);
        let at = (left + 2.0, body - 6.0 - HEAD_PX / 2.0);
        canvas.text(at, TEXT_PX, MUTED, Anchor::Start, &self.rows_are);
        for (from, to, line) in self.shared() {
            let ends = (lefts[from], lefts[to - 1] + widths[to - 1]);
            let at = (ends.0 + 4.0, top + HEAD_PX / 2.0 + 2.0);
            canvas.text(at, TEXT_PX, INK, Anchor::Start, line);
            let under = top + HEAD_PX + 2.0;
            canvas.line(&[(ends.0 + 4.0, under), (ends.1 - 4.0, under)], MUTED, 0.5);
        }
        for (head, x) in self.columns.iter().zip(&lefts) {
            for (line, text) in head.iter().enumerate().skip(1) {
                let at = (x + 4.0, top + (line as f64 + 0.5) * HEAD_PX + 4.0);
                canvas.text(at, TEXT_PX, MUTED, Anchor::Start, text);
            }
        }
        canvas.line(&[(left, body), (right, body)], INK, 1.0);
        for (row, (name, outcomes)) in self.rows.iter().enumerate() {
            let y = body + row as f64 * ROW_PX;
            let middle = y + ROW_PX / 2.0;
            canvas.text((left + 2.0, middle), TEXT_PX, INK, Anchor::Start, name);
            for ((outcome, x), width) in outcomes.iter().zip(&lefts).zip(&widths) {
                if let Some(colour) = outcome.colour {
                    canvas.rectangle(
                        (x + 1.0, y + 1.0),
                        (x + width - 1.0, y + ROW_PX - 1.0),
                        colour,
                    );
                }
                canvas.text((x + 4.0, middle), TEXT_PX, INK, Anchor::Start, &outcome.text);
            }
        }
        let end = body + self.rows.len() as f64 * ROW_PX;
        canvas.line(&[(left, end), (right, end)], INK, 1.5);
        Ok(())
    }
}
