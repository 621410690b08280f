//! What the tests share: the devices there are, and scenes small enough for a software one.

#![expect(dead_code, reason = "each test binary uses a part of it")]

use oit_lab::{FrameSize, ViewData};
use oit_scene::{Camera, Projection, Scene, shuffle_triangles};

/// The ids of the GPUs there are, software ones too. None is a visible skip, and a failure where
/// `OIT_REQUIRE_GPU=1` says that there must be one.
pub(crate) fn gpus() -> Vec<String> {
    let listed = oit_gpu::enumerate();
    let usable: Vec<String> =
        listed.into_iter().filter(|device| device.info.is_ok()).map(|device| device.id).collect();
    if usable.is_empty() {
        let required = std::env::var("OIT_REQUIRE_GPU").is_ok_and(|value| value == "1");
        assert!(!required, "OIT_REQUIRE_GPU=1, and no GPU can be used");
        eprintln!("SKIPPED: no GPU can be used here; `just setup` installs a software one");
    }
    usable
}

/// The same, and the CPU.
pub(crate) fn devices() -> Vec<String> {
    let mut devices = gpus();
    devices.push("cpu".into());
    devices
}

/// A folder for compiled pipelines that ends with the test.
pub(crate) fn cache() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// A small soup of intersecting triangles, its triangles in an order of this seed.
pub(crate) fn soup(seed: u64, size: FrameSize) -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let scene = oit_scene::load(&path.join("random_triangles.toml"), &Default::default());
    let mut scene: Scene = scene.expect("a scene of this repository");
    if seed > 0 {
        scene.mesh = shuffle_triangles(&scene.mesh, seed).into();
    }
    ViewData::new(&scene, "front", size).expect("one of its views")
}

/// `count` squares that fill the view, as deep as wanted.
pub(crate) fn stack(count: u32, size: FrameSize) -> ViewData {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let text = format!("count = {count}\norder = \"random\"\nsize = 1.2");
    let overrides = text.parse::<toml::Table>().expect("TOML").into_iter().collect();
    let scene = oit_scene::load(&path.join("stack.toml"), &overrides);
    let mut scene = scene.expect("a scene of this repository");
    let projection = Projection::Orthographic { height: 2.0, near: 0.0, far: 8.0 };
    let camera = Camera { projection, ..scene.views[0].camera };
    scene.views[0].camera = camera;
    let view = scene.views[0].name.clone();
    ViewData::new(&scene, &view, size).expect("its view")
}
