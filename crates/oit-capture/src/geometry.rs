//! What a capture draws, as bytes for a device, and how its buffers are read back.

use std::sync::Arc;

use oit_fragments::Fragment;
use oit_gpu::{Buffer, Draw, GpuError, VertexAttribute, VertexFormat, VertexLayout};
use oit_scene::{Camera, Mesh, Shading, Vertex};

use crate::draw::pool_slots;
use crate::{CaptureError, Frame};

/// A mesh as bytes for a device: made once, shared by all its views.
#[derive(Clone, Debug)]
pub struct MeshBytes {
    /// `oit_scene::Vertex`es.
    pub vertices: Arc<[u8]>,
    /// `u32` indices, three a triangle.
    pub indices: Arc<[u8]>,
    /// How many indices.
    pub index_count: u32,
}

/// One view of a scene, ready for a device.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// `oit_scene::Vertex`es.
    pub vertices: Arc<[u8]>,
    /// `u32` indices, three a triangle.
    pub indices: Arc<[u8]>,
    /// How many indices.
    pub index_count: u32,
    /// The uniform `frame`: camera and shading, the bytes of a [`Frame`].
    pub frame: Arc<[u8]>,
}

impl MeshBytes {
    /// Copies a mesh's bytes. Its indices must lie inside its vertices: a device does not check.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            vertices: bytemuck::cast_slice(&mesh.vertices).into(),
            indices: bytemuck::cast_slice(&mesh.indices).into(),
            index_count: mesh.indices.len() as u32,
        }
    }

    /// One view of the mesh; its bytes are shared, not copied.
    #[must_use]
    pub fn view(
        &self,
        shading: &Shading,
        camera: &Camera,
        width_px: u32,
        height_px: u32,
    ) -> Geometry {
        let frame = Frame::new(shading, camera, width_px, height_px);
        Geometry {
            vertices: self.vertices.clone(),
            indices: self.indices.clone(),
            index_count: self.index_count,
            frame: bytemuck::bytes_of(&frame).into(),
        }
    }
}

impl Geometry {
    /// One view of a mesh. For several views make [`MeshBytes`] once.
    #[must_use]
    pub fn new(
        mesh: &Mesh,
        shading: &Shading,
        camera: &Camera,
        width_px: u32,
        height_px: u32,
    ) -> Self {
        MeshBytes::new(mesh).view(shading, camera, width_px, height_px)
    }

    /// The buffers `frame`, `vertices` and `indices`.
    #[must_use]
    pub fn buffers(&self) -> Vec<Buffer> {
        vec![
            Buffer::data("frame", self.frame.clone()),
            Buffer::data("vertices", self.vertices.clone()),
            Buffer::data("indices", self.indices.clone()),
        ]
    }

    /// Draws every triangle, with all that a vertex carries: position, normal and colour at
    /// locations 0 to 2.
    #[must_use]
    pub fn draw(&self) -> Draw {
        self.draw_attributes(&[
            (VertexFormat::Float32x3, std::mem::offset_of!(Vertex, position)),
            (VertexFormat::Float32x3, std::mem::offset_of!(Vertex, normal)),
            (VertexFormat::Unorm8x4, std::mem::offset_of!(Vertex, rgba)),
        ])
    }

    /// Draws every triangle with positions alone, at location 0.
    #[must_use]
    pub fn draw_positions(&self) -> Draw {
        self.draw_attributes(&[(VertexFormat::Float32x3, std::mem::offset_of!(Vertex, position))])
    }

    fn draw_attributes(&self, attributes: &[(VertexFormat, usize)]) -> Draw {
        let attribute = |(location, &(format, offset)): (usize, &(VertexFormat, usize))| {
            VertexAttribute { location: location as u32, format, offset_bytes: offset as u32 }
        };
        Draw::Indexed {
            vertices: "vertices".into(),
            layout: VertexLayout {
                stride_bytes: size_of::<Vertex>() as u32,
                attributes: attributes.iter().enumerate().map(attribute).collect(),
            },
            indices: "indices".into(),
            count: self.index_count,
        }
    }
}

/// A buffer of these `u32`.
pub(crate) fn words_buffer(name: &str, words: &[u32]) -> Buffer {
    Buffer::data(name, bytemuck::cast_slice(words).into())
}

/// The pool, holding these fragments.
pub(crate) fn fragments_buffer(fragments: &[Fragment]) -> Buffer {
    // Bindings have no less than two slots (see `pool_slots`).
    let mut bytes = bytemuck::cast_slice(fragments).to_vec();
    bytes.resize(bytes.len().max(8 * pool_slots(0) as usize), 0);
    Buffer::data("fragments", bytes.into())
}

/// Reads a captured frame back, buffer by buffer.
pub struct LfbReader<'a> {
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Room in the pool, in slots.
    pub pool_slots: u64,
    /// The bytes of a buffer of this name.
    pub read: &'a mut dyn FnMut(&str) -> Result<Vec<u8>, GpuError>,
}

impl LfbReader<'_> {
    pub(crate) fn pixels(&self) -> u64 {
        u64::from(self.width_px) * u64::from(self.height_px)
    }

    /// The first `count` words of a buffer of `u32`.
    pub(crate) fn words(
        &mut self,
        buffer: &'static str,
        count: u64,
    ) -> Result<Vec<u32>, CaptureError> {
        self.elements(buffer, count)
    }

    /// The first `count` fragments of the pool.
    pub(crate) fn fragments(&mut self, count: u64) -> Result<Vec<Fragment>, CaptureError> {
        self.elements("fragments", count)
    }

    /// The first `count` elements of a buffer.
    pub(crate) fn elements<T: bytemuck::AnyBitPattern>(
        &mut self,
        buffer: &'static str,
        count: u64,
    ) -> Result<Vec<T>, CaptureError> {
        let bytes = (self.read)(buffer)?;
        let expected = count * size_of::<T>() as u64;
        if (bytes.len() as u64) < expected {
            return Err(CaptureError::Short { buffer, bytes: bytes.len(), expected });
        }
        let elements = bytes[..expected as usize].chunks_exact(size_of::<T>());
        Ok(elements.map(bytemuck::pod_read_unaligned).collect())
    }
}
