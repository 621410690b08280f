//! PLY files, good and hostile.

use std::io::Write;
use std::path::Path;

use oit_scene::{ImportError, Mesh, import};
use proptest::prelude::*;

fn read(name: &str, bytes: &[u8]) -> Result<Mesh, ImportError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    import::import(&path)
}

fn error(bytes: &[u8]) -> String {
    read("mesh.ply", bytes).unwrap_err().to_string()
}

const HEADER: &str = "ply\nformat ascii 1.0\ncomment a quad\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n";
const QUAD: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

fn ascii() -> String {
    format!("{HEADER}{QUAD}")
}

/// The same quad with normals and colours, in a binary format.
fn binary(big: bool) -> Vec<u8> {
    let format = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{format}_endian 1.0\nelement vertex 4\nproperty float x\n\
        property double y\nproperty float z\nproperty float nx\nproperty float ny\n\
        property float nz\nproperty uchar red\nproperty ushort green\nproperty float blue\n\
        property uchar alpha\nelement edge 1\nproperty int vertex1\nproperty list uchar short more\n\
        element face 1\nproperty uchar flags\nproperty list ushort uint vertex_index\nend_header\n"
    )
    .into_bytes();
    macro_rules! put {
        ($($value:expr),*) => {
            $(bytes.extend(if big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() });)*
        };
    }
    for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        put!(x, f64::from(y), 0.0f32, 0.0f32, 0.0f32, -2.0f32, 255u8, 32_896u16, 0.2f32, 51u8);
    }
    put!(7i32, 2u8, 1i16, 2i16);
    put!(9u8, 4u16, 0u32, 1u32, 2u32, 3u32);
    bytes
}

