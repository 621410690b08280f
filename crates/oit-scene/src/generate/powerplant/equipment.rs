//! Boilers, pipe racks, tanks and machines.

use glam::Vec3;

use super::piping::{Pipe, flange, turned};
use super::{BAY, BOILER_HALF, Layout, STOREY, WORLD, materials::*};
use crate::SplitMix64;
use crate::generate::solids::{Place, Solids};

/// Between the tubes of a boiler's walls.
const WALL_PITCH: f32 = 0.16;
/// Panels of a superheater and the passes of a panel.
const PANELS: u32 = 16;
const PASSES: u32 = 12;

/// A furnace with walls of upright tubes, which draw together to a hopper below; panels of tubes
/// hang in its upper half and lie in its lower; a drum and headers on top.
pub(super) fn boiler(solids: &mut Solids, layout: &Layout, middle: Vec3) {
    let top = STOREY * layout.storeys as f32 - 2.0;
    let half = BOILER_HALF - 1.0;
    let tubes = (2.0 * half / WALL_PITCH) as u32;
    for (out, along) in [(Vec3::Z, Vec3::X), (Vec3::X, Vec3::Z)] {
        for side in [-1.0, 1.0] {
            for tube in 0..tubes {
                let across = WALL_PITCH * (tube as f32 + 0.5) - half;
                let at = |distance: f32, narrow: f32, y: f32| {
                    middle + out * side * distance + along * across * narrow + Vec3::Y * y
                };
                let path = [at(1.0, 0.7, 1.0), at(half, 1.0, 5.0), at(half, 1.0, top)];
                Pipe { path: &path, radius: 0.06, bend: 0.5, rgba: TUBE }.draw(solids);
            }
            let ends = [-half, half].map(|x| middle + out * side * half + along * x);
            for y in [top + 0.3, 5.0 + STOREY] {
                let lift = Vec3::Y * y + out * side * 0.5;
                let path = ends.map(|end| end + lift);
                Pipe { path: &path, radius: 0.3, bend: 0.0, rgba: HEADER }.draw(solids);
            }
        }
    }
    for panel in 0..PANELS {
        let x = (2.0 * half - 1.0) * ((panel as f32 + 0.5) / PANELS as f32 - 0.5);
        for (low, high) in [(0.55 * top, 0.95 * top), (0.3 * top, 0.5 * top)] {
            let mut path = Vec::new();
            for pass in 0..PASSES {
                let z = (half - 0.6) * (2.0 * pass as f32 / (PASSES - 1) as f32 - 1.0);
                let (near, far) = if pass % 2 == 0 { (low, high) } else { (high, low) };
                path.extend([near, far].map(|y| middle + Vec3::new(x, y, z)));
            }
            Pipe { path: &path, radius: 0.07, bend: 0.45, rgba: TUBE }.draw(solids);
        }
    }
    let drum = middle + Vec3::new(-half, top + 1.2, 0.0);
    let length = 2.0 * half;
    let profile = [[0.0, -0.5], [0.5, -0.4], [0.8, 0.0], [0.8, length], [0.5, length + 0.4]];
    turned(solids, [drum, Vec3::X], &profile, [96, 24], HEADER);
    turned(solids, [drum, Vec3::X], &[[0.5, length + 0.4], [0.0, length + 0.5]], [96, 4], HEADER);
}

/// Pipes that run side by side under a ceiling along the whole building, come up at one end and go
/// down at the other, and move aside on their way.
pub(super) fn rack(solids: &mut Solids, layout: &Layout, storey: u64, random: &mut SplitMix64) {
    let [half_x, half_z] = layout.half();
    let count = 8 + random.below(6);
    let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let radius = random.between(0.05, 0.13);
    let pitch = 2.6 * radius;
    let z = side * random.between(9.2, half_z - 0.6 - pitch * count as f32);
    let y = STOREY * storey as f32 + random.between(3.2, 4.2);
    let from = -half_x + random.between(0.5, 0.3 * half_x);
    let to = half_x - random.between(0.5, 0.3 * half_x);
    let (aside, turn) = (random.between(-1.5, 1.5), random.between(-0.6, 0.6) * half_x);
    let [down, up] = [0.3, 2.5].map(|least| random.between(least, least + 1.5));
    let rgba = PIPES[random.below(PIPES.len())];
    for pipe in 0..count {
        let shift = pitch * pipe as f32;
        let (z, x) = (z + side * shift, turn + side * shift * aside.signum());
        let path = [
            Vec3::new(from + shift, y - up, z),
            Vec3::new(from + shift, y, z),
            Vec3::new(x, y, z),
            Vec3::new(x, y, z + aside),
            Vec3::new(to - shift, y, z + aside),
            Vec3::new(to - shift, y - down, z + aside),
        ];
        Pipe { path: &path, radius, bend: 3.0 * radius, rgba }.draw(solids);
        let at = from + 0.4 * (x - from);
        flange(solids, Vec3::new(at, y, z), Vec3::X, 0.75 * radius, FLANGE);
    }
}

