//! The uniform `frame`: one camera and how what it sees is shaded.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};
use oit_scene::{Camera, Shading};

/// One view of a scene, as the shaders and the CPU rasteriser read it. The layout of `Frame` in
/// `frame.wgsl`: 128 bytes.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug, Pod, Zeroable)]
pub struct Frame {
    /// World to clip space; depth runs from 0 to w, y upwards.
    pub view_projection: Mat4,
    /// Towards the light, of length 1.
    pub light: Vec3,
    /// Light that reaches every surface, 0 to 1.
    pub ambient: f32,
    /// Direction of the stripes over their period: a surface is striped where the fraction of its
    /// product with the position in the world is below one half.
    pub stripes: Vec3,
    /// 1 with stripes, else 0.
    pub striped: u32,
    /// Colour of the stripes.
    pub stripe_rgba: Vec4,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Fills the struct up to a multiple of 16 bytes.
    unused: [u32; 2],
}

impl Frame {
    /// What the camera sees in a picture of this size.
    #[must_use]
    pub fn new(shading: &Shading, camera: &Camera, width_px: u32, height_px: u32) -> Self {
        let aspect = width_px as f32 / height_px.max(1) as f32;
        let mut frame = Self {
            view_projection: camera.view_projection(aspect),
            light: Vec3::from(shading.light).normalize_or_zero(),
            ambient: shading.ambient,
            width_px,
            height_px,
            ..Self::zeroed()
        };
        if let Some(stripes) = &shading.stripes {
            frame.stripes = Vec3::from(stripes.direction) / stripes.period;
            frame.striped = 1;
            frame.stripe_rgba = Vec4::from(stripes.rgba.map(|channel| f32::from(channel) / 255.0));
        }
        frame
    }

    /// Clip coordinates of a point, added up in the order of `project` in `frame.wgsl`.
    pub(crate) fn project(&self, position: Vec3) -> Vec4 {
        let m = &self.view_projection;
        ((m.x_axis * position.x + m.y_axis * position.y) + m.z_axis * position.z) + m.w_axis
    }

    /// The colour of a fragment as `pack4x8unorm` packs it: `shade` in `scene.wgsl`.
    pub(crate) fn shade(&self, world: Vec3, normal: Vec3, rgba: Vec4) -> u32 {
        self.lit(world.dot(self.stripes), normal, self.light, rgba)
    }

    /// The same with the product of direction of the stripes and position, and with a light for this
    /// normal's space.
    pub(crate) fn lit(&self, along: f32, normal: Vec3, light: Vec3, rgba: Vec4) -> u32 {
        let rgba = if self.striped != 0 {
            if along - along.floor() < 0.5 { self.stripe_rgba } else { rgba }
        } else {
            rgba
        };
        let cosine = normal.dot(light).abs() / normal.length().max(1e-20);
        let light = self.ambient + (1.0 - self.ambient) * cosine;
        let lit = (rgba.truncate() * light).extend(rgba.w);
        let bytes = lit.to_array().map(|channel| (channel * 255.0 + 0.5) as u8);
        u32::from_le_bytes(bytes)
    }
}