#[test]
fn ascii_gets_flat_normals_and_white() {
    let mesh = read("quad.ply", ascii().as_bytes()).unwrap();
    assert_eq!(mesh.indices, [0, 1, 2, 3, 4, 5]);
    let positions: Vec<_> = mesh.vertices.iter().map(|v| [v.position[0], v.position[1]]).collect();
    assert_eq!(positions, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert!(mesh.vertices.iter().all(|v| v.normal == [0.0, 0.0, 1.0] && v.rgba == [255; 4]));
}

#[test]
fn windows_line_ends_and_blank_lines() {
    let text = ascii().replace('\n', "\r\n").replace("1 1 0", "\r\n1 1 0");
    assert_eq!(read("quad.ply", text.as_bytes()).unwrap().triangle_count(), 2);
}

#[test]
fn binary_of_both_orders_keeps_normals_and_colours() {
    for big in [false, true] {
        let mesh = read("quad.ply", &binary(big)).unwrap();
        assert_eq!(mesh.indices, [0, 1, 2, 0, 2, 3]);
        assert_eq!(mesh.vertices[2].position, [1.0, 1.0, 0.0]);
        assert_eq!(mesh.vertices[0].normal, [0.0, 0.0, -1.0]);
        assert_eq!(mesh.vertices[3].rgba, [255, 128, 51, 51]);
    }
}

#[test]
fn gzipped() {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(&binary(false)).unwrap();
    let packed = encoder.finish().unwrap();
    let plain = read("quad.ply", &binary(false)).unwrap();
    assert_eq!(read("quad.ply.gz", &packed).unwrap(), plain);
    let cut = read("quad.ply.gz", &packed[..packed.len() - 12]).unwrap_err();
    assert!(cut.to_string().starts_with("gzip stream: "), "{cut}");
    let garbage = read("quad.ply.gz", b"garbage").unwrap_err();
    assert!(garbage.to_string().starts_with("gzip stream: "), "{garbage}");
}

#[test]
fn every_mistake_is_named() {
    let mistakes = [
        ("ply\n", "plx\n", "line 1: not a PLY file"),
        ("end_header\n", "", "line 10: unknown header line `0 0 0`"),
        ("format ascii 1.0\n", "", "header: no `format` line"),
        ("ascii", "utf8", "line 2: unknown format `utf8`"),
        ("ascii 1.0", "ascii 2.0", "line 2: unknown header line `format ascii 2.0`"),
        ("float y", "flaot y", "line 6: unknown type `flaot`"),
        ("property float y", "property y", "line 6: a property is `property type name`"),
        ("property float y", "property list uchar y", "line 6: a property is"),
        ("vertex 4", "vertex four", "line 4: bad element count"),
        ("vertex 4", "vertex -4", "line 4: bad element count"),
        ("element vertex 4\n", "", "line 4: a property before the first element"),
        ("element face 1", "element vertex 1", "line 8: a second element `vertex`"),
        ("element face 1", "element faces 1", "header: no element `face`"),
        ("element vertex 4", "element point 4", "header: no element `vertex`"),
        ("float z", "float w", "element `vertex`: no properties x, y and z"),
        ("float z", "list uchar float z", "element `vertex`: no properties x, y and z"),
        ("vertex_indices", "corners", "element `face`: no list `vertex_indices`"),
        (
            "uchar int vertex_indices\n",
            "uchar int vertex_indices\nelement void 9\n",
            "element `void`: no properties",
        ),
        ("vertex 4", "vertex 999999999999", "element `vertex`: 999999999999 of them need"),
        (
            "vertex 4",
            "vertex 18446744073709551615",
            "element `vertex`: 18446744073709551615 of them",
        ),
        ("vertex 4", "vertex 5", "line 15, vertex 4: `2` is one value too many"),
        ("vertex 4", "vertex 3", "line 14, face 0: `1` is one value too many"),
        ("face 1", "face 2", "line 15, face 1: the file ends here"),
        ("face 1", "face 0", "line 14: more data than the header says"),
        ("1 1 0\n", "1 1\n", "line 13, vertex 2: too few values"),
        ("1 1 0\n", "1 one 0\n", "line 13, vertex 2: `one` is not a number"),
        ("1 1 0\n", "1 nan 0\n", "line 13, vertex 2: `y` is NaN, not a finite float"),
        ("1 1 0\n", "1 1 -inf\n", "line 13, vertex 2: `z` is -inf, not a finite float"),
        ("1 1 0\n", "1e39 1 0\n", "line 13, vertex 2: `x` is 1"),
        ("4 0 1 2 3", "4 0 1 2 4", "line 15, face 0: corner 3 is vertex 4, of 4"),
        ("4 0 1 2 3", "4 0 1 2 -1", "line 15, face 0: corner 3 is vertex -1, of 4"),
        ("4 0 1 2 3", "4 0 1 2 1.5", "line 15, face 0: corner 3 is vertex 1.5, of 4"),
        ("4 0 1 2 3", "4 0 1 2", "line 15, face 0: too few values"),
        ("4 0 1 2 3", "-4 0 1 2 3", "line 15, face 0: a list length must be a whole number"),
        ("4 0 1 2 3", "4000000000 0 1 2 3", "line 15, face 0: too few values"),
        ("4 0 1 2 3", "2 0 1", "face 0: 2 corners, at least 3 are needed"),
        ("4 0 1 2 3", "0", "face 0: 0 corners, at least 3 are needed"),
    ];
    for (old, new, message) in mistakes {
        assert!(ascii().contains(old), "{old}");
        let found = error(ascii().replacen(old, new, 1).as_bytes());
        assert!(found.starts_with(message), "`{new}` gave: {found}");
    }
    assert_eq!(error(b""), "line 1: the header has no `end_header`");
    assert_eq!(error(b"ply\n\xff\xff\n"), "line 2: the header is not text");
    let mut text = ascii().into_bytes();
    text.extend(b"\xff");
    assert_eq!(error(&text), "line 15: more data than the header says");
}

#[test]
fn binary_mistakes_name_the_element() {
    let whole = binary(false);
    assert_eq!(error(&whole[..whole.len() - 1]), "face 0: the file ends here");
    let mut longer = whole.clone();
    longer.push(0);
    assert_eq!(error(&longer), "after the last element: more data than the header says");

    let body = whole.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let mut infinite = whole.clone();
    infinite[body + 4..body + 12].copy_from_slice(&f64::INFINITY.to_le_bytes());
    assert_eq!(error(&infinite), "vertex 0: `y` is inf, not a finite float");
    let mut normal = whole.clone();
    normal[body + 16..body + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(error(&normal), "vertex 0: `nx` is NaN, not a finite float");
    let mut index = whole.clone();
    let last = index.len() - 4;
    index[last..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(error(&index), "face 0: corner 3 is vertex 4294967295, of 4");
    // Every truncation is an error, and none is a panic.
    for end in 0..whole.len() {
        read("mesh.ply", &whole[..end]).unwrap_err();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn mutations_never_panic(
        kind in 0..3,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = match kind {
            0 => ascii().into_bytes(),
            other => binary(other == 2),
        };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Ok(mesh) = read("mesh.ply", &bytes) {
            prop_assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
            prop_assert!(mesh.vertices.iter().flat_map(|v| v.position).all(f32::is_finite));
        }
    }
}

#[test]
fn the_path_must_be_a_file() {
    assert!(import::import(Path::new("/")).is_err());
}
