//! What a figure is made of, and the files it becomes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use analysis::RunInfo;

use crate::canvas::{Anchor, Canvas, text_width, wrapped};
use crate::chart::Chart;
use crate::style::{INK, MUTED};
use crate::{FigureError, render};

/// A figure, before it is written: a chart, the same as tables, and where it comes from.
pub struct Output {
    /// The name of its files.
    pub name: String,
    /// What it shows, as a heading.
    pub title: String,
    /// Under which conditions.
    pub subtitle: String,
    /// The chart.
    pub chart: Box<dyn Chart>,
    /// The chart in tables for readers.
    pub tables: Vec<Table>,
    /// The chart's numbers for programs.
    pub csv: Csv,
    /// What a reader must know to read it.
    pub notes: Vec<String>,
    /// The runs behind it.
    pub stamps: BTreeSet<Stamp>,
}

/// The run behind a figure.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Stamp {
    /// The device and its backend.
    pub device: String,
    /// Driver and API.
    pub driver: String,
    /// The commit measured.
    pub commit: String,
    /// The run folder's name.
    pub run: String,
    /// The command line recorded.
    pub command: String,
}

impl Stamp {
    /// The stamp of a run.
    #[must_use]
    pub fn of(run: &RunInfo) -> Self {
        let device = &run.run.device;
        Self {
            device: run.device(),
            driver: format!("{}, {}", device.driver, device.api),
            commit: run.commit(),
            run: run.name.clone(),
            command: run.run.command.join(" "),
        }
    }

    /// All of it in one line.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { device, driver, commit, run, command } = self;
        format!("{device}; {driver}; commit {commit}; run {run}; command: {command}")
    }
}

/// A table for readers.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Table {
    /// Its heading; empty for none.
    pub heading: String,
    /// Column heads. Lines of a head stand one above the other; equal neighbours are joined.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<Value>>,
}

/// One entry of a table.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Value {
    /// The text.
    pub text: String,
    /// Whether it is marked, as the fastest are.
    pub marked: bool,
}

impl<T: Into<String>> From<T> for Value {
    fn from(text: T) -> Self {
        Self { text: text.into(), marked: false }
    }
}

impl Table {
    /// The table in Markdown; marked entries are bold.
    #[must_use]
    pub fn markdown(&self) -> String {
        let escape = |text: &str| text.replace('|', "\\|").replace('\n', " ");
        let mut text = String::new();
        if !self.heading.is_empty() {
            text += &format!("## {}\n\n", self.heading);
        }
        let heads: Vec<String> = self.columns.iter().map(|head| escape(head)).collect();
        text += &format!("| {} |\n|{}\n", heads.join(" | "), " --- |".repeat(heads.len()));
        for row in &self.rows {
            let cells = row.iter().map(|value| match value.marked {
                true => format!("**{}**", escape(&value.text)),
                false => escape(&value.text),
            });
            text += &format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "));
        }
        text
    }
}

/// A table for programs: one observation a row.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Csv {
    /// The columns' names.
    pub columns: Vec<&'static str>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

impl Csv {
    /// The table as RFC 4180 text.
    #[must_use]
    pub fn text(&self) -> String {
        let quote = |field: &str| {
            if field.contains([',', '"', '\n', '\r']) {
                format!("\"{}\"", field.replace('"', "\"\""))
            } else {
                field.to_owned()
            }
        };
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            let fields: Vec<String> = row.iter().map(|field| quote(field)).collect();
            text += &(fields.join(",") + "\n");
        }
        text
    }
}

/// Space around a page.
const MARGIN: f64 = 24.0;
const TITLE_PX: f64 = 18.0;
const SUBTITLE_PX: f64 = 13.0;
const NOTE_PX: f64 = 11.0;
const STAMP_PX: f64 = 9.5;

/// Of outputs with the same name, those made of most points, by name.
#[must_use]
pub(crate) fn fullest(outputs: impl IntoIterator<Item = (usize, Output)>) -> Vec<Output> {
    let mut best: BTreeMap<String, (usize, Output)> = BTreeMap::new();
    for (points, output) in outputs {
        if best.get(&output.name).is_none_or(|(most, _)| points > *most) {
            best.insert(output.name.clone(), (points, output));
        }
    }
    best.into_values().map(|(_, output)| output).collect()
}

