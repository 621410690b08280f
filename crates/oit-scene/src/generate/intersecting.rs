use glam::{Vec2, Vec3};

use super::shapes::{part_colour, push_quad};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params};

/// Upright squares that cut through one another along the y axis, fanned out about it: seen from +z,
/// of any two the one is nearer on the left of the axis and the other on the right.
///
/// The squares' angles to the view's plane are equally spaced over `spread`, the largest first; at
/// the angle a, a square goes through the direction (cos a, 0, sin a).
pub(super) struct Intersecting;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Squares.", 4, 2, 4096),
    Parameter::number("size", "Side of a square, world units.", 1.6, 1e-3, 1e6),
    Parameter::number("spread", "From the first square to the last, degrees.", 120.0, 0.0, 179.0),
    Parameter::number("alpha", "Opacity of every square.", 0.5, 0.0, 1.0),
];

impl Generator for Intersecting {
    fn name(&self) -> &'static str {
        "intersecting"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        check_triangles(&[count, 2])?;
        let half = params.number("size") / 2.0;
        let mut mesh = Mesh::default();
        for (i, angle) in (0..).zip(spaced(count, params.number("spread").to_radians())) {
            let across = Vec2::from_angle(angle) * half;
            let corner =
                |x: f32, y: f32| Vec3::new(x * across.x, y * half, x * across.y).to_array();
            let corners =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            push_quad(&mut mesh, corners, part_colour(i, params.number("alpha")));
        }
        Ok(mesh)
    }
}
