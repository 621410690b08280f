//! Small scenes of spheres and what the tests of devices share.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part")]

use std::io::Write;
use std::sync::Arc;

use oit_gpu::{Device, GpuError};
use oit_scene::{
    Atom, Camera, Level, Object, Projection, Shading, SphereKind, Spheres, SplitMix64,
};
use oit_spheres::{Comparison, Detail, Expected, SphereBytes, SphereRequest, Variation, expected};

/// A scene and how it is seen.
pub struct View {
    pub spheres: Arc<Spheres>,
    pub bytes: SphereBytes,
    pub camera: Camera,
    pub shading: Shading,
    pub size: (u32, u32),
}

/// Side light, so that normals show.
pub const LIT: Shading = Shading { light: [0.48, 0.6, 0.64], ambient: 0.2, stripes: None };

impl View {
    pub fn new(spheres: Spheres, camera: Camera, size: (u32, u32)) -> Self {
        let spheres = Arc::new(spheres);
        let bytes = SphereBytes::new(&spheres);
        Self { spheres, bytes, camera, shading: LIT, size }
    }

    pub fn request(&self) -> SphereRequest<'_> {
        SphereRequest {
            spheres: &self.bytes,
            shading: &self.shading,
            camera: &self.camera,
            width_px: self.size.0,
            height_px: self.size.1,
        }
    }

    pub fn expected(&self, detail: Detail) -> Expected {
        let (width, height) = self.size;
        expected(&self.spheres, detail, &self.shading, &self.camera, width, height)
    }

    /// A variation's picture after its second run, or why it cannot be drawn.
    pub fn draw(
        &self,
        device: &mut dyn Device,
        variation: &Variation,
    ) -> Result<Vec<[f32; 4]>, String> {
        let plan = variation.plan(&self.request())?;
        let id = match device.prepare(&plan) {
            Ok(id) => id,
            Err(GpuError::Unsupported(why)) => return Err(why),
            Err(error) => panic!("{variation}: {error}"),
        };
        for _ in 0..2 {
            device.poison(id).expect("poisoned");
            device.run(id).expect("ran");
        }
        // Once more with what the last run left.
        device.run(id).expect("ran");
        let picture = picture(&device.read(id, oit_spheres::PICTURE).expect("read"));
        device.reset();
        Ok(picture)
    }

    pub fn compare(
        &self,
        device: &mut dyn Device,
        variation: &Variation,
    ) -> Result<Comparison, String> {
        Ok(self.expected(variation.detail).compare(&self.draw(device, variation)?))
    }
}

/// Molecules in a ball about the origin: kinds of several levels, turned at random.
pub fn molecules(objects: usize, atoms: u32, seed: u64) -> Spheres {
    let mut random = SplitMix64::new(seed);
    let mut spheres = Spheres::default();
    let ball = |random: &mut SplitMix64, radius: f32| loop {
        let at = [0; 3].map(|_| random.between(-1.0, 1.0));
        if at.iter().map(|x| x * x).sum::<f32>() <= 1.0 {
            return at.map(|x| x * radius);
        }
    };
    for kind in 0..3 {
        let first_level = spheres.levels.len() as u32;
        for level in 0..3 {
            let count = (atoms >> (2 * level)).max(1) + kind;
            spheres.levels.push(Level {
                first_atom: spheres.atoms.len() as u32,
                atoms: count,
                from_distance: [0.0, 14.0, 17.0][level as usize],
            });
            for _ in 0..count {
                let radius = 0.12 * (1 << level) as f32 * random.between(0.8, 1.2);
                spheres.atoms.push(Atom { center: ball(&mut random, 1.0), radius });
                spheres.atom_rgba.push((random.next_u64() as u32 | 0xff40_4040).to_le_bytes());
            }
        }
        let (name, levels) = (format!("kind {kind}"), 3);
        spheres.kinds.push(SphereKind { name, first_level, levels, radius: 2.0 });
    }
    for i in 0..objects {
        let mut rotation = [0; 4].map(|_| random.between(-1.0, 1.0));
        let length = rotation.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
        rotation = rotation.map(|x| x / length);
        spheres.objects.push(Object {
            position: ball(&mut random, 5.0),
            rotation,
            kind: i as u32 % 3,
            rgba: (random.next_u64() as u32 | 0xff80_8080).to_le_bytes(),
        });
    }
    spheres
}

/// From aside, far enough that all is before the camera.
pub fn outside() -> Camera {
    Camera {
        eye: [3.0, 4.0, 15.0],
        target: [0.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Perspective { fov_y_degrees: 40.0, near: 0.5, far: 60.0 },
    }
}

/// Among the objects: spheres about the eye, beside it and behind.
pub fn inside() -> Camera {
    Camera {
        eye: [0.5, 0.2, 1.0],
        target: [-1.0, 0.5, -4.0],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Perspective { fov_y_degrees: 75.0, near: 0.3, far: 30.0 },
    }
}

/// A box whose near plane cuts through.
pub fn orthographic() -> Camera {
    Camera {
        eye: [2.0, 3.0, 6.0],
        target: [0.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Orthographic { height: 9.0, near: 3.0, far: 11.0 },
    }
}

/// Past the test harness, which keeps back what passing tests print.
pub fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr");
}

/// Without a device the tests say so and pass; with `OIT_REQUIRE_GPU=1` they fail.
pub fn on_every_device(test: &str, mut run: impl FnMut(&mut dyn Device)) {
    let cache = tempfile::tempdir().expect("a folder for pipelines");
    let mut ran = 0;
    for listed in oit_gpu::enumerate() {
        let open = |_| oit_gpu::open(&listed.id, cache.path()).map_err(|error| error.to_string());
        match listed.info.and_then(open) {
            Ok(mut device) => {
                run(device.as_mut());
                ran += 1;
            }
            Err(reason) => say(&format!("{test}: skipped on {}: {reason}", listed.id)),
        }
    }
    if ran == 0 {
        let required = std::env::var("OIT_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "{test}: OIT_REQUIRE_GPU is set and no device can be used");
        say(&format!("{test}: SKIPPED, no device can be used"));
    }
}

/// The pixels of a target of four floats.
pub fn picture(bytes: &[u8]) -> Vec<[f32; 4]> {
    let floats: Vec<f32> =
        bytes.chunks_exact(4).map(|word| f32::from_le_bytes(word.try_into().expect("4"))).collect();
    floats.chunks_exact(4).map(|pixel| pixel.try_into().expect("4")).collect()
}
