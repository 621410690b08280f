//! glTF and GLB files, good and hostile.

use std::path::Path;

use base64::Engine;
use oit_scene::{ImportError, Mesh, import};
use proptest::prelude::*;
use serde_json::{Value, json};

/// Three corners of a triangle (36 bytes), three normals (36), three RGBA bytes (12), three u16
/// indices (6) and padding (2).
fn data() -> Vec<u8> {
    let mut bytes = Vec::new();
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    for x in [0.0f32, 0.0, 2.0].repeat(3) {
        bytes.extend(x.to_le_bytes());
    }
    bytes.extend([255, 0, 128, 255].repeat(3));
    for i in [2u16, 1, 0, 0] {
        bytes.extend(i.to_le_bytes());
    }
    bytes
}

/// One triangle, moved by (10, 0, 0) by its node's parent and doubled by its node.
fn document() -> Value {
    let encoded = base64::engine::general_purpose::STANDARD.encode(data());
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1], "translation": [10.0, 0.0, 0.0]},
            {"mesh": 0, "scale": [2.0, 2.0, 2.0]},
        ],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2},
            "indices": 3,
            "material": 0,
        }]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 0.5, 0.25]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": true},
            {"bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            {"buffer": 0, "byteOffset": 72, "byteLength": 12},
            {"buffer": 0, "byteOffset": 84, "byteLength": 6},
        ],
        "buffers": [{
            "byteLength": data().len(),
            "uri": format!("data:application/octet-stream;base64,{encoded}"),
        }],
    })
}

fn glb(document: &Value) -> Vec<u8> {
    let mut document = document.clone();
    document["buffers"][0].as_object_mut().unwrap().remove("uri");
    let mut text = serde_json::to_vec(&document).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + 8 + text.len() as u32 + 8 + data().len() as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((data().len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(data());
    bytes
}

fn read_in(dir: &Path, name: &str, bytes: &[u8]) -> Result<Mesh, ImportError> {
    let path = dir.join(name);
    std::fs::write(&path, bytes).unwrap();
    import::import(&path)
}

fn read(document: &Value) -> Result<Mesh, ImportError> {
    let dir = tempfile::tempdir().unwrap();
    read_in(dir.path(), "mesh.gltf", &serde_json::to_vec(document).unwrap())
}

/// The document with one value replaced, or a new one added.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(items) => {
            let i: usize = key.parse().unwrap();
            if i == items.len() {
                items.push(value);
            } else {
                items[i] = value;
            }
        }
        object => object[key] = value,
    }
    document
}

fn without(parent: &str, key: &str) -> Value {
    let mut document = document();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(key).unwrap();
    document
}

#[test]
fn transforms_colours_and_order() {
    let mesh = read(&document()).unwrap();
    assert_eq!(mesh.indices, [2, 1, 0]);
    assert_eq!(mesh.vertices[1].position, [12.0, 0.0, 0.0]);
    assert_eq!(mesh.vertices[1].normal, [0.0, 0.0, 1.0]);
    assert_eq!(mesh.vertices[1].rgba, [255, 0, 64, 64]);
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(read_in(dir.path(), "mesh.glb", &glb(&document())).unwrap(), mesh);
}

#[test]
fn normals_turn_rightly_under_uneven_scale() {
    let mut document = document();
    document["nodes"][1]["scale"] = json!([1.0, 1.0, 4.0]);
    document["nodes"][1]["rotation"] = json!([0.0, 0.707_106_77, 0.0, 0.707_106_77]);
    let normal = read(&document).unwrap().vertices[0].normal;
    assert!((normal[0] - 1.0).abs() < 1e-6, "{normal:?}");
}

#[test]
fn without_normals_colours_and_indices() {
    let mut document = without("/meshes/0/primitives/0", "indices");
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    let mesh = read(&document).unwrap();
    assert_eq!(mesh.indices, [0, 1, 2]);
    assert_eq!(mesh.vertices[0].normal, [0.0, 0.0, 1.0]);
    assert_eq!(mesh.vertices[0].rgba, [255, 255, 128, 64]);
}