/// A thin pipe that winds through the building, crossing whatever is there.
pub(super) fn stray(solids: &mut Solids, layout: &Layout, random: &mut SplitMix64) {
    let [half_x, half_z] = layout.half();
    let height = STOREY * layout.storeys as f32;
    let mut at = Vec3::new(
        random.between(-half_x, half_x),
        random.between(0.5, height),
        random.between(-half_z, half_z),
    );
    let mut path = vec![at];
    let mut axis = random.below(3);
    for _ in 0..5 {
        let reach = [half_x, height / 2.0, half_z][axis];
        let middle = [0.0, height / 2.0, 0.0][axis];
        // To the other half, so that no leg is too short to bend.
        let way = if at[axis] < middle { 1.0 } else { -1.0 };
        at[axis] = middle + way * random.between(0.1, 0.95) * reach;
        path.push(at);
        axis = (axis + 1 + random.below(2)) % 3;
    }
    let radius = random.between(0.03, 0.09);
    let rgba = PIPES[random.below(PIPES.len())];
    Pipe { path: &path, radius, bend: 0.3, rgba }.draw(solids);
    for leg in path.windows(2).step_by(2) {
        let way = leg[1] - leg[0];
        flange(solids, leg[0].lerp(leg[1], 0.5), way.normalize(), radius, FLANGE);
    }
}

/// What stands on a cell of a floor: one of four kinds, or nothing.
pub(super) fn machine(solids: &mut Solids, place: &Place, random: &mut SplitMix64) {
    let kind = random.below(6);
    let size = random.between(0.7, 1.2);
    match kind {
        0 => cooler(solids, place, size),
        1 => tank(solids, place, size),
        2 => pump(solids, place, size),
        3 => cabinets(solids, place, size),
        _ => {}
    }
}

/// A block with fins on either side.
fn cooler(solids: &mut Solids, place: &Place, size: f32) {
    let [x, y, z] = [1.4, 1.6, 0.8].map(|extent| extent * size);
    solids.block(place, [-x, 0.05, -0.4 * z], [x, y, 0.4 * z], CASING);
    for fin in 0..16 {
        let at = x * ((fin as f32 + 0.5) / 8.0 - 1.0);
        for side in [-1.0, 1.0] {
            let [low, high] = [side * 0.45 * z, side * z];
            let low = [at - 0.015, 0.15, low.min(high)];
            let high = [at + 0.015, y - 0.1, low[2] + 0.55 * z];
            solids.block(place, low, high, FIN);
        }
    }
}

/// An upright tank with domed ends on legs.
fn tank(solids: &mut Solids, place: &Place, size: f32) {
    let (radius, height) = (1.1 * size, 3.0 * size);
    let profile = [
        [0.0, 0.4],
        [0.7 * radius, 0.5],
        [radius, 0.9],
        [radius, height],
        [0.7 * radius, height + 0.4],
        [0.0, height + 0.5],
    ];
    turned(solids, [place.origin, Vec3::Y], &profile, [96, 16], TANK);
    for (x, z) in [(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)] {
        let path = [place.at(x * radius, 0.02, z * radius), place.at(x * radius, 0.6, z * radius)];
        Pipe { path: &path, radius: 0.08, bend: 0.0, rgba: CASING }.draw(solids);
    }
}

