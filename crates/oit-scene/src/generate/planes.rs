use super::shapes::{part_colour, push_rectangle};
use super::{GenerateError, Generator, ORDERS, check_triangles, spaced};
use crate::{Mesh, Parameter, Params};

/// Two sets of parallel planes about the origin, facing +z, in strictly sorted order.
///
/// It follows the strips of pknowles/oit scenes/planes.xml and planes2.xml (RBS paper, section 4):
/// `full` planes equally spaced over `depth`, and `small` planes whose width, height and depth are
/// all `small_scale` times as large, so that they gather in the middle. There one strip is written
/// after the other; here all planes are written in the order of their depth, since what the paper
/// tests is sorted input.
pub(super) struct Planes;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("full", "Full-size planes.", 16, 0, 4096),
    Parameter::integer("small", "Small planes.", 112, 0, 4096),
    Parameter::number("small_scale", "Size of the small planes by the full.", 0.1, 0.0, 1.0),
    Parameter::number("width", "Width of a full plane, world units.", 2.48, 0.0, 1e6),
    Parameter::number("height", "Height of a full plane, world units.", 1.39, 0.0, 1e6),
    Parameter::number("depth", "From the first full plane to the last.", 1.0, 0.0, 1e6),
    Parameter::integer("tessellation", "Cells along each side of a plane.", 4, 1, 1024),
    Parameter::number("alpha", "Opacity of every plane.", 0.5, 0.0, 1.0),
    Parameter::word("order", "As seen from +z.", "front_to_back", ORDERS),
];

impl Generator for Planes {
    fn name(&self) -> &'static str {
        "planes"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let (full, small) = (params.integer("full"), params.integer("small"));
        let cells = params.integer("tessellation");
        check_triangles(&[full + small, cells, cells, 2])?;

        let scale = params.number("small_scale");
        let depth = params.number("depth");
        let mut planes: Vec<(f32, f32)> = spaced(full, depth)
            .map(|z| (z, 1.0))
            .chain(spaced(small, depth * scale).map(|z| (z, scale)))
            .collect();
        planes.sort_by(|a, b| b.0.total_cmp(&a.0));
        if params.word("order") == "back_to_front" {
            planes.reverse();
        }

        let mut mesh = Mesh::default();
        for (i, (z, scale)) in (0..).zip(planes) {
            let size = [params.number("width") * scale, params.number("height") * scale];
            let rgba = part_colour(i, params.number("alpha"));
            push_rectangle(&mut mesh, [0.0, 0.0, z], size, [cells, cells], rgba);
        }
        Ok(mesh)
    }
}