#[test]
fn strips_and_fans_become_triangles() {
    for (mode, expected) in [(5, [2, 1, 0, 0, 1, 2]), (6, [2, 1, 0, 2, 0, 2])] {
        let mut document = with("/meshes/0/primitives/0/mode", json!(mode));
        // Four indices 2 1 0 2, in a buffer of their own.
        let indices: Vec<u8> = [2u16, 1, 0, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
        let encoded = base64::engine::general_purpose::STANDARD.encode(indices);
        let buffer = json!({"byteLength": 8, "uri": format!("data:;base64,{encoded}")});
        document["buffers"].as_array_mut().unwrap().push(buffer);
        document["bufferViews"][3] = json!({"buffer": 1, "byteLength": 8});
        document["accessors"][3]["count"] = json!(4);
        assert_eq!(read(&document).unwrap().indices, expected);
    }
}

#[test]
fn one_mesh_may_have_many_instances() {
    let mut document = document();
    document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [0.0, 5.0, 0.0]}]);
    document["scenes"][0]["nodes"] = json!([0, 1]);
    let mesh = read(&document).unwrap();
    assert_eq!(mesh.indices, [2, 1, 0, 5, 4, 3]);
    assert_eq!(mesh.vertices[3].position, [0.0, 5.0, 0.0]);
}

