use super::shapes::{part_colour, push_sphere};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params};

/// Closed spheres about the origin, one in the other. Every shell has surfaces on both sides of those
/// inside it, so from outside no order of whole shells is right. Shells closer together than their
/// triangles are deep cannot be drawn by sorting those either.
pub(super) struct Shells;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Spheres.", 5, 1, 1024),
    Parameter::number("outer", "Radius of the largest.", 1.0, 1e-3, 1e6),
    Parameter::number("inner", "Radius of the smallest.", 0.8, 1e-3, 1e6),
    Parameter::integer("tessellation", "Rings of a sphere; twice as many sectors.", 24, 3, 1024),
    Parameter::number("alpha", "Opacity of every shell.", 0.5, 0.0, 1.0),
];

impl Generator for Shells {
    fn name(&self) -> &'static str {
        "shells"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    /// The largest first.
    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        let rings = params.integer("tessellation");
        check_triangles(&[count, rings, 2 * rings, 2])?;
        let (outer, inner) = (params.number("outer"), params.number("inner"));
        let mut mesh = Mesh::default();
        for (i, offset) in (0..).zip(spaced(count, outer - inner)) {
            let radius = (outer + inner) / 2.0 + offset;
            let rgba = part_colour(i, params.number("alpha"));
            push_sphere(&mut mesh, [0.0; 3], radius, rings as u32, rgba);
        }
        Ok(mesh)
    }
}
