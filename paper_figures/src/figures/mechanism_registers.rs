//! What the size of its array does to a program, as far as its driver tells, and what that costs:
//! registers, local memory and resolve time.

use analysis::{RESOLVE, Tables};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::Group;
use crate::mechanism::{Families, NEEDS, SizedProgram, Sizes, families, groups, or_dash, or_empty};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::sort_colour;

/// Registers, local memory and time against array size.
pub(super) struct MechanismRegisters;

impl Figure for MechanismRegisters {
    fn name(&self) -> &'static str {
        "mechanism-registers"
    }

    fn source(&self) -> &'static str {
        "what an array's size does to a program, after BMA 2013, Figure 3, and RBS 2014, section 2"
    }

    fn needs(&self) -> &'static str {
        NEEDS
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        Ok(groups(tables).iter().filter_map(output).collect())
    }
}

/// A quantity of a program.
type Of<'a> = &'a dyn Fn(&SizedProgram) -> Option<[f64; 3]>;

/// A panel of one quantity against another, if anything is told of both.
fn panel(
    title: String,
    sorts: &std::collections::BTreeMap<(&str, &str), Sizes>,
    (x_title, x_is_size, x_of): (&str, bool, Of),
    (y_title, y_log, y_of): (&str, bool, Of),
) -> Option<LinePanel> {
    let lines = sorts.iter().map(|((sort, store), sizes)| Line {
        label: if *store == "local" { (*sort).to_owned() } else { format!("{sort}, {store}") },
        colour: sort_colour(sort),
        points: sizes
            .values()
            .filter_map(|one| Some(LinePoint { x: x_of(one)?[0], y: y_of(one)?, hollow: false }))
            .collect(),
    });
    let lines: Vec<Line> = lines.filter(|line| !line.points.is_empty()).collect();
    let points = || lines.iter().flat_map(|line| &line.points);
    points().next()?;
    let mut x = if x_is_size {
        Scale::logarithmic(x_title, points().map(|point| point.x))
    } else {
        Scale::from_zero(x_title, points().map(|point| point.x))
    };
    if x_is_size {
        x.ticks = points().map(|point| point.x).collect();
        x.ticks.sort_by(f64::total_cmp);
        x.ticks.dedup();
    }
    let y = if y_log {
        Scale::logarithmic(y_title, points().flat_map(|point| point.y))
    } else {
        Scale::from_zero(y_title, points().flat_map(|point| point.y))
    };
    Some(LinePanel { title, x, y, across: None, lines })
}

fn panels(families: &Families, total: f64) -> Vec<LinePanel> {
    let exactly = |value: u64| [value as f64; 3];
    let size = |one: &SizedProgram| Some(exactly(one.program.high.into()));
    let registers = |one: &SizedProgram| one.figures.registers.map(exactly);
    let local = |one: &SizedProgram| one.figures.local_bytes.map(exactly);
    let time = |one: &SizedProgram| {
        let summary = one.cell.times.get(RESOLVE)?.summary;
        let ns = [summary.median, summary.low, summary.high].map(|ns| ns / total);
        (ns[1] > 0.0).then_some(ns)
    };
    let by_size = ("fragments that the array holds, log scale", true, &size as Of);
    let y_time = ("resolve, ns a fragment, log scale", true, &time as Of);
    let y_registers = ("registers of an invocation", false, &registers as Of);
    let y_local = ("local memory of an invocation, bytes", false, &local as Of);
    let x_registers = ("registers of an invocation", false, &registers as Of);
    let x_local = ("local memory of an invocation, bytes", false, &local as Of);
    let mut panels = Vec::new();
    for (family, sorts) in families {
        let of = |what: &str| format!("{what}: {family}");
        panels.extend(panel(of("time by size"), sorts, by_size, y_time));
        panels.extend(panel(of("registers by size"), sorts, by_size, y_registers));
        panels.extend(panel(of("local memory by size"), sorts, by_size, y_local));
        panels.extend(panel(of("time by registers"), sorts, x_registers, y_time));
        panels.extend(panel(of("time by local memory"), sorts, x_local, y_time));
    }
    panels
}

fn output(group: &Group) -> Option<Output> {
    let total = group.run.total_fragments(&group.name()).filter(|&total| total > 0)? as f64;
    let families = families(group);
    let columns = vec![
        "family",
        "sort",
        "store",
        "array",
        "registers",
        "local_bytes",
        "workgroup_bytes",
        "binary_bytes",
        "occupancy",
        "compile_ms",
        "from_cache",
        "n",
        "median_ns",
        "low_ns",
        "high_ns",
        "ns_per_fragment",
        "technique",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let mut tables = Vec::new();
    let mut told = false;
    for (family, sorts) in &families {
        let columns = [
            "sort",
            "store",
            "array",
            "registers",
            "local\nbytes",
            "workgroup\nbytes",
            "code\nbytes",
            "made in\nms",
            "resolve\nns a fragment",
        ];
        let columns = columns.map(str::to_owned).to_vec();
        let mut table = Table { heading: family.clone(), columns, rows: Vec::new() };
        for ((sort, store), sizes) in sorts {
            for (size, SizedProgram { cell, program, figures }) in sizes {
                let Some(timing) = cell.times.get(RESOLVE) else { continue };
                told |= program.executables.is_some();
                let s = timing.summary;
                let compile_ms = program.compile_ns.map(|ns| ns as f64 / 1e6);
                let cached = program.from_cache.map(|cached| cached.to_string());
                let mut row: Vec<String> =
                    vec![family.clone(), (*sort).into(), (*store).into(), size.to_string()];
                row.extend(
                    [
                        figures.registers,
                        figures.local_bytes,
                        figures.workgroup_bytes,
                        figures.binary_bytes,
                        figures.occupancy,
                    ]
                    .map(or_empty),
                );
                row.push(compile_ms.map(|ms| format!("{ms}")).unwrap_or_default());
                row.push(cached.unwrap_or_default());
                row.push(s.samples.to_string());
                row.extend([s.median, s.low, s.high, s.median / total].map(|ns| format!("{ns}")));
                row.push(cell.name.technique.clone());
                csv.rows.push(row);
                let mut row = vec![(*sort).into(), (*store).into(), size.to_string().into()];
                row.extend(
                    [
                        figures.registers,
                        figures.local_bytes,
                        figures.workgroup_bytes,
                        figures.binary_bytes,
                    ]
                    .map(|figure| or_dash(figure).into()),
                );
                row.push(compile_ms.map_or("–".to_owned(), three_digits).into());
                row.push(three_digits(s.median / total).into());
                table.rows.push(row);
            }
        }
        tables.push(table);
    }
    let mut notes = vec![
        "The fragments are the same at every size, so that what changes is what the array's size \
         costs. Medians of resolve with 95 % bootstrap intervals. Lines against registers and local \
         memory go from the smallest array to the largest."
            .to_owned(),
    ];
    notes.push(if told {
        "Registers and bytes are what the driver tells of the program that resolves \
         (VK_KHR_pipeline_executable_properties); – is what it does not tell."
            .to_owned()
    } else {
        "The driver tells nothing of its programs, so that there are neither registers nor bytes to \
         draw."
            .to_owned()
    });
    Some(Output {
        name: format!("mechanism-registers-{}-{}", group.slug(), group.device_slug()),
        title: format!("Array size, registers and time: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(Lines(panels(&families, total))),
        tables,
        csv,
        notes,
        stamps: [Stamp::of(group.run)].into(),
    })
}
