//! Tuning: from runs to files, and from files to techniques. No number here was measured.

mod support;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_fragments::DepthHistogram;
use oit_lab::{CellError, FrameSize, Technique, Tuner, Tuning, open_engine, tune, tuning_path};
use oit_record::{
    Cell, DeviceInfo, Event, Host, Record, Run, SCHEMA_VERSION, Verdict, Verification,
};

const SIZE: FrameSize = FrameSize { width_px: 100, height_px: 10 };

fn device() -> DeviceInfo {
    DeviceInfo { name: "Test 1".into(), backend: "vulkan".into(), ..DeviceInfo::default() }
}

fn exact() -> Verification {
    let json = r#"{"verdict":"exact","wrong_px":0,"max_error":0,"rmse":0,"max_alpha_error":0,
        "fragments_missing":0,"fragments_extra":0,"max_frags":8,"pool_initial":1,"pool_final":1,
        "pool_grown":0,"memory_bytes":0,"prepare_ms":0}"#;
    serde_json::from_str(json).expect("a verification as older records have it")
}

/// A run of techniques on stacks: depth, technique, nanoseconds of the resolve and of grouping. The
/// stacks cover 100 pixels.
fn record(cells: &[(u32, &str, u64, u64)]) -> Record {
    let cell = |&(depth, technique, ..): &(u32, &str, u64, u64)| Cell {
        technique: technique.into(),
        scene: format!("stack{{count={depth}}}"),
        view: "front".into(),
        width_px: SIZE.width_px,
        height_px: SIZE.height_px,
    };
    let run = Run {
        schema: SCHEMA_VERSION,
        experiment: "a-test".into(),
        experiment_toml: String::new(),
        profile: "full".into(),
        device: device(),
        host: Host::default(),
        oit_version: String::new(),
        git_commit: Some("abc".into()),
        git_dirty: Some(true),
        command: Vec::new(),
        seed: 1,
        started: "2026-01-01T00:00:00Z".into(),
        cells: cells.iter().map(cell).collect(),
    };
    let mut events = Vec::new();
    for (place, &(depth, _, resolve, group)) in cells.iter().enumerate() {
        let mut histogram = vec![0; depth as usize + 1];
        (histogram[0], histogram[depth as usize]) = (900, 100);
        let name = run.cells[place].group();
        events.push(Event::Counted { group: name, triangles: 1, spheres: None, histogram });
        events.push(Event::Verified { cell: place, result: exact() });
        let stages = [("resolve", resolve), ("group", group), ("capture", 7)];
        let stages_ns = stages.map(|(stage, ns)| (stage.to_owned(), ns)).into();
        events.push(Event::Sample {
            cell: place,
            sample: 0,
            stages_ns,
            parts_ns: BTreeMap::new(),
            total_ns: 1,
        });
    }
    events.push(Event::Finished { wall_s: 1.0 });
    Record { folder: PathBuf::from("a-run"), run, events }
}

/// Costs that rise with the size of the array, and an interval of 50 ns.
fn costs() -> Vec<(u32, &'static str, u64, u64)> {
    vec![
        (1, "linked_list/bma-list/insertion/compute/max1/intervals4096", 100, 600),
        (8, "linked_list/bma-list/insertion/compute/max8/intervals4096", 800, 600),
        (8, "linked_list/bma-list/insertion/compute/max10/intervals8-9-10", 850, 650),
        (1, "linked_list/bma-list/insertion/compute/max32/intervals4096", 3000, 600),
        (32, "linked_list/bma-list/insertion/compute/max32/intervals4096", 3200, 600),
    ]
}

fn fastest() -> Vec<(u32, &'static str, u64, u64)> {
    vec![
        (8, "linked_list/bma-list/insertion/compute/peak", 700, 600),
        (8, "linked_list/bma-list/merge/compute/peak", 800, 600),
        (16, "linked_list/bma-list/insertion/compute/peak", 1700, 600),
        (16, "linked_list/bma-list/rs/compute/peak", 1600, 600),
        (32, "linked_list/bma-list/insertion/compute/peak", 3700, 600),
        (32, "linked_list/bma-list/rs/compute/peak", 3600, 600),
        // Not as full as its array, and of two strategies: neither counts.
        (24, "linked_list/bma-list/merge/compute/peak", 1, 600),
        (32, "linked_list/bma-list/merge@8+rbs/compute/peak", 1, 600),
    ]
}

