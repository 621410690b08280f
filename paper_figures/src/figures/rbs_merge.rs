//! How register-based block sort merges and sorts its blocks: by linear search, by a heap or in two
//! levels, against the number of blocks; in blocks of 8, 16 and 32; sorted by insertion or by a
//! network.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, RESOLVE, Ratio, Tables, compare};

use super::Figure;
use super::ratios::families;
use crate::FigureError;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, all_groups, random_depth, slug};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::SERIES;

/// Variants of register-based block sort.
pub(super) struct RbsMerge;

/// What the others are compared with: blocks of 32, sorted by insertion, merged by linear search.
const REFERENCE: &str = "rbs";
/// Fragments of a block of [`REFERENCE`].
const BLOCK: u64 = 32;

/// A question: its heading, and the sorts that answer it with what they stand for.
const QUESTIONS: [(&str, &[(&str, &str)]); 3] = [
    (
        "merging blocks of 32",
        &[("rbs", "linear search"), ("rbs_heap", "heap"), ("rbs_hier", "two levels")],
    ),
    ("fragments of a block", &[("rbs8", "8"), ("rbs16", "16"), ("rbs", "32")]),
    (
        "sorting the blocks",
        &[
            ("rbs", "insertion, 32"),
            ("network_merge32", "network, 32"),
            ("network_merge", "network, 64"),
        ],
    ),
];

impl Figure for RbsMerge {
    fn name(&self) -> &'static str {
        "rbs-merge"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, sections 3 and 5: k-way merges, block sizes, and what the paper left for future work"
    }

    fn needs(&self) -> &'static str {
        "rbs beside a variant of it, all else equal, on views whose covered pixels all have the same \
         number of fragments, more than 32, in random order"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        // By device, and by run, so that what is put side by side is of one run.
        let mut runs: BTreeMap<(String, String), Found> = BTreeMap::new();
        for group in all_groups(tables) {
            let key = (group.run.device(), group.run.name.clone());
            add(&group, runs.entry(key).or_default())?;
        }
        let mut best: BTreeMap<String, (usize, Output)> = BTreeMap::new();
        for ((device, _), found) in &runs {
            let count = found.values().map(BTreeMap::len).sum();
            if count > 0 && best.get(device).is_none_or(|(most, _)| count > *most) {
                best.insert(device.clone(), (count, output(device, found)));
            }
        }
        Ok(best.into_values().map(|(_, output)| output).collect())
    }
}

/// A variant beside the reference.
struct Point<'a> {
    ratio: Ratio,
    cell: &'a CellResult,
    group: Group<'a>,
}

/// By family, then by depth and sort.
type Found<'a> = BTreeMap<String, BTreeMap<(u64, &'a str), Point<'a>>>;

fn add<'a>(group: &Group<'a>, found: &mut Found<'a>) -> Result<(), FigureError> {
    let Some(depth) = random_depth(group).filter(|depth| *depth > BLOCK) else { return Ok(()) };
    let asked = |sort: &str| QUESTIONS.iter().any(|(_, of)| of.iter().any(|(one, _)| *one == sort));
    for (family, sorts) in families(group) {
        let timed = |cell: &&CellResult| cell.times.contains_key(RESOLVE);
        let Some(reference) = sorts.get(REFERENCE).copied().filter(|cell| timed(cell)) else {
            continue;
        };
        let others = sorts.into_iter().filter(|(sort, cell)| asked(sort) && timed(cell));
        let others: Vec<(&str, &CellResult)> = others.collect();
        if others.len() < 2 {
            continue;
        }
        for (sort, cell) in others {
            let ratio = compare(cell, reference, RESOLVE)?;
            let point = Point { ratio, cell, group: group.clone() };
            found.entry(family.clone()).or_default().insert((depth, sort), point);
        }
    }
    Ok(())
}

