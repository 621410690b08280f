use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::shapes::{part_colour, push_quad};
use super::{GenerateError, Generator, check_triangles};
use crate::{Mesh, Parameter, Params};

/// Flat bars along the sides of a regular polygon, each beyond its corners and rising towards +z on
/// its way round: every bar lies over the next, and the last over the first (LFB chapter, Figure
/// 20.2). Seen from +z no order of the bars is right.
///
/// The i-th bar's middle lies on a circle of the radius `radius` about the origin at the angle
/// `TAU * i / bars`, its end towards greater angles at z = `rise`, the other at -`rise`.
pub(super) struct Cyclic;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("bars", "Bars in the cycle.", 3, 3, 64),
    Parameter::number("radius", "From the middle to the middle of a bar.", 0.35, 1e-3, 1e6),
    Parameter::number("width", "Width of a bar, world units.", 0.2, 1e-3, 1e6),
    Parameter::number(
        "overhang",
        "Half a bar's length as a multiple of the way to the corner.",
        1.4,
        1.0,
        100.0,
    ),
    Parameter::number("rise", "Height of a bar's upper end over its middle.", 0.3, 0.0, 1e6),
    Parameter::number("alpha", "Opacity of every bar.", 0.5, 0.0, 1.0),
];

impl Generator for Cyclic {
    fn name(&self) -> &'static str {
        "cyclic"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let bars = params.integer("bars");
        check_triangles(&[bars, 2])?;
        let radius = params.number("radius");
        let half_length = params.number("overhang") * radius * (PI / bars as f32).tan();
        let half_width = params.number("width") / 2.0;
        let mut mesh = Mesh::default();
        for i in 0..bars {
            let outward = Vec2::from_angle(TAU * i as f32 / bars as f32);
            let along = outward.perp();
            let corner = |along_by: f32, out_by: f32| {
                let flat =
                    outward * (radius + half_width * out_by) + along * half_length * along_by;
                Vec3::new(flat.x, flat.y, params.number("rise") * along_by).to_array()
            };
            let corners =
                [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
            push_quad(&mut mesh, corners, part_colour(i, params.number("alpha")));
        }
        Ok(mesh)
    }
}
