//! One sort against all others in whole scenes, a chart a view. Scenes of one depth are on the page
//! ([`super::compare_pages`]).

use std::collections::BTreeSet;

use analysis::{CellResult, RESOLVE, Tables, scene_name};

use super::compare_page::is_sort;
use super::ratios::{self, Compared, families};
use crate::FigureError;
use crate::data::{groups, slug};
use crate::output::Output;

/// Draws one sort against all others, one chart a view and device.
///
/// # Errors
/// Where no record has the sort, or drawing fails.
pub fn compare(tables: &Tables, sort: &str) -> Result<Vec<Output>, FigureError> {
    let known: BTreeSet<&str> = tables
        .results
        .iter()
        .map(|cell| cell.technique.sort.as_str())
        .filter(|known| !known.is_empty())
        .collect();
    if !known.iter().any(|known| is_sort(known, sort)) {
        let known = known.into_iter().collect::<Vec<_>>().join(", ");
        return Err(FigureError::Unknown {
            what: "sort in the records",
            name: sort.to_owned(),
            known,
        });
    }
    let mut outputs = Vec::new();
    // The run that speaks for a view is the one with most of this sort.
    let own = |cell: &CellResult| {
        let whole = scene_name(&cell.name.scene) != "stack";
        whole && ratios::wanted(cell) && is_sort(&cell.technique.sort, sort)
    };
    for group in groups(tables, own) {
        let mut compared = Vec::new();
        for (family, sorts) in families(&group) {
            let named = sorts.get_key_value(sort);
            let longer = || sorts.iter().find(|(name, _)| is_sort(name, sort));
            let Some((own_name, own)) = named.or_else(longer) else { continue };
            for (with, cell) in sorts.iter().filter(|(with, _)| *with != own_name) {
                if let Ok(ratio) = analysis::compare(own, cell, RESOLVE) {
                    compared.push(Compared { family: family.clone(), sort: own_name, with, ratio });
                }
            }
        }
        if compared.is_empty() {
            continue;
        }
        let name = format!("compare-{}-{}-{}", slug(sort), group.slug(), group.device_slug());
        let title = format!("{sort} against the other sorts: {}", group.title());
        let axis =
            format!("resolve time (with grouping) of {sort} over that of the other, log scale");
        let sides = (format!("{sort} is faster"), format!("{sort} is slower"));
        let output =
            ratios::output(&group, (name, title), (axis, sides), &compared, |one| one.with);
        outputs.push(output);
    }
    Ok(outputs)
}
