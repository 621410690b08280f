//! The tables of the thesis on biomolecular scenes as our ways of drawing spheres.

use crate::published::Published;

/// A table: which way of drawing stands for each of its entries.
pub(crate) struct SphereTable {
    /// Its number in the thesis; files are named by it.
    pub(crate) number: &'static str,
    /// The published table.
    pub(crate) published: &'static str,
    /// Our scene and view.
    pub(crate) view: (&'static str, &'static str),
    /// What it shows, as a heading.
    pub(crate) title: &'static str,
    /// Its columns: the thesis's head, what is appended to the row's name, and the stage timed.
    pub(crate) columns: &'static [(&'static str, &'static str, &'static str)],
    /// Its rows: the thesis's head and our name. The first is what others are compared with.
    pub(crate) rows: &'static [(&'static str, &'static str)],
    /// Rows that the thesis does not have.
    pub(crate) beyond: &'static [(&'static str, &'static str)],
}

/// The stage of the thesis's protein program.
pub(crate) const DRAW: &str = "draw";
/// The stage of its preprocessing.
pub(crate) const PREPROCESS: &str = "preprocess";

/// The thesis's program.
pub(crate) const BASELINE: &str =
    "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes64";

const HIV: (&str, &str) = ("virus", "hiv");

/// Every table of times of the thesis.
pub(crate) const TABLES: [SphereTable; 6] = [
    SphereTable {
        number: "3.1",
        published: "spheres-table-3.1",
        view: ("sphere_stack", "front"),
        title: "order and depth, on a stack of 10,000 spheres",
        columns: &[
            ("back-to-front", "/back-to-front", DRAW),
            ("front-to-back", "/front-to-back", DRAW),
        ],
        rows: &[
            ("default depth", "spheres/batches/geometry/per-fragment/flat-depth/discard/bytes64"),
            ("per-fragment depth", BASELINE),
            (
                "+ conservative depth",
                "spheres/batches/geometry/per-fragment/conservative-depth/discard/bytes64",
            ),
        ],
        beyond: &[(
            "pulled, early projection, 4 byte, conservative",
            "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4",
        )],
    },
    SphereTable {
        number: "3.2",
        published: "spheres-table-3.2",
        view: HIV,
        title: "depth and discarding",
        columns: &[("GPU duration", "", DRAW)],
        rows: &[
            ("default depth", "spheres/batches/geometry/per-fragment/flat-depth/discard/bytes64"),
            ("per-fragment depth", BASELINE),
            (
                "per-fragment depth, conservative depth",
                "spheres/batches/geometry/per-fragment/conservative-depth/discard/bytes64",
            ),
            (
                "default depth, no discard",
                "spheres/batches/geometry/per-fragment/flat-depth/no-discard/bytes64",
            ),
            (
                "per-fragment depth, no discard",
                "spheres/batches/geometry/per-fragment/sphere-depth/infinite-depth/bytes64",
            ),
        ],
        beyond: &[(
            "per-fragment depth, triangles seen",
            "spheres/batches/geometry/per-fragment/sphere-depth/no-discard/bytes64",
        )],
    },
    SphereTable {
        number: "3.3",
        published: "spheres-table-3.3",
        view: HIV,
        title: "where positions are projected",
        columns: &[("GPU time", "", DRAW)],
        rows: &[
            ("per fragment", BASELINE),
            (
                "per billboard vertex",
                "spheres/batches/geometry/per-vertex/sphere-depth/discard/bytes64",
            ),
            (
                "per billboard center",
                "spheres/batches/geometry/per-center/sphere-depth/discard/bytes64",
            ),
        ],
        beyond: &[(
            "per billboard center, pulled",
            "spheres/per-object/pulled/per-center/sphere-depth/discard/bytes64",
        )],
    },
    SphereTable {
        number: "3.4",
        published: "spheres-table-3.4",
        view: HIV,
        title: "bytes written for each fragment",
        columns: &[("GPU time", "", DRAW)],
        rows: &[
            ("64 byte", BASELINE),
            ("36 byte", "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes36"),
            ("24 byte", "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes24"),
            ("12 byte", "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes12"),
            ("4 byte", "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes4"),
        ],
        beyond: &[],
    },
    SphereTable {
        number: "3.5",
        published: "spheres-table-3.5",
        view: HIV,
        title: "how draws are submitted",
        columns: &[("preprocessing", "", PREPROCESS), ("rendering", "", DRAW)],
        rows: &[
            ("tessellation", BASELINE),
            (
                "one draw command per object",
                "spheres/per-object/geometry/per-fragment/sphere-depth/discard/bytes64",
            ),
            (
                "one draw command per mesh",
                "spheres/per-mesh/geometry/per-fragment/sphere-depth/discard/bytes64",
            ),
        ],
        beyond: &[
            (
                "a list of atoms",
                "spheres/index-list/geometry/per-fragment/sphere-depth/discard/bytes64",
            ),
            ("compute rasteriser", "spheres/compute/bytes64"),
        ],
    },
    SphereTable {
        number: "4.1",
        published: "spheres-table-4.1",
        view: HIV,
        title: "combinations",
        columns: &[("preprocessing", "", PREPROCESS), ("protein program", "", DRAW)],
        rows: &[
            ("baseline", BASELINE),
            ("reduced output", "spheres/batches/geometry/per-fragment/sphere-depth/discard/bytes4"),
            ("multi draw", "spheres/per-object/geometry/per-fragment/sphere-depth/discard/bytes64"),
            (
                "instanced rendering",
                "spheres/per-mesh/geometry/per-fragment/sphere-depth/discard/bytes64",
            ),
            (
                "early projection",
                "spheres/batches/geometry/per-center/sphere-depth/discard/bytes64",
            ),
            (
                "reduced output + instanced rendering",
                "spheres/per-mesh/geometry/per-fragment/sphere-depth/discard/bytes4",
            ),
            (
                "instanced rendering + early projection",
                "spheres/per-mesh/geometry/per-center/sphere-depth/discard/bytes64",
            ),
            (
                "reduced output + early projection",
                "spheres/batches/geometry/per-center/sphere-depth/discard/bytes4",
            ),
            (
                "reduced output + multi draw + early projection",
                "spheres/per-object/geometry/per-center/sphere-depth/discard/bytes4",
            ),
            (
                "reduced output + instanced rendering + early projection",
                "spheres/per-mesh/geometry/per-center/sphere-depth/discard/bytes4",
            ),
        ],
        beyond: &[
            (
                "the same, pulled, conservative depth",
                "spheres/per-object/pulled/per-center/conservative-depth/discard/bytes4",
            ),
            (
                "a list of atoms, pulled, conservative depth",
                "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4",
            ),
            (
                "the same, outside in",
                "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4/outside-in",
            ),
            (
                "the same, occlusion culling",
                "spheres/index-list/pulled/per-center/conservative-depth/discard/bytes4/occlusion",
            ),
            ("compute rasteriser", "spheres/compute/bytes4"),
            ("the same, shaded in compute", "spheres/compute/direct"),
        ],
    },
];