impl Output {
    /// The page: title, chart, notes, stamps.
    ///
    /// # Errors
    /// Where the font is damaged.
    pub fn page(&self) -> Result<Canvas, FigureError> {
        let (width, height) = self.chart.size()?;
        let title =
            text_width(&self.title, TITLE_PX)?.max(text_width(&self.subtitle, SUBTITLE_PX)?);
        let inner = width.max(title).max(480.0).ceil();
        let mut notes = Vec::new();
        for note in &self.notes {
            notes.extend(wrapped(note, NOTE_PX, inner)?);
        }
        let mut stamps = Vec::new();
        for stamp in &self.stamps {
            stamps.extend(wrapped(&stamp.line(), STAMP_PX, inner)?);
        }
        let head = MARGIN + 46.0;
        let notes_top = head + height + 12.0;
        let stamps_top = notes_top + notes.len() as f64 * 15.0 + 6.0;
        let page_height = stamps_top + stamps.len() as f64 * 13.0 + MARGIN * 0.6;
        let mut canvas = Canvas::new(inner + 2.0 * MARGIN, page_height.ceil());
        canvas.text((MARGIN, MARGIN + 4.0), TITLE_PX, INK, Anchor::Start, &self.title);
        canvas.text((MARGIN, MARGIN + 26.0), SUBTITLE_PX, MUTED, Anchor::Start, &self.subtitle);
        self.chart.draw(&mut canvas, (MARGIN, head))?;
        for (row, note) in notes.iter().enumerate() {
            let at = (MARGIN, notes_top + row as f64 * 15.0 + 7.0);
            canvas.text(at, NOTE_PX, INK, Anchor::Start, note);
        }
        for (row, stamp) in stamps.iter().enumerate() {
            let at = (MARGIN, stamps_top + row as f64 * 13.0 + 6.0);
            canvas.text(at, STAMP_PX, MUTED, Anchor::Start, stamp);
        }
        Ok(canvas)
    }

    /// The page as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n\n", self.title, self.subtitle);
        for table in &self.tables {
            text += &table.markdown();
            text.push('\n');
        }
        for note in &self.notes {
            text += &format!("{note}\n\n");
        }
        text += "Made from:\n\n";
        for Stamp { device, driver, commit, run, command } in &self.stamps {
            text += &format!("- {device}; {driver}; commit {commit}; run `{run}`; `{command}`\n");
        }
        text
    }

    /// Writes `NAME.svg`, `NAME.png`, `NAME.csv` and `NAME.md`.
    ///
    /// # Errors
    /// Where drawing fails or a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), FigureError> {
        let canvas = self.page()?;
        let stamps: Vec<String> = self.stamps.iter().map(Stamp::line).collect();
        let description = format!("{}\n{}\n{}", self.title, self.subtitle, stamps.join("\n"));
        // Comment lines, which readers of CSV can be told to skip.
        let comments: String = description.lines().map(|line| format!("# {line}\n")).collect();
        let files: [(&str, Vec<u8>); 4] = [
            ("svg", render::svg(&canvas, &description)?.into_bytes()),
            ("png", render::png(&canvas, &description)?),
            ("csv", (comments + &self.csv.text()).into_bytes()),
            ("md", self.markdown().into_bytes()),
        ];
        for (extension, bytes) in files {
            let path = folder.join(format!("{}.{extension}", self.name));
            fs::write(&path, bytes).map_err(|error| FigureError::Io { path, error })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_and_cells_are_escaped() {
        let csv = Csv { columns: vec!["a", "b"], rows: vec![vec!["1,\"2\"".into(), "3".into()]] };
        assert_eq!(csv.text(), "a,b\n\"1,\"\"2\"\"\",3\n");
        let marked = Value { text: "x|y".into(), marked: true };
        let table = Table {
            heading: String::new(),
            columns: vec!["head\nunder".into()],
            rows: vec![vec![marked]],
        };
        assert_eq!(table.markdown(), "| head under |\n| --- |\n| **x\\|y** |\n");
    }
}
