//! Scenes of spheres: their generators, counts and levels of detail.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{Quat, Vec3};
use oit_scene::{
    GenerateError, Kind, MAX_ATOMS, MAX_OBJECTS, Object, Params, SPHERE_GENERATORS, Scene,
    SphereGenerator, Spheres, load,
};
use toml::Value;

fn scene(name: &str, overrides: &[(&str, Value)]) -> Scene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let overrides = overrides.iter().map(|(key, value)| ((*key).to_owned(), value.clone()));
    load(&scenes.join(name), &overrides.collect()).unwrap()
}

fn spheres(name: &str, overrides: &[(&str, Value)]) -> Spheres {
    Spheres::clone(&scene(name, overrides).spheres.unwrap())
}

fn kind_name<'a>(spheres: &'a Spheres, object: &Object) -> &'a str {
    &spheres.kinds[object.kind as usize].name
}

/// Spheres drawn where every object has the level of its distance from the eye.
fn drawn(spheres: &Spheres, eye: [f32; 3]) -> u64 {
    let level = |object: &Object| {
        let distance = Vec3::from(eye).distance(object.position.into());
        u64::from(spheres.level_at(&spheres.kinds[object.kind as usize], distance).atoms)
    };
    spheres.objects.iter().map(level).sum()
}

/// What every user of spheres relies on.
fn assert_sound(name: &str, spheres: &Spheres) {
    assert_eq!(spheres.atoms.len(), spheres.atom_rgba.len(), "{name}");
    assert!(spheres.atoms.len() as u64 <= MAX_ATOMS, "{name}");
    assert!(spheres.objects.len() as u64 <= MAX_OBJECTS, "{name}");
    let mut next_level = 0;
    let mut next_atom = 0;
    for kind in &spheres.kinds {
        assert_eq!(kind.first_level, next_level, "{name} {}", kind.name);
        assert!(kind.levels >= 1, "{name} {}", kind.name);
        next_level += kind.levels;
        let levels = &spheres.levels[kind.first_level as usize..][..kind.levels as usize];
        assert_eq!(levels[0].from_distance, 0.0, "{name} {}", kind.name);
        for pair in levels.windows(2) {
            assert!(pair[0].from_distance < pair[1].from_distance, "{name} {}", kind.name);
            assert!(pair[0].atoms > pair[1].atoms, "{name} {}", kind.name);
        }
        let mut volumes = Vec::new();
        for level in levels {
            assert_eq!(level.first_atom, next_atom, "{name} {}", kind.name);
            assert!(level.atoms >= 1 && level.from_distance.is_finite(), "{name} {}", kind.name);
            next_atom += level.atoms;
            let atoms = &spheres.atoms[level.first_atom as usize..next_atom as usize];
            for atom in atoms {
                assert!(atom.radius > 0.0, "{name} {}", kind.name);
                let reach = Vec3::from(atom.center).length() + atom.radius;
                assert!(reach <= kind.radius * 1.000_001, "{name} {} {reach}", kind.name);
            }
            volumes.push(atoms.iter().map(|atom| f64::from(atom.radius).powi(3)).sum::<f64>());
        }
        for volume in &volumes {
            assert!((volume / volumes[0] - 1.0).abs() < 1e-4, "{name} {} {volumes:?}", kind.name);
        }
    }
    assert_eq!(next_level as usize, spheres.levels.len(), "{name}");
    assert_eq!(next_atom as usize, spheres.atoms.len(), "{name}");
    for object in &spheres.objects {
        assert!((object.kind as usize) < spheres.kinds.len(), "{name}");
        assert!(Vec3::from(object.position).is_finite(), "{name} {object:?}");
        assert!(Quat::from_array(object.rotation).is_normalized(), "{name} {object:?}");
    }
}

/// A generator with its defaults, a virus of few objects.
fn defaults(generator: &dyn SphereGenerator) -> Params {
    let mut params = Params::new(generator.parameters());
    if generator.name() == "virus" {
        params.set("objects", &2000.into()).unwrap();
    }
    params
}