/// A tuner by such runs, through a file.
fn tuner(folder: &Path, cells: Vec<(u32, &str, u64, u64)>) -> Tuner {
    let tuning = tune(&[record(&cells)]).expect("a tuning").remove(0);
    std::fs::write(tuning_path(folder, "Test 1", "vulkan"), tuning.text()).expect("written");
    Tuner::open(folder, &device())
}

fn choose(tuner: &Tuner, name: &str, counts: &[u32]) -> Result<String, String> {
    let technique: Technique = name.parse().expect("a technique");
    let histogram = DepthHistogram::from_counts(counts.iter().copied());
    match tuner.choose(&technique, &histogram, SIZE) {
        Ok(technique) => Ok(technique.to_string()),
        Err(CellError::Unsupported(reason)) => Err(reason),
        Err(CellError::Failed(reason)) => panic!("{reason}"),
    }
}

#[test]
fn runs_say_what_is_fastest_and_what_it_costs() {
    let cells: Vec<_> = costs().into_iter().chain(fastest()).collect();
    let tunings = tune(&[record(&cells)]).expect("a tuning");
    let [tuning] = tunings.as_slice() else { panic!("one device: {tunings:?}") };
    let sizes =
        vec![(8, "insertion".into(), 7.0), (16, "rs".into(), 16.0), (32, "rs".into(), 36.0)];
    assert_eq!(tuning.fastest.len(), 1);
    assert_eq!(tuning.fastest[0].sizes, sizes);
    assert_eq!(tuning.pixels.len(), 1);
    let points = [(1, 1, 1.0), (8, 8, 8.0), (32, 1, 30.0), (32, 32, 32.0)];
    assert_eq!(tuning.pixels[0].points, points);
    assert_eq!(tuning.intervals.len(), 1);
    // Two intervals more took 100 ns more.
    let interval = &tuning.intervals[0];
    assert_eq!((interval.interval_ns, interval.grouping_ns), (50.0, 550.0));
    assert_eq!((interval.frame_px, interval.schedule.as_str()), (1000, "bma-list"));
    let run = &interval.run;
    assert_eq!((run.experiment.as_str(), run.commit.as_str()), ("a-test", "abc+"));
    let read = Tuning::parse(Path::new("x.toml"), &tuning.text()).expect("it reads back");
    assert_eq!(read, *tuning);
}

#[test]
fn cells_that_are_not_exact_say_nothing() {
    let mut record = record(&fastest());
    for event in &mut record.events {
        if let Event::Verified { cell: 1 | 3 | 5, result } = event {
            result.verdict = Verdict::Wrong;
        }
    }
    let tuning = tune(std::slice::from_ref(&record)).expect("a tuning").remove(0);
    let sorts: Vec<&str> = tuning.fastest[0].sizes.iter().map(|(_, sort, _)| &**sort).collect();
    assert_eq!(sorts, ["insertion"; 3]);
    record.events.retain(|event| !matches!(event, Event::Verified { .. }));
    assert!(
        tune(std::slice::from_ref(&record)).expect_err("nothing").to_string().contains("exact")
    );
    record.events.pop();
    assert!(tune(&[record]).expect_err("unfinished").to_string().contains("a-run"));
}

#[test]
fn auto_is_the_fastest_of_the_next_larger_array() {
    let folder = tempfile::tempdir().expect("a folder");
    let tuner = tuner(folder.path(), fastest());
    let name = "linked_list/bma-list/auto/compute/peak";
    // rs holds 32, which need not be said.
    assert_eq!(
        choose(&tuner, name, &[30]),
        Ok("linked_list/bma-list/insertion@8+rs/compute/peak".into())
    );
    let bounds = format!("{name}/intervals9-20");
    assert_eq!(
        choose(&tuner, &bounds, &[20]),
        Ok("linked_list/bma-list/insertion@8+rs/compute/peak/intervals9-20".into())
    );
    let reason = choose(&tuner, name, &[33]).expect_err("64 was not measured");
    assert!(reason.contains("oit tune") && reason.contains("64 fragments"), "{reason}");
    for other in ["linearized/bma-list/auto/compute/peak", "linked_list/base/auto/fragment/peak"] {
        let reason = choose(&tuner, other, &[8]).expect_err("not measured");
        assert!(reason.contains("oit tune") && reason.contains("Test 1 (vulkan)"), "{reason}");
    }
}

