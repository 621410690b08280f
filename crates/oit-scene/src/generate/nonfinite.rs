use super::shapes::{part_colour, push_quad};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params};

/// Squares behind one another, of which every other one has a vertex where no vertex can be: a damaged
/// mesh. It is one of the square's two triangles that has it; the other is whole.
///
/// Importers refuse such meshes with the place of the vertex. This generator is the one way to have one,
/// so that what draws can be tested with it. What is right: a triangle with a vertex that is not finite,
/// or that is not finite once projected, is not drawn, as if the mesh did not have it (`removed`).
pub(super) struct Nonfinite;

const KINDS: &[&str] = &["nan", "infinite", "negative_infinite", "huge", "removed"];

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Squares.", 8, 0, 4096),
    Parameter::number("size", "Side, world units.", 1.0, 0.0, 1e6),
    Parameter::number("gap", "Distance between squares, world units.", 0.02, 0.0, 1e6),
    Parameter::number("alpha", "Opacity of every square.", 0.5, 0.0, 1.0),
    Parameter::word(
        "kind",
        "What the x of a damaged vertex is; `huge` is the largest float; with `removed` the damaged \
         triangles are left out.",
        "nan",
        KINDS,
    ),
];

impl Generator for Nonfinite {
    fn name(&self) -> &'static str {
        "nonfinite"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        check_triangles(&[count, 2])?;
        let x = match params.word("kind") {
            "nan" => Some(f32::NAN),
            "infinite" => Some(f32::INFINITY),
            "negative_infinite" => Some(f32::NEG_INFINITY),
            "huge" => Some(f32::MAX),
            _ => None,
        };
        let half = params.number("size") / 2.0;
        let extent = params.number("gap") * count.saturating_sub(1) as f32;
        let mut mesh = Mesh::default();
        for (i, z) in (0..).zip(spaced(count, extent)) {
            let corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
            push_quad(&mut mesh, corners, part_colour(i, params.number("alpha")));
            if i % 2 == 1 {
                continue;
            }
            // The second vertex of four is the first triangle's alone.
            match x {
                Some(x) => {
                    let damaged = mesh.vertices.len() - 3;
                    mesh.vertices[damaged].position[0] = x;
                }
                None => {
                    let first = mesh.indices.len() - 6;
                    mesh.indices.drain(first..first + 3);
                }
            }
        }
        Ok(mesh)
    }
}