fn output(device: &str, found: &Found) -> Output {
    let columns = vec![
        "question",
        "family",
        "sort",
        "stands_for",
        "fragments",
        "blocks_of_32",
        "over_rbs",
        "low",
        "high",
        "ms",
        "verdict",
        "technique",
        "scene",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut panels, mut stamps) = (Vec::new(), Vec::new(), BTreeSet::new());
    let mut sizes: BTreeSet<[u32; 2]> = BTreeSet::new();
    for (family, points) in found {
        for (question, sorts) in QUESTIONS {
            let of = |sort: &str| -> BTreeMap<u64, &Point> {
                let of_sort = points.iter().filter(|((_, known), _)| *known == sort);
                of_sort.map(|((depth, _), point)| (*depth, point)).collect()
            };
            // A reference alone answers nothing.
            let answers = sorts.iter().filter(|(sort, _)| *sort != REFERENCE);
            let depths: BTreeSet<u64> =
                answers.flat_map(|(sort, _)| of(sort).into_keys()).collect();
            if depths.is_empty() {
                continue;
            }
            let heads = depths.iter().map(|depth| format!("{depth}\n{} blocks", depth / BLOCK));
            let columns = ["sort".to_owned(), "is".to_owned()].into_iter().chain(heads).collect();
            let heading = format!("{question}: {family}");
            let mut table = Table { heading: heading.clone(), columns, rows: Vec::new() };
            let mut lines = Vec::new();
            for ((sort, is), colour) in sorts.iter().zip(SERIES) {
                let known = of(sort);
                let mut row: Vec<Value> = vec![(*sort).into(), (*is).into()];
                let mut line = Vec::new();
                for depth in &depths {
                    let Some(Point { ratio, cell, group }) = known.get(depth) else {
                        row.push("–".into());
                        continue;
                    };
                    let ms = cell.median_ms(RESOLVE).unwrap_or(f64::NAN);
                    row.push(format!("{:.3} ({ms:.3} ms)", ratio.ratio).into());
                    sizes.insert([group.width_px, group.height_px]);
                    stamps.insert(Stamp::of(group.run));
                    if ratio.low > 0.0 {
                        let (x, y) =
                            ((*depth / BLOCK) as f64, [ratio.ratio, ratio.low, ratio.high]);
                        line.push(LinePoint { x, y, hollow: false });
                    }
                    csv.rows.push(vec![
                        question.to_owned(),
                        family.clone(),
                        (*sort).to_owned(),
                        (*is).to_owned(),
                        depth.to_string(),
                        (depth / BLOCK).to_string(),
                        format!("{}", ratio.ratio),
                        format!("{}", ratio.low),
                        format!("{}", ratio.high),
                        format!("{ms}"),
                        ratio.word().to_owned(),
                        cell.name.technique.clone(),
                        group.scene.to_owned(),
                    ]);
                }
                table.rows.push(row);
                if !line.is_empty() {
                    let label = format!("{is} ({sort})");
                    lines.push(Line { label, colour: *colour, points: line });
                }
            }
            tables.push(table);
            let ends = lines.iter().flat_map(|line| &line.points).flat_map(|point| point.y);
            let y = Scale::logarithmic(
                "resolve time over that of rbs, log scales",
                ends.chain([0.9, 1.1]).collect::<Vec<f64>>().into_iter(),
            );
            let blocks = depths.iter().map(|depth| (*depth / BLOCK) as f64);
            let mut x = Scale::logarithmic("fragments of every pixel over 32", blocks.clone());
            x.ticks = blocks.collect();
            panels.push(LinePanel { title: heading, x, y, across: Some(1.0), lines });
        }
    }
    let sizes: Vec<String> = sizes.iter().map(|[w, h]| format!("{w} × {h} px")).collect();
    Output {
        name: format!("rbs-merge-{}", slug(device)),
        title: "Register-based block sort: merges, block sizes, and how blocks are sorted".to_owned(),
        subtitle: format!("{device}, {}; random order of depth", sizes.join(", ")),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![
            "Ratios of medians of resolve with grouping over rbs (blocks of 32 sorted by insertion, \
             one merge by linear search), with 95 % bootstrap intervals, all of one run. The paper \
             found the linear search faster on its scenes, which have up to 14 blocks, and left the \
             heap and hierarchical merges for future work. Blocks of 8 and 16 are four times and twice \
             as many; rbs merges up to 32."
                .to_owned(),
        ],
        stamps,
    }
}
