//! One colour a sort, one a layout and one shape a schedule, the same in every figure.
//!
//! Colours are Okabe and Ito's, which stay apart for colour-blind readers (Color Universal Design,
//! 2008). A filled marker resolves in a fragment shader, a hollow one in a compute shader.

use analysis::Technique;

use crate::canvas::{Canvas, Colour};

/// Text and axes.
pub(crate) const INK: Colour = Colour(0x22, 0x22, 0x22);
/// Secondary text.
pub(crate) const MUTED: Colour = Colour(0x66, 0x66, 0x66);
/// Grid lines.
pub(crate) const GRID: Colour = Colour(0xe2, 0xe2, 0xe2);
/// Behind a value that is marked: light green, as in the papers.
pub(crate) const MARKED: Colour = Colour(0xc8, 0xea, 0xdd);

/// The page.
pub(crate) const PAPER: Colour = Colour(0xff, 0xff, 0xff);

const BLACK: Colour = Colour(0x00, 0x00, 0x00);
const ORANGE: Colour = Colour(0xe6, 0x9f, 0x00);
const SKY_BLUE: Colour = Colour(0x56, 0xb4, 0xe9);
const GREEN: Colour = Colour(0x00, 0x9e, 0x73);
const YELLOW: Colour = Colour(0xf0, 0xe4, 0x42);
const BLUE: Colour = Colour(0x00, 0x72, 0xb2);
const VERMILLION: Colour = Colour(0xd5, 0x5e, 0x00);
const PURPLE: Colour = Colour(0xcc, 0x79, 0xa7);
const GREY: Colour = Colour(0x99, 0x99, 0x99);
/// Paul Tol's wine, for sorts that have no colour here: one of one's own stands out.
const WINE: Colour = Colour(0x88, 0x22, 0x55);

/// Colours for series that are no techniques, such as the views of a histogram.
pub(crate) const SERIES: &[Colour] =
    &[BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY_BLUE, BLACK, YELLOW, GREY];

const SORTS: &[(&str, Colour)] = &[
    ("insertion", VERMILLION),
    ("merge", YELLOW),
    ("insertion_merge", ORANGE),
    ("rs", GREEN),
    ("rbs", BLUE),
    ("network", SKY_BLUE),
    ("insertion_merge64", Colour(0xdd, 0xcc, 0x77)),
    ("auto", Colour(0x44, 0xaa, 0x99)),
    ("passthrough", BLACK),
    ("unsorted", GREY),
    // Beyond Okabe and Ito's colours: Paul Tol's muted scheme and shades of it, by kinds of sort.
    ("network_u64", Colour(0x33, 0x22, 0x88)),
    ("network_merge", Colour(0x11, 0x77, 0x33)),
    ("network_merge32", Colour(0x99, 0x99, 0x33)),
    ("rbs_heap", Colour(0x66, 0x99, 0xcc)),
    ("rbs_hier", Colour(0x00, 0x44, 0x88)),
    ("heap", Colour(0x99, 0x4f, 0x00)),
    ("shell", Colour(0xcc, 0x66, 0x77)),
    ("cooperative", Colour(0xaa, 0x44, 0x99)),
    ("cooperative4", Colour(0xd4, 0xa6, 0xd0)),
    ("cooperative8", Colour(0xbb, 0x66, 0xb4)),
    ("cooperative16", Colour(0x8f, 0x2d, 0x86)),
    ("cooperative32", Colour(0x5c, 0x1a, 0x56)),
];

/// Layouts, by the captures that make them. There are more than Okabe and Ito have colours for: the
/// others are of Paul Tol's muted scheme. Lines are labelled too.
const LAYOUTS: &[(&str, Colour)] = &[
    ("linked_list", VERMILLION),
    ("linked_list_subgroup", ORANGE),
    ("linked_pages4", PURPLE),
    ("linked_pages6", Colour(0xaa, 0x44, 0x99)),
    ("array3d", BLACK),
    ("array3d_nearest", GREY),
    ("linearized", BLUE),
    ("linearized_sweep", SKY_BLUE),
    ("linearized_lookback", Colour(0x44, 0xaa, 0x99)),
    ("linearized_blend", Colour(0x33, 0x22, 0x88)),
    ("linearized_nearest", Colour(0x99, 0x99, 0x33)),
    ("linearized_unclipped", Colour(0xcc, 0x66, 0x77)),
    ("linearized_late", Colour(0x11, 0x77, 0x33)),
    ("interleaved", GREEN),
    ("interleaved_lists", Colour(0xdd, 0xcc, 0x77)),
];