#[test]
fn every_mistake_is_named() {
    let primitive = "/meshes/0/primitives/0";
    let at = |tail: &str| format!("{primitive}/{tail}");
    // A finite transform that takes a corner beyond the floats.
    let mut far = with("/nodes/0/scale", json!([1.5e38, 1.0, 1.0]));
    far["nodes"][0]["translation"] = json!([3e38, 0.0, 0.0]);
    let mistakes = [
        // Nodes.
        (with("/nodes/1/children", json!([0])), "node 0: reached twice"),
        (with("/nodes/1/children", json!([1])), "node 1: reached twice"),
        (with("/scenes/0/nodes", json!([0, 1])), "node 1: reached twice"),
        (with("/nodes/0/children", json!([7])), "file: "),
        (with("/nodes/0/scale", json!([1e30, 1e30, 1e30])), "accessor 1: element 0 is not finite"),
        (with("/nodes/0/scale", json!([3e38, 1.0, 1.0])), "node 1: its transform is not finite"),
        (far, "accessor 0: element 1 is not finite where its node puts it"),
        (without("", "scenes"), "file: "),
        // Accessors.
        (with("/accessors/0/count", json!(4)), "accessor 0: 4 elements do not fit"),
        (with("/accessors/0/count", json!(0)), "accessor 0: its count is 0"),
        (with("/accessors/0/count", json!(u64::MAX)), "accessor 0: its count is"),
        (with("/accessors/0/count", json!(50_000_000)), "accessor 0: 50000000 elements do not fit"),
        (with("/accessors/0/byteOffset", json!(4)), "accessor 0: 3 elements do not fit"),
        (with("/accessors/0/byteOffset", json!(u64::MAX)), "accessor 0: 3 elements do not fit"),
        (with("/accessors/0/componentType", json!(5123)), "accessor 0: Vec3 of U16 cannot be used"),
        (with("/accessors/0/type", json!("VEC2")), "accessor 0: Vec2 of F32 cannot be used"),
        (with("/accessors/1/count", json!(2)), "accessor 1: 2 elements, not 3 as POSITION"),
        (with("/accessors/2/count", json!(1)), "accessor 2: 1 elements, not 3 as POSITION"),
        (with("/accessors/3/componentType", json!(5126)), "accessor 3: Scalar of F32"),
        (with("/accessors/3/componentType", json!(5121)), ""),
        (with("/accessors/3/count", json!(2)), "mesh 0 primitive 0: 2 corners do not make"),
        (without("/accessors/0", "bufferView"), "file: "),
        (
            with(
                "/accessors/0/sparse",
                json!({"count": 1,
            "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}),
            ),
            "accessor 0: sparse accessors are not supported",
        ),
        (with("/accessors/0/bufferView", json!(9)), "file: "),
        // Views and buffers.
        (with("/bufferViews/0/byteStride", json!(8)), "accessor 0: a stride of 8 bytes"),
        (with("/bufferViews/0/byteOffset", json!(90)), "accessor 0: buffer view 0 is outside"),
        (
            with("/bufferViews/0/byteOffset", json!(u64::MAX)),
            "accessor 0: buffer view 0 is outside",
        ),
        (
            with("/bufferViews/0/byteLength", json!(1u64 << 40)),
            "accessor 0: buffer view 0 is outside",
        ),
        (with("/bufferViews/0/byteLength", json!(35)), "accessor 0: 3 elements do not fit"),
        (with("/buffers/0/byteLength", json!(93)), "buffer 0: 92 bytes, not 93"),
        (with("/buffers/0/byteLength", json!(u64::MAX)), "buffer 0: 92 bytes, not"),
        (without("/buffers/0", "uri"), "buffer 0: the file has no BIN chunk"),
        (
            with("/buffers/0/uri", json!("data:text/plain,hello")),
            "buffer 0: a data URI that is not",
        ),
        (with("/buffers/0/uri", json!("data:;base64,%%%")), "buffer 0: its base64 is wrong"),
        (with("/buffers/0/uri", json!("http://example.org/x.bin")), "buffer 0: the URI `http"),
        (with("/buffers/0/uri", json!("file:///etc/passwd")), "buffer 0: the URI `file"),
        (with("/buffers/0/uri", json!("/etc/passwd")), "buffer 0: the URI `/etc"),
        (
            with("/buffers/0/uri", json!("../x.bin")),
            "buffer 0: the URI `../x.bin` is no path inside",
        ),
        (with("/buffers/0/uri", json!("a/../../x.bin")), "buffer 0: the URI `a/.."),
        (with("/buffers/0/uri", json!("%2e%2e/x.bin")), "buffer 0: the URI `%2e%2e/x.bin` is no"),
        (with("/buffers/0/uri", json!("..\\x.bin")), "buffer 0: the URI `..\\x.bin` is no"),
        (with("/buffers/0/uri", json!("")), "buffer 0: the URI `` is no path"),
        (with("/buffers/0/uri", json!("%zz")), "buffer 0: bad URI `%zz`"),
        (with("/buffers/0/uri", json!("a%00b")), "buffer 0: bad URI"),
        (with("/buffers/0/uri", json!("missing.bin")), "buffer 0 (`missing.bin`): "),
        // Primitives.
        (with(&at("mode"), json!(0)), "mesh 0 primitive 0: unsupported mode Points"),
        (with(&at("mode"), json!(1)), "mesh 0 primitive 0: unsupported mode Lines"),
        (with(&at("mode"), json!(9)), "file: "),
        (with(&at("attributes"), json!({"NORMAL": 1})), "file: "),
        (with(&at("indices"), json!(12)), "file: "),
        (with(&at("material"), json!(3)), "file: "),
    ];
    for (document, message) in mistakes {
        match read(&document) {
            Ok(mesh) => assert!(message.is_empty() && mesh.triangle_count() == 1, "{message}"),
            Err(error) => {
                let error = error.to_string();
                assert!(!message.is_empty() && error.starts_with(message), "{message} / {error}");
            }
        }
    }
}

/// The document with some bytes of its buffer replaced.
fn with_data(offset: usize, value: &[u8]) -> Value {
    let mut bytes = data();
    bytes[offset..offset + value.len()].copy_from_slice(value);
    let encoded = base64::engine::general_purpose::STANDARD.encode(bytes);
    with("/buffers/0/uri", json!(format!("data:;base64,{encoded}")))
}

#[test]
fn bad_numbers_name_the_accessor_and_element() {
    let error = |document: &Value| read(document).unwrap_err().to_string();
    let nan = f32::NAN.to_le_bytes();
    let message = "accessor 0: element 2 is not finite where its node puts it";
    assert_eq!(error(&with_data(28, &nan)), message);
    assert_eq!(error(&with_data(28, &f32::NEG_INFINITY.to_le_bytes())), message);
    assert_eq!(error(&with_data(48, &nan)), "accessor 1: element 1 is not finite");
    assert_eq!(
        error(&with_data(86, &3u16.to_le_bytes())),
        "accessor 3: element 1 is vertex 3, of 3"
    );
}

#[test]
fn many_instances_of_a_large_mesh_are_refused() {
    // 30,000 triangles, instanced 2,000 times: 60 M from a file of well below 1 MB.
    let mut document = without("/meshes/0/primitives/0", "indices");
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    document["accessors"][0]["count"] = json!(90_000);
    document["bufferViews"][0]["byteLength"] = json!(90_000 * 12);
    document["buffers"][0] = json!({"byteLength": 90_000 * 12, "uri": "zero.bin"});
    document["bufferViews"].as_array_mut().unwrap().truncate(1);
    document["accessors"].as_array_mut().unwrap().truncate(1);
    document["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    document["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("zero.bin"), vec![0; 90_000 * 12]).unwrap();
    let bytes = serde_json::to_vec(&document).unwrap();
    let error = read_in(dir.path(), "mesh.gltf", &bytes).unwrap_err();
    assert!(matches!(error, ImportError::TooManyTriangles { .. }), "{error}");
}

#[test]
fn buffers_stay_inside_the_folder() {
    let outside = tempfile::tempdir().unwrap();
    std::fs::write(outside.path().join("secret.bin"), data()).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let bytes = |uri: &str| serde_json::to_vec(&with("/buffers/0/uri", json!(uri))).unwrap();

    // Inside, and in a folder below, with an escaped space.
    std::fs::create_dir(dir.path().join("sub dir")).unwrap();
    std::fs::write(dir.path().join("sub dir/mesh.bin"), data()).unwrap();
    let inside = read_in(dir.path(), "a.gltf", &bytes("sub%20dir/mesh.bin")).unwrap();
    assert_eq!(inside.triangle_count(), 1);

    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(outside.path(), dir.path().join("link")).unwrap();
        let error = read_in(dir.path(), "b.gltf", &bytes("link/secret.bin")).unwrap_err();
        assert!(error.to_string().contains("leads out of the scene's folder"), "{error}");
    }
    let folder = read_in(dir.path(), "c.gltf", &bytes("sub%20dir")).unwrap_err().to_string();
    assert!(folder.starts_with("buffer 0"), "{folder}");
}

#[test]
fn a_deep_chain_of_nodes_needs_no_stack() {
    let mut nodes: Vec<Value> = (1..50_000).map(|i| json!({"children": [i]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(read(&with("/nodes", json!(nodes))).unwrap().triangle_count(), 1);
}

#[test]
fn truncated_glb_is_an_error() {
    let whole = glb(&document());
    let dir = tempfile::tempdir().unwrap();
    for end in 0..whole.len() {
        read_in(dir.path(), "mesh.glb", &whole[..end]).unwrap_err();
    }
    // The length in the header: below its own size, and beyond the file.
    for length in [0u32, 11, 12, u32::MAX] {
        let mut bytes = whole.clone();
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        let result = read_in(dir.path(), "mesh.glb", &bytes);
        assert!(length == 12 || result.is_err(), "{length}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn mutations_never_panic(
        binary in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes =
            if binary { glb(&document()) } else { serde_json::to_vec(&document()).unwrap() };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        let dir = tempfile::tempdir().unwrap();
        if let Ok(mesh) = read_in(dir.path(), if binary { "m.glb" } else { "m.gltf" }, &bytes) {
            prop_assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
            prop_assert!(mesh.vertices.iter().flat_map(|v| v.position).all(f32::is_finite));
        }
    }

    #[test]
    fn numbers_out_of_range_never_panic(
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::sample::select(vec![
                0u64, 1, 2, 3, 4, 5, 7, 12, 35, 36, 37, 92, 93, 5121, 5123, 5125, 5126,
                u64::from(u32::MAX), u64::MAX / 2, u64::MAX - 11, u64::MAX,
            ])),
            1..5,
        ),
    ) {
        let mut document = document();
        for (which, value) in changes {
            let mut numbers = Vec::new();
            collect_numbers(&mut document, &mut numbers);
            let which = which.index(numbers.len());
            *numbers.swap_remove(which) = json!(value);
        }
        if let Ok(mesh) = read(&document) {
            prop_assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
        }
    }
}

fn collect_numbers<'a>(value: &'a mut Value, found: &mut Vec<&'a mut Value>) {
    match value {
        Value::Number(_) => found.push(value),
        Value::Array(items) => items.iter_mut().for_each(|item| collect_numbers(item, found)),
        Value::Object(map) => map.values_mut().for_each(|item| collect_numbers(item, found)),
        _ => {}
    }
}
