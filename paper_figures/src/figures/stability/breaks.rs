//! Pictures of what broke, beside the right ones, as kept beside the record.

use std::collections::BTreeSet;

use super::rule::error_text;
use super::{Entry, Study};
use crate::FigureError;
use crate::canvas::fitted;
use crate::chart::{Picture, PictureRow, Pictures, SMALL_PX};
use crate::figures::images::{self, Rgb};
use crate::output::{Csv, Output, Stamp, Table};

/// Pictures side by side, the right one first.
const ACROSS: usize = 4;

/// The most breaks of one case that are shown.
const SHOWN: usize = 6;

/// Width in which a title must fit.
const TITLE_PX: f64 = 316.0;

/// The pictures of a study's breaks, by case; breaks with the same picture once.
pub(super) fn pictures(study: &Study) -> Result<Option<Output>, FigureError> {
    let columns = vec!["case", "technique", "word", "figure", "wrong_px", "max_error", "hash"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = ["case", "technique", "what", "the same picture"].map(str::to_owned).to_vec();
    let mut table = Table { columns, ..Table::default() };
    let mut rows = Vec::new();
    let mut left_out = 0;
    for (place, case) in study.cases.iter().enumerate() {
        let mut broken: Vec<(&str, &Entry)> = Vec::new();
        for (name, entries) in &study.rows {
            let entry = entries.get(place).and_then(Option::as_ref);
            let entry = entry.filter(|entry| entry.finding.word.breaks());
            broken.extend(entry.map(|entry| (name.as_str(), entry)));
        }
        broken.sort_by(|(_, a), (_, b)| {
            let (a, b) = (&a.finding, &b.finding);
            b.word.cmp(&a.word).then(b.size.total_cmp(&a.size))
        });
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        let mut shown: Vec<Picture> = Vec::new();
        let mut right: Option<Rgb> = None;
        for (name, entry) in &broken {
            let hash = hash(entry);
            if !hash.is_empty() && !seen.insert(hash) {
                continue;
            }
            let Some(kept) = images::read_break(study.run, &entry.cell.name)? else { continue };
            if shown.len() == SHOWN {
                left_out += 1;
                continue;
            }
            let same =
                broken.iter().filter(|(_, other)| !hash.is_empty() && self::hash(other) == hash);
            let same: Vec<&str> =
                same.map(|(name, _)| *name).filter(|other| other != name).collect();
            let (word, figure) = (entry.finding.word.text(), &entry.finding.figure);
            let result = entry.cell.verification.as_ref();
            csv.rows.push(vec![
                case.title(),
                (*name).to_owned(),
                word.to_owned(),
                figure.clone(),
                result.map_or(String::new(), |result| result.wrong_px.to_string()),
                result.map_or(String::new(), |result| error_text(result.max_error)),
                hash.to_owned(),
            ]);
            table.rows.push(vec![
                case.title().into(),
                (*name).into(),
                format!("{word} {figure}").trim_end().into(),
                same.join(", ").into(),
            ]);
            let more = if same.is_empty() { String::new() } else { format!(", +{}", same.len()) };
            let title = format!("{word} {figure}: {name}{more}");
            let title = fitted(title.trim_end(), SMALL_PX, TITLE_PX)?;
            shown.push(Picture { title, width: kept.picture.width, rgb: kept.picture.bytes });
            right.get_or_insert(kept.right);
        }
        let Some(Rgb { width, bytes }) = right else { continue };
        let right = Picture { title: "The right picture".to_owned(), width, rgb: bytes };
        shown.insert(0, right);
        let mut heading = case.title();
        for across in shown.chunks(ACROSS) {
            rows.push(PictureRow { title: heading, pictures: across.to_vec() });
            heading = format!("{}, continued", case.title());
        }
    }
    if rows.is_empty() {
        return Ok(None);
    }
    let mut notes = vec![
        "Pictures are kept of what is wrong, lost, not finite or varies. Each picture is of the run or frame kept last; breaks with the same picture, bit by bit, are \
         shown once (+n: n more techniques), the worst first. What is not finite is magenta."
            .to_owned(),
    ];
    if left_out > 0 {
        notes.push(format!("Left out, since there are {SHOWN} of their case: {left_out}."));
    }
    Ok(Some(Output {
        name: study.name().replacen("stability-", "stability-breaks-", 1),
        title: format!("What broke, beside the right pictures: {}", study.run.run.experiment),
        subtitle: study.conditions(),
        chart: Box::new(Pictures {
            rows,
            scale: (Vec::new(), ["Pictures are over white.".to_owned(), String::new()]),
        }),
        tables: vec![table],
        csv,
        notes,
        stamps: [Stamp::of(study.run)].into(),
    }))
}

/// The hash of an entry's picture; empty where it has none.
fn hash<'a>(entry: &'a Entry) -> &'a str {
    let result = entry.cell.verification.as_ref();
    let stability = result.and_then(|result| result.stability.as_ref());
    stability.map_or("", |stability| stability.hash.as_str())
}
