//! What happens where a pool has no room for all fragments: how wrong the picture is, what it costs
//! to grow the pool and render again, and whether two runs of a frame agree.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, Ratio, TOTAL, Tables, compare};
use oit_record::Verdict;

use super::Figure;
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, groups};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::{layout_colour, layout_place};

/// Overflow of the pool.
pub(super) struct LfbOverflow;

impl Figure for LfbOverflow {
    fn name(&self) -> &'static str {
        "lfb-overflow"
    }

    fn source(&self) -> &'static str {
        "pools too small, after LFB 2012, section 20.3"
    }

    fn needs(&self) -> &'static str {
        "a view with techniques whose pool is of another size than is needed, or drops fragments"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        Ok(groups(tables, wanted).iter().filter_map(output).collect())
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.pool_percent.parse::<u32>().is_ok() && !technique.whole_pool()
}

/// One cell: the pool, and what came of it.
struct Attempt<'a> {
    cell: &'a CellResult,
    percent: u32,
    wrong_share: Option<f64>,
    max_error: Option<f64>,
    missing_share: Option<f64>,
    differs_px: Option<u64>,
    /// Its time over that of the pool of the right size that may grow.
    over_whole: Option<Ratio>,
}

/// The same with a pool of the right size: one that may grow, else one that may not.
fn whole<'a>(group: &Group<'a>, cell: &CellResult) -> Option<&'a CellResult> {
    let own = (&cell.technique.capture, resolve_of(cell));
    let same = |other: &&&CellResult| {
        other.technique.pool_percent == "100"
            && (&other.technique.capture, resolve_of(other)) == own
    };
    let same: Vec<&CellResult> = group.cells.iter().filter(same).copied().collect();
    let grows = same.iter().find(|cell| cell.technique.whole_pool());
    grows.or(same.first()).copied()
}

fn attempts<'a>(group: &Group<'a>) -> Vec<Attempt<'a>> {
    let pixels = f64::from(group.width_px) * f64::from(group.height_px);
    let total = group.run.total_fragments(&group.name()).filter(|&total| total > 0);
    // Also the techniques with room for all that the others are compared with.
    let starved = || group.cells.iter().filter(|cell| wanted(cell));
    let compared: BTreeSet<usize> =
        starved().filter_map(|cell| whole(group, cell)).map(|cell| cell.cell).collect();
    let shown = group.cells.iter().filter(|cell| wanted(cell) || compared.contains(&cell.cell));
    let mut all: Vec<Attempt> = shown
        .filter_map(|&cell| {
            let exact = cell.verification.as_ref().is_some_and(|v| v.verdict == Verdict::Exact);
            let of =
                |value: fn(&oit_record::Verification) -> f64| cell.verification.as_ref().map(value);
            Some(Attempt {
                cell,
                percent: cell.technique.pool_percent.parse().ok()?,
                wrong_share: of(|v| v.wrong_px as f64).map(|px| px / pixels),
                // The last digits of an exact picture are no error.
                max_error: if exact { Some(0.0) } else { of(|v| v.max_error) },
                missing_share: of(|v| v.fragments_missing as f64)
                    .zip(total)
                    .map(|(n, all)| n / all as f64),
                differs_px: cell.verification.as_ref().and_then(|v| v.repeat_differs_px),
                over_whole: whole(group, cell).and_then(|whole| compare(cell, whole, TOTAL).ok()),
            })
        })
        .collect();
    all.sort_by_key(|attempt| {
        let t = &attempt.cell.technique;
        let technique = (layout_place(&t.capture), t.capture.clone(), resolve_of(attempt.cell));
        (technique, t.pool_policy.clone(), std::cmp::Reverse(attempt.percent))
    });
    all
}

/// What follows the capture in a coordinate, without the pool.
fn resolve_of(cell: &CellResult) -> String {
    let t = &cell.technique;
    let ties = if t.ties == "total" { String::new() } else { format!("/ties-{}", t.ties) };
    format!("{}/{}/{}/{}{ties}", t.schedule, t.sort, t.shader_stage, t.max)
}

