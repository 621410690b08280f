//! Spheres as one camera sees them: what a device draws, and what its shader does in Rust.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, Vec4};
use oit_gpu::{Buffer, Draw};
use oit_scene::{Atom, Camera, Level, Object, Projection, Shading, Spheres};
use rayon::prelude::*;

use crate::Frame;
use crate::draw::FRAME;

const SPHERES: &str = include_str!("wgsl/spheres.wgsl");

/// The most spheres of a view: six vertices each are below what a draw has, and their buffers take
/// 1.25 GiB.
pub const MOST_SPHERES: u64 = 1 << 26;

/// A view has more spheres than are placed one by one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("the view has {spheres} spheres, of which {MOST_SPHERES} at most are drawn transparent")]
pub struct TooManySpheres {
    /// How many, each object in the level of detail for its distance.
    pub spheres: u64,
}

/// A sphere where the camera is the origin, x points to the right, y up and z along the line of sight:
/// 16 bytes, as the shaders read it.
#[derive(Clone, Copy, PartialEq, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlacedSphere {
    /// Its centre, world units.
    pub center: [f32; 3],
    /// Its radius, world units.
    pub radius: f32,
}

/// The uniform `sphere_view`: rays and planes of a camera, and light and stripes where it is the
/// origin. The layout of `SphereView` in `spheres.wgsl`: 64 bytes.
#[derive(Clone, Copy, PartialEq, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereView {
    /// A pixel's ray goes through `(px * scale + offset, 1)`: at distance 1 in a perspective, else
    /// everywhere.
    pub scale: [f32; 2],
    /// See [`Self::scale`].
    pub offset: [f32; 2],
    /// Distance of the near plane.
    pub near: f32,
    /// Distance of the far plane.
    pub far: f32,
    /// Depth at distance t is `(t * depth[0] + depth[1]) / t` in a perspective, else without the
    /// division.
    pub depth: [f32; 2],
    /// Towards the light, of length 1.
    pub light: [f32; 3],
    /// What a position's product with [`Self::stripes`] is at the camera, its whole part left out.
    pub stripe_offset: f32,
    /// Direction of the stripes over their period.
    pub stripes: [f32; 3],
    /// Fills the struct up to a multiple of 16 bytes.
    unused: f32,
}

/// One view of spheres, ready for a device: each object's level of detail is that for its distance from
/// the camera, and its atoms follow each other in the order of submission.
///
/// A fragment is where the ray through a pixel's centre first hits a sphere, if that is between the near
/// and the far plane: no sphere is seen from inside. A sphere that is not finite or has no radius is left
/// out.
///
/// Which pixels a sphere covers follows from sums and products of `f32` alone, which are rounded alike on
/// every device and on the CPU, unless a compiler makes one operation of a product and a sum. The
/// `vulkan` backend forbids that (`EXACT_ARITHMETIC`); `wgpu` has no way to, so that there two programs
/// may disagree on a sphere's rim where a driver compiles them differently. Depth also takes a root and a
/// division, on which devices may differ in the last bits.
#[derive(Clone, Debug)]
pub struct PlacedSpheres {
    /// Size and shading of the view.
    pub frame: Frame,
    /// Camera of the view.
    pub view: SphereView,
    /// Whether rays start at one point.
    pub perspective: bool,
    /// [`PlacedSphere`]s.
    spheres: Arc<[u8]>,
    /// Their colours: RGBA8, straight alpha.
    rgba: Arc<[u8]>,
}

/// Where a ray first hits a sphere.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Hit {
    /// Where, as a [`PlacedSphere`]'s centre is.
    pub(crate) at: Vec3,
    /// 0 at the near plane to 1 at the far plane.
    pub(crate) depth: f32,
}

