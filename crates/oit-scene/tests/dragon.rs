//! The real dragon, if `just assets` has fetched it; otherwise the test is listed as ignored.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial, run};
use oit_scene::{Asset, list, load};

fn main() -> ExitCode {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let present = list(&scenes).is_ok_and(|entries| {
        entries.iter().any(|e| e.name == "dragon" && matches!(e.asset, Asset::Present(_)))
    });
    let dragon = Trial::test("dragon_has_its_871414_triangles", move || {
        let scene = load(&scenes.join("dragon.toml"), &BTreeMap::new())?;
        let mesh = &scene.mesh;
        let expected = (871_414, 3 * 871_414);
        if (mesh.triangle_count(), mesh.vertices.len()) != expected {
            return Err(Failed::from(format!("{} triangles", mesh.triangle_count())));
        }
        let rgba = mesh.vertices[0].rgba;
        if rgba != [230, 230, 235, 90] {
            return Err(Failed::from(format!("the material's colour became {rgba:?}")));
        }
        // All of it is inside the view.
        let matrix = scene.views[0].camera.view_projection(16.0 / 9.0);
        for vertex in &mesh.vertices {
            let clip = matrix.project_point3(vertex.position.into());
            if clip.truncate().abs().max_element() > 1.0 || !(0.0..=1.0).contains(&clip.z) {
                return Err(Failed::from(format!("{vertex:?} is outside the view")));
            }
        }
        Ok(())
    });
    run(&Arguments::from_args(), vec![dragon.with_ignored_flag(!present)]).exit_code()
}
