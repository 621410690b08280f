use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

use super::solids::{Arch, Place, Solids};
use super::{GenerateError, Generator, check_triangles};
use crate::mesh::to_byte;
use crate::{Mesh, Parameter, Params, SplitMix64};

/// A courtyard under the open sky with two storeys of arcades about it, in metres: fluted columns,
/// vaulted galleries, balustrades, curtains, glazed windows, tiled roofs, a fountain and potted
/// plants. It takes the place of the Sponza atrium of the papers (LFB chapter, section 20.5; BMA
/// paper, section 4; RBS paper, section 4), of which it has the number of triangles.
///
/// The floor lies at y = 0, the middle of the court at the origin, its long side along x. Parts are
/// written whole, kind by kind, as a modelling package saves its objects.
pub(super) struct Atrium;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("bays_long", "Arches along the court's long side.", 8, 1, 64),
    Parameter::integer("bays_wide", "Arches along its short side.", 3, 1, 64),
    Parameter::number(
        "detail",
        "Triangles as a share of the full ones, about; no fewer than its surfaces need, a tenth.",
        1.0,
        0.01,
        16.0,
    ),
    Parameter::number("alpha", "Opacity of every material as a share of its own.", 1.0, 0.0, 2.0),
    Parameter::integer(
        "seed",
        "Of the tones, the folds of cloth and the leaves.",
        1,
        0,
        u32::MAX as u64,
    ),
];

/// Width of an arch with its column, and depth of the galleries.
const BAY: f32 = 3.6;
/// Where arches begin, downstairs.
const SPRING: f32 = 3.2;
/// Depth of the chambers behind the galleries.
const CHAMBER: f32 = 2.6;
/// The floor upstairs.
const UPPER: f32 = 5.4;
/// Where arches begin, upstairs, above the ground.
const UPPER_SPRING: f32 = 7.9;
/// Where the walls end.
const EAVES: f32 = 9.4;

/// The underside of the paving.
const BED: f32 = -0.2;
/// How far below a floor the things end that stand on it, lest two faces lie in one another.
const SUNK: f32 = -0.05;

// Materials: colour and opacity.
const PAVING: [u8; 4] = [150, 132, 112, 128];
const LIMESTONE: [u8; 4] = [205, 190, 160, 92];
const MARBLE: [u8; 4] = [225, 220, 210, 102];
const PLASTER: [u8; 4] = [215, 180, 130, 77];
const TIMBER: [u8; 4] = [120, 75, 45, 110];
const ROOF_TILE: [u8; 4] = [185, 85, 55, 115];
const BRONZE: [u8; 4] = [140, 105, 45, 128];
const GLASS: [u8; 4] = [150, 200, 220, 51];
const WATER: [u8; 4] = [70, 150, 190, 64];
const TERRACOTTA: [u8; 4] = [195, 100, 65, 115];
const LEAF: [u8; 4] = [60, 140, 55, 90];
const CLOTHS: [[u8; 4]; 3] = [[185, 35, 40, 77], [40, 125, 70, 77], [45, 70, 165, 77]];

impl Generator for Atrium {
    fn name(&self) -> &'static str {
        "atrium"
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
    let court = Court::new(params.integer("bays_long"), params.integer("bays_wide"));
    let bays = court.arcade();
    let cells = court.gallery();

    court.floor(solids, &mut random);
    bays.iter().for_each(|bay| column(solids, bay));
    bays.iter().for_each(|bay| arcade(solids, bay));
    cells.iter().for_each(|cell| vault(solids, cell));
    cells.iter().for_each(|cell| outer_walls(solids, cell));
    cells.iter().for_each(|cell| chambers(solids, cell));
    bays.iter().for_each(|bay| balustrade(solids, bay));
    bays.iter().for_each(|bay| loggia(solids, bay));
    cells.iter().for_each(|cell| roof(solids, cell));
    for (i, bay) in bays.iter().enumerate() {
        let rgba = CLOTHS[i % CLOTHS.len()];
        curtains(solids, bay, rgba, &mut random);
        if i % 2 == 1 {
            banner(solids, bay, rgba, &mut random);
        }
    }
    cells.iter().for_each(|cell| lantern(solids, &cell.place.moved(0.0, 0.0, BAY / 2.0)));
    for bay in &bays {
        potted_plant(solids, &bay.place.moved(-BAY / 2.0, 0.0, -0.9), &mut random);
    }
    fountain(solids, &Place { origin: Vec3::ZERO, x: Vec3::X, z: Vec3::Z });
}

