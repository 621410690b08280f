//! The papers' names of techniques, as coordinates.

use analysis::CellResult;

/// The names of the register-based block sort paper (section 4) that this project can run, without
/// the tie rule. The papers compare depths only, so `ties-depth` is preferred where it was run.
pub(crate) const ALIASES: &[(&str, &str)] = &[
    ("BASE-IS", "linked_list/base/insertion/fragment/peak"),
    ("BASE-IMS", "linked_list/base/insertion_merge/fragment/peak"),
    ("BASE-RBS-L", "linked_list/base/rbs/fragment/peak"),
    ("BMA-IS", "linked_list/bma-stencil/insertion/fragment/peak"),
    ("BMA-IMS", "linked_list/bma-stencil/insertion_merge/fragment/peak"),
    ("BMA-RBS-L", "linked_list/bma-stencil/rbs/fragment/peak"),
    ("CUDA-IS", "linked_list/base/insertion/cuda/peak"),
    ("CUDA-IMS", "linked_list/base/insertion_merge/cuda/peak"),
    ("CUDA-RBS-L", "linked_list/base/rbs/cuda/peak"),
    ("RBS-G", "linked_list/base/rbs-global/fragment/peak"),
    // Of the backwards memory allocation paper (Table 2), with its own bounds between sorts.
    ("OIT", "linked_list/base/insertion_merge64/fragment/peak"),
    ("BMA-OIT", "linked_list/bma-stencil/insertion@16+merge/fragment/peak"),
];

/// The sort of the backwards memory allocation paper's standard OIT: which of insertion and merge sort
/// is the shader's choice, pixel by pixel.
const OIT_SORT: &str = "insertion_merge64";
/// The sort of its BMA-OIT: each interval's program has one.
const BMA_OIT_SORT: &str = "insertion@16+merge";

/// The techniques of the backwards memory allocation paper (section 4), as schedule, sort and shader
/// stage. A name is followed by a space and the size of the array: `OIT max64`, `BMA-OIT peak`. Those
/// of the compute stage are this project's. `OIT-intervals` is OIT's program timed by intervals.
const OIT: &[(&str, &str, &str, &str)] = &[
    ("OIT", "base", OIT_SORT, "fragment"),
    ("OIT compute", "base", OIT_SORT, "compute"),
    ("OIT-intervals", "base-intervals", OIT_SORT, "fragment"),
    ("OIT-intervals compute", "base-intervals", OIT_SORT, "compute"),
    ("BMA-OIT", "bma-stencil", BMA_OIT_SORT, "fragment"),
    ("BMA-OIT compute", "bma-list", BMA_OIT_SORT, "compute"),
];

/// The coordinate of a technique of [`OIT`].
fn oit(name: &str) -> Option<String> {
    let (name, max) = name.rsplit_once(' ')?;
    let (_, schedule, sort, stage) = OIT.iter().find(|(known, ..)| *known == name)?;
    Some(format!("linked_list/{schedule}/{sort}/{stage}/{max}/ties-depth"))
}

/// Whether a sort sorts nothing: what is left of a resolve's time without one.
#[must_use]
pub(crate) fn is_floor(sort: &str) -> bool {
    ["passthrough", "unsorted"].contains(&sort)
}

/// The coordinates meant by a name, best first: a paper's name, or a coordinate, which stands for
/// both tie rules unless it names one.
#[must_use]
pub(crate) fn coordinates(name: &str) -> Vec<String> {
    if let Some(coordinate) = oit(name) {
        return vec![coordinate];
    }
    match ALIASES.iter().find(|(alias, _)| *alias == name) {
        Some((_, coordinate)) => vec![format!("{coordinate}/ties-depth"), (*coordinate).to_owned()],
        None if name.contains("/ties-") => vec![name.to_owned()],
        None => vec![name.to_owned(), format!("{name}/ties-depth")],
    }
}

/// The cell of a technique among cells of one group. A charted one is preferred, so that a
/// technique that failed under one tie rule is still found under the other.
#[must_use]
pub(crate) fn find<'a>(cells: &[&'a CellResult], name: &str) -> Option<&'a CellResult> {
    let candidates: Vec<&CellResult> = coordinates(name)
        .iter()
        .filter_map(|coordinate| cells.iter().find(|cell| cell.name.technique == *coordinate))
        .copied()
        .collect();
    let charted = candidates.iter().find(|cell| !cell.times.is_empty());
    charted.or(candidates.first()).copied()
}

/// The paper's name of a coordinate, or the coordinate.
#[must_use]
pub(crate) fn label(coordinate: &str) -> String {
    let bare = coordinate.trim_end_matches("/ties-depth");
    let alias = ALIASES.iter().find(|(_, known)| *known == bare);
    match alias {
        Some((name, known)) if *known == coordinate => format!("{name}, total order"),
        Some((name, _)) => (*name).to_owned(),
        None => coordinate.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_papers_are_coordinates() {
        let compute = format!("linked_list/bma-list/{BMA_OIT_SORT}/compute/max64/ties-depth");
        assert_eq!(coordinates("BMA-OIT compute max64"), [compute]);
        let base = format!("linked_list/base/{OIT_SORT}/fragment/peak/ties-depth");
        assert_eq!(coordinates("OIT peak"), [base]);
        assert_eq!(
            coordinates("BASE-IS")[0],
            "linked_list/base/insertion/fragment/peak/ties-depth"
        );
        assert_eq!(coordinates("a/b/c/d/e/ties-depth"), ["a/b/c/d/e/ties-depth"]);
        // No name of a technique: left as it is, and found nowhere.
        assert_eq!(coordinates("OAT max64")[0], "OAT max64");
    }
}
