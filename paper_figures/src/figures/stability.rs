//! Which techniques stay right, and stay the same, where methods fail: a table of techniques and cases
//! for each stability experiment, and pictures of what broke.

mod breaks;
mod cases;
mod rule;

use std::collections::BTreeMap;

use analysis::{CellResult, RunInfo, Tables, Technique};

use super::Figure;
use crate::FigureError;
use crate::chart::{Outcome, OutcomeTable};
use crate::data::{is_stability, slug};
use crate::output::{Csv, Output, Stamp, Table, Value};
use cases::{Case, cases, row_name};
use rule::{Finding, Word, find, worst};

/// The table of techniques and cases.
pub(super) struct Stability;

impl Figure for Stability {
    fn name(&self) -> &'static str {
        "stability"
    }

    fn source(&self) -> &'static str {
        "where methods fail: techniques and cases"
    }

    fn needs(&self) -> &'static str {
        "run of a stability experiment (experiments/stability-*.toml)"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (run, cells) in runs(tables) {
            let study = Study::new(run, &cells);
            if study.rows.is_empty() {
                continue;
            }
            outputs.push(study.table());
            outputs.extend(breaks::pictures(&study)?);
        }
        Ok(outputs)
    }
}

/// The run that speaks for each experiment on each device, with its cells: one of the full profile
/// before another, then the one started last.
fn runs(tables: &Tables) -> Vec<(&RunInfo, Vec<&CellResult>)> {
    let mut best: BTreeMap<(String, &str), (usize, &RunInfo)> = BTreeMap::new();
    for (place, run) in tables.runs.iter().enumerate() {
        if !is_stability(run) {
            continue;
        }
        let rank = |run: &RunInfo| (run.run.profile == "full", run.run.started.clone());
        let key = (run.device(), run.run.experiment.as_str());
        if best.get(&key).is_none_or(|(_, other)| rank(run) >= rank(other)) {
            best.insert(key, (place, run));
        }
    }
    let cells = |place| tables.results.iter().filter(|cell| cell.run == place).collect();
    best.into_values().map(|(place, run)| (run, cells(place))).collect()
}

/// What became of one technique in one case.
struct Entry<'a> {
    finding: Finding,
    /// The cell of that finding, and of a path the frame.
    cell: &'a CellResult,
}

/// One run of a stability experiment.
struct Study<'a> {
    run: &'a RunInfo,
    cases: Vec<Case<'a>>,
    /// Techniques in the order of the run, and what became of them in each case.
    rows: Vec<(String, Vec<Option<Entry<'a>>>)>,
}

impl<'a> Study<'a> {
    fn new(run: &'a RunInfo, cells: &[&'a CellResult]) -> Self {
        let cases = cases(run, cells);
        let mut rows: Vec<(String, Vec<Option<Entry>>)> = Vec::new();
        for cell in cells {
            let name = row_name(&cell.technique);
            if !rows.iter().any(|(known, _)| *known == name) {
                let entries = cases.iter().map(|case| entry(case, &name)).collect();
                rows.push((name, entries));
            }
        }
        rows.retain(|(_, entries)| entries.iter().any(Option::is_some));
        // What sorts fragments, then methods, each in the order of the run.
        rows.sort_by_key(|(name, _)| Technique::parse(name).is_method());
        Self { run, cases, rows }
    }

    fn name(&self) -> String {
        format!("{}-{}", self.run.run.experiment, slug(&self.run.device()))
    }

    fn conditions(&self) -> String {
        let cell = self.cases.first().and_then(|case| case.cells.first());
        let size = cell.map_or(String::new(), |cell| {
            format!(", {} × {} px", cell.name.width_px, cell.name.height_px)
        });
        format!("{}{size}, {} profile", self.run.device(), self.run.run.profile)
    }

    fn table(&self) -> Output {
        let mut reasons: Vec<String> = Vec::new();
        let mut csv = Csv { columns: COLUMNS.to_vec(), rows: Vec::new() };
        let mut columns = vec!["technique".to_owned()];
        columns.extend(self.cases.iter().map(Case::title));
        let mut table = Table { columns, ..Table::default() };
        let mut drawn = Vec::new();
        for (name, entries) in &self.rows {
            let mut row: Vec<Value> = vec![name.clone().into()];
            let mut outcomes = Vec::new();
            for (case, entry) in self.cases.iter().zip(entries) {
                let Some(Entry { finding, cell }) = entry else {
                    row.push("–".into());
                    outcomes.push(Outcome { text: String::new(), colour: None });
                    continue;
                };
                let mut text = finding.word.text().to_owned();
                if !finding.figure.is_empty() {
                    text += &format!(" {}", finding.figure);
                }
                if let Some(reason) = &finding.reason {
                    text += &format!(" [{}]", number_of(reason, &mut reasons));
                }
                outcomes.push(Outcome { text: text.clone(), colour: Some(finding.word.colour()) });
                row.push(Value { text, marked: finding.word.breaks() });
                csv.rows.push(fields(name, case, finding, cell));
            }
            table.rows.push(row);
            drawn.push((name.clone(), outcomes));
        }
        let mut notes: Vec<String> = self.words();
        let numbered = reasons.iter().enumerate();
        notes.extend(numbered.map(|(place, reason)| format!("[{}] {reason}.", place + 1)));
        let chart = OutcomeTable {
            rows_are: "technique".to_owned(),
            columns: self.cases.iter().map(|case| case.head.clone()).collect(),
            rows: drawn,
        };
        Output {
            name: self.name(),
            title: format!("Where methods fail: {}", self.run.run.experiment),
            subtitle: self.conditions(),
            chart: Box::new(chart),
            tables: vec![table],
            csv,
            notes,
            stamps: [Stamp::of(self.run)].into(),
        }
    }

    /// What the words of the table mean: those that are in it.
    fn words(&self) -> Vec<String> {
        let entries = || self.rows.iter().flat_map(|(_, entries)| entries.iter().flatten());
        let used = |word: Word| entries().any(|entry| entry.finding.word == word);
        let meant = Word::ALL.iter().filter(|(word, ..)| used(*word));
        meant.map(|(_, text, _, meaning)| format!("{text}: {meaning}.")).collect()
    }
}

