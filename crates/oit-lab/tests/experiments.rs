//! Experiment files: what they expand to, and what is said of a mistake in one.

use std::path::Path;

use oit_lab::{Experiment, ProfileName, list_experiments};

const HEAD: &str = r#"about = "a test"
source = "a test"
[profile.quick]
resolution = [64, 32]
samples = 2
warmup_ms = 0
timeout_s = 9
[profile.full]
resolution = [1920, 1080]
samples = 20
warmup_ms = 500
timeout_s = 9
"#;

fn scenes() -> Vec<oit_scene::SceneEntry> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    oit_scene::list(Path::new(folder)).expect("the scenes of this repository")
}

fn cells(sweeps: &str) -> Result<Vec<String>, String> {
    let text = format!("{HEAD}{sweeps}");
    let experiment = Experiment::parse(Path::new("x.toml"), text).map_err(|e| e.to_string())?;
    let cells = experiment.cells(ProfileName::Quick, &scenes()).map_err(|e| e.to_string())?;
    Ok(cells.iter().map(|c| format!("{} {}", c.cell.technique, c.cell.group())).collect())
}

#[test]
fn axes_multiply_and_repeated_cells_are_one() {
    let cells = cells(
        r#"
[[sweep]]
techniques = ["BASE-IS"]
sorts = ["insertion", "rbs"]
stages = ["compute"]
max_frags = ["peak", 8]
views = ["planes:front", "stack"]
[[sweep]]
sorts = ["insertion"]
stages = ["compute"]
views = ["planes:front"]
scene = { alpha = 0.25 }
[[sweep]]
sorts = ["insertion"]
stages = ["compute"]
views = ["planes:front"]
"#,
    )
    .expect("a good experiment");
    let expected = [
        "linked_list/base/insertion/fragment/peak/ties-depth planes:front@64x32",
        "linked_list/base/insertion/compute/peak planes:front@64x32",
        "linked_list/base/insertion/compute/max8 planes:front@64x32",
        "linked_list/base/rbs/compute/peak planes:front@64x32",
        "linked_list/base/rbs/compute/max8 planes:front@64x32",
    ];
    assert_eq!(cells[..5], expected);
    assert_eq!(cells.len(), 16);
    assert_eq!(cells[15], "linked_list/base/insertion/compute/peak planes{alpha=0.25}:front@64x32");
}

#[test]
fn several_scene_parameters_are_several_scenes() {
    let cells = cells(
        r#"
[[sweep]]
sorts = ["insertion"]
stages = ["fragment"]
schedules = ["base", "base-stencil"]
pools = [25, "50-drop"]
views = ["planes:front"]
scene = [{ alpha = 0.25 }, { alpha = 0.5 }]
"#,
    )
    .expect("a good experiment");
    let expected = [
        "linked_list/base/insertion/fragment/peak/pool25 planes{alpha=0.25}:front@64x32",
        "linked_list/base/insertion/fragment/peak/pool50-drop planes{alpha=0.25}:front@64x32",
        "linked_list/base-stencil/insertion/fragment/peak/pool25 planes{alpha=0.25}:front@64x32",
        "linked_list/base-stencil/insertion/fragment/peak/pool50-drop planes{alpha=0.25}:front@64x32",
    ];
    assert_eq!(cells[..4], expected);
    assert_eq!(cells.len(), 8);
    assert!(cells[4].contains("planes{alpha=0.5}"), "{}", cells[4]);
}

#[test]
fn intervals_are_an_axis_of_schedules_that_have_them() {
    let cells = cells(
        r#"
[[sweep]]
sorts = ["auto"]
stages = ["compute"]
schedules = ["all"]
intervals = ["powers-of-two", [4, 12, 40], "optimal"]
views = ["planes:front"]
[[sweep]]
profiles = ["full"]
sorts = ["rbs"]
views = ["planes:front"]
"#,
    )
    .expect("a good experiment");
    let expected = [
        "linked_list/base/auto/compute/peak planes:front@64x32",
        "linked_list/bma-list/auto/compute/peak planes:front@64x32",
        "linked_list/bma-list/auto/compute/peak/intervals4-12-40 planes:front@64x32",
        "linked_list/bma-list/auto/compute/peak/intervals-optimal planes:front@64x32",
        "linked_list/base-intervals/auto/compute/peak planes:front@64x32",
        "linked_list/base-intervals/auto/compute/peak/intervals4-12-40 planes:front@64x32",
        "linked_list/base-intervals/auto/compute/peak/intervals-optimal planes:front@64x32",
    ];
    assert_eq!(cells, expected);
}

