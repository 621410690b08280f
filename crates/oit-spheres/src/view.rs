//! The uniform `view`: one camera, and how what it sees is shaded.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};
use oit_scene::{Camera, Projection, Shading};

/// One view, as the shaders and the CPU twin read it: the layout of `View` in `view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct View {
    /// View space to clip space by columns, depth reversed: 1 at the near plane, 0 at the far plane.
    pub(crate) projection: [[f32; 4]; 4],
    /// World to view space, about the eye: a unit quaternion.
    pub(crate) turn: [f32; 4],
    /// World space.
    pub(crate) eye: [f32; 3],
    /// Depth of the near plane.
    pub(crate) near: f32,
    /// Towards the light, view space, of length 1.
    pub(crate) light: [f32; 3],
    /// As [`Shading::ambient`].
    pub(crate) ambient: f32,
    /// A pixel's place at depth 1 (perspective) or any depth (a box) is `pixel * scale + offset`.
    pub(crate) pixel_scale: [f32; 2],
    pub(crate) pixel_offset: [f32; 2],
    /// The sides of the frustum: a point is inside where `dot(xyz, point) + w >= 0`.
    pub(crate) sides: [[f32; 4]; 4],
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    pub(crate) objects: u32,
    /// Depth of the far plane.
    pub(crate) far: f32,
    /// As the frame's of meshes: direction of the stripes over their period, and whether there are.
    pub(crate) stripes: [f32; 3],
    pub(crate) striped: u32,
    pub(crate) stripe_rgba: [f32; 4],
    /// A little behind the near plane: no billboard lies before it, and so none is clipped.
    pub(crate) board_near: f32,
    unused: [u32; 3],
}

/// Whether rays start in one point.
pub(crate) fn is_perspective(camera: &Camera) -> bool {
    matches!(camera.projection, Projection::Perspective { .. })
}

impl View {
    pub(crate) fn new(
        shading: &Shading,
        camera: &Camera,
        width_px: u32,
        height_px: u32,
        objects: u32,
    ) -> Self {
        let [eye, target, up] =
            [camera.eye, camera.target, camera.up].map(|v| DVec3::from(Vec3::from(v)));
        let turn = DMat3::from_mat4(DMat4::look_at_rh(eye, target, up));
        let aspect = f64::from(width_px) / f64::from(height_px.max(1));
        let (half, near, far) = match camera.projection {
            Projection::Perspective { fov_y_degrees, near, far } => {
                ((f64::from(fov_y_degrees).to_radians() / 2.0).tan(), near, far)
            }
            Projection::Orthographic { height, near, far } => (f64::from(height) / 2.0, near, far),
        };
        let (x, y) = (half * aspect, half);
        let (n, f) = (f64::from(near), f64::from(far));
        let (mut projection, mut sides) = ([[0.0; 4]; 4], [[0.0; 4]; 4]);
        projection[0][0] = 1.0 / x;
        projection[1][1] = 1.0 / y;
        let board_near;
        if is_perspective(camera) {
            projection[2][2] = n / (f - n);
            projection[2][3] = -1.0;
            projection[3][2] = n * f / (f - n);
            let (a, b) = (x.hypot(1.0), y.hypot(1.0));
            sides[0] = [1.0 / a, 0.0, -x / a, 0.0];
            sides[1] = [-1.0 / a, 0.0, -x / a, 0.0];
            sides[2] = [0.0, 1.0 / b, -y / b, 0.0];
            sides[3] = [0.0, -1.0 / b, -y / b, 0.0];
            board_near = n * 1.0001;
        } else {
            projection[2][2] = 1.0 / (f - n);
            projection[3][2] = f / (f - n);
            projection[3][3] = 1.0;
            sides[0] = [1.0, 0.0, 0.0, x];
            sides[1] = [-1.0, 0.0, 0.0, x];
            sides[2] = [0.0, 1.0, 0.0, y];
            sides[3] = [0.0, -1.0, 0.0, y];
            board_near = n + 1e-5 * (f - n);
        }
        let (width, height) = (f64::from(width_px), f64::from(height_px));
        let light = turn * DVec3::from(Vec3::from(shading.light));
        let mut view = Self {
            projection: projection.map(|column| column.map(|value| value as f32)),
            turn: DQuat::from_mat3(&turn).normalize().as_quat().to_array(),
            eye: camera.eye,
            near,
            light: light.normalize_or_zero().as_vec3().to_array(),
            ambient: shading.ambient,
            pixel_scale: [(2.0 * x / width) as f32, (-2.0 * y / height) as f32],
            pixel_offset: [-x as f32, y as f32],
            sides: sides.map(|side| side.map(|value| value as f32)),
            width_px,
            height_px,
            objects,
            far,
            board_near: board_near as f32,
            ..Self::zeroed()
        };
        if let Some(stripes) = &shading.stripes {
            view.stripes = (Vec3::from(stripes.direction) / stripes.period).to_array();
            view.striped = 1;
            view.stripe_rgba = stripes.rgba.map(|channel| f32::from(channel) / 255.0);
        }
        view
    }
}
