//! What several generators are made of.

use std::f32::consts::PI;

use crate::mesh::{flat_normal, to_byte};
use crate::{Mesh, Vertex};

/// Appends an upright rectangle about `centre`, facing +z, cut into `columns` x `rows` cells of two
/// triangles each.
pub(super) fn push_rectangle(
    mesh: &mut Mesh,
    centre: [f32; 3],
    [width, height]: [f32; 2],
    [columns, rows]: [u64; 2],
    rgba: [u8; 4],
) {
    let first = mesh.vertices.len() as u32;
    for row in 0..=rows {
        for column in 0..=columns {
            let x = centre[0] + width * (column as f32 / columns as f32 - 0.5);
            let y = centre[1] + height * (row as f32 / rows as f32 - 0.5);
            let position = [x, y, centre[2]];
            mesh.vertices.push(Vertex { position, normal: [0.0, 0.0, 1.0], rgba });
        }
    }
    push_cells(mesh, first, columns as u32, rows as u32);
}

/// Appends the triangles of a lattice of (columns + 1) x (rows + 1) vertices, row by row.
pub(super) fn push_cells(mesh: &mut Mesh, first: u32, columns: u32, rows: u32) {
    let stride = columns + 1;
    for row in 0..rows {
        for column in 0..columns {
            let a = first + row * stride + column;
            let (b, c, d) = (a + 1, a + stride, a + stride + 1);
            mesh.indices.extend([a, b, d, a, d, c]);
        }
    }
}

/// Appends two triangles over four corners of one plane, in the order they go round.
pub(super) fn push_quad(mesh: &mut Mesh, corners: [[f32; 3]; 4], rgba: [u8; 4]) {
    let first = mesh.vertices.len() as u32;
    let normal = flat_normal(corners[0], corners[1], corners[2]);
    mesh.vertices.extend(corners.map(|position| Vertex { position, normal, rgba }));
    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
}

/// Appends a sphere: rings about the z axis, written from the pole towards +z to the other, of twice
/// as many sectors. Two triangles per cell; one of the two is empty in the first and last ring.
pub(super) fn push_sphere(
    mesh: &mut Mesh,
    centre: [f32; 3],
    radius: f32,
    rings: u32,
    rgba: [u8; 4],
) {
    let sectors = 2 * rings;
    let first = mesh.vertices.len() as u32;
    for ring in 0..=rings {
        let (sin, cos) = (PI * ring as f32 / rings as f32).sin_cos();
        for sector in 0..=sectors {
            // The seam's two sides are the same numbers, so that no pixel falls between them.
            let (y, x) = (2.0 * PI * (sector % sectors) as f32 / sectors as f32).sin_cos();
            let normal = [sin * x, sin * y, cos];
            let position = std::array::from_fn(|i| centre[i] + radius * normal[i]);
            mesh.vertices.push(Vertex { position, normal, rgba });
        }
    }
    push_cells(mesh, first, sectors, rings);
}

/// A colour for the i-th of many parts: hues a golden angle apart, so that neighbours differ.
pub(super) fn part_colour(i: u64, alpha: f32) -> [u8; 4] {
    let hue = (i as f32 * 0.618_034).fract() * 6.0;
    let channel = |offset: f32| {
        let distance = ((hue + offset) % 6.0 - 3.0).abs();
        to_byte(0.25 + 0.75 * (distance - 1.0).clamp(0.0, 1.0))
    };
    [channel(0.0), channel(4.0), channel(2.0), to_byte(alpha)]
}

#[cfg(test)]
mod tests {
    use super::part_colour;

    #[test]
    fn neighbouring_parts_differ() {
        assert_eq!(part_colour(0, 1.0), [255, 64, 64, 255]);
        for i in 0..200 {
            assert_ne!(part_colour(i, 0.5), part_colour(i + 1, 0.5));
        }
    }
}
