//! Programs that differ in the size of their array and in nothing else, on the same fragments: what the
//! figures on the mechanism of backwards memory allocation are drawn from.

use std::collections::BTreeMap;

use analysis::{CellResult, ProgramFigures, RESOLVE, Tables};
use oit_record::Program;

use crate::data::{Group, groups_with};

/// A program with its cell. The cell has no other program, so that its resolve time is the program's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizedProgram<'a> {
    /// The cell.
    pub cell: &'a CellResult,
    /// Its program.
    pub program: &'a Program,
    /// What is told of it.
    pub figures: ProgramFigures,
}

/// Programs of one sort in one store, by the size of their arrays.
pub(crate) type Sizes<'a> = BTreeMap<u32, SizedProgram<'a>>;

/// By family (all that is neither sort nor size), then by sort and store.
pub(crate) type Families<'a> = BTreeMap<String, BTreeMap<(&'a str, &'a str), Sizes<'a>>>;

/// Fewer sizes show no trend.
const LEAST_SIZES: usize = 3;

/// What records must hold for these figures.
pub(crate) const NEEDS: &str = "a view with programs of one sort recorded for three array sizes or \
                                more, each of which holds all its fragments";

/// Cells of one recorded program.
pub(crate) fn wanted(cell: &CellResult) -> bool {
    cell.programs.len() == 1 && cell.technique.whole_pool() && !cell.technique.sort.is_empty()
}

/// The groups that hold a sort in several sizes.
pub(crate) fn groups(tables: &Tables) -> Vec<Group<'_>> {
    groups_with(tables, wanted, |group| !families(group).is_empty())
}

/// Fragments of a pixel that has any.
pub(crate) fn fragments_of_covered(group: &Group) -> Option<f64> {
    let histogram = group.run.histogram(&group.name())?;
    let covered = histogram.iter().skip(1).fold(0_u64, |sum, &px| sum.saturating_add(px));
    let total = group.run.total_fragments(&group.name())?;
    (covered > 0).then(|| total as f64 / covered as f64)
}

/// The charted programs of a group whose arrays leave nothing out, of sorts in enough sizes.
pub(crate) fn families<'a>(group: &Group<'a>) -> Families<'a> {
    let histogram = group.run.histogram(&group.name()).unwrap_or(&[]);
    let peak = histogram.iter().rposition(|&pixels| pixels > 0).unwrap_or(0);
    let mut families: Families = BTreeMap::new();
    for cell in group.cells.iter().copied().filter(|cell| wanted(cell)) {
        let [program] = cell.programs.as_slice() else { continue };
        if !cell.times.contains_key(RESOLVE) || (program.high as usize) < peak {
            continue;
        }
        let technique = &cell.technique;
        let [capture, schedule, stage, ties] =
            [&technique.capture, &technique.schedule, &technique.shader_stage, &technique.ties];
        let name = format!("{capture}, {schedule}, {stage} stage, {ties} order");
        let figures = ProgramFigures::of(program, stage);
        let sorts = families.entry(name).or_default();
        let sizes = sorts.entry((&program.sort, &program.store)).or_default();
        sizes.entry(program.high).or_insert(SizedProgram { cell, program, figures });
    }
    for sorts in families.values_mut() {
        sorts.retain(|_, sizes| sizes.len() >= LEAST_SIZES);
    }
    families.retain(|_, sorts| !sorts.is_empty());
    families
}

/// A figure that may not be told.
pub(crate) fn or_dash(figure: Option<u64>) -> String {
    figure.map_or("–".to_owned(), |figure| figure.to_string())
}

/// The same in tables for programs.
pub(crate) fn or_empty(figure: Option<u64>) -> String {
    figure.map(|figure| figure.to_string()).unwrap_or_default()
}