/// How the courtyard is laid out.
struct Court {
    /// Half the court's extent between the lines of columns, along x and z.
    half: [f32; 2],
    bays: [u64; 2],
}

/// One arch of the arcade: its origin is the middle of its foot, x runs along the wall, z outward.
/// The column at the end towards -x is its own.
struct Bay {
    place: Place,
}

/// A square of the gallery: its origin is the middle of its inner edge, x runs along the wall, z
/// outward.
struct Cell {
    place: Place,
    /// Whether two galleries meet in it, so that it has an outer wall towards +x as well.
    corner: bool,
}

impl Court {
    fn new(long: u64, wide: u64) -> Self {
        Self { half: [long, wide].map(|bays| bays as f32 * BAY / 2.0), bays: [long, wide] }
    }

    /// The four walls: the place of each wall's foot at its end towards -x, and how many bays it
    /// has. Each begins where the one before ends.
    fn walls(&self) -> [(Place, u64); 4] {
        let ([hx, hz], [long, wide]) = (self.half, self.bays);
        let wall = |origin, x: Vec3, z, bays| (Place { origin, x, z }, bays);
        [
            wall(Vec3::new(-hx, 0.0, hz), Vec3::X, Vec3::Z, long),
            wall(Vec3::new(hx, 0.0, hz), Vec3::NEG_Z, Vec3::X, wide),
            wall(Vec3::new(hx, 0.0, -hz), Vec3::NEG_X, Vec3::NEG_Z, long),
            wall(Vec3::new(-hx, 0.0, -hz), Vec3::Z, Vec3::NEG_X, wide),
        ]
    }

    fn arcade(&self) -> Vec<Bay> {
        let mut all = Vec::new();
        for (wall, bays) in self.walls() {
            all.extend((0..bays).map(|i| Bay { place: wall.moved(middle(i), 0.0, 0.0) }));
        }
        all
    }

    /// The squares of the galleries, each wall's with the corner behind its end.
    fn gallery(&self) -> Vec<Cell> {
        let mut all = Vec::new();
        for (wall, bays) in self.walls() {
            let cell = |i| Cell { place: wall.moved(middle(i), 0.0, 0.0), corner: i == bays };
            all.extend((0..=bays).map(cell));
        }
        all
    }

    /// Paving, square by square, each in a tone of its own, on a bed that shows from below.
    fn floor(&self, solids: &mut Solids, random: &mut SplitMix64) {
        let [long, wide] = self.bays.map(|bays| bays + 2);
        let [x, z] = self.half.map(|half| -half - BAY);
        let cells = [solids.cells(8, 1); 2];
        for row in 0..wide {
            for column in 0..long {
                let corner = Vec3::new(x + BAY * column as f32, 0.0, z + BAY * row as f32);
                let rgba = toned(PAVING, random.between(0.8, 1.1));
                for y in [BED, 0.0] {
                    solids.patch(cells, rgba, |u, v| corner + Vec3::new(BAY * u, y, BAY * v));
                }
            }
        }
    }
}

/// Where along a wall its i-th bay has its middle.
fn middle(i: u64) -> f32 {
    BAY * (i as f32 + 0.5)
}

fn toned([r, g, b, a]: [u8; 4], tone: f32) -> [u8; 4] {
    let [r, g, b] = [r, g, b].map(|channel| to_byte(f32::from(channel) / 255.0 * tone));
    [r, g, b, a]
}