fn output(group: &Group) -> Option<Output> {
    let attempts = attempts(group);
    let resolves: BTreeSet<String> =
        attempts.iter().map(|attempt| resolve_of(attempt.cell)).collect();
    let one_resolve = resolves.len() == 1;
    let mut lines: BTreeMap<(usize, String, String, String), Vec<&Attempt>> = BTreeMap::new();
    for attempt in &attempts {
        let t = &attempt.cell.technique;
        let resolve = if one_resolve { String::new() } else { resolve_of(attempt.cell) };
        let key = (layout_place(&t.capture), t.capture.clone(), resolve, t.pool_policy.clone());
        lines.entry(key).or_default().push(attempt);
    }
    let mut x = Scale::from_zero(
        "room in the pool, percent of what is needed",
        attempts.iter().map(|attempt| f64::from(attempt.percent)),
    );
    let percents: BTreeSet<u32> = attempts.iter().map(|attempt| attempt.percent).collect();
    // Falling, so that lines end, and are labelled, where they are apart.
    x.falling = true;
    x.ticks = percents.into_iter().map(f64::from).collect();
    let panel = |title: &str,
                 y_title: &str,
                 policies: &[&str],
                 of: &dyn Fn(&Attempt) -> Option<[f64; 3]>| {
        let own = lines.iter().filter(|((_, _, _, policy), _)| policies.contains(&policy.as_str()));
        let own = own.filter_map(|((_, capture, resolve, policy), attempts)| {
            let point = |attempt: &&Attempt| {
                let x = f64::from(attempt.percent);
                let hollow = attempt.differs_px.is_some_and(|px| px > 0);
                Some(LinePoint { x, y: of(attempt)?, hollow })
            };
            let points: Vec<LinePoint> = attempts.iter().filter_map(point).collect();
            let resolve = if resolve.is_empty() { String::new() } else { format!(" {resolve}") };
            let label = format!("{capture}{resolve}, {policy}");
            let colour = if policy == "grow" {
                layout_colour(capture).tint(0.45)
            } else {
                layout_colour(capture)
            };
            (!points.is_empty()).then_some(Line { label, colour, points })
        });
        let own: Vec<Line> = own.collect();
        let values = own.iter().flat_map(|line| &line.points).flat_map(|point| point.y);
        let y = Scale::from_zero(y_title, values);
        (!own.is_empty()).then(|| LinePanel {
            title: title.to_owned(),
            x: x.clone(),
            y,
            across: None,
            lines: own,
        })
    };
    let same = |value: Option<f64>, by: f64| value.map(|value| [value * by; 3]);
    let mut panels = vec![
        panel("Pixels wrong", "percent of all pixels", &["drop"], &|a| same(a.wrong_share, 100.0)),
        panel("Largest error", "of a colour channel, 0 to 1", &["drop"], &|a| {
            same(a.max_error, 1.0)
        }),
        panel("Fragments missing", "percent of all", &["drop"], &|a| same(a.missing_share, 100.0)),
    ];
    let time = |attempt: &Attempt| attempt.over_whole.as_ref().map(|r| [r.ratio, r.low, r.high]);
    panels.push(panel("Time", "total over that with room for all", &["grow", "drop"], &time));
    let panels: Vec<LinePanel> = panels.into_iter().flatten().collect();
    if panels.is_empty() {
        return None;
    }
    Some(Output {
        name: format!("lfb-overflow-{}-{}", group.slug(), group.device_slug()),
        title: format!("Pools too small: {}", group.title()),
        subtitle: match (one_resolve, resolves.first()) {
            (true, Some(resolve)) => format!("{}; {resolve}", group.conditions()),
            _ => group.conditions(),
        },
        chart: Box::new(Lines(panels)),
        tables: vec![table(&attempts)],
        csv: csv(group, &attempts),
        notes: vec![
            "drop: fragments without room are left out, in the order they arrive, or with a nearest \
             layout the farthest. grow: the pool grows and the frame is rendered again, and both \
             attempts are timed; its pictures are exact, and not drawn but in the times. Times are \
             ratios of medians to the same technique with a pool of 100 percent, with \
             95 % bootstrap intervals."
                .to_owned(),
            "Hollow: two runs of the same frame differ.".to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    })
}

fn percent(share: Option<f64>) -> Value {
    let text = |share: f64| match share {
        0.0 => "0".to_owned(),
        share => three_digits(share * 100.0),
    };
    share.map_or("–".to_owned(), text).into()
}

fn table(attempts: &[Attempt]) -> Table {
    let columns = [
        "layout",
        "resolve",
        "pool\n%",
        "policy",
        "picture",
        "pixels wrong\n%",
        "largest\nerror",
        "fragments missing\n%",
        "total\nms",
        "over\n100 %",
        "two runs\nagree",
    ];
    let rows = attempts.iter().map(|attempt| {
        let t = &attempt.cell.technique;
        let verdict = attempt.cell.verification.as_ref().map(|v| v.verdict);
        vec![
            t.capture.as_str().into(),
            resolve_of(attempt.cell).into(),
            attempt.percent.to_string().into(),
            t.pool_policy.as_str().into(),
            match verdict {
                Some(Verdict::Exact) => "exact",
                Some(Verdict::Approximate) => "approximate",
                Some(Verdict::Wrong) => "wrong",
                None => attempt.cell.state.name(),
            }
            .into(),
            percent(attempt.wrong_share),
            attempt.max_error.map_or("–".to_owned(), number).into(),
            percent(attempt.missing_share),
            attempt.cell.median_ms(TOTAL).map_or("–".to_owned(), three_digits).into(),
            attempt.over_whole.map_or("–".to_owned(), |ratio| format!("{:.2}", ratio.ratio)).into(),
            match attempt.differs_px {
                None => "–".into(),
                Some(0) => Value { text: "yes".to_owned(), marked: true },
                Some(px) => format!("no: {px} px").into(),
            },
        ]
    });
    let columns = columns.map(str::to_owned).to_vec();
    Table { heading: String::new(), rows: rows.collect(), columns }
}

fn csv(group: &Group, attempts: &[Attempt]) -> Csv {
    let columns = vec![
        "scene",
        "view",
        "width_px",
        "height_px",
        "technique",
        "layout",
        "pool_percent",
        "pool_policy",
        "state",
        "pool_initial",
        "pool_final",
        "pool_grown",
        "wrong_px",
        "max_error",
        "rmse",
        "fragments_missing",
        "fragments_extra",
        "repeat_differs_px",
        "memory_bytes",
        "peak_bytes",
        "total_ms",
        "over_whole",
        "over_low",
        "over_high",
    ];
    let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
    let whole = |value: Option<u64>| value.map_or(String::new(), |value| value.to_string());
    let rows = attempts.iter().map(|attempt| {
        let (cell, ratio) = (attempt.cell, attempt.over_whole);
        let v = cell.verification.as_ref();
        vec![
            group.scene.to_owned(),
            group.view.to_owned(),
            group.width_px.to_string(),
            group.height_px.to_string(),
            cell.name.technique.clone(),
            cell.technique.capture.clone(),
            attempt.percent.to_string(),
            cell.technique.pool_policy.clone(),
            cell.state.name().to_owned(),
            whole(v.map(|v| v.pool_initial)),
            whole(v.map(|v| v.pool_final)),
            whole(v.map(|v| u64::from(v.pool_grown))),
            whole(v.map(|v| v.wrong_px)),
            say(v.map(|v| v.max_error)),
            say(v.map(|v| v.rmse)),
            whole(v.map(|v| v.fragments_missing)),
            whole(v.map(|v| v.fragments_extra)),
            whole(attempt.differs_px),
            whole(v.map(|v| v.memory_bytes)),
            whole(v.and_then(|v| v.peak_bytes)),
            say(cell.median_ms(TOTAL)),
            say(ratio.map(|ratio| ratio.ratio)),
            say(ratio.map(|ratio| ratio.low)),
            say(ratio.map(|ratio| ratio.high)),
        ]
    });
    Csv { columns, rows: rows.collect() }
}