impl SphereView {
    fn new(frame: &Frame, camera: &Camera) -> Self {
        let [right, up, forward] = axes(camera);
        let aspect = f64::from(frame.width_px) / f64::from(frame.height_px.max(1));
        // Half of the view's height where rays are looked at.
        let (half, near, far) = match camera.projection {
            Projection::Perspective { fov_y_degrees, near, far } => {
                ((f64::from(fov_y_degrees).to_radians() / 2.0).tan(), near, far)
            }
            Projection::Orthographic { height, near, far } => (f64::from(height) / 2.0, near, far),
        };
        let (wide, high) = (half * aspect, half);
        let pixels = [frame.width_px, frame.height_px].map(|size| f64::from(size.max(1)));
        let (n, f) = (f64::from(near), f64::from(far));
        let depth = match camera.projection {
            Projection::Perspective { .. } => [f / (f - n), -n * f / (f - n)],
            Projection::Orthographic { .. } => [1.0 / (f - n), -n / (f - n)],
        };
        let turned = |v: Vec3| {
            let v = v.as_dvec3();
            [right, up, forward].map(|axis| axis.dot(v) as f32)
        };
        let stripe_offset = frame.stripes.as_dvec3().dot(Vec3::from(camera.eye).as_dvec3());
        Self {
            scale: [(2.0 * wide / pixels[0]) as f32, (-2.0 * high / pixels[1]) as f32],
            offset: [-wide as f32, high as f32],
            near,
            far,
            depth: depth.map(|factor| factor as f32),
            light: turned(frame.light),
            stripe_offset: stripe_offset.rem_euclid(1.0) as f32,
            stripes: turned(frame.stripes),
            unused: 0.0,
        }
    }
}

/// The directions to the right, upwards and along the line of sight.
fn axes(camera: &Camera) -> [DVec3; 3] {
    let [eye, target, up] =
        [camera.eye, camera.target, camera.up].map(|v| Vec3::from(v).as_dvec3());
    let forward = (target - eye).normalize_or_zero();
    let right = forward.cross(up).normalize_or_zero();
    [right, right.cross(forward), forward]
}

impl PlacedSpheres {
    /// Places the spheres that a camera sees, or would see if they were in its picture. The indices in
    /// `spheres` must lie inside its lists.
    ///
    /// # Errors
    /// [`TooManySpheres`] where they are more than [`MOST_SPHERES`].
    pub fn new(
        spheres: &Spheres,
        shading: &Shading,
        camera: &Camera,
        width_px: u32,
        height_px: u32,
    ) -> Result<Self, TooManySpheres> {
        let eye = Vec3::from(camera.eye);
        let level = |object: &Object| {
            let distance = Vec3::from(object.position).distance(eye);
            spheres.level_at(&spheres.kinds[object.kind as usize], distance)
        };
        let objects = &spheres.objects;
        let count: u64 = objects.par_iter().map(|object| u64::from(level(object).atoms)).sum();
        if count > MOST_SPHERES {
            return Err(TooManySpheres { spheres: count });
        }
        let axes = axes(camera);
        let placed = |object: &Object, atom: &Atom| {
            let (center, radius) = spheres.placed(object, atom);
            let from_eye = center.as_dvec3() - eye.as_dvec3();
            PlacedSphere { center: axes.map(|axis| axis.dot(from_eye) as f32), radius }
        };
        let all = objects.par_iter().flat_map_iter(|object| {
            let Level { first_atom, atoms, .. } = *level(object);
            let own = first_atom as usize..first_atom as usize + atoms as usize;
            spheres.atoms[own.clone()].iter().zip(&spheres.atom_rgba[own]).filter_map(
                move |(atom, &rgba)| {
                    let sphere = placed(object, atom);
                    let finite = Vec3::from(sphere.center).is_finite() && sphere.radius.is_finite();
                    (finite && sphere.radius > 0.0).then(|| (sphere, Spheres::color(object, rgba)))
                },
            )
        });
        let (spheres, rgba): (Vec<PlacedSphere>, Vec<[u8; 4]>) = all.unzip();
        let frame = Frame::new(shading, camera, width_px, height_px);
        Ok(Self {
            frame,
            view: SphereView::new(&frame, camera),
            perspective: matches!(camera.projection, Projection::Perspective { .. }),
            spheres: bytemuck::cast_slice(&spheres).into(),
            rgba: rgba.as_flattened().into(),
        })
    }