/// A fluted column with its plinth, base and capital.
fn column(solids: &mut Solids, bay: &Bay) {
    let place = bay.place.moved(-BAY / 2.0, 0.0, 0.0);
    solids.block(&place, [-0.36, SUNK, -0.36], [0.36, 0.2, 0.36], LIMESTONE);
    let base = [[0.33, 0.2], [0.36, 0.25], [0.33, 0.3], [0.29, 0.33], [0.31, 0.37], [0.28, 0.42]];
    solids.turned(&place, &base, [36, 1], 0, MARBLE);
    let shaft = [[0.27, 0.42], [0.275, 1.2], [0.23, SPRING - 0.55]];
    solids.turned(&place, &shaft, [64, 3], 16, MARBLE);
    let capital = [
        [0.23, SPRING - 0.55],
        [0.27, SPRING - 0.52],
        [0.24, SPRING - 0.48],
        [0.28, SPRING - 0.3],
        [0.38, SPRING - 0.12],
    ];
    solids.turned(&place, &capital, [36, 1], 8, MARBLE);
    solids.block(&place, [-0.37, SPRING - 0.12, -0.37], [0.37, SPRING, 0.37], LIMESTONE);
}

/// The wall over an arch downstairs, and the moulding that runs along it.
fn arcade(solids: &mut Solids, bay: &Bay) {
    let arch =
        Arch { width: BAY, spring: SPRING, top: UPPER, radius: BAY / 2.0 - 0.32, thickness: 0.5 };
    solids.arch(&bay.place, arch, 32, LIMESTONE);
    moulding(solids, bay, UPPER - 0.45, 0.2);
    moulding(solids, bay, EAVES - 0.35, 0.3);
}

/// A rounded band along the court's side of the wall.
fn moulding(solids: &mut Solids, bay: &Bay, y: f32, height: f32) {
    let cells = [solids.cells(10, 1), solids.cells(12, 3)];
    solids.patch(cells, MARBLE, |u, v| {
        let (sin, cos) = (PI * v).sin_cos();
        bay.place.at(BAY * (u - 0.5), y + height * (0.5 - 0.5 * cos), -0.25 - 0.12 * sin)
    });
}

/// A groin vault, the arch across the gallery at its end towards -x, and the floor above it.
fn vault(solids: &mut Solids, cell: &Cell) {
    let place = cell.place.moved(0.0, 0.0, BAY / 2.0);
    let cells = [solids.cells(12, 2); 2];
    for shell in [0.0, 0.12] {
        solids.patch(cells, PLASTER, |u, v| {
            let round = |t: f32| (1.0 - (2.0 * t - 1.0).powi(2)).max(0.0).sqrt();
            let height = SPRING + shell + 1.55 * round(u).max(round(v));
            place.at(BAY * (u - 0.5), height, BAY * (v - 0.5))
        });
    }
    let across = Place { x: place.z, z: place.x, ..place.moved(-BAY / 2.0, 0.0, 0.0) };
    let arch =
        Arch { width: BAY, spring: SPRING, top: UPPER, radius: BAY / 2.0 - 0.32, thickness: 0.4 };
    solids.arch(&across, arch, 24, LIMESTONE);
    let half = BAY / 2.0;
    solids.slab(&place, [[-half; 2], [half; 2]], [UPPER - 0.25, UPPER], TIMBER);
}

/// Where the outer walls of a square of the gallery stand: one, or two of a corner.
fn outer_places(cell: &Cell) -> impl Iterator<Item = Place> {
    let half = BAY / 2.0;
    let Place { x, z, .. } = cell.place;
    let beside = Place { x: -z, z: x, ..cell.place.moved(half, 0.0, half) };
    [Some(cell.place.moved(0.0, 0.0, BAY)), cell.corner.then_some(beside)].into_iter().flatten()
}

fn outer_walls(solids: &mut Solids, cell: &Cell) {
    outer_places(cell).for_each(|place| outer_wall(solids, &place));
}

