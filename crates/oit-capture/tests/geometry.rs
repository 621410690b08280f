//! Scenes that only a method that sorts fragments draws right: rays against planes and spheres, in
//! double precision and without the rasteriser, say what each pixel is; the oracle agrees, and no
//! painter does, whatever order it paints whole objects or triangles in.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::{DVec2, DVec3, Vec3};
use oit_capture::rasterize;
use oit_fragments::{Fragment, Lfb, oracle};
use oit_scene::{Camera, Mesh, Projection, Scene, load};

const WIDTH_PX: u32 = 320;
const HEIGHT_PX: u32 = 180;

/// Wrong by more than this can be seen.
const STEP: f64 = 1.0 / 255.0;

fn scene(name: &str, parameters: &[(&str, f64)]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
    let value = |value: f64| {
        if value.fract() == 0.0 { (value as i64).into() } else { toml::Value::Float(value) }
    };
    let overrides = parameters.iter().map(|(key, v)| ((*key).to_owned(), value(*v)));
    load(&path, &overrides.collect::<BTreeMap<_, _>>()).unwrap()
}

/// A half line; its parameter is the depth along the line of sight.
struct Ray {
    origin: DVec3,
    direction: DVec3,
    near: f64,
}

/// Where a camera stands and what it turns to.
struct Eye {
    at: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    projection: Projection,
}

impl Eye {
    fn new(camera: &Camera) -> Self {
        let [at, target, up] =
            [camera.eye, camera.target, camera.up].map(|p| Vec3::from(p).as_dvec3());
        let forward = (target - at).normalize();
        let right = forward.cross(up).normalize();
        Self { at, right, up: right.cross(forward), forward, projection: camera.projection }
    }

    /// Through the centre of a pixel, counted from the top left.
    fn ray(&self, x: u32, y: u32) -> Ray {
        let across = (f64::from(x) + 0.5) / f64::from(WIDTH_PX) * 2.0 - 1.0;
        let upward = 1.0 - (f64::from(y) + 0.5) / f64::from(HEIGHT_PX) * 2.0;
        let across = across * f64::from(WIDTH_PX) / f64::from(HEIGHT_PX);
        let offset = |half: f64| (self.right * across + self.up * upward) * half;
        match self.projection {
            Projection::Perspective { fov_y_degrees, near, .. } => {
                let half = (f64::from(fov_y_degrees).to_radians() / 2.0).tan();
                let direction = self.forward + offset(half);
                Ray { origin: self.at, direction, near: near.into() }
            }
            Projection::Orthographic { height, near, .. } => {
                let origin = self.at + offset(f64::from(height) / 2.0);
                Ray { origin, direction: self.forward, near: near.into() }
            }
        }
    }
}

enum Surface {
    /// A rectangle: its middle, and from there to the middles of two sides.
    Rectangle(DVec3, DVec3, DVec3),
    /// About the origin; the mesh lies inside it by this share of the radius at most.
    Sphere { radius: f64, sag: f64 },
}

/// Too near an edge to say.
struct Unsure;

impl Surface {
    fn hits(&self, ray: &Ray) -> Result<Vec<f64>, Unsure> {
        match *self {
            Self::Rectangle(middle, a, b) => {
                let normal = a.cross(b);
                let t = normal.dot(middle - ray.origin) / normal.dot(ray.direction);
                let point = ray.origin + ray.direction * t - middle;
                let out = [a, b].map(|side| point.dot(side).abs() / side.length_squared());
                let farthest = out[0].max(out[1]);
                if (farthest - 1.0).abs() < 0.01 {
                    return Err(Unsure);
                }
                Ok(if farthest < 1.0 && t > ray.near { vec![t] } else { Vec::new() })
            }
            Self::Sphere { radius, sag } => {
                // |origin + t direction| = radius
                let a = ray.direction.length_squared();
                let half_b = ray.origin.dot(ray.direction);
                let nearest = (ray.origin - ray.direction * (half_b / a)).length();
                if (nearest / radius - 1.0).abs() < 1.5 * sag {
                    return Err(Unsure);
                }
                let discriminant =
                    half_b * half_b - a * (ray.origin.length_squared() - radius * radius);
                if discriminant < 0.0 {
                    return Ok(Vec::new());
                }
                let root = discriminant.sqrt();
                let both = [(-half_b - root) / a, (-half_b + root) / a];
                Ok(both.into_iter().filter(|t| *t > ray.near).collect())
            }
        }
    }
}

/// Premultiplied colour of layers over nothing, the farthest first.
fn blend(back_to_front: impl Iterator<Item = [u8; 4]>) -> [f64; 4] {
    back_to_front.fold([0.0; 4], |behind, rgba| {
        let [r, g, b, a] = rgba.map(|channel| f64::from(channel) / 255.0);
        let own = [r * a, g * a, b * a, a];
        std::array::from_fn(|i| own[i] + (1.0 - a) * behind[i])
    })
}