    /// How many spheres are drawn.
    #[must_use]
    pub fn count(&self) -> u32 {
        (self.spheres.len() / size_of::<PlacedSphere>()) as u32
    }

    /// A sphere and its colour, in the order of submission.
    ///
    /// # Panics
    /// Where there are no so many.
    #[must_use]
    pub fn sphere(&self, index: u32) -> (PlacedSphere, [u8; 4]) {
        let (bytes, index) = (size_of::<PlacedSphere>(), index as usize);
        let sphere = bytemuck::pod_read_unaligned(&self.spheres[index * bytes..][..bytes]);
        (sphere, bytemuck::pod_read_unaligned(&self.rgba[4 * index..][..4]))
    }

    /// The pixels in which a sphere may have fragments: columns, then rows.
    pub(crate) fn pixels(&self, sphere: &PlacedSphere) -> [std::ops::Range<u32>; 2] {
        let [x, y, along] = sphere.center.map(f64::from);
        let radius = f64::from(sphere.radius);
        let (near, far) = (f64::from(self.view.near), f64::from(self.view.far));
        if along + radius < near || along - radius > far {
            return [0..0, 0..0];
        }
        // As in the shader, but with a box for all spheres, and a pixel more on each side.
        let first = if self.perspective { (along - radius).max(near) } else { 1.0 };
        let last = if self.perspective { (along + radius).max(near) } else { 1.0 };
        std::array::from_fn(|axis| {
            let (across, size) = [(x, self.frame.width_px), (y, self.frame.height_px)][axis];
            let (low, high) = (across - radius, across + radius);
            let low = low / if low < 0.0 { first } else { last };
            let high = high / if high < 0.0 { last } else { first };
            let [scale, offset] = [self.view.scale[axis], self.view.offset[axis]].map(f64::from);
            let ends = [low, high].map(|end| (end - offset) / scale);
            let clamped = |px: f64| px.clamp(0.0, f64::from(size)) as u32;
            let first = clamped(ends[0].min(ends[1]).floor() - 1.0);
            first..clamped(ends[0].max(ends[1]).ceil() + 1.0).max(first)
        })
    }

    /// Where a pixel's ray first hits a sphere between the planes: `covered`, `fragment_depth` and
    /// what `shade` starts with in `spheres.wgsl`, operation by operation.
    pub(crate) fn hit(&self, sphere: &PlacedSphere, x_px: u32, y_px: u32) -> Option<Hit> {
        let view = &self.view;
        let ray_x = (x_px as f32 + 0.5) * view.scale[0] + view.offset[0];
        let ray_y = (y_px as f32 + 0.5) * view.scale[1] + view.offset[1];
        let ([x, y, z], r) = (sphere.center, sphere.radius);
        let (square, along, discriminant) = if self.perspective {
            let cross = [y - z * ray_y, z * ray_x - x, x * ray_y - y * ray_x];
            let square = (ray_x * ray_x + ray_y * ray_y) + 1.0;
            let along = (x * ray_x + y * ray_y) + z;
            let distance = (cross[0] * cross[0] + cross[1] * cross[1]) + cross[2] * cross[2];
            (square, along, square * (r * r) - distance)
        } else {
            let (x, y) = (x - ray_x, y - ray_y);
            (1.0, z, r * r - (x * x + y * y))
        };
        let near = along - square * view.near;
        let far = along - square * view.far;
        let behind_near = near >= 0.0 && near * near >= discriminant;
        let before_far = far <= 0.0 || far * far <= discriminant;
        if !(discriminant >= 0.0 && behind_near && before_far) {
            return None;
        }
        let t = (along - discriminant.sqrt()) / square;
        let depth = t * view.depth[0] + view.depth[1];
        Some(if self.perspective {
            Hit { at: Vec3::new(ray_x * t, ray_y * t, t), depth: (depth / t).clamp(0.0, 1.0) }
        } else {
            Hit { at: Vec3::new(ray_x, ray_y, t), depth: depth.clamp(0.0, 1.0) }
        })
    }