#[test]
fn methods_stand_beside_the_axes() {
    let cells = cells(
        r#"
[[sweep]]
techniques = ["BASE-IS", "hybrid/k4"]
methods = ["dual_peel", "dual_peel/passes4"]
sorts = ["insertion"]
stages = ["compute"]
max_frags = [8, 16]
views = ["planes:front"]
[[sweep]]
methods = ["all"]
views = ["planes:back"]
"#,
    )
    .expect("a good experiment");
    let expected = [
        "linked_list/base/insertion/fragment/peak/ties-depth planes:front@64x32",
        "hybrid/k4 planes:front@64x32",
        "dual_peel planes:front@64x32",
        "dual_peel/passes4 planes:front@64x32",
        "linked_list/base/insertion/compute/max8 planes:front@64x32",
        "linked_list/base/insertion/compute/max16 planes:front@64x32",
    ];
    assert_eq!(cells[..6], expected);
    let all = cells[6..].iter().map(|cell| cell.split_once(' ').expect("a technique").0);
    assert!(all.eq(oit_lab::methods().map(oit_capture::Method::name)));
}

#[test]
fn a_mistake_is_named_with_its_line_and_the_nearest_words() {
    let error = |sweep: &str| cells(sweep).expect_err("a mistake");
    let cases = [
        ("[[sweep]]\nsorts = [\"insertoin\"]\nviews = [\"planes\"]\n", "x.toml:14", "insertion"),
        ("[[sweep]]\nsorts = [\"rs\"]\nviews = [\"plains:front\"]\n", "x.toml:15", "planes"),
        ("[[sweep]]\nsorts = [\"rs\"]\nviews = [\"planes:frnt\"]\n", "x.toml:15", "front"),
        ("[[sweep]]\nsort = [\"rs\"]\nviews = [\"planes\"]\n", "x.toml:14", "sorts"),
        ("[[sweep]]\nsorts = [\"rs\"]\nmax_frags = [\"pick\"]\nviews = []\n", "x.toml:15", "peak"),
        (
            "[[sweep]]\nsorts = [\"rs\"]\nstages = [\"vertex\"]\nviews = []\n",
            "x.toml:15",
            "compute",
        ),
        ("[[sweep]]\ntechniques = [\"BMA-RBS\"]\nviews = []\n", "x.toml:14", "BMA-RBS"),
        ("[[sweep]]\nsorts = [\"rs\"]\npools = [\"0-drop\"]\nviews = []\n", "x.toml:15", "0-drop"),
        (
            "[[sweep]]\nsorts = [\"rs\"]\nschedules = [\"base-stencil\"]\nviews = []\n",
            "x.toml:15",
            "fragment stage",
        ),
        ("[[sweep]]\nstages = [\"compute\"]\nviews = []\n", "x.toml:14", "sorts"),
        (
            "[[sweep]]\nsorts = [\"rs\"]\nschedules = [\"bma\"]\nintervals = [[8, 4]]\nviews = []\n",
            "x.toml:16",
            "8-4",
        ),
        (
            "[[sweep]]\nsorts = [\"rs\"]\nintervals = [\"optimal\"]\nviews = []\n",
            "x.toml:15",
            "base has one program",
        ),
        ("[[sweep]]\nmethods = [\"dual_pel\"]\nviews = []\n", "x.toml:14", "dual_peel"),
        (
            "[[sweep]]\nmethods = [\"all\", \"hybrid/k0\"]\nviews = []\n",
            "x.toml:14",
            "N from 1 to 256",
        ),
        (
            "[[sweep]]\nmethods = [\"all\"]\nstages = [\"compute\"]\nviews = []\n",
            "x.toml:15",
            "sorts",
        ),
        ("[[sweep]]\nprofiles = [\"fast\"]\nviews = []\n", "x.toml:14", "quick"),
    ];
    for (sweep, line, word) in cases {
        let text = error(sweep);
        assert!(text.contains(line) && text.contains(word), "{sweep}\n{text}");
    }
    // A scene parameter of a profile must belong to a scene there is.
    let text = HEAD.replace("[profile.full]", "scene.plains = { alpha = 1.0 }\n[profile.full]");
    let experiment = Experiment::parse(Path::new("x.toml"), text + "[[sweep]]\nviews = []\n");
    let error = experiment.expect("well formed").cells(ProfileName::Quick, &scenes());
    let error = error.expect_err("no such scene").to_string();
    assert!(error.contains("x.toml:8") && error.contains("planes"), "{error}");
}

