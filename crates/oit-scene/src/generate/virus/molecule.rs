//! Shapes of molecules: clouds of spheres in nanometres.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::place::unit;
use crate::SplitMix64;
use crate::detail::Cloud;

/// What a protein of a kilodalton fills, nm^3: 0.81 Da/Å^3, a density of 1.35 g/cm^3.
const VOLUME_OF_KDA: f32 = 1.235;

/// Of a protein's spheres, as a share of the distance between neighbours. The volumes of all add up to
/// 1.2 times that of the protein, as van der Waals spheres of its atoms do, since they overlap.
const RADIUS: f32 = 0.66;

/// How far a sphere is from its place in a cubic lattice along each axis at most, as a share of the
/// lattice's step.
const JITTER: f32 = 0.3;

/// A ball that is part of a molecule's outline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub(super) center: Vec3,
    pub(super) radius: f32,
}

pub(super) fn ball(x: f32, y: f32, z: f32, radius: f32) -> Ball {
    Ball { center: Vec3::new(x, y, z), radius }
}

/// How a plasma protein is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// So many domains grown together.
    Globule(u32),
    /// Three knots on a thin rod, as fibrinogen.
    Rod,
    /// Two arms and a stem, as an antibody.
    Fork,
}

impl Shape {
    /// A protein of that mass about its middle; random in its details.
    pub(super) fn balls(self, kda: f32, random: &mut SplitMix64) -> Vec<Ball> {
        let mut balls = match self {
            Self::Globule(domains) => {
                let mut balls = vec![ball(0.0, 0.0, 0.0, 1.0)];
                for _ in 1..domains {
                    let onto = balls[random.below(balls.len())];
                    let radius = random.between(0.6, 1.0);
                    let apart = 0.8 * onto.radius.max(radius);
                    balls.push(Ball { center: onto.center + apart * unit(random), radius });
                }
                balls
            }
            Self::Rod => {
                let knot = |x: f32, radius: f32| ball(x, 0.0, 0.0, radius);
                let rod = (-10..=10).map(|i| ball(i as f32 * 0.45, 0.0, 0.0, 0.4));
                [knot(-4.8, 1.15), knot(0.0, 0.9), knot(4.8, 1.15)].into_iter().chain(rod).collect()
            }
            Self::Fork => {
                let arm = |angle: f32| {
                    let (sin, cos) = angle.sin_cos();
                    [0.9f32, 2.3].map(|along| ball(along * sin, along * cos, 0.0, 0.85))
                };
                [arm(PI), arm(1.05), arm(-1.05)].concat()
            }
        };
        let middle = balls.iter().map(|ball| ball.center).sum::<Vec3>() / balls.len() as f32;
        let scale = (kda * VOLUME_OF_KDA / volume(&balls)).cbrt();
        for ball in &mut balls {
            ball.center = (ball.center - middle) * scale;
            ball.radius *= scale;
        }
        balls
    }
}

/// The box about balls.
fn bounds(balls: &[Ball]) -> [Vec3; 2] {
    let low = balls.iter().map(|ball| ball.center - ball.radius).reduce(Vec3::min);
    let high = balls.iter().map(|ball| ball.center + ball.radius).reduce(Vec3::max);
    [low.unwrap_or_default(), high.unwrap_or_default()]
}

/// Calls `visit` with the points of a cubic lattice that lie within balls.
fn lattice(balls: &[Ball], step: f32, mut visit: impl FnMut(Vec3)) {
    let [low, high] = bounds(balls);
    let [nx, ny, nz] = ((high - low) / step).ceil().to_array().map(|cells| cells as u32);
    for x in 0..nx {
        for y in 0..ny {
            for z in 0..nz {
                let at = low + step * (Vec3::new(x as f32, y as f32, z as f32) + 0.5);
                if balls.iter().any(|b| at.distance_squared(b.center) < b.radius * b.radius) {
                    visit(at);
                }
            }
        }
    }
}

/// What balls fill together, to a few percent.
fn volume(balls: &[Ball]) -> f32 {
    let [low, high] = bounds(balls);
    let step = ((high - low).element_product() / 8000.0).cbrt();
    let mut points = 0;
    lattice(balls, step, |_| points += 1);
    points as f32 * step.powi(3)
}

/// Fills balls with spheres, neighbours `grain` apart.
pub(super) fn fill(balls: &[Ball], grain: f32, rgb: [u8; 3], random: &mut SplitMix64) -> Cloud {
    let mut cloud = Cloud::default();
    lattice(balls, grain, |at| {
        let jitter = [(); 3].map(|()| random.between(-JITTER, JITTER) * grain);
        let at = at + Vec3::from(jitter);
        cloud.push(at.to_array(), RADIUS * grain, shaded(rgb, random));
    });
    if cloud.atoms.is_empty() {
        // Smaller than a grain.
        let [low, high] = bounds(balls);
        cloud.push(((low + high) / 2.0).to_array(), RADIUS * grain, shaded(rgb, random));
    }
    cloud
}

/// Opaque, and up to an eighth darker, so that neighbours differ.
fn shaded(rgb: [u8; 3], random: &mut SplitMix64) -> [u8; 4] {
    let light = random.between(0.875, 1.0);
    let [r, g, b] = rgb.map(|channel| (f32::from(channel) * light).round() as u8);
    [r, g, b, 255]
}