#[test]
fn optimal_intervals_are_those_of_the_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let tuner = tuner(folder.path(), costs());
    let name = "linked_list/bma-list/insertion/compute/peak";
    let optimal = format!("{name}/intervals-optimal");
    // Few pixels are not worth an interval, many are.
    assert_eq!(choose(&tuner, &optimal, &[1, 32]), Ok(format!("{name}/intervals32")));
    let many = [[1; 90], [32; 90]].concat();
    assert_eq!(choose(&tuner, &optimal, &many), Ok(format!("{name}/intervals1-32")));
    // Deeper pixels than the array holds cost what full ones do.
    let truncated = optimal.replace("peak", "max16");
    let found = choose(&tuner, &truncated, &many).expect("supported");
    assert!(found.ends_with("max16/intervals1-16"), "{found}");

    let technique: Technique = format!("{name}/intervals1-32").parse().expect("a technique");
    let histogram = DepthHistogram::from_counts(many.iter().copied());
    let ns = tuner.predicted_ns(&technique, &histogram, SIZE);
    assert_eq!(ns, Some(550.0 + 2.0 * 50.0 + 90.0 + 90.0 * 32.0));
    // An array of 64 has no cost.
    let deep = DepthHistogram::from_counts([40]);
    let usual: Technique = name.parse().expect("a technique");
    assert_eq!(tuner.predicted_ns(&usual, &deep, SIZE), None);
    let reason = choose(&tuner, &optimal, &[40]).expect_err("deeper than measured");
    assert!(reason.contains("40 fragments") && reason.contains("up to 32"), "{reason}");
    let reason = choose(&tuner, &optimal.replace("insertion", "rbs"), &many);
    assert!(reason.as_ref().is_err_and(|reason| reason.contains("cost of rbs")), "{reason:?}");
}

#[test]
fn nothing_is_guessed_without_a_tuning() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = Tuner::open(folder.path(), &device());
    let names = ["bma-list/auto/compute/peak", "bma-list/rbs/compute/peak/intervals-optimal"];
    for name in names {
        let reason = choose(&none, &format!("linked_list/{name}"), &[8]).expect_err("no tuning");
        assert!(reason.contains("no tuning for Test 1 (vulkan)"), "{reason}");
        assert!(reason.contains("oit tune"), "{reason}");
    }
    // What leaves nothing open needs none.
    let name = "linked_list/bma-list/rbs/compute/peak/intervals4-12";
    assert_eq!(choose(&none, name, &[8]), Ok(name.into()));
    // Neither does a damaged file, nor one of another device.
    let path = tuning_path(folder.path(), "Test 1", "vulkan");
    for text in ["version = 7\n", "version = 1\ndevice = \"Test 2\"\nbackend = \"vulkan\"\n"] {
        std::fs::write(&path, text).expect("written");
        let tuner = Tuner::open(folder.path(), &device());
        assert_eq!(choose(&tuner, name, &[8]), Ok(name.into()));
        let reason = choose(&tuner, "linked_list/bma-list/auto/compute/peak", &[8]);
        let reason = reason.expect_err("no tuning");
        assert!(reason.contains("version 7") || reason.contains("Test 2"), "{reason}");
    }
}

#[test]
fn an_engine_refuses_what_was_not_chosen() {
    let cache = support::cache();
    let mut engine = open_engine("cpu", cache.path()).expect("the CPU");
    let lfb = oit_fragments::Lfb::from_lists(1, 1, &[Vec::new()]);
    engine.open_view(oit_lab::ViewData::stored(lfb)).expect("the view opens");
    for rest in ["auto/compute/peak", "rbs/compute/peak/intervals-optimal"] {
        let technique = format!("linked_list/bma-list/{rest}").parse().expect("a technique");
        let refused = engine.prepare(&technique);
        assert!(matches!(refused, Err(CellError::Unsupported(_))), "{rest}");
    }
    assert!(!support::gpus().contains(&"cpu".to_owned()));
}
