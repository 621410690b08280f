use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::SplitMix64;

/// No generator or importer makes a mesh of more triangles than this (indices 384 MiB).
pub const MAX_TRIANGLES: u64 = 1 << 25;

/// One vertex: 28 bytes, without padding, as it lies in a vertex buffer.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// World space.
    pub position: [f32; 3],
    /// Unit length. Which of the two sides it names does not matter: shading is two-sided.
    pub normal: [f32; 3],
    /// Straight (not premultiplied) alpha, linear values, 255 is 1.
    pub rgba: [u8; 4],
}

/// Triangles in submission order: three indices each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Three per triangle, each below `vertices.len()`.
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Submits the last triangle first.
    pub(crate) fn reverse_triangles(&mut self) {
        let (triangles, _) = self.indices.as_chunks_mut::<3>();
        triangles.reverse();
    }
}

/// The same triangles in a random order that depends on the seed only. The order of the vertices,
/// and the order of the three within a triangle, stay.
pub fn shuffle_triangles(mesh: &Mesh, seed: u64) -> Mesh {
    let mut shuffled = mesh.clone();
    let mut random = SplitMix64::new(seed);
    let (triangles, _) = shuffled.indices.as_chunks_mut::<3>();
    for last in (1..triangles.len()).rev() {
        triangles.swap(last, random.below(last + 1));
    }
    shuffled
}

/// 0.0 to 1.0 as 0 to 255, rounded; beyond it saturates, and NaN is 0.
pub(crate) fn to_byte(value: f32) -> u8 {
    (value * 255.0).round() as u8
}

/// Unit normal of a triangle. In f64, so that no finite triangle overflows; +z for one without area.
pub(crate) fn flat_normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let [a, b, c] = [a, b, c].map(|p| DVec3::from(p.map(f64::from)));
    let normal = (b - a).cross(c - a);
    // Scaled first: the square of the length would overflow for the largest floats.
    let largest = normal.abs().max_element();
    if largest > 0.0 {
        (normal / largest).normalize().as_vec3().to_array()
    } else {
        Vec3::Z.to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_is_28_bytes() {
        assert_eq!(size_of::<Vertex>(), 28);
    }

    #[test]
    fn shuffling_permutes_the_triangles() {
        let mesh = Mesh { vertices: Vec::new(), indices: (0..300).collect() };
        let shuffled = shuffle_triangles(&mesh, 1);
        assert_eq!(shuffled, shuffle_triangles(&mesh, 1));
        assert_ne!(shuffled, shuffle_triangles(&mesh, 2));
        assert_ne!(shuffled, mesh);
        let mut triangles = shuffled.indices.as_chunks::<3>().0.to_vec();
        triangles.sort_unstable();
        assert_eq!(triangles.as_flattened(), mesh.indices);
    }

    #[test]
    fn flat_normals_survive_extremes() {
        let huge = f32::MAX;
        assert_eq!(flat_normal([0.0; 3], [huge, 0.0, 0.0], [0.0, huge, 0.0]), [0.0, 0.0, 1.0]);
        let tiny = f32::from_bits(1);
        assert_eq!(flat_normal([0.0; 3], [0.0, tiny, 0.0], [0.0, 0.0, tiny]), [1.0, 0.0, 0.0]);
        assert_eq!(flat_normal([1.0; 3], [1.0; 3], [1.0; 3]), [0.0, 0.0, 1.0]);
    }
}
