//! Sorts in registers and in an array: resolve time beside what the driver tells of the programs, at
//! each number of fragments. Listings 1, 2, 4 and 5 of the register-based block sort paper.

use std::collections::BTreeMap;

use analysis::{CellResult, ProgramFigures, RESOLVE, Tables};
use oit_record::Program;

use super::Figure;
use super::ratios::families;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, all_groups, random_depth, slug};
use crate::mechanism::{or_dash, or_empty};
use crate::output::{Csv, Output, Stamp, Table, fullest};
use crate::style::SERIES;

/// Registers, local memory, code and compile time of sorts in registers.
pub(super) struct RbsRegisters;

/// The sorts, and what they are.
const SORTS: [(&str, &str); 6] = [
    ("insertion", "array, indexed at run time (Listing 1)"),
    ("rs", "unrolled whole, early exit (Listing 5)"),
    ("rs_inner", "inner loop unrolled (Listing 4)"),
    ("network", "network by depth, no branch"),
    ("bitonic", "bitonic network"),
    ("odd_even", "odd-even network"),
];

/// Fewer show no comparison.
const LEAST_SORTS: usize = 3;

impl Figure for RbsRegisters {
    fn name(&self) -> &'static str {
        "rbs-registers"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Listings 1, 2, 4 and 5, and section 3: unrolled loops and registers"
    }

    fn needs(&self) -> &'static str {
        "three of insertion, rs, rs_inner, network, bitonic and odd_even with one recorded program each, \
         all else equal, where all covered pixels have the same number of fragments in random order"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut runs: BTreeMap<(String, [u32; 2]), Families> = BTreeMap::new();
        for group in all_groups(tables) {
            let Some(depth) = random_depth(&group) else { continue };
            for (family, known) in families(&group) {
                let of_sort = |&(sort, _): &(&'static str, &str)| {
                    let cell = *known.get(sort)?;
                    let timed = cell.times.contains_key(RESOLVE) && cell.programs.len() == 1;
                    timed.then_some((sort, cell))
                };
                let sorts: Vec<_> = SORTS.iter().filter_map(of_sort).collect();
                if sorts.len() < LEAST_SORTS {
                    continue;
                }
                let key = (group.run.name.clone(), [group.width_px, group.height_px]);
                let depths = runs.entry(key).or_default().entry(family).or_default();
                let cells = sorts.into_iter().map(|(sort, cell)| (sort, (group.clone(), cell)));
                depths.entry(depth).or_default().extend(cells);
            }
        }
        let drawn = runs.values().filter_map(|families| {
            let depths = families.values().flat_map(BTreeMap::values);
            Some((depths.map(BTreeMap::len).sum(), output(families)?))
        });
        Ok(fullest(drawn))
    }
}

/// A cell by family, depth and sort.
type Families<'a> =
    BTreeMap<String, BTreeMap<u64, BTreeMap<&'static str, (Group<'a>, &'a CellResult)>>>;

/// A quantity of a cell, with the ends of its interval.
type Of<'a> = &'a dyn Fn(&Group, &CellResult) -> Option<[f64; 3]>;

fn program(cell: &CellResult) -> Option<&Program> {
    cell.programs.first()
}

fn figures(cell: &CellResult) -> ProgramFigures {
    let stage = &cell.technique.shader_stage;
    program(cell).map(|program| ProgramFigures::of(program, stage)).unwrap_or_default()
}

/// Milliseconds to compile, where it was in no cache.
fn compile_ms(cell: &CellResult) -> Option<f64> {
    let program = program(cell).filter(|program| program.from_cache != Some(true))?;
    program.compile_ns.map(|ns| ns as f64 / 1e6)
}

/// Nanoseconds of a fragment.
fn per_fragment(group: &Group, cell: &CellResult) -> Option<[f64; 3]> {
    let total = group.run.total_fragments(&group.name()).filter(|&total| total > 0)? as f64;
    let summary = cell.times.get(RESOLVE)?.summary;
    let ns = [summary.median, summary.low, summary.high].map(|ns| ns / total);
    (ns[1] > 0.0).then_some(ns)
}

fn panel(
    title: String,
    depths: &BTreeMap<u64, BTreeMap<&'static str, (Group, &CellResult)>>,
    (y_title, log, of): (&str, bool, Of),
) -> Option<LinePanel> {
    let lines = SORTS.iter().zip(SERIES).map(|((sort, _), colour)| {
        let points = depths.iter().filter_map(|(depth, sorts)| {
            let (group, cell) = sorts.get(sort)?;
            Some(LinePoint { x: *depth as f64, y: of(group, cell)?, hollow: false })
        });
        Line { label: (*sort).to_owned(), colour: *colour, points: points.collect() }
    });
    let lines: Vec<Line> = lines.filter(|line| !line.points.is_empty()).collect();
    let values = || lines.iter().flat_map(|line| &line.points).flat_map(|point| point.y);
    values().next()?;
    let heads = depths.keys().map(|depth| *depth as f64);
    let mut x = Scale::logarithmic("fragments of every pixel, log scale", heads.clone());
    x.ticks = heads.collect();
    let y = if log {
        Scale::logarithmic(y_title, values())
    } else {
        Scale::from_zero(y_title, values())
    };
    Some(LinePanel { title, x, y, across: None, lines })
}

