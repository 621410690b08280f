//! PDB and mmCIF files: what they become, and that nothing in them is trusted.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glam::Vec3;
use oit_scene::import::import_structure;
use oit_scene::{Coloring, ImportError, Spheres, Splitting, StructureOptions, list, load};
use proptest::prelude::*;

const WHOLE: StructureOptions =
    StructureOptions { colors: Coloring::Element, objects: Splitting::Whole, rgba: [255; 4] };

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn helix() -> String {
    std::fs::read_to_string(scenes().join("helix.pdb")).unwrap()
}

/// The helix as mmCIF: every field of its atoms, as the PDB file has them.
fn helix_cif() -> String {
    let mut text = String::from(
        "data_HELIX\n#\nloop_\n_atom_site.group_PDB\n_atom_site.id\n_atom_site.type_symbol\n\
         _atom_site.label_atom_id\n_atom_site.label_alt_id\n_atom_site.auth_asym_id\n\
         _atom_site.auth_seq_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
         _atom_site.pdbx_PDB_model_num\n",
    );
    for line in helix().lines().filter(|line| line.starts_with("ATOM")) {
        let field = |columns: std::ops::Range<usize>| line[columns].trim();
        let fields = [
            "ATOM",
            field(6..11),
            field(76..78),
            field(12..16),
            ".",
            field(21..22),
            field(22..26),
            field(30..38),
            field(38..46),
            field(46..54),
            "1",
        ];
        text += &fields.join(" ");
        text.push('\n');
    }
    text + "#\n"
}

fn imported(name: &str, bytes: &[u8], options: &StructureOptions) -> Result<Spheres, ImportError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    import_structure(&path, options)
}

#[test]
fn all_formats_are_the_same_structure() {
    let pdb = imported("helix.pdb", helix().as_bytes(), &WHOLE).unwrap();
    let atoms = helix().lines().filter(|line| line.starts_with("ATOM")).count();
    assert_eq!((pdb.total(), pdb.objects.len(), pdb.kinds.len()), (atoms as u64, 1, 1));
    assert!(pdb.kinds[0].levels > 1);
    assert_eq!(pdb.kinds[0].name, "helix");
    assert_eq!(imported("helix.cif", helix_cif().as_bytes(), &WHOLE).unwrap(), pdb);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(helix().as_bytes()).unwrap();
    let unpacked = imported("HELIX.ENT.gz", &packed.finish().unwrap(), &WHOLE).unwrap();
    assert_eq!((&unpacked.atoms, &unpacked.objects), (&pdb.atoms, &pdb.objects));
    let error = imported("helix.xyz", helix().as_bytes(), &WHOLE).unwrap_err().to_string();
    assert!(error.contains("known endings: .pdb"), "{error}");
}

#[test]
fn atoms_are_where_and_what_the_file_says() {
    let options = StructureOptions { rgba: [255, 128, 255, 51], ..WHOLE };
    let spheres = imported("helix.pdb", helix().as_bytes(), &options).unwrap();
    let object = &spheres.objects[0];
    assert_eq!(object.rgba, [255, 128, 255, 51]);
    for (i, line) in helix().lines().filter(|line| line.starts_with("ATOM")).enumerate() {
        let at = [30..38, 38..46, 46..54].map(|columns| line[columns].trim().parse().unwrap());
        let (center, radius) = spheres.placed(object, &spheres.atoms[i]);
        assert!(center.distance(Vec3::from(at)) < 1e-4, "{line}");
        let (wanted, rgba) = match line[76..78].trim() {
            "C" => (1.70, [71, 71, 71, 255]),
            "N" => (1.55, [8, 20, 239, 255]),
            "O" => (1.52, [255, 1, 1, 255]),
            "S" => (1.80, [255, 255, 8, 255]),
            other => panic!("{other}"),
        };
        assert_eq!((radius, spheres.atom_rgba[i]), (wanted, rgba), "{line}");
    }
}

#[test]
fn chains_are_objects_and_colours() {
    let options = StructureOptions { colors: Coloring::Chain, objects: Splitting::Chain, ..WHOLE };
    let spheres = imported("helix.cif", helix_cif().as_bytes(), &options).unwrap();
    let names: Vec<_> = spheres.kinds.iter().map(|kind| kind.name.as_str()).collect();
    assert_eq!(names, ["chain A", "chain B"]);
    assert_eq!(spheres.objects.len(), 2);
    for object in &spheres.objects {
        // The chains lie beside one another.
        assert!((object.position[0].abs() - 6.0).abs() < 1.0, "{object:?}");
        let levels = &spheres.kinds[object.kind as usize];
        let first = spheres.levels[levels.first_level as usize];
        let colors = &spheres.atom_rgba[first.first_atom as usize..][..first.atoms as usize];
        assert!(colors.iter().all(|rgba| *rgba == colors[0]));
    }
    assert_ne!(spheres.atom_rgba.first(), spheres.atom_rgba.last());
}

