//! Every generator keeps its promises.

use std::collections::BTreeMap;
use std::path::Path;

use oit_scene::{GENERATORS, GenerateError, Generator, Kind, Mesh, Params, Scene, load};
use toml::Value;

fn generator(name: &str) -> &'static dyn Generator {
    *GENERATORS.iter().find(|generator| generator.name() == name).unwrap()
}

fn generate(name: &str, values: &[(&str, Value)]) -> Result<Mesh, GenerateError> {
    let generator = generator(name);
    let mut params = Params::new(generator.parameters());
    for (key, value) in values {
        params.set(key, value).unwrap();
    }
    generator.generate(&params)
}

fn scene(name: &str) -> Scene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    load(&scenes.join(name), &BTreeMap::new()).unwrap()
}

/// Per triangle, in submission order: the depths of its corners along z.
fn depths(mesh: &Mesh) -> Vec<[f32; 3]> {
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize].position[2])).collect()
}

fn assert_sound(name: &str, mesh: &Mesh) {
    assert!(mesh.indices.len().is_multiple_of(3), "{name}");
    assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()), "{name}");
    for vertex in &mesh.vertices {
        assert!(vertex.position.iter().all(|x| x.is_finite()), "{name} {vertex:?}");
        let length = vertex.normal.iter().map(|n| n * n).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-4, "{name} {vertex:?}");
    }
}

#[test]
fn names_and_documentation() {
    for generator in GENERATORS {
        let name = generator.name();
        assert_eq!(GENERATORS.iter().filter(|other| other.name() == name).count(), 1);
        let mut names: Vec<_> = generator.parameters().iter().map(|p| p.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), generator.parameters().len(), "{name}");
        for parameter in generator.parameters() {
            assert!(parameter.about.ends_with('.'), "{name} {}", parameter.name);
            let in_range = match parameter.kind {
                Kind::Integer { default, min, max } => (min..=max).contains(&default),
                Kind::Number { default, min, max } => (min..=max).contains(&default),
                Kind::Word { default, valid } => valid.contains(&default),
            };
            assert!(in_range, "{name} {}", parameter.name);
        }
    }
}

#[test]
fn pure_functions_of_their_parameters() {
    for generator in GENERATORS {
        let mut params = Params::new(generator.parameters());
        let first = generator.generate(&params).unwrap();
        assert!(first == generator.generate(&params).unwrap(), "{}", generator.name());
        assert_sound(generator.name(), &first);
        if generator.parameters().iter().any(|p| p.name == "seed") {
            // A stack draws at random for one order only.
            if generator.name() == "stack" {
                params.set("order", &"random".into()).unwrap();
            }
            let first = generator.generate(&params).unwrap();
            params.set("seed", &2.into()).unwrap();
            assert!(first != generator.generate(&params).unwrap(), "{}", generator.name());
        }
    }
}

#[test]
fn least_and_most_of_every_parameter() {
    for generator in GENERATORS {
        for parameter in generator.parameters() {
            let extremes: Vec<Value> = match parameter.kind {
                Kind::Integer { min, max, .. } => {
                    [min, max].map(|n| Value::Integer(n as i64)).to_vec()
                }
                Kind::Number { min, max, .. } => [min, max].map(Value::Float).to_vec(),
                Kind::Word { valid, .. } => valid.iter().map(|w| Value::from(*w)).collect(),
            };
            for value in extremes {
                // A hairball of few strands, since every extreme makes one.
                let mut params = Params::new(generator.parameters());
                if generator.name() == "hairball" {
                    params.set("strands", &20.into()).unwrap();
                }
                params.set(parameter.name, &value).unwrap();
                let name = format!("{} {}={value}", generator.name(), parameter.name);
                match generator.generate(&params) {
                    Ok(mesh) => assert_sound(&name, &mesh),
                    Err(GenerateError::TooLarge { triangles }) => {
                        assert!(triangles > oit_scene::MAX_TRIANGLES, "{name}");
                    }
                    Err(error) => panic!("{name}: {error}"),
                }
            }
        }
    }
}

