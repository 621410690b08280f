//! The resolve time of each sort relative to insertion sort, with intervals, after Figure 9 of the
//! backwards memory allocation paper.

use std::collections::BTreeMap;

use analysis::{CellResult, RESOLVE, Tables};

use super::Figure;
use super::ratios::{self, Compared, families};
use crate::FigureError;
use crate::data::{Group, groups_with};
use crate::output::Output;
use crate::technique_names::is_floor;

/// Sorts relative to insertion sort.
pub(super) struct SortIntervals;

/// What the others are compared with.
const REFERENCE: &str = "insertion";

impl Figure for SortIntervals {
    fn name(&self) -> &'static str {
        "sort-intervals"
    }

    fn source(&self) -> &'static str {
        "sorts relative to insertion sort, after BMA 2013, Figure 9"
    }

    fn needs(&self) -> &'static str {
        "a view with insertion and another sort that sorts, all else equal"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        let enough =
            |group: &Group| families(group).values().any(|sorts| reference(sorts).is_some());
        for group in groups_with(tables, ratios::wanted, enough) {
            let mut compared = Vec::new();
            for (family, sorts) in families(&group) {
                let Some(reference) = reference(&sorts) else { continue };
                for (sort, cell) in sorts.iter().filter(|(sort, _)| **sort != REFERENCE) {
                    let ratio = analysis::compare(cell, reference, RESOLVE)?;
                    compared.push(Compared {
                        family: family.clone(),
                        sort,
                        with: REFERENCE,
                        ratio,
                    });
                }
            }
            let name = format!("sort-intervals-{}-{}", group.slug(), group.device_slug());
            let title = format!("Sorts relative to insertion sort: {}", group.title());
            let axis = "resolve time (with grouping) over that of insertion sort, log scale";
            let sides = ("faster than insertion".to_owned(), "slower".to_owned());
            let axis = (axis.to_owned(), sides);
            outputs.push(ratios::output(&group, (name, title), axis, &compared, |one| one.sort));
        }
        Ok(outputs)
    }
}

/// What the sorts of a family are compared with, if there is a sort to compare with it.
fn reference<'a>(sorts: &BTreeMap<&str, &'a CellResult>) -> Option<&'a CellResult> {
    let others = sorts.keys().any(|sort| *sort != REFERENCE && !is_floor(sort));
    let reference = sorts.get(REFERENCE).copied()?;
    (others && reference.times.contains_key(RESOLVE)).then_some(reference)
}
