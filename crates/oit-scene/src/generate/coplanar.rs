use glam::{Quat, Vec3};

use super::shapes::{part_colour, push_quad};
use super::{GenerateError, Generator, check_triangles};
use crate::{Mesh, Parameter, Params};

/// Rectangles in one plane, or hardly apart, about the origin: what is called z-fighting. The plane is
/// turned about the x and then the y axis, so that depths must be interpolated; and each rectangle is a
/// little smaller than the one before and cut along the other diagonal, so that they are interpolated
/// from other numbers, and equal places on equal planes come out some last bits apart.
pub(super) struct Coplanar;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Rectangles.", 8, 0, 4096),
    Parameter::number("size", "Side of the first, world units.", 1.6, 0.0, 1e6),
    Parameter::number("shrink", "Each side by that of the one before.", 0.97, 0.0, 1.0),
    Parameter::number("gap", "From one plane to the next, world units.", 0.0, 0.0, 1e6),
    Parameter::number("tilt", "Turn about the x axis, degrees; 0 faces +z.", 40.0, -89.0, 89.0),
    Parameter::number("turn", "Turn about the y axis, degrees.", 25.0, -89.0, 89.0),
    Parameter::number("alpha", "Opacity of every rectangle.", 0.5, 0.0, 1.0),
];

impl Generator for Coplanar {
    fn name(&self) -> &'static str {
        "coplanar"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        check_triangles(&[count, 2])?;
        let [tilt, turn] = ["tilt", "turn"].map(|angle| params.number(angle).to_radians());
        let turned = Quat::from_rotation_y(turn) * Quat::from_rotation_x(tilt);
        let mut mesh = Mesh::default();
        let mut half = params.number("size") / 2.0;
        for i in 0..count {
            let z = -params.number("gap") * i as f32;
            let corner = |x: f32, y: f32| (turned * Vec3::new(x * half, y * half, z)).to_array();
            let mut corners =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            // The diagonal runs from the first corner to the third.
            corners.rotate_left((i % 2) as usize);
            push_quad(&mut mesh, corners, part_colour(i, params.number("alpha")));
            half *= params.number("shrink");
        }
        Ok(mesh)
    }
}
