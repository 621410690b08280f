//! Columns, girders, floors, stairs and handrails.

use glam::Vec3;

use super::piping::Pipe;
use super::{BAY, Layout, ROWS, STOREY, WORLD, materials::*};
use crate::SplitMix64;
use crate::generate::solids::Solids;

/// Bars of a grating, each a span long.
const GRATING_BARS: u32 = 15;
/// Steps of a flight of stairs.
const STEPS: u32 = 20;

pub(super) fn build(solids: &mut Solids, layout: &Layout, random: &mut SplitMix64) {
    columns(solids, layout);
    girders(solids, layout);
    floors(solids, layout, random);
    stairs(solids, layout);
    handrails(solids, layout);
}

/// A rolled section from one end to the other, open at both.
fn section(solids: &mut Solids, ends: [Vec3; 2], up: Vec3, [width, height]: [f32; 2]) {
    let axis = (ends[1] - ends[0]).normalize();
    let side = axis.cross(up);
    // Once round an I, as shares of its half width and height.
    let outline = [
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.0, -0.85],
        [0.08, -0.85],
        [0.08, 0.85],
        [1.0, 0.85],
        [1.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.85],
        [-0.08, 0.85],
        [-0.08, -0.85],
        [-1.0, -0.85],
    ];
    let cells = [12 * solids.cells(2, 1), solids.cells(14, 1)];
    solids.patch(cells, GIRDER, |u, v| {
        let along = u * 12.0;
        let i = (along as usize).min(11);
        let at = |k: usize| {
            let (from, to): (f32, f32) = (outline[i][k], outline[(i + 1) % 12][k]);
            from + (to - from) * (along - i as f32)
        };
        ends[0].lerp(ends[1], v) + side * at(0) * width / 2.0 + up * at(1) * height / 2.0
    });
}

fn columns(solids: &mut Solids, layout: &Layout) {
    for i in 0..=layout.bays {
        for j in 0..=ROWS {
            let foot = layout.corner(i, j);
            if layout.in_boiler(foot) {
                continue;
            }
            for storey in 0..layout.storeys {
                let low = foot + Vec3::Y * STOREY * storey as f32;
                section(solids, [low, low + Vec3::Y * STOREY], Vec3::Z, [0.4, 0.4]);
            }
        }
    }
}

fn girders(solids: &mut Solids, layout: &Layout) {
    for storey in 1..=layout.storeys {
        let lift = Vec3::Y * (STOREY * storey as f32 - 0.35);
        for i in 0..=layout.bays {
            for j in 0..=ROWS {
                let from = layout.corner(i, j) + lift;
                let along = [(i < layout.bays, Vec3::X), (j < ROWS, Vec3::Z)];
                for (_, axis) in along.into_iter().filter(|(there, _)| *there) {
                    if !layout.in_boiler(from + axis * BAY / 2.0) {
                        let ends = [from + 0.2 * axis, from + (BAY - 0.2) * axis];
                        section(solids, ends, Vec3::Y, [0.3, 0.5]);
                    }
                }
            }
        }
    }
}

/// Plates and gratings, cell by cell; none over the boilers and the stairs.
fn floors(solids: &mut Solids, layout: &Layout, random: &mut SplitMix64) {
    for storey in 1..=layout.storeys {
        for (i, j) in layout.cells() {
            let plate = random.unit() < 0.3;
            if layout.in_boiler(layout.middle(i, j)) || layout.has_stairs(i, j) {
                continue;
            }
            let place = layout.place(i, j, storey);
            let half = BAY / 2.0 - 0.02;
            if plate {
                solids.slab(&place, [[-half; 2], [half; 2]], [-0.08, -0.02], PLATE);
                continue;
            }
            for bar in 0..GRATING_BARS {
                let z = BAY * ((bar as f32 + 0.5) / GRATING_BARS as f32 - 0.5);
                let cells = [4, solids.cells(12, 1)];
                solids.patch(cells, GRATING, |u, v| {
                    // Once round the bar: four corners.
                    let corner = (4.0 * u).round() as u32 % 4;
                    let y = if corner < 2 { -0.08 } else { -0.02 };
                    let across = if corner == 1 || corner == 2 { 0.03 } else { -0.03 };
                    place.at(half * (2.0 * v - 1.0), y, z + across)
                });
            }
        }
    }
}

/// A flight a storey, to and fro.
fn stairs(solids: &mut Solids, layout: &Layout) {
    for (i, j) in layout.cells().filter(|&(i, j)| layout.has_stairs(i, j)) {
        for storey in 0..layout.storeys {
            let place = layout.place(i, j, storey);
            let (way, z) = if storey % 2 == 0 { (1.0, -1.2) } else { (-1.0, 1.2) };
            let rise = STOREY / STEPS as f32;
            let run = (BAY - 1.2) / STEPS as f32;
            for step in 0..STEPS {
                let x = way * (run * (step as f32 + 0.5) - BAY / 2.0 + 0.6);
                let y = rise * (step + 1) as f32;
                let low = [x - run * 0.45, y - 0.05, z - 0.8];
                solids.block(&place, low, [x + run * 0.45, y, z + 0.8], PLATE);
            }
            for side in [-0.85, 0.85] {
                for height in [0.0, 1.0] {
                    let end = |way: f32, y: f32| place.at(way * (BAY / 2.0 - 0.6), y, z + side);
                    let path = [end(-way, height), end(way, STOREY + height)];
                    Pipe { path: &path, radius: 0.04, bend: 0.0, rgba: RAIL }.draw(solids);
                }
            }
        }
    }
}

/// Posts and two rails along the long sides of every storey.
fn handrails(solids: &mut Solids, layout: &Layout) {
    let [half_x, half_z] = layout.half();
    for storey in 1..=layout.storeys {
        let y = STOREY * storey as f32;
        for z in [-half_z - 0.3, half_z + 0.3] {
            for rail in [0.55, 1.1] {
                let path = [-half_x, half_x].map(|x| Vec3::new(x, y + rail, z));
                Pipe { path: &path, radius: 0.025, bend: 0.0, rgba: RAIL }.draw(solids);
            }
            for post in 0..=4 * layout.bays {
                let x = BAY / 4.0 * post as f32 - half_x;
                let path = [WORLD.at(x, y - 0.2, z), WORLD.at(x, y + 1.1, z)];
                Pipe { path: &path, radius: 0.025, bend: 0.0, rgba: RAIL }.draw(solids);
            }
        }
    }
}