fn error(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The colours of a mesh's objects, in the order in which they are written; no two are alike.
fn objects(mesh: &Mesh) -> Vec<[u8; 4]> {
    let mut colours: Vec<_> = mesh.vertices.iter().map(|vertex| vertex.rgba).collect();
    colours.dedup();
    let mut unlike = colours.clone();
    unlike.sort_unstable();
    unlike.dedup();
    assert_eq!(unlike.len(), colours.len(), "each object has a colour of its own");
    colours
}

fn permutations(n: usize) -> Vec<Vec<usize>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let with_last = |shorter: Vec<usize>| {
        (0..n).map(move |at| {
            let mut longer = shorter.clone();
            longer.insert(at, n - 1);
            longer
        })
    };
    permutations(n - 1).into_iter().flat_map(with_last).collect()
}

fn draw(scene: &Scene, mesh: &Mesh, camera: &Camera) -> Lfb {
    rasterize(mesh, &scene.shading, camera, WIDTH_PX, HEIGHT_PX)
}

/// The oracle's picture is that of the rays, on all pixels but those on edges.
fn assert_oracle_is_right(scene: &Scene, view: &str, surfaces: &[Surface]) {
    let camera = &scene.view(view).unwrap().camera;
    let colours = objects(&scene.mesh);
    assert_eq!(colours.len(), surfaces.len());
    let lfb = draw(scene, &scene.mesh, camera);
    let picture = oracle::composite(&lfb);
    let eye = Eye::new(camera);
    let (mut unsure, mut covered) = (0, 0);
    for (pixel, found) in picture.iter().enumerate() {
        let (x, y) = (pixel as u32 % WIDTH_PX, pixel as u32 / WIDTH_PX);
        let ray = eye.ray(x, y);
        let hits = surfaces
            .iter()
            .zip(&colours)
            .map(|(surface, &rgba)| Ok(surface.hits(&ray)?.into_iter().map(move |t| (t, rgba))));
        let Ok(hits) = hits.collect::<Result<Vec<_>, Unsure>>() else {
            unsure += 1;
            continue;
        };
        let mut layers: Vec<_> = hits.into_iter().flatten().collect();
        layers.sort_by(|a, b| b.0.total_cmp(&a.0));
        if layers.windows(2).any(|pair| pair[0].0 - pair[1].0 < 1e-4) {
            unsure += 1;
            continue;
        }
        covered += usize::from(!layers.is_empty());
        let expected = blend(layers.iter().map(|(_, rgba)| *rgba));
        assert_eq!(lfb.pixel(pixel).len(), layers.len(), "{} {view} {x} {y}", scene.name);
        let wrong = error(expected, *found);
        assert!(wrong < 1e-9, "{} {view} {x} {y}: {expected:?}, not {found:?}", scene.name);
    }
    assert!(covered > 3000, "{} {view}: {covered} pixels are covered", scene.name);
    assert!(unsure * 20 < picture.len(), "{} {view}: {unsure} pixels are unsure", scene.name);
}

/// Every order of the objects is wrong somewhere, even if each object's own fragments are painted in
/// the right order; and so is painting triangles from the farthest middle to the nearest.
fn assert_painters_are_wrong(scene: &Scene, view: &str) {
    let camera = &scene.view(view).unwrap().camera;
    let colours = objects(&scene.mesh);
    let lfb = draw(scene, &scene.mesh, camera);
    let picture = oracle::composite(&lfb);
    let mut pixels: Vec<Vec<Fragment>> = (0..lfb.pixels()).map(|p| lfb.pixel(p).to_vec()).collect();
    for pixel in &mut pixels {
        pixel.sort_by_key(|fragment| std::cmp::Reverse(fragment.key()));
    }
    let worst = |pixels: &[Vec<Fragment>]| {
        let painted = pixels.iter().map(|p| blend(p.iter().map(|f| f.rgba.to_le_bytes())));
        painted.zip(&picture).map(|(painted, right)| error(painted, *right)).fold(0.0, f64::max)
    };
    assert!(worst(&pixels) < 1e-9, "a painter of sorted fragments is right");

    for order in permutations(colours.len()) {
        let rank = |fragment: &Fragment| {
            let rgba = fragment.rgba.to_le_bytes();
            order[colours.iter().position(|colour| *colour == rgba).unwrap()]
        };
        let mut painted = pixels.clone();
        painted.iter_mut().for_each(|pixel| pixel.sort_by_key(rank));
        let wrong = worst(&painted);
        assert!(wrong > STEP, "{} {view}: {order:?} is right to {wrong}", scene.name);
    }

    let eye = Eye::new(camera);
    let middle = |triangle: &[u32; 3]| {
        let corners = triangle.map(|i| Vec3::from(scene.mesh.vertices[i as usize].position));
        corners.map(|corner| corner.as_dvec3()).iter().sum::<DVec3>() / 3.0 - eye.at
    };
    let keys: [(&str, &dyn Fn(DVec3) -> f64); 2] =
        [("depth", &|p| p.dot(eye.forward)), ("distance", &|p| p.length())];
    for (name, key) in keys {
        let mut mesh = Mesh::clone(&scene.mesh);
        let (triangles, _) = mesh.indices.as_chunks_mut::<3>();
        triangles.sort_by(|a, b| key(middle(b)).total_cmp(&key(middle(a))));
        let lfb = draw(scene, &mesh, camera);
        let painted: Vec<_> = (0..lfb.pixels()).map(|pixel| lfb.pixel(pixel).to_vec()).collect();
        let wrong = worst(&painted);
        assert!(wrong > STEP, "{} {view}: triangles by {name} are right to {wrong}", scene.name);
    }
}