/// The colour of a layout, wine for those that have none here.
#[must_use]
pub(crate) fn layout_colour(capture: &str) -> Colour {
    LAYOUTS.iter().find(|(name, _)| *name == capture).map_or(WINE, |(_, colour)| *colour)
}

/// Where a layout stands in tables and legends: those known by name first, in a fixed order.
#[must_use]
pub(crate) fn layout_place(capture: &str) -> usize {
    LAYOUTS.iter().position(|(name, _)| *name == capture).unwrap_or(LAYOUTS.len())
}

/// The colour of a sort: its own, purple for strategies joined by `+`, wine for others.
#[must_use]
pub(crate) fn sort_colour(sort: &str) -> Colour {
    let known = SORTS.iter().find(|(name, _)| *name == sort);
    known.map_or(if sort.contains('+') { PURPLE } else { WINE }, |(_, colour)| *colour)
}

/// Methods by kind: the word that their names begin with.
const METHOD_KINDS: &[(&str, Colour)] = &[
    ("weighted", BLACK),
    ("stochastic", ORANGE),
    ("moments", GREEN),
    ("k", BLUE),
    ("hybrid", SKY_BLUE),
    ("multi", VERMILLION),
    ("adaptive", YELLOW),
    ("hamburger", Colour(0x99, 0x4f, 0x00)),
    ("quantised", GREY),
    ("depth", Colour(0x33, 0x22, 0x88)),
    ("dual", PURPLE),
];

/// The kind of a method: `moments` of `moments4_bounded`, `dual` of `dual_peel_stop`.
#[must_use]
pub(crate) fn method_kind(method: &str) -> &str {
    method.split(|c: char| c == '_' || c.is_ascii_digit()).next().unwrap_or(method)
}

/// The colour of a technique: its sort's; a method's is its kind's.
fn technique_colour(technique: &Technique) -> Colour {
    if technique.method.is_empty() {
        return sort_colour(&technique.sort);
    }
    let kind = method_kind(&technique.method);
    METHOD_KINDS.iter().find(|(name, _)| *name == kind).map_or(WINE, |(_, colour)| *colour)
}

/// Draws the marker of a technique: colour by sort or by kind of method, shape by schedule, filled in
/// the fragment stage.
pub(crate) fn marker(canvas: &mut Canvas, technique: &Technique, at: (f64, f64), radius: f64) {
    let colour = technique_colour(technique);
    let filled = technique.shader_stage != "compute";
    let corners: &[(f64, f64)] = match technique.schedule.as_str() {
        "base" => {
            canvas.circle(at, radius, colour);
            if !filled {
                canvas.circle(at, radius * 0.55, PAPER);
            }
            return;
        }
        "bma-stencil" => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
        "bma-list" => &[(0.0, -1.15), (1.1, 0.85), (-1.1, 0.85)],
        _ => &[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)],
    };
    let points = |scale: f64| -> Vec<(f64, f64)> {
        corners
            .iter()
            .map(|(x, y)| (at.0 + x * radius * scale, at.1 + y * radius * scale))
            .collect()
    };
    canvas.polygon(&points(1.0), colour);
    if !filled {
        canvas.polygon(&points(0.5), PAPER);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_share_a_colour() {
        for colours in [SORTS, LAYOUTS, METHOD_KINDS] {
            for (index, (_, colour)) in colours.iter().enumerate() {
                assert!(colours[index + 1..].iter().all(|(_, other)| other != colour));
            }
        }
        assert_ne!(sort_colour("network+rbs"), sort_colour("new-sort"));
    }
}