    /// The colour of a fragment as `pack4x8unorm` packs it: `shade` in `spheres.wgsl`.
    pub(crate) fn shade(&self, sphere: &PlacedSphere, rgba: [u8; 4], at: Vec3) -> u32 {
        let along = at.dot(self.view.stripes.into()) + self.view.stripe_offset;
        let rgba = Vec4::from(rgba.map(|channel| f32::from(channel) / 255.0));
        self.frame.lit(along, at - Vec3::from(sphere.center), self.view.light.into(), rgba)
    }

    pub(crate) fn buffers(&self) -> [Buffer; 3] {
        [
            Buffer::data("sphere_view", bytemuck::bytes_of(&self.view).into()),
            Buffer::data("spheres", self.spheres.clone()),
            Buffer::data("sphere_rgba", self.rgba.clone()),
        ]
    }

    /// Draws a rectangle for each sphere. One long draw: instances of six vertices each would leave
    /// most of a subgroup empty on some devices.
    pub(crate) fn draw(&self) -> Draw {
        Draw::Vertices { count: 6 * self.count(), instances: 1 }
    }

    pub(crate) fn wgsl(&self) -> String {
        let constant = format!("const PERSPECTIVE = {};\n\n", self.perspective);
        [FRAME, &constant, SPHERES].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_is_the_shaders() {
        assert_eq!((size_of::<SphereView>(), size_of::<PlacedSphere>()), (64, 16));
        assert_eq!(std::mem::offset_of!(SphereView, light), 32);
        assert_eq!(std::mem::offset_of!(SphereView, stripes), 48);
    }

    /// Rays and depths are those of the camera's own matrix.
    #[test]
    fn a_point_of_a_ray_is_seen_in_its_pixel() {
        for projection in [
            Projection::Perspective { fov_y_degrees: 50.0, near: 0.5, far: 9.0 },
            Projection::Orthographic { height: 3.0, near: -1.0, far: 9.0 },
        ] {
            let camera = Camera {
                eye: [1.0, 2.0, 3.0],
                target: [0.5, 0.0, -1.0],
                up: [0.1, 1.0, 0.0],
                projection,
            };
            let shading = Shading { light: [0.0, 0.0, 1.0], ambient: 1.0, stripes: None };
            let placed = PlacedSpheres::new(&Spheres::default(), &shading, &camera, 40, 30);
            let placed = placed.expect("there are none");
            let [right, up, forward] = axes(&camera);
            for (x, y, t) in [(0u32, 0u32, 1.0), (39, 3, 5.0), (17, 29, 8.5)] {
                let view = &placed.view;
                let ray = [(x, 0), (y, 1)].map(|(px, axis)| {
                    f64::from((px as f32 + 0.5) * view.scale[axis] + view.offset[axis])
                });
                let reach = if placed.perspective { t } else { 1.0 };
                let world = Vec3::from(camera.eye).as_dvec3()
                    + right * ray[0] * reach
                    + up * ray[1] * reach
                    + forward * t;
                let clip = placed.frame.project(world.as_vec3());
                let seen = clip.truncate() / clip.w;
                let pixel = [(seen.x + 1.0) * 20.0, (1.0 - seen.y) * 15.0];
                assert!((pixel[0] - x as f32 - 0.5).abs() < 1e-3, "{projection:?}: {pixel:?}");
                assert!((pixel[1] - y as f32 - 0.5).abs() < 1e-3, "{projection:?}: {pixel:?}");
                let t = t as f32;
                let depth = t * view.depth[0] + view.depth[1];
                let depth = if placed.perspective { depth / t } else { depth };
                assert!((depth - seen.z).abs() < 1e-5, "{projection:?}: {depth} {}", seen.z);
            }
        }
    }
}
