//! The time that a model of occupancy predicts for each array size, beside the time measured.

use analysis::occupancy::{ModelError, SmLimits, predicted_ratio, warps};
use analysis::{RESOLVE, Ratio, Tables};

use super::Figure;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Chart, Line, LinePanel, LinePoint, Lines, Scale, TableImage};
use crate::data::Group;
use crate::mechanism::{
    NEEDS, SizedProgram, families, fragments_of_covered, groups, or_dash, or_empty,
};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::{MUTED, sort_colour};

/// Predicted against measured.
pub(super) struct MechanismOccupancy;

impl Figure for MechanismOccupancy {
    fn name(&self) -> &'static str {
        "mechanism-occupancy"
    }

    fn source(&self) -> &'static str {
        "occupancy as an explanation of what an array's size costs, after BMA 2013, section 3"
    }

    fn needs(&self) -> &'static str {
        NEEDS
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        groups(tables).iter().map(output).collect()
    }
}

/// A program beside that of the smallest array of its sort and store.
struct Compared<'a> {
    family: String,
    sort: &'a str,
    store: &'a str,
    size: u32,
    base_size: u32,
    one: SizedProgram<'a>,
    warps: Option<u64>,
    predicted: Option<f64>,
    measured: Ratio,
}

fn compared<'a>(
    group: &Group<'a>,
    limits: Option<&SmLimits>,
) -> Result<Vec<Compared<'a>>, FigureError> {
    let fragments = fragments_of_covered(group).unwrap_or(0.0);
    let mut all = Vec::new();
    for (family, sorts) in families(group) {
        for ((sort, store), sizes) in sorts {
            let Some((&base_size, &base)) = sizes.first_key_value() else { continue };
            for (size, one) in sizes {
                let measured = analysis::compare(one.cell, base.cell, RESOLVE)?;
                let predicted = limits.and_then(|limits| {
                    let of = (one.program, &one.figures);
                    predicted_ratio(limits, fragments, of, (base.program, &base.figures))
                });
                let warps = limits.and_then(|limits| warps(limits, one.program, &one.figures));
                let family = family.clone();
                all.push(Compared {
                    family,
                    sort,
                    store,
                    size,
                    base_size,
                    one,
                    warps,
                    predicted,
                    measured,
                });
            }
        }
    }
    Ok(all)
}

/// Predicted and measured of all but the smallest arrays, which are 1 by definition.
fn pairs<'a>(all: impl Iterator<Item = &'a Compared<'a>>) -> Vec<(f64, f64)> {
    let others = all.filter(|one| one.size != one.base_size);
    others.filter_map(|one| Some((one.predicted?, one.measured.ratio))).collect()
}

/// How far predictions are off, beside how far it is off that nothing changes with the size. Nothing for
/// none.
fn error_text(of: &str, pairs: &[(f64, f64)]) -> Option<String> {
    let ModelError { count, median, worst, rank_correlation } = ModelError::of(pairs)?;
    let nothing: Vec<(f64, f64)> = pairs.iter().map(|(_, measured)| (1.0, *measured)).collect();
    let nothing = ModelError::of(&nothing)?;
    let same = |of: fn(&(f64, f64)) -> f64| pairs.iter().all(|pair| of(pair) == of(&pairs[0]));
    let rank = match rank_correlation {
        Some(rank) => format!("{rank:.2}"),
        None if count < 3 => "none, since they are fewer than three".to_owned(),
        None if same(|pair| pair.0) => "none, since all predictions are the same".to_owned(),
        None => "none, since all that was measured is the same".to_owned(),
    };
    Some(format!(
        "Error of {count} predictions ({of}): median {:.0} %, worst {:.0} % of what was measured (of no \
         change with the size: median {:.0} %, worst {:.0} %); Spearman's rank correlation {rank}.",
        100.0 * median,
        100.0 * worst,
        100.0 * nothing.median,
        100.0 * nothing.worst
    ))
}