#[test]
fn a_scene_names_a_structure() {
    let entry = list(&scenes()).unwrap().into_iter().find(|e| e.name == "helix").unwrap();
    assert!(entry.spheres);
    let scene = load(&entry.path, &BTreeMap::new()).unwrap();
    assert!(scene.mesh.indices.is_empty());
    assert_eq!(scene.spheres.unwrap().objects.len(), 2);

    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.toml");
    let good = std::fs::read_to_string(&entry.path).unwrap();
    std::fs::create_dir(dir.path().join("scenes")).unwrap();
    std::fs::write(dir.path().join("scenes/helix.pdb"), helix()).unwrap();
    let with = |old: &str, new: &str| {
        assert!(good.contains(old), "{old}");
        std::fs::write(&path, good.replacen(old, new, 1)).unwrap();
        load(&path, &BTreeMap::new()).map_err(|error| error.to_string())
    };
    let line = 1 + good[..good.find("[spheres]").unwrap()].matches('\n').count();
    for (old, new, message) in [
        (
            "\"element\"",
            "\"elemant\"",
            format!(":{}: unknown key `elemant`, the nearest valid: `element`", line + 2),
        ),
        ("import = \"scenes/helix.pdb\"", "", format!(":{line}: `spheres` needs either")),
        (
            "import = \"scenes/helix.pdb\"",
            "generator = \"virus\"",
            format!(":{line}: `colors`, `objects` and `rgba` go with `import` only"),
        ),
        (
            "rgba = [",
            "parameters.count = 1\nrgba = [",
            ": `parameters` go with `generator` only".to_owned(),
        ),
        (
            "[spheres]",
            "[mesh]\ngenerator = \"stack\"\n\n[spheres]",
            "either `mesh` or `spheres`, not both".to_owned(),
        ),
        ("helix.pdb", "helixx.pdb", "the asset scenes/helixx.pdb is missing".to_owned()),
    ] {
        let error = with(old, new).unwrap_err();
        assert!(error.contains(&message), "{new}: {error}");
    }
    let (before, after) = good.split_once("[spheres]").unwrap();
    let (_, views) = after.split_once("\n\n").unwrap();
    std::fs::write(&path, format!("{before}{views}")).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.contains(":1: a scene needs either `mesh` or `spheres`"), "{error}");
    let unknown = format!("{before}[spheres]\ngenerator = \"vyrus\"\n\n{views}");
    std::fs::write(&path, unknown).unwrap();
    let error = load(&path, &BTreeMap::new()).unwrap_err().to_string();
    assert!(error.contains("unknown generator `vyrus`, the nearest valid: `virus`"), "{error}");

    // The structure's own mistakes name its file, line and field.
    let broken = helix().replacen(" GLY A   1      ", " GLY A   1     x", 1);
    std::fs::write(dir.path().join("scenes/helix.pdb"), broken).unwrap();
    let error = with("rgba", "rgba").unwrap_err();
    let message = "helix.pdb: line 4, field `x` (columns 31 to 38): `x";
    assert!(error.contains(message) && error.ends_with("is not a number"), "{error}");
}

#[test]
fn files_without_atoms_are_refused() {
    for (name, text, message) in [
        ("x.pdb", "", "file: no atoms"),
        ("x.pdb", "HEADER\nEND\nATOM", "file: no atoms"),
        ("x.cif", "", "file: no loop of `_atom_site`"),
        (
            "x.cif",
            "loop_ _atom_site.type_symbol _atom_site.Cartn_x _atom_site.Cartn_y _atom_site.Cartn_z",
            "file: no atoms",
        ),
        ("x.cif", "loop_", "file: no loop of `_atom_site`"),
    ] {
        assert_eq!(imported(name, text.as_bytes(), &WHOLE).unwrap_err().to_string(), message);
    }
    let tags: String = (0..2000).map(|i| format!("_atom_site.t{i}\n")).collect();
    let error = imported("x.cif", format!("loop_\n{tags}").as_bytes(), &WHOLE).unwrap_err();
    assert!(error.to_string().contains("more than 1024 fields"), "{error}");
    let chains: String = (0..70_000).map(|i| format!("C 1 2 3 c{i}\n")).collect();
    let loop_of = "loop_ _atom_site.type_symbol _atom_site.Cartn_x _atom_site.Cartn_y \
                   _atom_site.Cartn_z _atom_site.auth_asym_id\n";
    let error = imported("x.cif", format!("{loop_of}{chains}").as_bytes(), &WHOLE).unwrap_err();
    assert!(error.to_string().contains("more than 65536 chains"), "{error}");
}

/// What a reader said of a file that may be damaged: no panic, and if it is refused, the line or the file.
fn judge(name: &str, bytes: &[u8]) {
    let options = StructureOptions { objects: Splitting::Chain, ..WHOLE };
    match imported(name, bytes, &options) {
        Ok(spheres) => {
            assert!(spheres.total() > 0);
            assert!(spheres.atoms.iter().all(|atom| {
                Vec3::from(atom.center).is_finite() && atom.radius > 0.0 && atom.radius.is_finite()
            }));
            assert!(spheres.levels.iter().all(|level| level.from_distance.is_finite()));
        }
        Err(ImportError::Invalid { place, .. }) => {
            assert!(place.starts_with("line ") || place == "file", "{place}");
        }
        Err(error) => panic!("{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn any_bytes_are_judged(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        judge("x.pdb", &bytes);
        judge("x.cif", &bytes);
        judge("x.cif", &[b"loop_ _atom_site.Cartn_x _atom_site.Cartn_y _atom_site.Cartn_z \
            _atom_site.type_symbol\n", &bytes[..]].concat());
        judge("x.pdb", &[b"ATOM  ", &bytes[..]].concat());
    }

    #[test]
    fn a_damaged_file_is_judged(
        cut in 0usize..15_000,
        changes in prop::collection::vec((0usize..15_000, any::<u8>()), 0..12),
    ) {
        for (name, mut bytes) in [("x.pdb", helix().into_bytes()), ("x.cif", helix_cif().into_bytes())] {
            for &(at, byte) in &changes {
                let length = bytes.len();
                bytes[at % length] = byte;
            }
            bytes.truncate(cut % bytes.len());
            judge(name, &bytes);
        }
    }

    #[test]
    fn any_coordinate_is_read_or_refused(text in "[-+0-9.eEnNaAiIfF]{1,8}") {
        let line = format!("ATOM      1  N   ALA A   1    {text:>8}   6.134  -6.504  1.00  0.00           N");
        judge("x.pdb", line.as_bytes());
    }
}
