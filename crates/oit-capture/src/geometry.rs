//! What a capture draws, as bytes for a device, and how its buffers are read back.

use std::sync::Arc;

use oit_fragments::Fragment;
use oit_gpu::{Buffer, Draw, GpuError, VertexAttribute, VertexFormat, VertexLayout};
use oit_scene::{Camera, Mesh, Scene, Shading, Vertex};

use crate::draw::{FRAME, POSITIONS, SCENE, pool_slots};
use crate::{CaptureError, Frame, PlacedSpheres, TooManySpheres};

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
    /// What is drawn.
    pub drawn: Drawn,
    /// The uniform `frame`: camera and shading, the bytes of a [`Frame`].
    pub frame: Arc<[u8]>,
}

/// What a view of a scene draws.
#[derive(Clone, Debug)]
pub enum Drawn {
    /// Triangles.
    Mesh(MeshBytes),
    /// Spheres, each as a rectangle whose fragments a shader chooses.
    Spheres(PlacedSpheres),
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
        Geometry { drawn: Drawn::Mesh(self.clone()), frame: bytemuck::bytes_of(&frame).into() }
    }

    /// Draws every triangle with these attributes of its vertices, at locations from 0 on.
    fn draw(&self, attributes: &[(VertexFormat, usize)]) -> Draw {
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

    /// One view of a scene, of triangles or of spheres.
    ///
    /// # Errors
    /// [`TooManySpheres`].
    pub fn of_scene(
        scene: &Scene,
        camera: &Camera,
        width_px: u32,
        height_px: u32,
    ) -> Result<Self, TooManySpheres> {
        let shading = &scene.shading;
        let Some(spheres) = &scene.spheres else {
            return Ok(Self::new(&scene.mesh, shading, camera, width_px, height_px));
        };
        let placed = PlacedSpheres::new(spheres, shading, camera, width_px, height_px)?;
        Ok(Self::of_spheres(placed))
    }

    /// One view of spheres.
    #[must_use]
    pub fn of_spheres(spheres: PlacedSpheres) -> Self {
        let frame = bytemuck::bytes_of(&spheres.frame).into();
        Self { drawn: Drawn::Spheres(spheres), frame }
    }

    /// The buffer `frame` and those of what is drawn: `vertices` and `indices`, or `sphere_view`,
    /// `spheres` and `sphere_rgba`.
    #[must_use]
    pub fn buffers(&self) -> Vec<Buffer> {
        let mut buffers = vec![Buffer::data("frame", self.frame.clone())];
        match &self.drawn {
            Drawn::Mesh(mesh) => buffers.extend([
                Buffer::data("vertices", mesh.vertices.clone()),
                Buffer::data("indices", mesh.indices.clone()),
            ]),
            Drawn::Spheres(spheres) => buffers.extend(spheres.buffers()),
        }
        buffers
    }

    /// Draws everything, with all that [`crate::scene_wgsl`] reads: of triangles position, normal and
    /// colour at locations 0 to 2; of spheres no vertex buffer.
    #[must_use]
    pub fn draw(&self) -> Draw {
        match &self.drawn {
            Drawn::Mesh(mesh) => mesh.draw(&[
                (VertexFormat::Float32x3, std::mem::offset_of!(Vertex, position)),
                (VertexFormat::Float32x3, std::mem::offset_of!(Vertex, normal)),
                (VertexFormat::Unorm8x4, std::mem::offset_of!(Vertex, rgba)),
            ]),
            Drawn::Spheres(spheres) => spheres.draw(),
        }
    }

    /// Draws everything for a program that shades nothing: of triangles positions alone, at location 0.
    #[must_use]
    pub fn draw_positions(&self) -> Draw {
        match &self.drawn {
            Drawn::Mesh(mesh) => {
                mesh.draw(&[(VertexFormat::Float32x3, std::mem::offset_of!(Vertex, position))])
            }
            Drawn::Spheres(spheres) => spheres.draw(),
        }
    }

    /// How many triangles are drawn; of a sphere two.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        match &self.drawn {
            Drawn::Mesh(mesh) => u64::from(mesh.index_count) / 3,
            Drawn::Spheres(spheres) => 2 * u64::from(spheres.count()),
        }
    }

    /// WGSL of all before a fragment stage that shades; goes with [`Geometry::draw`].
    pub(crate) fn scene_wgsl(&self) -> String {
        match &self.drawn {
            Drawn::Mesh(_) => [FRAME, SCENE].concat(),
            Drawn::Spheres(spheres) => spheres.wgsl(),
        }
    }

    /// WGSL of all before a fragment stage that shades nothing; goes with
    /// [`Geometry::draw_positions`].
    pub(crate) fn positions_wgsl(&self) -> String {
        match &self.drawn {
            Drawn::Mesh(_) => [FRAME, POSITIONS].concat(),
            Drawn::Spheres(spheres) => spheres.wgsl(),
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

    fn elements<T: bytemuck::AnyBitPattern>(
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