#[test]
fn too_large_is_refused_before_it_is_made() {
    let most = Value::Integer(4096);
    let fine = Value::Integer(1024);
    for (name, values) in [
        ("planes", vec![("full", most.clone()), ("tessellation", fine.clone())]),
        ("grid", vec![("layers", most.clone()), ("tessellation", Value::Integer(1 << 24))]),
        ("stack", vec![("count", most.clone()), ("tessellation", fine)]),
        ("hairball", vec![("strands", Value::Integer(1 << 22)), ("levels", Value::Integer(4096))]),
        ("shells", vec![("count", 1024.into()), ("tessellation", 1024.into())]),
        ("atrium", vec![("bays_long", 64.into()), ("bays_wide", 64.into()), ("detail", 16.into())]),
        ("powerplant", vec![("detail", 16.into())]),
        ("powerplant", vec![("bays", 20.into()), ("strays", 4096.into()), ("detail", 1.into())]),
    ] {
        let error = generate(name, &values).unwrap_err();
        assert!(error.to_string().contains("triangles, more than"), "{name}: {error}");
    }
}

#[test]
fn documented_counts() {
    let count = |name, values: &[(&str, Value)]| generate(name, values).unwrap().triangle_count();
    assert_eq!(count("planes", &[]), 128 * 4 * 4 * 2);
    assert_eq!(count("grid", &[]), 10 * 20_000);
    // 999 triangles are 499 cells at most: 22 rows of 22.
    assert_eq!(count("grid", &[("tessellation", 999.into())]), 10 * 2 * 22 * 22);
    assert_eq!(count("stack", &[]), 32 * 8 * 8 * 2);
    assert_eq!(count("stack", &[("shape", "sphere".into())]), 32 * 8 * 16 * 2);
    assert_eq!(count("hairball", &[]), 2 * 3000 * 240 * 2);
    assert_eq!(count("random_triangles", &[]), 64);
    assert_eq!(count("cyclic", &[]), 3 * 2);
    assert_eq!(count("intersecting", &[]), 4 * 2);
    assert_eq!(count("shells", &[]), 5 * 24 * 48 * 2);
    assert_eq!(count("atrium", &[]), 279_200);
    assert_eq!(count("smoke", &[]), 13_468);
    assert_eq!(count("powerplant", &[]), 848_780);
    assert_eq!(count("powerplant", &[("detail", 0.001.into())]), 290_336);
}

#[test]
fn planes_are_written_in_order_of_depth() {
    let mesh = generate("planes", &[]).unwrap();
    let front = depths(&mesh);
    assert!(front.iter().all(|[a, b, c]| a == b && b == c));
    let mut planes: Vec<f32> = front.iter().map(|[z, ..]| *z).collect();
    assert!(planes.is_sorted_by(|nearer, farther| nearer >= farther));
    planes.dedup();
    assert_eq!(planes.len(), 128, "all at different depths");
    assert_eq!((planes[0], planes[127]), (0.5, -0.5));

    let back = generate("planes", &[("order", "back_to_front".into())]).unwrap();
    assert!(depths(&back).is_sorted_by(|a, b| a[0] <= b[0]));
}

#[test]
fn planes_views_see_that_order_and_its_reverse() {
    for name in ["planes.toml", "planes2.toml"] {
        let scene = scene(name);
        for view in &scene.views {
            let matrix = view.camera.view_projection(16.0 / 9.0);
            let (triangles, _) = scene.mesh.indices.as_chunks::<3>();
            let seen: Vec<f32> = triangles
                .iter()
                .map(|t| {
                    let position = scene.mesh.vertices[t[0] as usize].position;
                    matrix.project_point3([0.0, 0.0, position[2]].into()).z
                })
                .collect();
            assert!(seen.iter().all(|z| (0.0..1.0).contains(z)), "{name} {}", view.name);
            // A linked list is read last in first out: `front` reads them sorted.
            if view.name.starts_with("front") {
                assert!(seen.iter().rev().is_sorted(), "{name} {}", view.name);
            } else {
                assert!(seen.is_sorted(), "{name} {}", view.name);
            }
        }
    }
}

