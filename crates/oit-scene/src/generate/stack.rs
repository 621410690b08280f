use std::f32::consts::PI;

use super::shapes::{part_colour, push_cells, push_rectangle};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params, Vertex, shuffle_triangles};

/// Squares or spheres behind one another on the z axis about the origin. A pixel in the middle has
/// exactly `count` fragments for squares and twice as many for spheres.
pub(super) struct Stack;

/// `random` shuffles the triangles of all parts together, so that the order of a pixel's fragments
/// differs from cell to cell.
const ORDERS: &[&str] = &["front_to_back", "back_to_front", "random"];

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Squares or spheres.", 32, 0, 4096),
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
                push_sphere(&mut mesh, z, size / 2.0, cells as u32, rgba);
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

/// Rings about the z axis, written from the near pole to the far one. Two triangles per cell; one
/// of the two is empty in the first and last ring.
fn push_sphere(mesh: &mut Mesh, z: f32, radius: f32, rings: u32, rgba: [u8; 4]) {
    let sectors = 2 * rings;
    let first = mesh.vertices.len() as u32;
    for ring in 0..=rings {
        let (sin, cos) = (PI * ring as f32 / rings as f32).sin_cos();
        for sector in 0..=sectors {
            // The seam's two sides are the same numbers, so that no pixel falls between them.
            let (y, x) = (2.0 * PI * (sector % sectors) as f32 / sectors as f32).sin_cos();
            let normal = [sin * x, sin * y, cos];
            let [x, y, dz] = normal.map(|n| n * radius);
            mesh.vertices.push(Vertex { position: [x, y, z + dz], normal, rgba });
        }
    }
    push_cells(mesh, first, sectors, rings);
}
