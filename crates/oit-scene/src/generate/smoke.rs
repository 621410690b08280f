use std::f32::consts::TAU;

use glam::Vec3;

use super::{GenerateError, Generator, check_triangles};
use crate::mesh::to_byte;
use crate::{Mesh, Parameter, Params, SplitMix64, Vertex};

/// A plume of smoke: square billboards that rise from the origin, grow, spread and curl as they age.
/// It takes the place of the smoke of the BMA paper (Figure 1 and Table 2), of which it has the
/// number of triangles.
///
/// Every square faces +z, as billboards face the screen of a camera that looks along -z, and is
/// turned within its plane. Squares are written as they were emitted, the oldest first; their depths
/// are in no order.
pub(super) struct Smoke;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("particles", "Squares, two triangles each.", 6734, 1, 1 << 20),
    Parameter::number("size", "Side of the oldest squares, world units, about.", 0.291, 0.0, 1e3),
    Parameter::number(
        "spread",
        "Radius of the plume at its top before turbulence, world units.",
        1.02,
        0.0,
        1e3,
    ),
    Parameter::number(
        "curl",
        "How far turbulence carries the oldest, world units, about.",
        1.0,
        0.0,
        1e3,
    ),
    Parameter::number(
        "alpha",
        "Opacity of the squares of middle age, about; the oldest have half.",
        0.05,
        0.0,
        0.5,
    ),
    Parameter::integer("seed", "Seed of the random numbers.", 1, 0, i64::MAX as u64),
];

/// How high the plume rises before turbulence, world units.
const HEIGHT: f32 = 4.0;
/// Age to height: below 1, so that the smoke slows down as it rises.
const SLOWING: f32 = 0.8;
/// Radius of the plume, and side of a square, when it is emitted, as a share of the oldest's.
const YOUNGEST: f32 = 0.2;
/// The plume is emitted in so many puffs.
const PUFFS: f32 = 9.0;
/// How much of a puff's time is moved towards its middle: 1 leaves a moment without emission.
const PULSE: f32 = 0.6;
/// Steps along the turbulence from where a square would be without it.
const STEPS: usize = 8;

impl Generator for Smoke {
    fn name(&self) -> &'static str {
        "smoke"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let particles = params.integer("particles");
        check_triangles(&[2, particles])?;
        let mut random = SplitMix64::new(params.integer("seed"));
        let turbulence = Turbulence::new(&mut random);
        let mut mesh = Mesh::default();
        for i in 0..particles {
            let age = 1.0 - (i as f32 + random.unit()) / particles as f32;
            push_particle(&mut mesh, age, params, &turbulence, &mut random);
        }
        Ok(mesh)
    }
}

/// One square of an age from 0, just emitted, to 1.
fn push_particle(
    mesh: &mut Mesh,
    age: f32,
    params: &Params,
    turbulence: &Turbulence,
    random: &mut SplitMix64,
) {
    let grown = YOUNGEST + (1.0 - YOUNGEST) * age;
    let offset = Vec3::from_array(std::array::from_fn(|_| bell(random)));
    let pulsed = (age + PULSE * (TAU * PUFFS * age).sin() / (TAU * PUFFS)).clamp(0.0, 1.0);
    let axis = Vec3::Y * HEIGHT * pulsed.powf(SLOWING);
    let calm = axis + offset * params.number("spread") * grown;
    let middle = turbulence.carry(calm, params.number("curl") * age);

    let half = params.number("size") * grown * random.between(0.7, 1.3) / 2.0;
    let (sin, cos) = random.between(0.0, TAU).sin_cos();
    let (x, y) = (Vec3::new(cos, sin, 0.0) * half, Vec3::new(-sin, cos, 0.0) * half);
    // Thick and dark when young, thin and bright when old.
    let grey = to_byte((0.25 + 0.5 * age + random.between(-0.15, 0.15)).clamp(0.0, 1.0));
    let thickness = (1.6 - 1.1 * age) * random.between(0.8, 1.2);
    let rgba = [grey, grey, grey, to_byte(params.number("alpha") * thickness)];

    let first = mesh.vertices.len() as u32;
    let corners = [middle - x - y, middle + x - y, middle + x + y, middle - x + y];
    let normal = Vec3::Z.to_array();
    mesh.vertices.extend(corners.map(|position| Vertex {
        position: position.to_array(),
        normal,
        rgba,
    }));
    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
}

/// From -1 to 1, like a bell about 0: the mean of four uniform numbers.
fn bell(random: &mut SplitMix64) -> f32 {
    (0..4).map(|_| random.between(-1.0, 1.0)).sum::<f32>() / 4.0
}

/// A velocity field without sources or sinks: waves, each across the way it runs.
struct Turbulence {
    waves: [Wave; 8],
}

struct Wave {
    /// Radians a world unit.
    number: Vec3,
    velocity: Vec3,
    phase: f32,
}

impl Turbulence {
    /// Waves from long and strong to short and weak.
    fn new(random: &mut SplitMix64) -> Self {
        let waves = std::array::from_fn(|i| {
            let length = 4.0 * 0.72f32.powi(i as i32);
            let [along, other] = [direction(random), direction(random)];
            let across = along.cross(other).normalize_or(along.any_orthonormal_vector());
            let phase = random.between(0.0, TAU);
            Wave { number: along * TAU / length, velocity: across * length / 4.0, phase }
        });
        Self { waves }
    }

    fn velocity(&self, at: Vec3) -> Vec3 {
        self.waves.iter().map(|wave| wave.velocity * (wave.number.dot(at) + wave.phase).cos()).sum()
    }

    /// Where a particle gets to in a time.
    fn carry(&self, from: Vec3, time: f32) -> Vec3 {
        let step = time / STEPS as f32;
        (0..STEPS).fold(from, |at, _| at + self.velocity(at) * step)
    }
}

/// A unit vector, all alike likely.
fn direction(random: &mut SplitMix64) -> Vec3 {
    let z = random.between(-1.0, 1.0);
    let (sin, cos) = random.between(0.0, TAU).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}