/// Fragments at 1920x1080 of a mesh of upright rectangles about the z axis, and the most of a
/// pixel: the pixel centres inside each rectangle, as it is projected.
fn rectangle_fragments(scene: &Scene, view: usize) -> (u64, usize) {
    let (width, height) = (1920.0f32, 1080.0f32);
    let matrix = scene.views[view].camera.view_projection(width / height);
    let mut extents: BTreeMap<u32, glam::Vec2> = BTreeMap::new();
    for vertex in &scene.mesh.vertices {
        let clip = matrix.project_point3(vertex.position.into()).truncate().abs();
        let extent = extents.entry(vertex.position[2].to_bits()).or_default();
        *extent = extent.max(clip);
    }
    let centres = |extent: f32, size: f32| {
        let low = ((0.5 - extent / 2.0) * size - 0.5).ceil().max(0.0);
        let high = ((0.5 + extent / 2.0) * size - 0.5).floor().min(size - 1.0);
        (high - low + 1.0) as u64
    };
    let total = extents.values().map(|e| centres(e.x, width) * centres(e.y, height)).sum();
    // The middle of the view lies inside all of them.
    (total, extents.len())
}

#[test]
fn planes_have_the_fragments_of_rbs_table_2() {
    let planes = scene("planes.toml");
    for view in 0..2 {
        let (total, peak) = rectangle_fragments(&planes, view);
        assert!((36_000_000..44_000_000).contains(&total), "{total}");
        assert_eq!(peak, 128);
    }
    let planes2 = scene("planes2.toml");
    for view in 0..4 {
        let (total, peak) = rectangle_fragments(&planes2, view);
        assert!((36_000_000..44_000_000).contains(&total), "{total}");
        assert_eq!(peak, 128);
    }
}

#[test]
fn grid_fills_the_view_it_is_made_for() {
    let scene = scene("grid.toml");
    let (total, peak) = rectangle_fragments(&scene, 0);
    assert_eq!((total, peak), (10 * 1920 * 1080, 10));
    let depths: Vec<f32> = depths(&scene.mesh).iter().step_by(20_000).map(|z| z[0]).collect();
    assert!(!depths.is_sorted() && !depths.iter().rev().is_sorted(), "{depths:?}");
}

#[test]
fn stacks_are_sorted_both_ways() {
    for order in ["front_to_back", "back_to_front"] {
        let mesh = generate("stack", &[("order", order.into())]).unwrap();
        let mut depths = depths(&mesh);
        if order == "back_to_front" {
            depths.reverse();
        }
        assert!(depths.is_sorted_by(|a, b| a[0] >= b[0]), "{order}");
    }
    // A sphere's rings go from the near pole to the far one.
    let one = [("shape", "sphere".into()), ("count", 1.into()), ("tessellation", 16.into())];
    let mesh = generate("stack", &one).unwrap();
    let middles: Vec<f32> = depths(&mesh).iter().map(|z| z.iter().sum::<f32>() / 3.0).collect();
    // Within a ring the two triangles of a cell alternate, so compare rings.
    let rings: Vec<f32> = middles.chunks(64).map(|ring| ring.iter().sum::<f32>() / 64.0).collect();
    assert!(rings.is_sorted_by(|near, far| near > far), "{rings:?}");
    assert!((mesh.vertices[0].position[2] - 0.5).abs() < 1e-6);
}

#[test]
fn hairball_grows_level_by_level() {
    let (strands, levels) = (50usize, 12usize);
    let values = [("strands", Value::Integer(50)), ("levels", Value::Integer(12))];
    let mesh = generate("hairball", &values).unwrap();
    let radius = |i: &u32| glam::Vec3::from(mesh.vertices[*i as usize].position).length();
    let in_back = |i: &u32| mesh.vertices[*i as usize].position[2] > 0.0;
    let per_level = strands * 2 * 3;
    for (chunk, indices) in mesh.indices.chunks(per_level).enumerate() {
        let back = chunk < levels;
        // The half towards +z comes first, from the core outward; the other from the tips inward.
        let level = if back { chunk } else { 2 * levels - 1 - chunk };
        let (inner, outer) =
            (0.5 + 4.5 * level as f32 / 12.0, 0.5 + 4.5 * (level + 1) as f32 / 12.0);
        assert!(
            indices.iter().map(radius).all(|r| r > inner - 1e-3 && r < outer + 1e-3),
            "{chunk}"
        );
        let share = indices.iter().filter(|i| in_back(i)).count() as f32 / per_level as f32;
        assert!(if back { share > 0.95 } else { share < 0.05 }, "{chunk}: {share}");
    }
}