#[test]
fn a_frame_is_repeated_as_often_as_is_sensible() {
    let parse = |repeats: i64| {
        let text =
            HEAD.replacen("samples = 2\n", &format!("samples = 2\nrepeats = {repeats}\n"), 1);
        Experiment::parse(Path::new("x.toml"), text + "[[sweep]]\nviews = []\n")
    };
    let repeats = |name| parse(20).expect("a good experiment").profile(name).repeats;
    assert_eq!((repeats(ProfileName::Quick), repeats(ProfileName::Full)), (Some(20), None));
    for wrong in [0, 1001, -1] {
        parse(wrong).expect_err("it is refused");
    }
}

#[test]
fn every_experiment_of_the_repository_expands_in_both_profiles() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
    let experiments = list_experiments(Path::new(folder)).expect("they load");
    assert!(!experiments.is_empty());
    for experiment in experiments {
        for profile in [ProfileName::Quick, ProfileName::Full] {
            let cells = experiment.cells(profile, &scenes());
            let cells = cells.unwrap_or_else(|error| panic!("{}: {error}", experiment.name));
            assert!(!cells.is_empty(), "{}", experiment.name);
        }
    }
}

#[test]
fn a_path_stands_for_its_frames() {
    let planned = |views: &str, path: &str| {
        let head = HEAD.replacen("timeout_s = 9\n", &format!("timeout_s = 9\n{path}\n"), 1);
        let sweep = format!("[[sweep]]\ntechniques = [\"BASE-IS\"]\nviews = [\"{views}\"]\n");
        let experiment = Experiment::parse(Path::new("x.toml"), head + &sweep)?;
        experiment.cells(ProfileName::Quick, &scenes())
    };
    let cells = planned("atrium:flythrough@*", "").expect("frames");
    assert_eq!(cells.len(), 300);
    assert!(cells.iter().all(|cell| cell.in_full));
    assert_eq!(cells[299].cell.view, "flythrough@299");
    assert_eq!(cells[7].camera_path.as_deref(), Some("flythrough"));

    let path = "path = { frames = 6, full_every = 3 }";
    for views in ["atrium:flythrough@*", "atrium:flythrough@*/6", "atrium:flythrough@*/100"] {
        let cells = planned(views, path).expect("frames");
        let frames: Vec<&str> = cells.iter().map(|cell| &*cell.cell.view).collect();
        let expected = [0, 50, 100, 150, 200, 250].map(|frame| format!("flythrough@{frame}"));
        assert_eq!(frames, expected);
        let in_full: Vec<bool> = cells.iter().map(|cell| cell.in_full).collect();
        assert_eq!(in_full, [true, false, false, true, false, false]);
    }
    let cells = planned("atrium:flythrough@*/4", path).expect("frames");
    assert_eq!(cells[1].cell.view, "flythrough@75");
    let one = planned("atrium:flythrough@120", path).expect("a frame");
    assert_eq!((one.len(), one[0].in_full), (1, true));
    // A scene's views are without its frames.
    assert!(planned("atrium", "").expect("views").iter().all(|cell| cell.camera_path.is_none()));

    for (views, path, message) in [
        ("atrium:flythrough@300", "", "path `flythrough` has the frames 0 to 299, not 300"),
        ("atrium:flythrough@*/0", "", "after `flythrough@*` comes nothing, or `/` and a number"),
        ("atrium:flythrough@*/x", "", "after `flythrough@*` comes nothing, or `/` and a number"),
        (
            "atrium:flythrough@07",
            "",
            "unknown view `flythrough@07`, the nearest valid: `flythrough@*`",
        ),
        ("atrium:flythrough@*", "path = { frames = 0 }", "`path.frames` and `path.full_every` are"),
        ("planes:fly@*", "", "unknown view `fly@*`"),
    ] {
        let error = planned(views, path).expect_err(views).to_string();
        assert!(error.contains(message), "{error}");
    }
}
