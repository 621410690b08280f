use std::f32::consts::TAU;

use glam::Vec3;

use super::shapes::part_colour;
use super::{GenerateError, Generator, check_triangles};
use crate::{Mesh, Parameter, Params, SplitMix64, Vertex};

/// A ball of curled ribbons that stand out from a hollow core at the origin: half of them towards
/// -z, half towards +z. It takes the place of the hairball of the RBS paper (section 4), whose point
/// is a single mesh with sorted geometry.
///
/// The ribbons lie across the line from the core, and all of them are written level by level: the
/// +z half from the core outward, then the -z half from its tips inward. So from the origin the
/// fragments of a pixel arrive back to front when looking to -z and front to back when looking to
/// +z, up to the depth of one level. A linked list, read from its head, meets them the other way
/// round: sorted when looking to -z.
pub(super) struct Hairball;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("strands", "Ribbons in each half.", 3_000, 1, 1 << 22),
    Parameter::integer("levels", "Segments of a ribbon, two triangles each.", 240, 1, 4096),
    Parameter::number("core", "Radius at which ribbons start, world units.", 0.5, 1e-3, 1e6),
    Parameter::number("radius", "Radius at which ribbons end, world units.", 5.0, 1e-3, 1e6),
    Parameter::number("width", "Width of a ribbon, world units.", 0.0325, 0.0, 1e6),
    Parameter::number("curl", "Angular radius of a curl at the tip, radians.", 0.12, 0.0, 0.7),
    Parameter::number("turns", "Most turns that a ribbon curls.", 12.0, 0.0, 1000.0),
    Parameter::number("focus", "Density about the z axis, as cos^focus.", 5.0, 0.0, 1000.0),
    Parameter::number("alpha", "Opacity.", 0.05, 0.0, 1.0),
    Parameter::integer("seed", "Seed of the random numbers.", 1, 0, i64::MAX as u64),
];

impl Generator for Hairball {
    fn name(&self) -> &'static str {
        "hairball"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let strands = params.integer("strands");
        let levels = params.integer("levels");
        check_triangles(&[2, strands, levels, 2])?;
        let mut random = SplitMix64::new(params.integer("seed"));
        let mut mesh = Mesh::default();
        for side in [1.0, -1.0] {
            let half: Vec<Strand> =
                (0..strands).map(|i| Strand::new(i, side, params, &mut random)).collect();
            let first = mesh.vertices.len() as u32;
            for level in 0..=levels {
                // The -z half is written from the tips (1) to the core (0).
                let along = level as f32 / levels as f32;
                let along = if side < 0.0 { 1.0 - along } else { along };
                mesh.vertices.extend(half.iter().flat_map(|strand| strand.edge(along, params)));
            }
            push_levels(&mut mesh, first, strands as u32, levels as u32);
        }
        Ok(mesh)
    }
}

/// One ribbon: a circle about a direction that widens from the core outward.
struct Strand {
    direction: Vec3,
    across: [Vec3; 2],
    curl: f32,
    angle: f32,
    phase: f32,
    rgba: [u8; 4],
}

impl Strand {
    fn new(i: u64, side: f32, params: &Params, random: &mut SplitMix64) -> Self {
        // Inverse of the cumulative distribution of the density cos^focus over a hemisphere.
        let cos = (1.0 - random.unit()).powf(1.0 / (params.number("focus") + 1.0));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (y, x) = (TAU * random.unit()).sin_cos();
        let direction = Vec3::new(sin * x, sin * y, side * cos);
        let (a, b) = direction.any_orthonormal_pair();
        Self {
            direction,
            across: [a, b],
            curl: params.number("curl") * random.between(0.3, 1.0),
            angle: TAU * params.number("turns") * random.between(0.5, 1.0),
            phase: TAU * random.unit(),
            rgba: part_colour(i, params.number("alpha")),
        }
    }

    /// Unit vector from the core to the ribbon's middle, 0 at the core and 1 at the tip.
    fn towards(&self, along: f32) -> Vec3 {
        let (sin, cos) = (self.phase + self.angle * along).sin_cos();
        let [a, b] = self.across;
        (self.direction + self.curl * along.sqrt() * (a * cos + b * sin)).normalize()
    }

    /// The two vertices at one place along the ribbon.
    fn edge(&self, along: f32, params: &Params) -> [Vertex; 2] {
        let (core, radius) = (params.number("core"), params.number("radius"));
        let middle = self.towards(along);
        let ahead = self.towards(along + 1e-3) - middle;
        // Across both the line from the core and the way the ribbon goes.
        let side = middle.cross(ahead).normalize_or(self.across[0]);
        let position = middle * (core + (radius - core) * along);
        let half = side * params.number("width") / 2.0;
        [position - half, position + half].map(|position| Vertex {
            position: position.to_array(),
            normal: middle.to_array(),
            rgba: self.rgba,
        })
    }
}

/// The triangles between successive levels, all strands of a level before the next level.
fn push_levels(mesh: &mut Mesh, first: u32, strands: u32, levels: u32) {
    for level in 0..levels {
        for strand in 0..strands {
            let a = first + (level * strands + strand) * 2;
            let (b, c, d) = (a + 1, a + 2 * strands, a + 2 * strands + 1);
            mesh.indices.extend([a, b, d, a, d, c]);
        }
    }
}