/// Triangles by their corners alone, wherever they lie in the mesh.
fn corners(mesh: &Mesh) -> Vec<[[u32; 3]; 3]> {
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    let bits = |i: u32| mesh.vertices[i as usize].position.map(f32::to_bits);
    let sorted = |triangle: &[u32; 3]| {
        let mut corners = triangle.map(bits);
        corners.sort_unstable();
        corners
    };
    triangles.iter().map(sorted).collect()
}

#[test]
fn surfaces_of_buildings_do_not_lie_in_one_another() {
    for name in ["atrium", "powerplant"] {
        let mesh = generate(name, &[]).unwrap();
        let mut triangles = corners(&mesh);
        // Those without area, at poles, draw nothing.
        triangles.retain(|[a, b, c]| a != b && b != c);
        let all = triangles.len();
        triangles.sort_unstable();
        triangles.dedup();
        assert_eq!(triangles.len(), all, "{name}: some triangle is there twice");
    }
}

#[test]
fn a_power_plant_is_transparent_and_as_large_as_its_bays() {
    let mesh = generate("powerplant", &[]).unwrap();
    // From 0.05 to 0.3.
    let alphas = || mesh.vertices.iter().map(|vertex| vertex.rgba[3]);
    assert_eq!((alphas().min(), alphas().max()), (Some(13), Some(77)));

    let least = |mesh: &Mesh, axis: usize| {
        mesh.vertices.iter().map(|vertex| vertex.position[axis]).fold(f32::MAX, f32::min)
    };
    let longer = generate("powerplant", &[("bays", 12.into())]).unwrap();
    assert!((least(&mesh, 0) - least(&longer, 0) - 6.0).abs() < 1e-3, "a bay more at each end");
    assert!(least(&mesh, 1) > -1.0, "nothing is far below the ground");

    let clear = generate("powerplant", &[("alpha", 0.5.into())]).unwrap();
    assert_eq!(clear.indices, mesh.indices);
    let halves = mesh.vertices.iter().zip(&clear.vertices);
    assert!(halves.into_iter().all(|(full, half)| full.rgba[3].abs_diff(2 * half.rgba[3]) <= 1));
}

#[test]
fn a_power_plants_details_leave_its_extent() {
    let extent = |detail: f64| {
        let mesh = generate("powerplant", &[("detail", detail.into())]).unwrap();
        let corner = |pick: fn(f32, f32) -> f32, from: f32| {
            let points = mesh.vertices.iter().map(|vertex| vertex.position);
            points.fold([from; 3], |a, b| std::array::from_fn(|i| pick(a[i], b[i])))
        };
        [corner(f32::min, f32::MAX), corner(f32::max, f32::MIN)]
    };
    let (small, large) = (extent(0.001), extent(0.3));
    let pairs = small.as_flattened().iter().zip(large.as_flattened());
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 0.3), "{small:?} {large:?}");
}

#[test]
fn an_atrium_is_transparent_and_as_large_as_its_bays() {
    let mesh = generate("atrium", &[]).unwrap();
    assert!(mesh.vertices.iter().all(|vertex| (51..=128).contains(&vertex.rgba[3])));
    let extent = |mesh: &Mesh, axis: usize| {
        mesh.vertices.iter().map(|vertex| vertex.position[axis]).fold(0.0, f32::max)
    };
    let longer = generate("atrium", &[("bays_long", 10.into())]).unwrap();
    assert!((extent(&longer, 0) - extent(&mesh, 0) - 3.6).abs() < 1e-3, "a bay more at each end");
    assert_eq!(extent(&longer, 2), extent(&mesh, 2));

    let clear = generate("atrium", &[("alpha", 0.5.into())]).unwrap();
    assert_eq!(clear.indices, mesh.indices);
    let halves = mesh.vertices.iter().zip(&clear.vertices);
    assert!(halves.into_iter().all(|(full, half)| full.rgba[3].abs_diff(2 * half.rgba[3]) <= 1));
}

