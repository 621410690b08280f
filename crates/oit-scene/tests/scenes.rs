//! Scene files: all of ours load, and every mistake is named.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_scene::{Asset, Problem, SceneError, list, load};
use toml::Value;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn overrides(values: &[(&str, Value)]) -> BTreeMap<String, Value> {
    values.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
}

#[test]
fn every_scene_file_loads() {
    let entries = list(&scenes()).unwrap();
    let names: Vec<_> = entries.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "atrium",
            "cyclic",
            "dragon",
            "grid",
            "hairball",
            "helix",
            "intersecting",
            "planes",
            "planes2",
            "powerplant",
            "random_triangles",
            "shells",
            "smoke",
            "sphere_stack",
            "stack",
            "virus"
        ]
    );
    for entry in &entries {
        assert!(entry.about.len() > 100, "{}: say what it is and its source", entry.name);
        if let Asset::Missing(asset) = &entry.asset {
            // tests/dragon.rs shows the missing asset as an ignored test.
            let error = load(&entry.path, &BTreeMap::new()).unwrap_err();
            assert!(matches!(error, SceneError::MissingAsset { .. }), "{error}");
            assert!(asset.starts_with("assets"));
            continue;
        }
        let scene = load(&entry.path, &BTreeMap::new()).unwrap();
        assert_eq!((&scene.name, &scene.about), (&entry.name, &entry.about));
        let views: Vec<_> = scene.views.iter().map(|view| view.name.clone()).collect();
        assert_eq!(views, entry.views);
        assert_eq!(scene.mesh.triangle_count() > 0, !entry.spheres, "{}", entry.name);
        let spheres = scene.spheres.map_or(0, |spheres| spheres.total());
        assert_eq!(spheres > 0, entry.spheres, "{}", entry.name);
    }
    let hairball = entries.iter().find(|entry| entry.name == "hairball").unwrap();
    assert_eq!(hairball.views, ["inside-front", "inside-back"]);
}

#[test]
fn overrides_replace_parameters() {
    let path = scenes().join("grid.toml");
    let values = overrides(&[("layers", 3.into()), ("size", 0.5.into())]);
    let scene = load(&path, &values).unwrap();
    assert_eq!(scene.mesh.triangle_count(), 3 * 20_000);

    let error = load(&path, &overrides(&[("layer", 3.into())])).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "grid.toml: override: unknown parameter `layer`, the nearest valid: `layers`"
        ),
        "{error}"
    );
    let error = load(&path, &overrides(&[("layers", "3".into())])).unwrap_err().to_string();
    assert!(error.ends_with("parameter `layers` must be a whole number, found: string"), "{error}");
    let dragon = scenes().join("dragon.toml");
    let error = load(&dragon, &overrides(&[("layers", 3.into())])).unwrap_err().to_string();
    assert!(error.ends_with("unknown parameter `layers`, none is valid here"), "{error}");
}