impl SphereTable {
    /// Whether a scene, by its name without parameters, and a view are this table's.
    pub(crate) fn is_on(&self, scene: &str, view: &str) -> bool {
        self.view == (scene, view)
    }

    /// Every way of drawing in it.
    pub(crate) fn techniques(&self) -> Vec<String> {
        let rows = self.rows.iter().chain(self.beyond);
        let each = rows.flat_map(|(_, technique)| {
            self.columns.iter().map(move |(_, suffix, _)| format!("{technique}{suffix}"))
        });
        each.collect()
    }

    /// What the thesis has for a way of drawing and a stage, in milliseconds.
    pub(crate) fn value(&self, published: &Published, technique: &str, stage: &str) -> Option<f64> {
        let view = published.views.first()?;
        self.rows.iter().find_map(|(head, known)| {
            let of_column = |(_, suffix, timed): &&(&str, &str, &str)| {
                *timed == stage && technique.strip_prefix(known) == Some(*suffix)
            };
            let (column, ..) = self.columns.iter().find(of_column)?;
            published.value(head, view, column)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published;

    #[test]
    fn every_entry_of_the_thesis_has_a_way_of_drawing() {
        for table in &TABLES {
            let published = published::table(table.published).unwrap();
            let heads: Vec<&str> = table.rows.iter().map(|(head, _)| *head).collect();
            let known: Vec<&str> = published.rows.iter().map(|row| row.name.as_str()).collect();
            assert_eq!(heads, known, "{}", table.number);
            let columns: Vec<&str> = table.columns.iter().map(|(head, ..)| *head).collect();
            assert_eq!(columns, published.quantities, "{}", table.number);
        }
    }

    #[test]
    fn values_are_found_by_the_way_of_drawing() {
        let table = &TABLES[0];
        let published = published::table(table.published).unwrap();
        let value = |technique: &str| table.value(&published, technique, DRAW);
        assert_eq!(value(&format!("{BASELINE}/front-to-back")), Some(5.5));
        assert_eq!(value(&format!("{BASELINE}/back-to-front")), Some(9.9));
        assert_eq!(value(BASELINE), None);
    }
}