fn output(families: &Families) -> Option<Output> {
    let groups = || families.values().flat_map(BTreeMap::values).flat_map(BTreeMap::values);
    let (first, _) = groups().next()?;
    let columns = vec![
        "family",
        "sort",
        "fragments",
        "registers",
        "local_bytes",
        "binary_bytes",
        "compile_ms",
        "n",
        "median_ns",
        "low_ns",
        "high_ns",
        "ns_per_fragment",
        "technique",
        "scene",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let (mut tables, mut panels) = (Vec::new(), Vec::new());
    let exactly = |value: Option<u64>| value.map(|value| [value as f64; 3]);
    let registers = |_: &Group, cell: &CellResult| exactly(figures(cell).registers);
    let local = |_: &Group, cell: &CellResult| exactly(figures(cell).local_bytes);
    let code =
        |_: &Group, cell: &CellResult| exactly(figures(cell).binary_bytes.filter(|b| *b > 0));
    let compile =
        |_: &Group, cell: &CellResult| compile_ms(cell).filter(|ms| *ms > 0.0).map(|ms| [ms; 3]);
    let quantities: [(&str, &str, bool, Of); 5] = [
        ("time", "resolve, ns a fragment, log scale", true, &per_fragment),
        ("registers", "registers of an invocation", false, &registers),
        ("local memory", "local memory of an invocation, bytes", false, &local),
        ("code", "code, bytes, log scale", true, &code),
        ("compile time", "ms to compile, in no cache, log scale", true, &compile),
    ];
    for (family, depths) in families {
        for (what, y_title, log, of) in quantities {
            panels.extend(panel(format!("{what}: {family}"), depths, (y_title, log, of)));
        }
        let columns = [
            "sort",
            "is",
            "fragments",
            "resolve\nns a fragment",
            "registers",
            "local\nbytes",
            "code\nbytes",
            "compiled in\nms",
        ];
        let columns = columns.map(str::to_owned).to_vec();
        let mut table = Table { heading: family.clone(), columns, rows: Vec::new() };
        for (sort, is) in SORTS {
            for (depth, sorts) in depths {
                let Some((group, cell)) = sorts.get(sort) else { continue };
                let Some(timing) = cell.times.get(RESOLVE) else { continue };
                let (told, s) = (figures(cell), timing.summary);
                let ns = per_fragment(group, cell).map(|ns| ns[0]);
                let compile_ms = compile_ms(cell);
                let mut row = vec![sort.into(), is.into(), depth.to_string().into()];
                row.push(ns.map_or("–".to_owned(), three_digits).into());
                row.extend(
                    [told.registers, told.local_bytes, told.binary_bytes]
                        .map(|f| or_dash(f).into()),
                );
                row.push(compile_ms.map_or("–".to_owned(), three_digits).into());
                table.rows.push(row);
                let mut row = vec![family.clone(), sort.to_owned(), depth.to_string()];
                row.extend([told.registers, told.local_bytes, told.binary_bytes].map(or_empty));
                row.push(compile_ms.map(|ms| format!("{ms}")).unwrap_or_default());
                row.push(s.samples.to_string());
                row.extend([s.median, s.low, s.high].map(|ns| format!("{ns}")));
                row.push(ns.map(|ns| format!("{ns}")).unwrap_or_default());
                row.extend([cell.name.technique.clone(), group.scene.to_owned()]);
                csv.rows.push(row);
            }
        }
        tables.push(table);
    }
    Some(Output {
        name: format!("rbs-registers-{}", slug(&first.run.device())),
        title: "Sorts in registers: time, registers, local memory, code and compile time".to_owned(),
        subtitle: first.conditions(),
        chart: Box::new(Lines(panels)),
        tables,
        csv,
        notes: vec![
            "insertion and rs are the pair of the paper's Listing 2: an array whose index is known at \
             run time only, and one whose indices are all constants, so that registers can hold it. \
             rs_inner leaves the outer loop a loop (Listing 4), rs unrolls both and ends an insertion \
             early (Listing 5). Medians of resolve with 95 % bootstrap intervals."
                .to_owned(),
            "Registers and bytes are what the driver tells of the program \
             (VK_KHR_pipeline_executable_properties); – and no line is what it does not tell. Compile \
             times are of programs that no cache held."
                .to_owned(),
        ],
        stamps: groups().map(|(group, _)| Stamp::of(group.run)).collect(),
    })
}