/// The chambers behind the doors and windows of a square: floors, and walls beside and behind them.
fn chambers(solids: &mut Solids, cell: &Cell) {
    let half = BAY / 2.0;
    for place in outer_places(cell) {
        let extent = [[-half, 0.0], [half, CHAMBER]];
        solids.slab(&place, extent, [BED, 0.0], PAVING);
        solids.slab(&place, extent, [UPPER - 0.25, UPPER], TIMBER);
        solids.slab(&place, extent, [EAVES, EAVES + 0.2], TIMBER);
        let (foot, top) = (SUNK, EAVES + 0.1);
        let back = [[-half, foot, CHAMBER], [half, top, CHAMBER + 0.3]];
        solids.run(&place, back[0], back[1], [false; 2], PLASTER);
        let beside = [[-half - 0.1, foot, 0.1], [-half + 0.1, top, CHAMBER + 0.1]];
        solids.block(&place, beside[0], beside[1], PLASTER);
    }
}

/// A wall with a door downstairs and a window upstairs.
fn outer_wall(solids: &mut Solids, place: &Place) {
    let door = Arch { width: BAY, spring: 2.1, top: UPPER, radius: 0.8, thickness: 0.4 };
    opening(solids, place, door, 0.0);
    for side in [-1.0, 1.0] {
        let leaf = place.moved(side * door.radius / 2.0, 0.0, 0.05);
        solids.block(&leaf, [-0.39, 0.01, -0.04], [0.39, door.spring, 0.04], TIMBER);
        for row in 0..3 {
            let y = 0.2 + 0.62 * row as f32;
            solids.block(&leaf, [-0.28, y, -0.07], [0.28, y + 0.5, 0.07], TIMBER);
        }
    }
    pane(solids, place, door, door.spring);

    let upstairs = place.moved(0.0, UPPER, 0.0);
    let window = Arch { spring: 2.2, top: EAVES - UPPER, radius: 0.7, ..door };
    opening(solids, &upstairs, window, 0.9);
    pane(solids, &upstairs, window, 0.9);
    for bar in 0..4 {
        let x = window.radius * (0.5 * bar as f32 - 0.75);
        let low = [x - 0.02, 0.9 + SUNK, -0.02];
        solids.block(&upstairs, low, [x + 0.02, window.spring, 0.02], BRONZE);
    }
}

/// A wall from the floor up around an opening, below which it is `sill` high.
fn opening(solids: &mut Solids, place: &Place, arch: Arch, sill: f32) {
    let Arch { spring, radius, .. } = arch;
    let (half, near, far) = (arch.width / 2.0, -arch.thickness / 2.0, arch.thickness / 2.0);
    solids.arch(place, arch, 24, PLASTER);
    let left = [[-half, SUNK, near], [-radius, spring, far]];
    solids.run(place, left[0], left[1], [false, true], PLASTER);
    let right = [[radius, SUNK, near], [half, spring, far]];
    solids.run(place, right[0], right[1], [true, false], PLASTER);
    if sill > 0.0 {
        let below = [[-radius, SUNK, near], [radius, sill, far]];
        solids.run(place, below[0], below[1], [false; 2], PLASTER);
    }
}

/// The glass of an opening from `foot` to its round head.
fn pane(solids: &mut Solids, place: &Place, arch: Arch, foot: f32) {
    let cells = [solids.cells(16, 4), solids.cells(2, 1)];
    solids.patch(cells, GLASS, |u, v| {
        let x = 2.0 * u - 1.0;
        let head = arch.spring + arch.radius * (1.0 - x * x).max(0.0).sqrt();
        place.at(arch.radius * x, foot + (head - foot) * v, 0.0)
    });
}

