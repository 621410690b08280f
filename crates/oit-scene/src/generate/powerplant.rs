mod equipment;
mod materials;
mod piping;
mod structure;

use glam::Vec3;

use super::solids::{Place, Solids};
use super::{GenerateError, Generator, check_triangles};
use crate::{Mesh, Parameter, Params, SplitMix64};

/// A power plant, in metres: an open frame of columns and girders with floors of plates and
/// gratings, boilers of tubes, racks of pipes, tanks, machines, stairs and a chimney. It takes the
/// place of the UNC power plant of the BMA paper (section 4) and the RBS paper (section 4), and has
/// about as many triangles at full detail.
///
/// The ground lies at y = 0, the middle of the building at the origin, its long side along x. Parts
/// are written whole, kind by kind, as a modelling package saves its objects.
pub(super) struct PowerPlant;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer(
        "bays",
        "Spans of 6 m along the building; a boiler in every five.",
        10,
        5,
        20,
    ),
    Parameter::integer("storeys", "Floors above the ground, 5 m each.", 7, 3, 12),
    Parameter::integer("strays", "Thin pipes that wind through the building.", 260, 0, 4096),
    Parameter::number(
        "detail",
        "Triangles as a share of the full ones, about; no fewer than its surfaces need.",
        0.05,
        0.001,
        16.0,
    ),
    Parameter::number("alpha", "Opacity of every material as a share of its own.", 1.0, 0.0, 2.0),
    Parameter::integer("seed", "Of where floors, machines and pipes are.", 1, 0, u32::MAX as u64),
];

/// Between two columns.
const BAY: f32 = 6.0;
/// Spans across the building.
const ROWS: u64 = 5;
/// Between two floors.
const STOREY: f32 = 5.0;
/// Half the side of the shaft that a boiler stands in.
const BOILER_HALF: f32 = 8.0;
/// Racks of pipes under each ceiling.
const RACKS: u64 = 5;

const WORLD: Place = Place { origin: Vec3::ZERO, x: Vec3::X, z: Vec3::Z };

impl Generator for PowerPlant {
    fn name(&self) -> &'static str {
        "powerplant"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let detail = params.number("detail");
        let mut counter = Solids::counter(detail);
        build(&mut counter, params);
        check_triangles(&[counter.triangles()])?;
        let mut solids = Solids::builder(detail, params.number("alpha"));
        build(&mut solids, params);
        Ok(solids.into_mesh())
    }
}

fn build(solids: &mut Solids, params: &Params) {
    let mut random = SplitMix64::new(params.integer("seed"));
    let layout = Layout { bays: params.integer("bays"), storeys: params.integer("storeys") };

    structure::build(solids, &layout, &mut random);
    for (i, middle) in layout.boilers().enumerate() {
        equipment::boiler(solids, &layout, middle);
        equipment::duct(solids, &layout, middle, 3.0 * i as f32);
        equipment::turbine(solids, middle + Vec3::Z * 12.0);
    }
    equipment::chimney(solids, &layout);
    for storey in 0..layout.storeys {
        for _ in 0..RACKS {
            equipment::rack(solids, &layout, storey, &mut random);
        }
    }
    for storey in 0..layout.storeys {
        for (i, j) in layout.cells() {
            let free = !layout.in_boiler(layout.middle(i, j)) && !layout.has_stairs(i, j);
            // The turbines stand in the last row of the ground floor.
            if free && (storey, j) != (0, ROWS - 1) {
                equipment::machine(solids, &layout.place(i, j, storey), &mut random);
            }
        }
    }
    for _ in 0..params.integer("strays") {
        equipment::stray(solids, &layout, &mut random);
    }
}

/// How the building is laid out.
struct Layout {
    bays: u64,
    storeys: u64,
}

impl Layout {
    /// Half the building's extent along x and z.
    fn half(&self) -> [f32; 2] {
        [self.bays, ROWS].map(|spans| BAY * spans as f32 / 2.0)
    }

    /// The foot of a column.
    fn corner(&self, i: u64, j: u64) -> Vec3 {
        let [half_x, half_z] = self.half();
        Vec3::new(BAY * i as f32 - half_x, 0.0, BAY * j as f32 - half_z)
    }

    /// The middle of the ground between four columns.
    fn middle(&self, i: u64, j: u64) -> Vec3 {
        self.corner(i, j) + Vec3::new(BAY / 2.0, 0.0, BAY / 2.0)
    }

    /// The middle of a cell of a floor.
    fn place(&self, i: u64, j: u64, storey: u64) -> Place {
        Place { origin: self.middle(i, j) + Vec3::Y * STOREY * storey as f32, ..WORLD }
    }

    fn cells(&self) -> impl Iterator<Item = (u64, u64)> + use<> {
        let bays = self.bays;
        (0..bays).flat_map(|i| (0..ROWS).map(move |j| (i, j)))
    }

    /// Where the boilers stand, evenly along the building.
    fn boilers(&self) -> impl Iterator<Item = Vec3> + use<> {
        let count = self.bays / 5;
        let slice = BAY * self.bays as f32 / count as f32;
        (0..count).map(move |i| Vec3::X * slice * (i as f32 - (count - 1) as f32 / 2.0))
    }

    /// Whether a point of the plan is within a boiler's shaft.
    fn in_boiler(&self, at: Vec3) -> bool {
        self.boilers().any(|b| (at.x - b.x).abs() < BOILER_HALF && at.z.abs() < BOILER_HALF)
    }

    /// Two corners of the building have stairs.
    fn has_stairs(&self, i: u64, j: u64) -> bool {
        (i, j) == (0, 0) || (i, j) == (self.bays - 1, ROWS - 1)
    }

    fn chimney(&self) -> Vec3 {
        Vec3::new(self.half()[0] + 8.0, 0.0, -1.0)
    }
}