/// A reason's number, from 1; a new one's is the next.
fn number_of(reason: &str, reasons: &mut Vec<String>) -> usize {
    let known = reasons.iter().position(|known| known == reason);
    1 + known.unwrap_or_else(|| {
        reasons.push(reason.to_owned());
        reasons.len() - 1
    })
}

/// What became of a technique in a case: of a camera path on its worst frame.
fn entry<'a>(case: &Case<'a>, name: &str) -> Option<Entry<'a>> {
    let own = case.cells.iter().filter(|cell| row_name(&cell.technique) == name);
    let mut own: Vec<&CellResult> = own.copied().collect();
    // The first frame of a path has none before it to be compared with.
    let changes = |cell: &&CellResult| {
        let stability = cell.verification.as_ref().and_then(|result| result.stability.as_ref());
        stability.is_some_and(|stability| stability.change.is_some())
    };
    if case.kind == rule::Kind::Path && own.iter().any(changes) {
        own.retain(|cell| changes(cell) || cell.verification.is_none());
    }
    let findings: Vec<(Finding, &CellResult)> =
        own.iter().filter_map(|cell| Some((find(cell, case.kind)?, *cell))).collect();
    let finding = worst(findings.iter().map(|(finding, _)| finding.clone()))?;
    let cell = findings.iter().find(|(own, _)| *own == finding).map(|(_, cell)| *cell)?;
    Some(Entry { finding, cell })
}

const COLUMNS: [&str; 21] = [
    "technique",
    "case",
    "word",
    "figure",
    "reason",
    "scene",
    "view",
    "cell",
    "verdict",
    "wrong_px",
    "max_error",
    "max_alpha_error",
    "rmse",
    "tied_px",
    "fragments_missing",
    "runs",
    "pictures",
    "repeat_differs_px",
    "change_px",
    "change_max",
    "hash",
];

fn fields(name: &str, case: &Case, finding: &Finding, cell: &CellResult) -> Vec<String> {
    let Finding { word, figure, reason, .. } = finding;
    let mut row = vec![
        name.to_owned(),
        case.title(),
        word.text().to_owned(),
        figure.clone(),
        reason.clone().unwrap_or_default(),
        cell.name.scene.clone(),
        cell.name.view.clone(),
        cell.name.technique.clone(),
    ];
    let Some(result) = &cell.verification else {
        row.resize(COLUMNS.len(), String::new());
        return row;
    };
    row.push(format!("{:?}", result.verdict).to_lowercase());
    row.push(result.wrong_px.to_string());
    row.extend([result.max_error, result.max_alpha_error, result.rmse].map(|e| format!("{e:e}")));
    row.push(result.tied_px.to_string());
    row.push(result.fragments_missing.to_string());
    let stability = result.stability.as_ref();
    let change = stability.and_then(|stability| stability.change);
    let optional = |value: Option<String>| value.unwrap_or_default();
    row.push(optional(stability.map(|stability| stability.runs.to_string())));
    row.push(optional(stability.map(|stability| stability.pictures.to_string())));
    row.push(optional(result.repeat_differs_px.map(|px| px.to_string())));
    row.push(optional(change.map(|change| change.px.to_string())));
    row.push(optional(change.map(|change| format!("{:e}", change.max))));
    row.push(optional(stability.map(|stability| stability.hash.clone())));
    row
}