/// Balusters and their rail, upstairs.
fn balustrade(solids: &mut Solids, bay: &Bay) {
    let place = bay.place.moved(0.0, UPPER, 0.0);
    let half = BAY / 2.0;
    solids.run(&place, [-half, SUNK, -0.12], [half, 0.1, 0.12], [false; 2], LIMESTONE);
    let profile = [
        [0.07, 0.1],
        [0.05, 0.16],
        [0.09, 0.3],
        [0.05, 0.5],
        [0.04, 0.62],
        [0.07, 0.72],
        [0.05, 0.8],
    ];
    for i in 0..8 {
        let at = place.moved(BAY * ((i as f32 + 0.5) / 8.0 - 0.5), 0.0, 0.0);
        solids.turned(&at, &profile, [10, 1], 0, MARBLE);
    }
    solids.run(&place, [-half, 0.8, -0.14], [half, 0.95, 0.14], [false; 2], LIMESTONE);
}

/// The two arches of a bay upstairs, with their columns.
fn loggia(solids: &mut Solids, bay: &Bay) {
    let (foot, head) = (UPPER, UPPER_SPRING);
    for x in [-BAY / 2.0, 0.0] {
        let place = bay.place.moved(x, 0.0, 0.0);
        solids.block(&place, [-0.2, foot + SUNK, -0.2], [0.2, foot + 1.0, 0.2], LIMESTONE);
        let shaft = [[0.15, foot + 1.0], [0.12, head - 0.3]];
        solids.turned(&place, &shaft, [20, 4], 0, MARBLE);
        let capital = [[0.12, head - 0.3], [0.15, head - 0.25], [0.14, head - 0.2], [0.2, head]];
        solids.turned(&place, &capital, [20, 2], 0, MARBLE);
        let arch = Arch {
            width: BAY / 2.0,
            spring: head,
            top: EAVES,
            radius: BAY / 4.0 - 0.16,
            thickness: 0.36,
        };
        solids.arch(&bay.place.moved(x + BAY / 4.0, 0.0, 0.0), arch, 24, LIMESTONE);
    }
}

/// Ceiling boards on beams, and tiles over them.
fn roof(solids: &mut Solids, cell: &Cell) {
    let half = BAY / 2.0;
    let place = cell.place.moved(0.0, 0.0, half);
    let cells = [solids.cells(6, 1); 2];
    solids.patch(cells, TIMBER, |u, v| place.at(BAY * (u - 0.5), EAVES, BAY * (v - 0.5)));
    for beam in 0..3 {
        let x = BAY * (beam as f32 / 3.0 - 1.0 / 3.0);
        let low = [x - 0.07, EAVES - 0.22, -half];
        solids.block(&place, low, [x + 0.07, EAVES - 0.01, half], TIMBER);
    }
    let cells = [solids.cells(40, 2), solids.cells(8, 2)];
    solids.patch(cells, ROOF_TILE, |u, v| {
        // In a corner the slopes of both galleries meet along the diagonal.
        let across = if cell.corner { u.max(v) } else { v };
        let ridge = 1.0 - (2.0 * across - 1.0).abs();
        let wave = if cell.corner && u > v { v } else { u };
        let y = EAVES + 0.12 + 1.3 * ridge + 0.04 * (TAU * 10.0 * wave).sin();
        place.at(BAY * (u - 0.5), y, BAY * (v - 0.5))
    });
}

/// A pair of curtains, drawn to either side of an arch downstairs.
fn curtains(solids: &mut Solids, bay: &Bay, rgba: [u8; 4], random: &mut SplitMix64) {
    let rod = bay.place.moved(0.0, SPRING - 0.1, 0.0);
    let reach = BAY / 2.0 - 0.4;
    solids.block(&rod, [-reach, -0.02, -0.02], [reach, 0.02, 0.02], BRONZE);
    let cells = [solids.cells(36, 14), solids.cells(9, 2)];
    for side in [-1.0, 1.0] {
        let phase = random.between(0.0, TAU);
        let drawn = random.between(0.75, 1.15);
        solids.patch(cells, rgba, |u, v| {
            // Held together by a tie two thirds down.
            let tie = 1.0 - 0.6 * (-((v - 0.65) / 0.2).powi(2)).exp();
            let fold = (phase + TAU * 6.0 * u + 1.5 * v).sin();
            let x = reach - drawn * u * tie;
            rod.at(side * x, -(SPRING - 0.35) * v, 0.13 * fold * (0.4 + 0.6 * v))
        });
    }
}

