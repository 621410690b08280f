//! Verdicts on all claims, for every device in the records.

use std::collections::BTreeSet;

use analysis::Tables;

use super::measured::Measured;
use super::paper::Paper;
use super::rule::Rule;
use super::{Claim, ClaimKind, Finding, all};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::output::{Csv, Stamp, Table};

/// Whether a claim holds.
#[derive(Clone, PartialEq, Debug)]
pub enum Answer {
    /// Decided by a measurement.
    Measured(Finding),
    /// The records lack something.
    NotTested(String),
}

/// One claim on one device.
#[derive(Clone, PartialEq, Debug)]
pub struct Verdict {
    /// The device.
    pub device: String,
    /// The paper.
    pub paper: String,
    /// The claim.
    pub claim: Claim,
    /// Whether it holds.
    pub answer: Answer,
    /// The same figure from the paper's own numbers on the same views, where it has them.
    pub published: Option<f64>,
}

impl Verdict {
    /// `holds`, `does not hold` or `not tested`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match &self.answer {
            Answer::Measured(finding) if finding.holds => "holds",
            Answer::Measured(_) => "does not hold",
            Answer::NotTested(_) => "not tested",
        }
    }

    /// The figure that decided, or nothing.
    #[must_use]
    pub fn figure(&self) -> Option<f64> {
        match &self.answer {
            Answer::Measured(finding) => Some(finding.figure),
            Answer::NotTested(_) => None,
        }
    }

    /// The figures it is made of, or the reason why there is none.
    #[must_use]
    pub fn detail(&self) -> &str {
        match &self.answer {
            Answer::Measured(finding) => &finding.detail,
            Answer::NotTested(reason) => reason,
        }
    }
}

/// Judges every claim on every device.
///
/// # Errors
/// Where a file of claims or published numbers is damaged.
pub fn verdicts(tables: &Tables) -> Result<Vec<Verdict>, FigureError> {
    let devices: BTreeSet<String> = tables.runs.iter().map(analysis::RunInfo::device).collect();
    let (claims, paper) = (all()?, Paper::read()?);
    let mut verdicts = Vec::new();
    for device in devices {
        for file in &claims {
            for claim in &file.claims {
                let rule = &claim.rule;
                let counted = matches!(rule, Rule::Work { .. });
                let measured = Measured::new(tables, &device, &rule.techniques(), counted);
                verdicts.push(Verdict {
                    device: device.clone(),
                    paper: file.paper.clone(),
                    claim: claim.clone(),
                    answer: claim
                        .rule
                        .finding(&measured)
                        .map_or_else(Answer::NotTested, Answer::Measured),
                    published: claim.rule.finding(&paper).ok().map(|finding| finding.figure),
                });
            }
        }
    }
    Ok(verdicts)
}

fn figure(value: Option<f64>) -> String {
    // Three digits have no room for what is next to nothing.
    value.map_or("–".to_owned(), |value| match value.abs() {
        size if size > 0.0 && size < 1e-4 => number(value),
        _ => three_digits(value),
    })
}

fn stamps(tables: &Tables) -> BTreeSet<Stamp> {
    tables.runs.iter().map(Stamp::of).collect()
}

/// The verdicts as Markdown.
#[must_use]
pub fn markdown(verdicts: &[Verdict], tables: &Tables) -> String {
    let mut text =
        "# Verdicts\n\nWhether the papers' claims hold on the devices measured. The figure \
                    is the one that the rule compares; beside it, the same from the paper's own \
                    numbers on the same views, where it printed them. Sentences in quotation marks \
                    stand so in their source; known is what is said of a method, in our words.\n\n"
            .to_owned();
    let devices: BTreeSet<&str> = verdicts.iter().map(|verdict| verdict.device.as_str()).collect();
    for device in devices {
        let columns = ["claim", "verdict", "figure", "paper's own", "because", "sentence", "rule"];
        let rows = verdicts.iter().filter(|verdict| verdict.device == device).map(|verdict| {
            let claim = &verdict.claim;
            vec![
                claim.id.clone().into(),
                verdict.word().into(),
                figure(verdict.figure()).into(),
                figure(verdict.published).into(),
                verdict.detail().into(),
                match claim.kind {
                    ClaimKind::Quoted => {
                        format!("“{}” ({}, {})", claim.sentence, verdict.paper, claim.place)
                    }
                    ClaimKind::Known => format!("Known: {} ({})", claim.sentence, claim.place),
                }
                .into(),
                claim.reading.clone().into(),
            ]
        });
        let table = Table {
            heading: device.to_owned(),
            columns: columns.map(str::to_owned).to_vec(),
            rows: rows.collect(),
        };
        text += &table.markdown();
        text.push('\n');
    }
    text += "Made from:\n\n";
    for stamp in stamps(tables) {
        text += &format!("- {}\n", stamp.line());
    }
    text
}

/// The verdicts as CSV.
#[must_use]
pub fn csv(verdicts: &[Verdict], tables: &Tables) -> String {
    let columns = vec![
        "device",
        "paper",
        "place",
        "claim",
        "verdict",
        "figure",
        "published_figure",
        "detail",
        "sentence",
        "reading",
        "kind",
    ];
    let rows = verdicts.iter().map(|verdict| {
        let claim = &verdict.claim;
        let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
        vec![
            verdict.device.clone(),
            verdict.paper.clone(),
            claim.place.clone(),
            claim.id.clone(),
            verdict.word().to_owned(),
            say(verdict.figure()),
            say(verdict.published),
            verdict.detail().to_owned(),
            claim.sentence.clone(),
            claim.reading.clone(),
            claim.kind.name().to_owned(),
        ]
    });
    let comments: String =
        stamps(tables).iter().map(|stamp| format!("# {}\n", stamp.line())).collect();
    comments + &Csv { columns, rows: rows.collect() }.text()
}

/// The verdicts for a terminal: one line a claim, a block a device.
#[must_use]
pub fn printed(verdicts: &[Verdict]) -> String {
    let id_width = verdicts.iter().map(|verdict| verdict.claim.id.len()).max().unwrap_or(0);
    let mut text = String::new();
    let mut device = "";
    for verdict in verdicts {
        let of_device = || verdicts.iter().filter(|other| other.device == verdict.device);
        let none = of_device().all(|other| other.figure().is_none());
        if verdict.device != device {
            device = &verdict.device;
            text += &format!("\n{device}\n");
            if none {
                text += "  no claim can be tested by its records\n";
            }
        }
        if none {
            continue;
        }
        let (word, id) = (verdict.word(), &verdict.claim.id);
        let (own, paper) = (figure(verdict.figure()), figure(verdict.published));
        let detail = verdict.detail();
        text += &format!("  {word:13}  {id:id_width$}  {own:>6}  (paper {paper:>5})  {detail}\n");
    }
    text
}
