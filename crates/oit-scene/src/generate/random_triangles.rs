use super::{GenerateError, Generator, check_triangles};
use crate::mesh::{flat_normal, to_byte};
use crate::{Mesh, Parameter, Params, SplitMix64, Vertex};

/// Triangles at random places and turns in a cube of side 2 about the origin. They intersect, so no
/// order of the triangles is right for every pixel.
pub(super) struct RandomTriangles;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Triangles.", 64, 0, 1 << 20),
    Parameter::number("size", "Farthest a corner lies from its centre, per axis.", 0.7, 0.0, 1e6),
    Parameter::number("alpha", "Opacity of every triangle.", 0.3, 0.0, 1.0),
    Parameter::integer("seed", "Seed of the random numbers.", 1, 0, i64::MAX as u64),
];

impl Generator for RandomTriangles {
    fn name(&self) -> &'static str {
        "random_triangles"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let count = params.integer("count");
        check_triangles(&[count])?;
        let size = params.number("size");
        let mut random = SplitMix64::new(params.integer("seed"));
        let mut mesh = Mesh::default();
        for _ in 0..count {
            let centre: [f32; 3] = std::array::from_fn(|_| random.between(-1.0, 1.0));
            let corners: [[f32; 3]; 3] =
                std::array::from_fn(|_| centre.map(|c| c + size * random.between(-1.0, 1.0)));
            let [r, g, b] = std::array::from_fn(|_| to_byte(random.unit()));
            let rgba = [r, g, b, to_byte(params.number("alpha"))];
            let normal = flat_normal(corners[0], corners[1], corners[2]);
            mesh.indices.extend((0..3).map(|corner| mesh.vertices.len() as u32 + corner));
            mesh.vertices.extend(corners.map(|position| Vertex { position, normal, rgba }));
        }
        Ok(mesh)
    }
}