/// The i-th bar of `cyclic`.
fn bar(i: f64, bars: f64) -> Surface {
    let outward = DVec2::from_angle(TAU * i / bars);
    let along = outward.perp() * (1.4 * 0.35 * (PI / bars).tan());
    let middle = (outward * 0.35).extend(0.0);
    // Tilted, so the sides to the ends are no longer than flat ones, but not at right angles to z.
    Surface::Rectangle(middle, along.extend(0.3), (outward * 0.1).extend(0.0))
}

fn cyclic(bars: u32) -> (Scene, Vec<Surface>) {
    let parameters = [("bars", f64::from(bars)), ("radius", 0.35), ("width", 0.2)];
    let parameters = [&parameters[..], &[("overhang", 1.4), ("rise", 0.3)]].concat();
    let surfaces = (0..bars).map(|i| bar(i.into(), bars.into())).collect();
    (scene("cyclic", &parameters), surfaces)
}

#[test]
fn each_bar_of_a_cycle_lies_over_the_next() {
    for bars in [3, 4, 5] {
        let (scene, _) = cyclic(bars);
        let colours = objects(&scene.mesh);
        let camera = &scene.view("front").unwrap().camera;
        let lfb = draw(&scene, &scene.mesh, camera);
        let Projection::Orthographic { height, .. } = camera.projection else {
            panic!("{camera:?}")
        };
        let px = f64::from(HEIGHT_PX) / f64::from(height);
        for i in 0..bars {
            // Where the middles of this bar and the next cross: a corner of the polygon.
            let angle = TAU * (f64::from(i) + 0.5) / f64::from(bars);
            let corner = DVec2::from_angle(angle) * (0.35 / (PI / f64::from(bars)).cos()) * px;
            let x = (f64::from(WIDTH_PX) / 2.0 + corner.x) as usize;
            let y = (f64::from(HEIGHT_PX) / 2.0 - corner.y) as usize;
            let mut fragments = lfb.pixel(y * WIDTH_PX as usize + x).to_vec();
            fragments.sort_by_key(|fragment| fragment.key());
            let order: Vec<_> = fragments.iter().map(|f| f.rgba.to_le_bytes()).collect();
            let next = colours[(i as usize + 1) % colours.len()];
            assert_eq!(order, [colours[i as usize], next], "{i} of {bars}");
        }
    }
}

#[test]
fn a_cycle_of_bars() {
    for bars in [3, 4] {
        let (scene, surfaces) = cyclic(bars);
        for view in ["front", "oblique"] {
            assert_oracle_is_right(&scene, view, &surfaces);
            assert_painters_are_wrong(&scene, view);
        }
    }
}

#[test]
fn squares_that_cut_through_one_another() {
    let scene = scene("intersecting", &[("count", 4.0), ("size", 1.6), ("spread", 120.0)]);
    let square = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Surface::Rectangle(DVec3::ZERO, 0.8 * DVec3::new(cos, 0.0, sin), 0.8 * DVec3::Y)
    };
    let surfaces = [60.0, 20.0, -20.0, -60.0].map(square);
    for view in ["front", "oblique"] {
        assert_oracle_is_right(&scene, view, &surfaces);
        assert_painters_are_wrong(&scene, view);
    }
}

#[test]
fn shells_from_outside_and_from_inside() {
    let parameters = [("count", 5.0), ("outer", 1.0), ("inner", 0.8), ("tessellation", 24.0)];
    let scene = scene("shells", &parameters);
    // The middle of a cell lies below the sphere by half a cell's angle in either direction.
    let sag = 1.0 - (PI / 48.0).cos().powi(2);
    let surfaces = [1.0, 0.95, 0.9, 0.85, 0.8].map(|radius| Surface::Sphere { radius, sag });
    for view in ["outside", "inside"] {
        assert_oracle_is_right(&scene, view, &surfaces);
        assert_painters_are_wrong(&scene, view);
    }
}