#[test]
fn names_and_documentation() {
    for generator in SPHERE_GENERATORS {
        let name = generator.name();
        assert_eq!(SPHERE_GENERATORS.iter().filter(|other| other.name() == name).count(), 1);
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
    for generator in SPHERE_GENERATORS {
        let mut params = defaults(*generator);
        if generator.name() == "sphere_stack" {
            // It draws at random for one order only.
            params.set("order", &"random".into()).unwrap();
        }
        let first = generator.generate(&params).unwrap();
        assert!(first == generator.generate(&params).unwrap(), "{}", generator.name());
        params.set("seed", &2.into()).unwrap();
        assert!(first != generator.generate(&params).unwrap(), "{}", generator.name());
    }
}

#[test]
fn least_and_most_of_every_parameter() {
    for generator in SPHERE_GENERATORS {
        for parameter in generator.parameters() {
            let extremes: Vec<Value> = match parameter.kind {
                Kind::Integer { min, max, .. } => {
                    [min, max].map(|n| Value::Integer(n as i64)).to_vec()
                }
                Kind::Number { min, max, .. } => [min, max].map(Value::Float).to_vec(),
                Kind::Word { valid, .. } => valid.iter().map(|w| Value::from(*w)).collect(),
            };
            for value in extremes {
                let mut params = defaults(*generator);
                params.set(parameter.name, &value).unwrap();
                let name = format!("{} {}={value}", generator.name(), parameter.name);
                match generator.generate(&params) {
                    Ok(spheres) => assert_sound(&name, &spheres),
                    Err(GenerateError::TooManyObjects { objects }) => {
                        assert!(objects > MAX_OBJECTS, "{name}");
                    }
                    Err(error) => panic!("{name}: {error}"),
                }
            }
        }
    }
}

#[test]
fn the_stack_has_ten_thousand_behind_one_another() {
    let depths = |overrides: &[(&str, Value)]| -> Vec<f32> {
        let stack = spheres("sphere_stack.toml", overrides);
        assert_eq!((stack.objects.len(), stack.total()), (10_000, 10_000));
        assert!(stack.objects.iter().all(|object| object.position[..2] == [0.0, 0.0]));
        stack.objects.iter().map(|object| object.position[2]).collect()
    };
    let front = depths(&[]);
    assert!(front.windows(2).all(|pair| pair[0] > pair[1]));
    let mut back = depths(&[("order", "back_to_front".into())]);
    back.reverse();
    assert_eq!(back, front);
    let mut random = depths(&[("order", "random".into())]);
    assert_ne!(random, front);
    random.sort_by(|a, b| b.total_cmp(a));
    assert_eq!(random, front);

    let one = spheres("sphere_stack.toml", &[("objects", "one".into()), ("alpha", 0.25.into())]);
    assert_eq!((one.objects.len(), one.total()), (1, 10_000));
    let along: Vec<f32> = one.atoms.iter().map(|atom| atom.center[2]).collect();
    assert_eq!(along, front);
    assert!(one.atom_rgba.iter().all(|rgba| rgba[3] == 64));

    // All of them lie in the picture, and the nearest hides the others.
    let scene = scene("sphere_stack.toml", &[]);
    for view in &scene.views {
        let seen = view.camera.view_projection(1.0);
        let edge = |z: f32| seen.project_point3(Vec3::new(0.0, 0.5, z)).y.abs();
        let [near, far] = if view.name == "front" { [0, 9999] } else { [9999, 0] };
        assert!(edge(front[near]) < 1.0 && edge(front[far]) < edge(front[near]), "{}", view.name);
    }
}

#[test]
fn the_virus_has_the_published_counts() {
    let scene = scene("virus.toml", &[]);
    let virus = scene.spheres.as_ref().unwrap();
    assert_sound("virus", virus);
    assert_eq!((virus.objects.len(), virus.kinds.len()), (35_000, 100));
    // Kugler 2018, chapter 3: 2.8 million.
    let seen = drawn(virus, scene.view("hiv").unwrap().camera.eye);
    assert!((seen as f64 / 2.8e6 - 1.0).abs() < 0.05, "{seen}");
    // As the scene's text says.
    let millions = |count: u64| format!("{:.1} M", count as f64 / 1e6);
    let text = scene.about.replace('\n', " ");
    for words in [
        format!("{:.2} M spheres are drawn from `hiv`", seen as f64 / 1e6),
        format!("{} at full detail", millions(virus.total())),
        format!(
            "from `inside`, between capsid and matrix, most are fine ({})",
            millions(drawn(virus, scene.view("inside").unwrap().camera.eye))
        ),
        format!("{},{:03} are stored", virus.atoms.len() / 1000, virus.atoms.len() % 1000),
    ] {
        assert!(text.contains(&words), "{words}");
    }
    let far = drawn(virus, scene.view("far").unwrap().camera.eye);
    let coarsest = |object: &Object| {
        let kind = &virus.kinds[object.kind as usize];
        u64::from(virus.levels[(kind.first_level + kind.levels - 1) as usize].atoms)
    };
    assert_eq!(far, virus.objects.iter().map(coarsest).sum::<u64>());
    assert!(virus.objects.iter().all(|object| object.rgba == [255; 4]));
}

#[test]
fn the_virus_has_all_its_parts() {
    let virus = spheres("virus.toml", &[("cutaway", 0.0.into())]);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for object in &virus.objects {
        *counts.entry(kind_name(&virus, object)).or_default() += 1;
    }
    assert!(virus.kinds.iter().all(|kind| counts.contains_key(kind.name.as_str())));
    let of = |prefix: &str| -> usize {
        counts.iter().filter(|(name, _)| name.starts_with(prefix)).map(|(_, count)| count).sum()
    };
    assert_eq!((of("lipids"), of("spike"), of("matrix"), of("RNA")), (15_000, 72, 1600, 6000));
    assert_eq!((counts["capsid hexamer"], counts["capsid pentamer"]), (238, 12));
    // The names fall off as their abundance does.
    assert!(counts["albumin"] > 2 * counts["haemopexin"]);

    for object in &virus.objects {
        let name = kind_name(&virus, object);
        let distance = Vec3::from(object.position).length();
        let shell = match name.split(' ').next().unwrap() {
            "lipids" | "spike," => 65.9..66.1,
            "matrix" => 59.9..60.1,
            "capsid" => 5.0..55.0,
            "RNA" => 0.0..50.0,
            "albumin" | "fibrinogen" | "plasma" => 70.0..300.0,
            _ => 0.0..300.0,
        };
        assert!(shell.contains(&distance), "{name} {distance}");
        // What stands in the membrane points out.
        if name.starts_with("spike") || name.starts_with("lipids") {
            let up = Quat::from_array(object.rotation) * Vec3::Z;
            assert!(up.dot(Vec3::from(object.position)) / distance > 0.999, "{name}");
        }
    }
}

#[test]
fn what_is_cut_away_is_not_there() {
    let virus = spheres("virus.toml", &[]);
    let in_front = |object: &&Object| object.position[2] > 1.0;
    for object in virus.objects.iter().filter(in_front) {
        let name = kind_name(&virus, object);
        assert!(name.starts_with("RNA") || name.starts_with("capsid"), "{name}");
    }
    assert!(virus.objects.iter().filter(in_front).count() > 1000);
    let whole = spheres("virus.toml", &[("cutaway", 1.0.into())]);
    assert_eq!(whole.objects.len(), 35_000);
    let left = whole.objects.iter().map(|object| kind_name(&whole, object));
    assert_eq!(left.filter(|name| name.starts_with("lipids")).count(), 0);
}

#[test]
fn alphas_are_of_their_part() {
    for (parameter, prefixes) in [
        ("membrane_alpha", &["lipids", "HLA", "ICAM", "CD5"][..]),
        ("spike_alpha", &["spike"]),
        ("matrix_alpha", &["matrix"]),
        ("capsid_alpha", &["capsid"]),
        ("genome_alpha", &["RNA"]),
        ("plasma_alpha", &["albumin", "plasma protein", "fibrinogen"]),
        ("enzyme_alpha", &["integrase", "Vpr"]),
    ] {
        let virus = spheres("virus.toml", &[(parameter, 0.2.into())]);
        let of = |object: &Object| {
            prefixes.iter().any(|prefix| kind_name(&virus, object).starts_with(prefix))
        };
        let of_part: Vec<_> = virus.objects.iter().filter(|object| of(object)).collect();
        assert!(!of_part.is_empty());
        assert!(of_part.iter().all(|object| object.rgba == [255, 255, 255, 51]), "{parameter}");
        assert!(virus.objects.iter().any(|object| object.rgba[3] == 255), "{parameter}");
    }
}

#[test]
fn a_factor_shares_kinds_and_nests() {
    let one = spheres("virus.toml", &[]);
    let three = spheres("virus.toml", &[("factor", 3.into())]);
    assert_sound("factor 3", &three);
    assert_eq!((&one.atoms, &one.kinds), (&three.atoms, &three.kinds));
    assert_eq!(three.objects.len(), 105_000);
    assert_eq!(three.objects[..35_000], one.objects);
    assert!(three.total() > 100_000_000);
    // For scaling: ten million drawn, from no more atoms.
    let hiv = scene("virus.toml", &[]).view("hiv").unwrap().camera.eye;
    let eight = spheres("virus.toml", &[("factor", 8.into())]);
    assert!(drawn(&eight, hiv) > 10_000_000);
    assert_eq!(eight.atoms.len(), one.atoms.len());
    // No virus lies in another.
    let lipids = |from: usize| -> Vec3 {
        let part = three.objects[from..from + 35_000].iter();
        let lipids = part.filter(|object| kind_name(&three, object).starts_with("lipids"));
        let (sum, count) = lipids.fold((Vec3::ZERO, 0.0), |(sum, count), object| {
            (sum + Vec3::from(object.position), count + 1.0)
        });
        sum / count
    };
    let middles = [0, 35_000, 70_000].map(lipids);
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        assert!(middles[a].distance(middles[b]) > 150.0, "{middles:?}");
    }
}