#[test]
fn smoke_rises_in_squares_that_face_the_view() {
    let scene = scene("smoke.toml");
    let camera = &scene.views[0].camera;
    let sight = glam::Vec3::from(camera.target) - glam::Vec3::from(camera.eye);
    assert_eq!(sight.normalize(), glam::Vec3::NEG_Z, "the squares face +z");
    let mesh = &scene.mesh;
    let (squares, rest) = mesh.vertices.as_chunks::<4>();
    assert!(rest.is_empty());
    for [a, b, c, d] in squares {
        let at = [a, b, c, d].map(|vertex| glam::Vec3::from(vertex.position));
        assert!(at.iter().all(|corner| corner.z == at[0].z));
        let (along, across) = (at[1] - at[0], at[3] - at[0]);
        let side = along.length();
        assert!((0.291 * 0.2 * 0.69..0.291 * 1.31).contains(&side), "{side}");
        assert!((across.length() - side).abs() < 1e-5 && along.dot(across).abs() < 1e-5);
        assert!((at[2] - at[0] - along - across).length() < 1e-5);
        let [red, green, blue, alpha] = a.rgba;
        assert!(red == green && green == blue);
        assert!((5..=25).contains(&alpha), "{alpha}: from 0.02 to 0.1");
    }
    // The oldest are written first and are the highest and the largest.
    let eighth = squares.len() / 8;
    let mean = |part: &[[oit_scene::Vertex; 4]], axis: usize| {
        part.iter().map(|square| square[0].position[axis]).sum::<f32>() / part.len() as f32
    };
    let heights: Vec<f32> = squares.chunks_exact(eighth).map(|part| mean(part, 1)).collect();
    assert!(heights.first() > heights.last(), "{heights:?}");
    assert!(heights[0] - heights[7] > 2.0, "{heights:?}");
    // Neither in order of depth nor in its reverse: about as many steps go nearer as farther.
    let nearer = squares.windows(2).filter(|w| w[1][0].position[2] > w[0][0].position[2]).count();
    let share = nearer as f64 / squares.len() as f64;
    assert!((0.45..0.55).contains(&share), "{share}");
}

#[test]
fn smoke_has_as_many_squares_as_asked_for() {
    for particles in [1, 2, 1000] {
        let mesh = generate("smoke", &[("particles", particles.into())]).unwrap();
        assert_eq!(mesh.triangle_count() as i64, 2 * particles);
        assert_eq!(mesh.vertices.len() as i64, 4 * particles);
    }
    let full = generate("smoke", &[]).unwrap();
    let thin = generate("smoke", &[("alpha", 0.0.into())]).unwrap();
    assert!(thin.vertices.iter().all(|vertex| vertex.rgba[3] == 0));
    let places = |mesh: &Mesh| mesh.vertices.iter().map(|v| v.position).collect::<Vec<_>>();
    assert_eq!(places(&full), places(&thin), "opacity moves nothing");
}

#[test]
fn random_triangles_intersect() {
    // Two triangles cross if corners of one lie on both sides of the other's plane, both ways;
    // that is necessary, and in a soup this dense some such pair crosses.
    let mesh = generate("random_triangles", &[]).unwrap();
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    let corners = |t: &[u32; 3]| t.map(|i| glam::Vec3::from(mesh.vertices[i as usize].position));
    let splits = |a: &[u32; 3], b: &[u32; 3]| {
        let normal = glam::Vec3::from(mesh.vertices[a[0] as usize].normal);
        let sides = corners(b).map(|p| normal.dot(p - corners(a)[0]) > 0.0);
        sides.contains(&true) && sides.contains(&false)
    };
    assert!(triangles.iter().any(|a| triangles.iter().any(|b| splits(a, b) && splits(b, a))));
}