/// A motor and a pump on a bed, with a pipe that leaves upward.
fn pump(solids: &mut Solids, place: &Place, size: f32) {
    let [x, z] = [1.6, 0.6].map(|extent| extent * size);
    solids.block(place, [-x, 0.03, -z], [x, 0.3, z], CASING);
    let radius = 0.55 * size;
    let start = place.at(-0.9 * x, 0.35 + radius, 0.0);
    let ribs: Vec<[f32; 2]> = (0..12)
        .map(|i| [radius * if i % 2 == 0 { 0.9 } else { 1.0 }, 1.1 * size * i as f32 / 11.0])
        .collect();
    turned(solids, [start, place.x], &ribs, [64, 2], TANK);
    let shaft = [start + place.x * 1.15 * size, start + place.x * 2.0 * size];
    Pipe { path: &shaft, radius: 0.1, bend: 0.0, rgba: HEADER }.draw(solids);
    let wheel = [[0.15, 0.0], [0.9 * radius, 0.05], [0.9 * radius, 0.4], [0.15, 0.45]];
    turned(solids, [shaft[1], place.x], &wheel, [64, 8], TANK);
    let out = shaft[1] + place.x * 0.2;
    let path = [out + Vec3::Y * radius, out + Vec3::Y * 2.2, out + Vec3::Y * 2.2 + place.z * 1.6];
    Pipe { path: &path, radius: 0.14, bend: 0.4, rgba: PIPES[0] }.draw(solids);
    flange(solids, out + Vec3::Y * (radius + 0.4), Vec3::Y, 0.14, FLANGE);
}

/// A row of cabinets.
fn cabinets(solids: &mut Solids, place: &Place, size: f32) {
    for i in 0..4 {
        let x = 0.9 * (i as f32 - 1.5);
        let low = [x - 0.42, 0.03, -0.35];
        solids.block(place, low, [x + 0.42, 2.0 * size, 0.35], CASING);
    }
}

/// A duct from a boiler's top over the roof to the chimney; `aside` of the middle, lest one duct lie
/// in another.
pub(super) fn duct(solids: &mut Solids, layout: &Layout, middle: Vec3, aside: f32) {
    let top = STOREY * layout.storeys as f32 + 2.0;
    let end = layout.chimney();
    let [x, z] = [middle.x + 2.0, end.z + aside];
    let low = [x, top, z - 1.3];
    solids.run(&WORLD, low, [end.x - 2.2, top + 1.6, z + 1.3], [true, true], DUCT);
    solids.block(&WORLD, [x, top - 2.2, z - 1.2], [x + 1.8, top - 0.02, z + 1.2], DUCT);
}

/// The chimney beside the building, tapered, with rings about it.
pub(super) fn chimney(solids: &mut Solids, layout: &Layout) {
    let foot = layout.chimney();
    let height = 1.6 * STOREY * layout.storeys as f32;
    for shell in [0.0, 0.25] {
        let profile = [[2.4 - shell, 0.0], [1.6 - shell, height]];
        turned(solids, [foot, Vec3::Y], &profile, [128, 160], CHIMNEY);
    }
    for ring in 1..8 {
        let y = height * ring as f32 / 8.0;
        let radius = 2.4 - 0.8 * ring as f32 / 8.0 + 0.1;
        let profile = [[radius, y], [radius + 0.9, y], [radius + 0.9, y + 1.0]];
        turned(solids, [foot, Vec3::Y], &profile, [96, 4], GRATING);
    }
}

/// A turbine and its generator on the ground floor, lengthwise.
pub(super) fn turbine(solids: &mut Solids, middle: Vec3) {
    let axis = [middle + Vec3::new(-BAY, 2.2, 0.0), Vec3::X];
    let mut profile = Vec::new();
    for i in 0..48 {
        let along = i as f32 / 47.0;
        let body = 0.7 + 1.0 * (1.0 - (2.0 * (along * 2.0).fract() - 1.0).powi(2));
        let rib = if i % 4 == 0 { 0.12 } else { 0.0 };
        profile.push([body + rib, 2.0 * BAY * along]);
    }
    turned(solids, axis, &profile, [96, 4], TANK);
    let path = [axis[0] - 0.4 * Vec3::X, axis[0] + (2.0 * BAY + 0.4) * Vec3::X];
    Pipe { path: &path, radius: 0.25, bend: 0.0, rgba: HEADER }.draw(solids);
    let place = Place { origin: middle, ..WORLD };
    solids.block(&place, [-BAY, 0.02, -1.9], [BAY, 0.5, 1.9], CASING);
}