#[test]
fn an_unknown_view_is_named() {
    let scene = load(&scenes().join("planes.toml"), &BTreeMap::new()).unwrap();
    assert_eq!(scene.view("back").unwrap().name, "back");
    let error = scene.view("fornt").unwrap_err();
    let SceneError::UnknownView { problem: Problem::Unknown { valid, .. }, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(valid, &["front", "back"]);
    let message = "scene `planes`: unknown view `fornt`, the nearest valid: `front`";
    assert_eq!(error.to_string(), message);
}

#[test]
fn a_frame_of_a_path_is_a_view() {
    let entries = list(&scenes()).unwrap();
    let atrium = entries.iter().find(|entry| entry.name == "atrium").unwrap();
    let [path] = &atrium.paths[..] else { panic!("{:?}", atrium.paths) };
    assert_eq!((path.name.as_str(), path.frames), ("flythrough", 300));
    let scene = load(&atrium.path, &overrides(&[("detail", 0.01.into())])).unwrap();
    let (_, path) = &scene.paths[0];
    assert!(path.is_closed() && path.about().len() > 100);
    let view = scene.view("flythrough@120").unwrap();
    assert_eq!((view.name.as_str(), view.camera), ("flythrough@120", path.camera(120)));
    // It stays inside the outer walls, above the floor and below the eaves.
    for frame in 0..300 {
        let [x, y, z] = path.camera(frame).eye;
        assert!(x.abs() < 17.8 && (0.5..9.0).contains(&y) && z.abs() < 8.8, "{frame}: {x} {y} {z}");
    }
    for (name, message) in [
        ("flythrough@300", "scene `atrium`: path `flythrough` has the frames 0 to 299, not 300"),
        ("flythrough@x", "unknown view `flythrough@x`, the nearest valid: `flythrough@0`"),
        ("flythrough@+1", "unknown view `flythrough@+1`"),
    ] {
        let error = scene.view(name).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_mistake_in_a_path_is_of_its_file() {
    let dir = tempfile::tempdir().unwrap();
    let scene = dir.path().join("scene.toml");
    let with = |name: &str| {
        std::fs::write(
            &scene,
            GOOD.replacen("\n\n[mesh]", &format!("\npaths.{name}\n\n[mesh]"), 1),
        )
        .unwrap();
        load(&scene, &BTreeMap::new()).unwrap_err().to_string()
    };
    std::fs::write(dir.path().join("p.path"), "about = \"x\"\nframs = 3\n").unwrap();
    let error = with("fly = \"p.path\"");
    assert!(
        error.contains("p.path:2: unknown key `frams`, the nearest valid: `frames`"),
        "{error}"
    );
    assert!(with("fly = \"q.path\"").contains("q.path: "));
    assert!(with("a = \"p.path\"").contains("scene.toml:2: path `a`: a view's name"));
}

const GOOD: &str = r#"about = "A test."

[mesh]
generator = "stack"
parameters = { count = 2 }

[shading]
light = [0.0, 3.0, 4.0]
ambient = 0.25
stripes = { direction = [0.0, 2.0, 0.0], period = 0.5, rgba = [1, 2, 3, 4] }

[[views]]
name = "a"
eye = [0.0, 0.0, 2.0]
target = [0.0, 0.0, 0.0]
projection.orthographic = { height = 2.0, near = 0.0, far = 4.0 }
"#;

#[test]
fn a_scene_file_says_it_all() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("good.toml");
    std::fs::write(&path, GOOD).unwrap();
    let scene = load(&path, &BTreeMap::new()).unwrap();
    assert_eq!(scene.shading.light, [0.0, 0.6, 0.8]);
    let stripes = scene.shading.stripes.unwrap();
    assert_eq!(
        (stripes.direction, stripes.period, stripes.rgba),
        ([0.0, 1.0, 0.0], 0.5, [1, 2, 3, 4])
    );
    assert_eq!(scene.views[0].camera.up, [0.0, 1.0, 0.0]);
    assert_eq!(scene.mesh.triangle_count(), 2 * 8 * 8 * 2);
}

#[test]
fn every_mistake_is_named_with_its_line() {
    // What to replace in GOOD, with what, and the message that must follow the file's name.
    let mistakes = [
        ("about =", "abuot =", ":1: unknown key `abuot`, the nearest valid: `about`"),
        (
            "generator =",
            "generater =",
            ":4: unknown key `generater`, the nearest valid: `generator`",
        ),
        ("\"stack\"", "\"stak\"", ":4: unknown generator `stak`, the nearest valid: `stack`"),
        (
            "\"stack\"",
            "\"teapot\"",
            ":4: unknown generator `teapot`, valid: `planes`, `grid`, `stack`, `hairball`, `random_triangles`, `atrium`, `smoke`, `cyclic`, `intersecting`, `shells`, `powerplant`",
        ),
        ("count = 2", "cuont = 2", ":5: unknown parameter `cuont`, the nearest valid: `count`"),
        ("count = 2", "count = 2.5", ":5: parameter `count` must be a whole number, found: float"),
        ("count = 2", "count = -2", ":5: parameter `count` must be from 0 to 4096, not -2"),
        ("count = 2", "shape = \"cube\"", ":5: unknown word `cube`, valid: `square`, `sphere`"),
        (
            "ambient = 0.25",
            "ambeint = 0.25",
            ":9: unknown key `ambeint`, the nearest valid: `ambient`",
        ),
        ("ambient = 0.25", "ambient = 2.5", ":7: `ambient` must be from 0 to 1"),
        ("[0.0, 3.0, 4.0]", "[0.0, 0.0, 0.0]", ":7: `light` must not be zero"),
        ("[0.0, 2.0, 0.0]", "[0, 0, 0]", ":7: `direction` must not be zero"),
        ("period = 0.5", "period = 0.0", ":7: `period` of stripes must be above 0"),
        ("[1, 2, 3, 4]", "[1, 2, 3, 400]", ":10: invalid value: integer `400`, expected u8"),
        (
            "orthographic",
            "ortographic",
            ":16: unknown key `ortographic`, the nearest valid: `orthographic`",
        ),
        ("height = 2.0", "hieght = 2.0", ":16: unknown key `hieght`, the nearest valid: `height`"),
        ("height = 2.0", "height = 0.0", "12: view `a`: `height` must be above 0"),
        ("eye = [0.0, 0.0, 2.0]", "eye = [0.0, 0.0]", ":14: invalid length 2"),
        ("\"A test.\"", "\" \"", ":1: `about` must say what the scene is"),
        ("\"A test.\"", "\"A test.", ":1: "),
        ("generator = \"stack\"", "", ":3: `mesh` needs either `generator` or `import`"),
        (
            "generator = \"stack\"",
            "generator = \"stack\"\nrgba = [1, 2, 3, 4]",
            "`rgba` goes with `import` only",
        ),
        (
            "generator = \"stack\"",
            "import = \"x.ply\"",
            ":5: `parameters` go with `generator` only",
        ),
        ("count = 2 }", "count = 2 }\nimport = \"x.ply\"", ":3: `mesh` needs either"),
    ];
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bad.toml");
    for (old, new, message) in mistakes {
        assert!(GOOD.contains(old), "{old}");
        std::fs::write(&path, GOOD.replacen(old, new, 1)).unwrap();
        let error = load(&path, &BTreeMap::new()).unwrap_err();
        assert!(matches!(error, SceneError::Fault(_)), "{error}");
        let error = error.to_string();
        assert!(error.starts_with(&*path.to_string_lossy()), "{error}");
        assert!(error.contains(message), "`{new}` gave: {error}");
        assert!(list(dir.path()).is_err(), "list accepts `{new}`");
    }
    let views = GOOD.find("[[views]]").unwrap();
    let second = format!("{GOOD}\n{}", &GOOD[views..]);
    std::fs::write(&path, second).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.contains(":18: a second view `a`"), "{error}");
    std::fs::write(&path, format!("views = []\n{}", &GOOD[..views])).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.contains(":1: `views` must hold at least one view"), "{error}");
}

