//! Drawing all figures, and the index of what was drawn and what was not.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use analysis::Tables;
use oit_record::Record;

use crate::figures::{FIGURES, Figure};
use crate::output::{Output, Stamp};
use crate::{FigureError, claims};

/// What became of a figure.
pub struct Drawn {
    /// The figure.
    pub figure: &'static dyn Figure,
    /// The names of its files without their extension, with what each is of. Empty where the
    /// records lack what it needs.
    pub files: Vec<(String, String)>,
}

/// Reads the records at or below some folders and makes tables of them.
///
/// # Errors
/// Where a record is damaged or given twice, or a folder holds none.
pub fn read(folders: &[PathBuf]) -> Result<Tables, FigureError> {
    let mut records = Vec::new();
    for folder in folders {
        let found = Record::read_all(folder).map_err(analysis::AnalysisError::from)?;
        if found.is_empty() {
            let error = std::io::Error::new(std::io::ErrorKind::NotFound, "no run folder in it");
            return Err(FigureError::Io { path: folder.clone(), error });
        }
        records.extend(found);
    }
    Ok(analysis::load(&records)?)
}

/// Writes outputs into a folder.
///
/// # Errors
/// Where drawing fails or a file cannot be written.
pub fn write_all(outputs: &[Output], folder: &Path) -> Result<Vec<(String, String)>, FigureError> {
    fs::create_dir_all(folder)
        .map_err(|error| FigureError::Io { path: folder.to_owned(), error })?;
    let mut files = Vec::new();
    for output in outputs {
        output.write(folder)?;
        files.push((output.name.clone(), format!("{}; {}", output.title, output.subtitle)));
    }
    Ok(files)
}

/// Draws figures whose name starts with `only`, all of them where it is `None`, and writes the
/// verdicts and an index beside them when all are drawn.
///
/// # Errors
/// Where no figure is named so, drawing fails, or a file cannot be written.
pub fn generate(
    tables: &Tables,
    folder: &Path,
    only: Option<&str>,
) -> Result<Vec<Drawn>, FigureError> {
    let meant = |figure: &&&'static dyn Figure| {
        // `rbs-table-2` names a figure; `pareto-planes-front` one file of a figure.
        only.is_none_or(|only| figure.name().starts_with(only) || only.starts_with(figure.name()))
    };
    let mut drawn = Vec::new();
    for figure in FIGURES.iter().filter(meant) {
        let mut outputs = figure.draw(tables)?;
        // A figure that is named is drawn whole, however its files are called (`spheres-table-3-1`).
        outputs.retain(|output| {
            only.is_none_or(|only| figure.name().starts_with(only) || output.name.starts_with(only))
        });
        drawn.push(Drawn { figure: *figure, files: write_all(&outputs, folder)? });
    }
    if drawn.is_empty() {
        let known: Vec<&str> = FIGURES.iter().map(|figure| figure.name()).collect();
        let (name, known) = (only.unwrap_or_default().to_owned(), known.join(", "));
        return Err(FigureError::Unknown { what: "figure", name, known });
    }
    if only.is_none() {
        let verdicts = claims::verdicts(tables)?;
        let files = [
            ("verdicts.md", claims::markdown(&verdicts, tables)),
            ("verdicts.csv", claims::csv(&verdicts, tables)),
            ("index.md", index(&drawn, tables)),
        ];
        for (name, text) in files {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|error| FigureError::Io { path, error })?;
        }
    }
    Ok(drawn)
}

fn index(drawn: &[Drawn], tables: &Tables) -> String {
    let mut text =
        "# Figures\n\nDrawn from records by `paper-figures`; do not edit. [Verdicts on the \
                    papers' claims](verdicts.md).\n\n"
            .to_owned();
    for Drawn { figure, files } in drawn {
        text += &format!("## {}: {}\n\n", figure.name(), figure.source());
        if files.is_empty() {
            text +=
                &format!("Not drawn: the records hold no {}.\n", without_article(figure.needs()));
        }
        for (name, of) in files {
            text += &format!(
                "- {of}: [PNG]({name}.png), [SVG]({name}.svg), [CSV]({name}.csv), \
                 [table]({name}.md)\n"
            );
        }
        text.push('\n');
    }
    text += "## Records\n\n";
    let stamps: BTreeSet<Stamp> = tables.runs.iter().map(Stamp::of).collect();
    for stamp in stamps {
        text += &format!("- {}\n", stamp.line());
    }
    text
}

fn without_article(needs: &str) -> &str {
    needs.strip_prefix("a ").unwrap_or(needs)
}