/// A long cloth that hangs over the rail upstairs into the court.
fn banner(solids: &mut Solids, bay: &Bay, rgba: [u8; 4], random: &mut SplitMix64) {
    let rail = bay.place.moved(0.0, UPPER + 0.97, -0.45);
    let phase = random.between(0.0, TAU);
    let cells = [solids.cells(24, 4), solids.cells(24, 4)];
    solids.patch(cells, rgba, |u, v| {
        let point = 0.35 * (1.0 - (2.0 * u - 1.0).abs());
        let wave = 0.08 * v * (phase + 5.0 * v + TAU * 2.5 * u).sin();
        rail.at(1.5 * (u - 0.5), -(2.2 + point) * v, wave)
    });
}

/// A lantern on a rod under the vault.
fn lantern(solids: &mut Solids, place: &Place) {
    let rod = [[0.015, 3.2], [0.015, SPRING + 1.55]];
    solids.turned(place, &rod, [6, 1], 0, BRONZE);
    let frame = [[0.02, 3.2], [0.16, 3.05], [0.19, 3.0], [0.17, 2.6], [0.08, 2.5], [0.0, 2.42]];
    solids.turned(place, &frame, [24, 1], 0, BRONZE);
    let glass = [[0.0, 2.95], [0.1, 2.9], [0.11, 2.7], [0.0, 2.6]];
    solids.turned(place, &glass, [16, 1], 0, GLASS);
}

/// A pot of earth with leaves that lean outward.
fn potted_plant(solids: &mut Solids, place: &Place, random: &mut SplitMix64) {
    let pot = [
        [0.0, 0.02],
        [0.2, 0.02],
        [0.3, 0.3],
        [0.32, 0.55],
        [0.36, 0.58],
        [0.36, 0.64],
        [0.3, 0.62],
        [0.0, 0.58],
    ];
    solids.turned(place, &pot, [28, 1], 0, TERRACOTTA);
    let cells = [solids.cells(2, 1), solids.cells(6, 1)];
    for _ in 0..31 {
        let (sin, cos) = random.between(0.0, TAU).sin_cos();
        let (length, lean) = (random.between(0.5, 1.1), random.between(0.2, 1.1));
        let rgba = toned(LEAF, random.between(0.7, 1.2));
        solids.patch(cells, rgba, |u, v| {
            // Bends over from the upright, and is widest in its middle.
            let angle = FRAC_PI_2 - lean * (0.3 + v);
            let out = length * v * angle.cos() + 0.05;
            let side = 0.12 * (u - 0.5) * (PI * (0.1 + 0.9 * v)).sin();
            let y = 0.6 + length * v * angle.sin();
            place.at(out * cos - side * sin, y, out * sin + side * cos)
        });
    }
}

/// Three basins over one another, with water in each.
fn fountain(solids: &mut Solids, place: &Place) {
    let mut foot = 0.0;
    for (radius, height) in [(1.7, 0.55), (0.9, 0.75), (0.45, 0.55)] {
        let basin = [
            [0.12 * radius, foot],
            [0.15 * radius, foot + 0.4 * height],
            [0.7 * radius, foot + 0.55 * height],
            [0.95 * radius, foot + 0.8 * height],
            [radius, foot + height],
            [0.94 * radius, foot + height],
            [0.8 * radius, foot + 0.8 * height],
            [0.0, foot + 0.65 * height],
        ];
        solids.turned(place, &basin, [64, 3], 16, MARBLE);
        let water = [[0.9 * radius, foot + 0.93 * height], [0.0, foot + 0.93 * height]];
        solids.turned(place, &water, [64, 8], 0, WATER);
        foot += 0.7 * height;
    }
}
