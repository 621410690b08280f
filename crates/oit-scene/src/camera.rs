use glam::{Mat4, Vec3};
use serde::Deserialize;

/// Where a scene is seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position, world space.
    pub eye: [f32; 3],
    /// The point in the middle of the image.
    pub target: [f32; 3],
    /// Direction that points up in the image; not parallel to the line of sight.
    pub up: [f32; 3],
    /// How the view volume is shaped.
    pub projection: Projection,
}

/// The view volume. Distances are along the line of sight, in world units.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Projection {
    /// A frustum.
    Perspective {
        /// Vertical field of view, degrees.
        fov_y_degrees: f32,
        /// Distance of the near plane, above 0.
        near: f32,
        /// Distance of the far plane.
        far: f32,
    },
    /// A box.
    Orthographic {
        /// Height of the view, world units.
        height: f32,
        /// Distance of the near plane; negative lies behind the eye.
        near: f32,
        /// Distance of the far plane.
        far: f32,
    },
}

impl Camera {
    /// World space to clip space as wgpu and Vulkan (with a flipped viewport) have it: x to the
    /// right, y up, depth 0 at the near plane and 1 at the far plane. `aspect` is width by height.
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        let view = Mat4::look_at_rh(self.eye.into(), self.target.into(), self.up.into());
        let projection = match self.projection {
            Projection::Perspective { fov_y_degrees, near, far } => {
                Mat4::perspective_rh(fov_y_degrees.to_radians(), aspect, near, far)
            }
            Projection::Orthographic { height, near, far } => {
                let (x, y) = (height * aspect / 2.0, height / 2.0);
                Mat4::orthographic_rh(-x, x, -y, y, near, far)
            }
        };
        projection * view
    }

    /// Why this camera sees nothing, in one sentence, if it does not.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let [eye, target, up] = [self.eye, self.target, self.up].map(Vec3::from);
        let (near, far) = match self.projection {
            Projection::Perspective { fov_y_degrees, near, far } => {
                if !(fov_y_degrees > 0.0 && fov_y_degrees < 180.0) {
                    return Some("`fov_y_degrees` must be between 0 and 180");
                }
                if near.is_nan() || near <= 0.0 {
                    return Some("`near` of a perspective must be above 0");
                }
                (near, far)
            }
            Projection::Orthographic { height, near, far } => {
                if !(height > 0.0 && height.is_finite()) {
                    return Some("`height` must be above 0");
                }
                (near, far)
            }
        };
        if !(near < far && near.is_finite() && far.is_finite()) {
            return Some("`near` must be below `far`");
        }
        let forward = target - eye;
        if !(forward.is_finite() && up.is_finite() && forward.length() > 0.0) {
            return Some("`eye` and `target` must be two different points");
        }
        if forward.normalize().cross(up.normalize_or_zero()).length() < 1e-4 {
            return Some("`up` must not be parallel to the line from `eye` to `target`");
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera { eye: [0.0, 0.0, 2.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], projection }
    }

    #[test]
    fn clip_space_is_wgpus() {
        for projection in [
            Projection::Perspective { fov_y_degrees: 90.0, near: 1.0, far: 3.0 },
            Projection::Orthographic { height: 2.0, near: 1.0, far: 3.0 },
        ] {
            let matrix = camera(projection).view_projection(2.0);
            let near = matrix.project_point3(Vec3::new(2.0, 1.0, 1.0));
            assert!((near - Vec3::new(1.0, 1.0, 0.0)).length() < 1e-6, "{projection:?} {near}");
            let far = matrix.project_point3(Vec3::new(0.0, 0.0, -1.0));
            assert!((far - Vec3::new(0.0, 0.0, 1.0)).length() < 1e-6, "{projection:?} {far}");
        }
    }

    #[test]
    fn a_blind_camera_is_found() {
        let good = camera(Projection::Orthographic { height: 2.0, near: -1.0, far: 3.0 });
        assert_eq!(good.fault(), None);
        let blind = [
            Camera { target: good.eye, ..good },
            Camera { eye: [f32::NAN; 3], ..good },
            Camera { up: [0.0, 0.0, 1.0], ..good },
            Camera { up: [0.0; 3], ..good },
            camera(Projection::Orthographic { height: 0.0, near: 1.0, far: 3.0 }),
            camera(Projection::Orthographic { height: 2.0, near: 3.0, far: 1.0 }),
            camera(Projection::Perspective { fov_y_degrees: 60.0, near: 0.0, far: 1.0 }),
            camera(Projection::Perspective { fov_y_degrees: 60.0, near: f32::NAN, far: 1.0 }),
            camera(Projection::Perspective { fov_y_degrees: 180.0, near: 0.1, far: 1.0 }),
            camera(Projection::Perspective { fov_y_degrees: 60.0, near: 0.1, far: f32::INFINITY }),
        ];
        for camera in blind {
            assert!(camera.fault().is_some(), "{camera:?}");
        }
    }
}
