use super::shapes::{part_colour, push_rectangle, push_sphere};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params, shuffle_triangles};

/// Squares or spheres behind one another on the z axis about the origin. A pixel in the middle has
/// exactly `count` fragments for squares and twice as many for spheres.
pub(super) struct Stack;

/// `random` shuffles the triangles of all parts together, so that the order of a pixel's fragments
/// differs from cell to cell.
const ORDERS: &[&str] = &["front_to_back", "back_to_front", "random"];

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Squares or spheres.", 32, 0, 16384),
    Parameter::word("shape", "What is stacked.", "square", &["square", "sphere"]),
    Parameter::number("size", "Side or diameter, world units.", 1.0, 0.0, 1e6),
    Parameter::number("gap", "Distance between centres, world units.", 0.02, 0.0, 1e6),
    Parameter::integer("tessellation", "Cells along a side, or rings of a sphere.", 8, 2, 1024),
    Parameter::number("alpha", "Opacity of every part.", 0.2, 0.0, 1.0),
    Parameter::word("order", "As seen from +z.", "front_to_back", ORDERS),
    Parameter::integer("seed", "Of the random order.", 1, 0, u32::MAX as u64),
];

impl Generator for Stack {
    fn name(&self) -> &'static str {
        "stack"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        let cells = params.integer("tessellation");
        let square = params.word("shape") == "square";
        check_triangles(&[count, cells, if square { cells } else { 2 * cells }, 2])?;

        let size = params.number("size");
        let extent = params.number("gap") * count.saturating_sub(1) as f32;
        let mut mesh = Mesh::default();
        for (i, z) in (0..).zip(spaced(count, extent)) {
            let rgba = part_colour(i, params.number("alpha"));
            if square {
                push_rectangle(&mut mesh, [0.0, 0.0, z], [size, size], [cells, cells], rgba);
            } else {
                push_sphere(&mut mesh, [0.0, 0.0, z], size / 2.0, cells as u32, rgba);
            }
        }
        match params.word("order") {
            "back_to_front" => mesh.reverse_triangles(),
            "random" => mesh = shuffle_triangles(&mesh, params.integer("seed")),
            _ => {}
        }
        Ok(mesh)
    }
}
