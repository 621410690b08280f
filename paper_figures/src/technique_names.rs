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
];

/// Whether a sort sorts nothing: what is left of a resolve's time without one.
#[must_use]
pub(crate) fn is_floor(sort: &str) -> bool {
    ["passthrough", "unsorted"].contains(&sort)
}

/// The coordinates meant by a name, best first: a paper's name, or a coordinate, which stands for
/// both tie rules unless it names one.
#[must_use]
pub(crate) fn coordinates(name: &str) -> Vec<String> {
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