fn panels(all: &[Compared]) -> Vec<LinePanel> {
    let told = || all.iter().filter(|one| one.predicted.is_some());
    let ends = || {
        let measured = told().flat_map(|one| [one.measured.low, one.measured.high]);
        measured.chain(told().filter_map(|one| one.predicted)).chain([1.0]).filter(|end| *end > 0.0)
    };
    let (low, high) = (ends().fold(f64::INFINITY, f64::min), ends().fold(0.0, f64::max));
    let x = Scale::logarithmic("predicted time over that of the smallest array, log scale", ends());
    let y = Scale::logarithmic("measured time over that of the smallest array, log scale", ends());
    let mut panels: Vec<LinePanel> = Vec::new();
    for one in told() {
        let Some(predicted) = one.predicted else { continue };
        if panels.last().is_none_or(|panel| panel.title != one.family) {
            let at = |value: f64| LinePoint { x: value, y: [value; 3], hollow: true };
            let points = vec![at(low), at(high)];
            let same = Line { label: "as predicted".to_owned(), colour: MUTED, points };
            let (title, x, y) = (one.family.clone(), x.clone(), y.clone());
            panels.push(LinePanel { title, x, y, across: None, lines: vec![same] });
        }
        let Some(panel) = panels.last_mut() else { continue };
        let label = match one.store {
            "local" => one.sort.to_owned(),
            store => format!("{}, {store}", one.sort),
        };
        if panel.lines.last().is_none_or(|line| line.label != label) {
            panel.lines.push(Line { label, colour: sort_colour(one.sort), points: Vec::new() });
        }
        let Ratio { ratio, low, high, .. } = one.measured;
        let point = LinePoint { x: predicted, y: [ratio, low, high], hollow: false };
        panel.lines.last_mut().into_iter().for_each(|line| line.points.push(point));
    }
    panels
}

fn output(group: &Group) -> Result<Output, FigureError> {
    let device = &group.run.run.device;
    let limits = SmLimits::of(device);
    let all = compared(group, limits.as_ref())?;
    let columns = vec![
        "family",
        "sort",
        "store",
        "array",
        "smallest_array",
        "registers",
        "local_bytes",
        "warps",
        "predicted",
        "measured",
        "low",
        "high",
        "error",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "technique",
        "sort",
        "store",
        "array",
        "registers",
        "local",
        "warps",
        "predicted",
        "measured",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for one in &all {
        let Ratio { ratio, low, high, .. } = one.measured;
        let number = |value: Option<f64>| value.map(|value| format!("{value}")).unwrap_or_default();
        let off = one.predicted.map(|predicted| predicted / ratio - 1.0);
        csv.rows.push(vec![
            one.family.clone(),
            one.sort.to_owned(),
            one.store.to_owned(),
            one.size.to_string(),
            one.base_size.to_string(),
            or_empty(one.one.figures.registers),
            or_empty(one.one.figures.local_bytes),
            or_empty(one.warps),
            number(one.predicted),
            format!("{ratio}"),
            format!("{low}"),
            format!("{high}"),
            number(off),
        ]);
        table.rows.push(vec![
            one.family.clone().into(),
            one.sort.into(),
            one.store.into(),
            one.size.to_string().into(),
            or_dash(one.one.figures.registers).into(),
            or_dash(one.one.figures.local_bytes).into(),
            or_dash(one.warps).into(),
            one.predicted.map_or("–".to_owned(), three_digits).into(),
            three_digits(ratio).into(),
        ]);
    }
    let told = all.iter().any(|one| one.one.figures.registers.is_some());
    let mut notes = Vec::new();
    let chart: Box<dyn Chart> = if let Some(error) = error_text("all", &pairs(all.iter())) {
        let capability = limits.map_or("", |limits| limits.capability);
        notes.push(format!(
            "Predicted: bytes that a pixel moves, those of local memory at the bandwidth of the L1 cache, \
             over the warps that a multiprocessor of compute \
             capability {capability} holds of the program, both relative to the smallest array of the \
             sort, which is left out of the errors. Measured: ratios of medians of resolve with their \
             95 % bootstrap intervals. Lines go from the smallest array to the largest."
        ));
        if all.iter().all(|one| one.one.figures.local_bytes.is_none()) {
            notes
                .push("The driver does not tell local memory: its traffic is left out.".to_owned());
        }
        notes.push(error);
        let mut families: Vec<&str> = all.iter().map(|one| one.family.as_str()).collect();
        families.dedup();
        for family in families.iter().filter(|_| families.len() > 1) {
            let of_family = all.iter().filter(|one| one.family == *family);
            notes.extend(error_text(family, &pairs(of_family)));
        }
        Box::new(Lines(panels(&all)))
    } else {
        notes.push(match (told, limits) {
            (false, _) => "Nothing is predicted: the driver tells no registers.".to_owned(),
            (true, None) => format!(
                "Nothing is predicted: what a processor of {} holds is not known here.",
                device.name
            ),
            (true, Some(_)) => "Nothing is predicted: too little is told.".to_owned(),
        });
        Box::new(TableImage(vec![table.clone()]))
    };
    Ok(Output {
        name: format!("mechanism-occupancy-{}-{}", group.slug(), group.device_slug()),
        title: format!("Predicted by occupancy, and measured: {}", group.title()),
        subtitle: group.conditions(),
        chart,
        tables: vec![table],
        csv,
        notes,
        stamps: [Stamp::of(group.run)].into(),
    })
}