#[test]
fn files_that_are_not_there() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scenes/x.toml");
    let error = load(&path, &BTreeMap::new()).unwrap_err();
    assert!(matches!(error, SceneError::Io { .. }), "{error}");
    assert!(matches!(list(&dir.path().join("none")), Err(SceneError::Io { .. })));

    std::fs::create_dir(dir.path().join("scenes")).unwrap();
    let import = |asset: &str| {
        GOOD.replace(
            "generator = \"stack\"\nparameters = { count = 2 }",
            &format!("import = {asset:?}"),
        )
    };
    std::fs::write(&path, import("assets/no-such/mesh.ply")).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    let hint = "the asset assets/no-such/mesh.ply is missing: run `just assets` to fetch it";
    assert!(error.ends_with(hint), "{error}");
    assert_eq!(
        list(path.parent().unwrap()).unwrap()[0].asset,
        Asset::Missing("assets/no-such/mesh.ply".into())
    );

    std::fs::write(&path, import("no-such-mesh.ply")).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.ends_with("the asset no-such-mesh.ply is missing"), "{error}");

    // Found in a folder above the scene file's, and refused with the mesh file's name.
    std::fs::write(dir.path().join("mesh.ply"), "plx\n").unwrap();
    std::fs::write(&path, import("mesh.ply")).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.ends_with("mesh.ply: line 1: not a PLY file"), "{error}");
    assert!(matches!(list(path.parent().unwrap()).unwrap()[0].asset, Asset::Present(_)));
}

#[test]
fn a_materials_colour_multiplies_the_meshs() {
    let dir = tempfile::tempdir().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 255 128 0\n1 0 0 255 128 0\n0 1 0 255 128 0\n3 0 1 2\n";
    std::fs::write(dir.path().join("mesh.ply"), ply).unwrap();
    let path = dir.path().join("x.toml");
    let import = "import = \"mesh.ply\"\nrgba = [128, 128, 255, 51]";
    std::fs::write(
        &path,
        GOOD.replace("generator = \"stack\"\nparameters = { count = 2 }", import),
    )
    .unwrap();
    let scene = load(&path, &BTreeMap::new()).unwrap();
    assert_eq!(scene.mesh.vertices[0].rgba, [128, 64, 0, 51]);
}