/// The same balls so many times about the z axis.
pub(super) fn around(count: u32, balls: &[Ball]) -> Vec<Ball> {
    let turn = |i: u32| glam::Quat::from_rotation_z(TAU * i as f32 / count as f32);
    let turned =
        |i: u32| balls.iter().map(move |b| Ball { center: turn(i) * b.center, radius: b.radius });
    (0..count).flat_map(turned).collect()
}

/// The envelope's trimer on the membrane's outside: a stem through the membrane and three heads. Its
/// origin lies in the membrane's middle, z points out.
pub(super) fn spike(open: bool) -> Vec<Ball> {
    let spread = if open { 3.2 } else { 2.4 };
    let lobe = [
        ball(0.7, 0.0, -1.5, 0.8),
        ball(0.8, 0.0, 0.5, 0.8),
        ball(0.9, 0.0, 2.5, 1.0),
        ball(1.4, 0.0, 4.5, 1.4),
        ball(spread, 0.0, 7.2, 2.2),
        ball(spread - 0.6, 1.2, 9.4, 2.0),
    ];
    around(3, &lobe)
}

/// The matrix protein's trimer: flat, z towards the membrane.
pub(super) fn matrix(twist: f32) -> Vec<Ball> {
    around(3, &[ball(2.0, 0.0, 0.3, 1.7), ball(2.9, twist, -1.3, 1.1), ball(1.2, twist, -2.4, 0.8)])
}

/// A ring of capsid proteins, z pointing out.
pub(super) fn capsomer(proteins: u32, twist: f32) -> Vec<Ball> {
    let ring = 0.54 * proteins as f32;
    around(proteins, &[ball(ring, 0.0, 0.9, 1.65), ball(ring + 1.0, 0.9 + twist, -1.7, 1.25)])
}

/// A protein of the host's in the membrane: a helix through it, and a mass outside.
pub(super) fn anchored(kda: f32, random: &mut SplitMix64) -> Vec<Ball> {
    let mut balls = Shape::Globule(4).balls(kda, random);
    let low = bounds(&balls)[0].z;
    for ball in &mut balls {
        ball.center.z += 2.8 - low;
    }
    balls.extend((-6..=7).map(|i| ball(0.0, 0.0, 0.45 * i as f32, 0.6)));
    balls
}

/// A piece of a lipid bilayer, z pointing out, its middle at 0: so many lipids in each leaflet.
pub(super) fn lipids(
    lipids: u32,
    heads: [u8; 3],
    tails: [u8; 3],
    random: &mut SplitMix64,
) -> Cloud {
    /// Side of the square that a lipid has, nm: 0.65 nm^2.
    const SIDE: f32 = 0.8;
    let mut cloud = Cloud::default();
    for leaflet in [1.0, -1.0] {
        for i in 0..lipids {
            // A sunflower's: even, and round.
            let distance = SIDE * ((i as f32 + 0.5) / PI).sqrt();
            let (sin, cos) = (i as f32 * super::place::GOLDEN + leaflet).sin_cos();
            let lift = random.between(-0.1, 0.1);
            let mut bead = |x: f32, z: f32, radius: f32, rgb| {
                let wag = [(); 2].map(|()| random.between(-0.12, 0.12));
                let at =
                    [distance * cos + x + wag[0], distance * sin + wag[1], leaflet * (z + lift)];
                cloud.push(at, radius, shaded(rgb, random));
            };
            bead(0.0, 2.1, 0.36, heads);
            bead(0.1, 1.7, 0.30, heads);
            for tail in [-0.2, 0.2] {
                for z in [1.25, 0.8, 0.3] {
                    bead(tail, z, 0.27, tails);
                }
            }
        }
    }
    cloud
}

/// A piece of a single strand of RNA along x, `length` nm long: three nucleotides of four spheres.
pub(super) fn strand(length: f32, rgb: [u8; 3], random: &mut SplitMix64) -> Cloud {
    let mut cloud = Cloud::default();
    let start = random.between(0.0, TAU);
    for i in 0..3 {
        let x = length * ((i as f32 + 0.5) / 3.0 - 0.5);
        let (sin, cos) = (start + 0.6 * i as f32).sin_cos();
        for (distance, along, radius) in
            [(0.9, -0.15, 0.27), (0.6, 0.1, 0.26), (0.25, 0.0, 0.28), (-0.2, 0.05, 0.28)]
        {
            let at = [x + along, distance * cos, distance * sin];
            cloud.push(at, radius, shaded(rgb, random));
        }
    }
    cloud
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_protein_has_its_volume_and_overlap() {
        let mut random = SplitMix64::new(1);
        for shape in [Shape::Globule(1), Shape::Globule(6), Shape::Rod, Shape::Fork] {
            let balls = shape.balls(100.0, &mut random);
            let filled = volume(&balls);
            assert!((filled / 123.5 - 1.0).abs() < 0.05, "{shape:?} {filled}");
            let cloud = fill(&balls, 0.4, [200; 3], &mut random);
            let spheres: f32 = cloud.atoms.iter().map(|a| 4.0 / 3.0 * PI * a.radius.powi(3)).sum();
            assert!((spheres / filled - 1.2).abs() < 0.1, "{shape:?} {}", spheres / filled);
        }
    }

    #[test]
    fn nothing_is_without_a_sphere() {
        let mut random = SplitMix64::new(1);
        assert_eq!(fill(&[ball(1.0, 2.0, 3.0, 0.1)], 5.0, [9; 3], &mut random).atoms.len(), 1);
    }
}
