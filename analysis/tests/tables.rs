//! Tables of tiny synthetic records. No number here was measured.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use analysis::{AnalysisError, CompareError, RESOLVE, State, TOTAL, compare, load};
use oit_record::{
    Bandwidth, Cell, DeviceInfo, Event, Executable, Host, PassKind, PassWork, Program,
    RasterCounts, Record, Run, SCHEMA_VERSION, Statistic, StatisticValue, Verdict, Verification,
};
use polars::prelude::*;

fn cell(technique: &str) -> Cell {
    Cell {
        technique: technique.to_owned(),
        scene: "grid{layers=20}".to_owned(),
        view: "front".to_owned(),
        width_px: 4,
        height_px: 2,
    }
}

fn verified(cell: usize, verdict: Verdict) -> Event {
    let result = Verification {
        verdict,
        note: None,
        wrong_px: 0,
        max_error: 0.25,
        rmse: 0.125,
        max_alpha_error: 0.0,
        fragments_missing: 0,
        fragments_extra: 0,
        fragments_compared: true,
        tied_px: 0,
        max_frags: 32,
        pool_initial: 100,
        pool_final: 160,
        pool_grown: 1,
        memory_bytes: 4096,
        lfb_bytes: Some(2048),
        peak_bytes: Some(8192),
        repeat_differs_px: None,
        prepare_ms: 1.5,
        tuned: None,
        predicted_ns: None,
        ssim: None,
        flip: None,
        stability: None,
    };
    Event::Verified { cell, result }
}

fn sample(cell: usize, sample: u32, stages: &[(&str, u64)], total_ns: u64) -> Event {
    let stages_ns: BTreeMap<String, u64> =
        stages.iter().map(|&(stage, ns)| (stage.to_owned(), ns)).collect();
    let parts_ns = BTreeMap::new();
    Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }
}

fn record(folder: &str, techniques: &[&str], events: Vec<Event>) -> Record {
    Record {
        folder: PathBuf::from(folder),
        run: Run {
            schema: SCHEMA_VERSION,
            experiment: "synthetic".to_owned(),
            experiment_toml: String::new(),
            profile: "quick".to_owned(),
            device: DeviceInfo { name: "test device".to_owned(), ..DeviceInfo::default() },
            host: Host::default(),
            oit_version: "0.0.0".to_owned(),
            git_commit: Some("0123456789abcdef".to_owned()),
            git_dirty: Some(true),
            command: vec!["test".to_owned()],
            seed: 1,
            started: "2026-01-01T00:00:00Z".to_owned(),
            cells: techniques.iter().map(|technique| cell(technique)).collect(),
        },
        events,
    }
}

const RBS: &str = "linked_list/bma-list/rbs/compute/peak/ties-depth";
const INSERTION: &str = "linked_list/bma-list/insertion/compute/peak/ties-depth";

/// One exact cell with three samples: its group and resolve vary against each other.
fn three_samples() -> Vec<Event> {
    vec![
        Event::Counted {
            group: "grid{layers=20}:front@4x2".to_owned(),
            triangles: 2,
            spheres: None,
            histogram: vec![1, 0, 4, 3],
        },
        verified(0, Verdict::Exact),
        sample(0, 0, &[("capture", 5), ("group", 1), ("resolve", 10)], 1000),
        sample(0, 1, &[("capture", 6), ("group", 10), ("resolve", 1)], 20),
        sample(0, 2, &[("capture", 9), ("group", 5), ("resolve", 5)], 40),
        Event::Finished { wall_s: 1.0 },
    ]
}

/// The value of a column in the one row of a frame where other columns have given values.
fn value(frame: &DataFrame, stage: &str, name: &str) -> f64 {
    let stages = frame.column("stage").unwrap().str().unwrap();
    let row = stages.iter().position(|found| found == Some(stage)).unwrap();
    frame.column(name).unwrap().cast(&DataType::Float64).unwrap().f64().unwrap().get(row).unwrap()
}

#[test]
fn the_median_is_the_median() {
    let tables = load(&[record("a", &[RBS], three_samples())]).unwrap();
    // The mean is 353, the 95th percentile 904.
    assert_eq!(value(&tables.summary, TOTAL, "median_ns"), 40.0);
    assert_eq!(value(&tables.summary, "capture", "median_ns"), 6.0);
    assert_eq!(value(&tables.summary, TOTAL, "q1_ns"), 30.0);
    assert_eq!(value(&tables.summary, TOTAL, "n"), 3.0);

    let mut even = three_samples();
    even.insert(5, sample(0, 3, &[("capture", 0), ("group", 0), ("resolve", 0)], 60));
    let tables = load(&[record("a", &[RBS], even)]).unwrap();
    assert_eq!(value(&tables.summary, TOTAL, "median_ns"), 50.0);
}

#[test]
fn resolve_is_summed_sample_by_sample() {
    let tables = load(&[record("a", &[RBS], three_samples())]).unwrap();
    // Sums 11, 11, 10. The sum of the medians of group and resolve would be 10.
    assert_eq!(value(&tables.summary, RESOLVE, "median_ns"), 11.0);
    assert_eq!(tables.results[0].times[RESOLVE].samples_ns, [11, 11, 10]);
}

#[test]
fn samples_stay_integers_and_cells_come_apart() {
    let tables = load(&[record("a", &[RBS], three_samples())]).unwrap();
    assert_eq!(tables.samples.height(), 12);
    assert_eq!(tables.samples.column("ns").unwrap().dtype(), &DataType::UInt64);
    let text =
        |name: &str| tables.cells.column(name).unwrap().str().unwrap().get(0).unwrap().to_owned();
    assert_eq!(text("capture"), "linked_list");
    assert_eq!(text("schedule"), "bma-list");
    assert_eq!(text("ties"), "depth");
    assert_eq!(text("scene_name"), "grid");
    assert_eq!(text("state"), "charted");
    let whole = |name: &str| tables.cells.column(name).unwrap().u64().unwrap().get(0).unwrap();
    assert_eq!((whole("peak_depth"), whole("total_fragments")), (3, 17));
    assert_eq!((whole("memory_bytes"), whole("pool_final")), (4096, 160));
    assert_eq!((whole("lfb_bytes"), whole("peak_bytes")), (2048, 8192));
    // What a record lacks is missing, not zero.
    assert_eq!(tables.cells.column("repeat_differs_px").unwrap().null_count(), 1);
    assert_eq!((text("pool_percent"), text("pool_policy")), ("100".to_owned(), "grow".to_owned()));
}

#[test]
fn only_whole_and_right_cells_have_times() {
    let stages: &[(&str, u64)] = &[("resolve", 7)];
    let mut events = vec![
        verified(0, Verdict::Exact),
        verified(1, Verdict::Wrong),
        Event::Skipped { cell: 2, reason: "no subgroups".to_owned() },
        verified(3, Verdict::Exact),
        Event::Failed { cell: 3, reason: "device lost".to_owned() },
        verified(4, Verdict::Approximate),
        verified(5, Verdict::Exact),
    ];
    for cell in [0, 1, 3, 4] {
        events.push(sample(cell, 0, stages, 9));
        events.push(sample(cell, 1, stages, 9));
    }
    events.push(sample(5, 0, stages, 9));
    let techniques = ["a", "b", "c", "d", "e", "f", "g"];
    let tables = load(&[record("a", &techniques, events.clone())]).unwrap();
    let states: Vec<State> = tables.results.iter().map(|cell| cell.state).collect();
    let expected = [
        State::Charted,
        State::Wrong,
        State::Skipped,
        State::Failed,
        State::Charted,
        State::Incomplete,
        State::Unverified,
    ];
    assert_eq!(states, expected);
    for result in &tables.results {
        assert_eq!(result.times.is_empty(), result.state != State::Charted);
    }
    assert_eq!(tables.results[2].reason.as_deref(), Some("no subgroups"));
    // The wrong cell's samples are kept, its summary is not made.
    assert_eq!(tables.samples.height(), 2 * 9);
    assert_eq!(tables.summary.height(), 2 * 3);

    // In a finished run a cell with fewer samples has all that it was to have.
    events.push(Event::Finished { wall_s: 1.0 });
    let tables = load(&[record("a", &techniques, events)]).unwrap();
    assert_eq!(tables.results[5].state, State::Charted);
}

#[test]
fn a_run_that_was_ended_keeps_cells_with_most_of_their_samples() {
    let stages: &[(&str, u64)] = &[("resolve", 7)];
    let mut events: Vec<Event> = (0..4).map(|cell| verified(cell, Verdict::Exact)).collect();
    for (cell, samples) in [(0, 5), (1, 4), (2, 3), (3, 2)] {
        events.extend((0..samples).map(|number| sample(cell, number, stages, 9)));
    }
    let tables = load(&[record("a", &["a", "b", "c", "d"], events)]).unwrap();
    let states: Vec<State> = tables.results.iter().map(|cell| cell.state).collect();
    assert_eq!(states, [State::Charted, State::Charted, State::Charted, State::Incomplete]);
}

#[test]
fn the_rms_error_of_an_exact_picture_is_none() {
    let events = vec![verified(0, Verdict::Exact), verified(1, Verdict::Approximate)];
    let tables = load(&[record("a", &["a", "b"], events)]).unwrap();
    assert_eq!(tables.results[0].rmse(), Some(0.0));
    assert_eq!(tables.results[1].rmse(), Some(0.125));
}

#[test]
fn contradictions_are_refused() {
    let mut twice = three_samples();
    twice.push(sample(0, 1, &[("resolve", 1)], 1));
    let error = load(&[record("a", &[RBS], twice)]).unwrap_err();
    assert!(matches!(error, AnalysisError::SampleTwice { cell: 0, sample: 1, .. }), "{error}");
    let reserved = vec![sample(0, 0, &[(TOTAL, 1)], 1)];
    let error = load(&[record("a", &[RBS], reserved)]).unwrap_err();
    assert!(matches!(error, AnalysisError::ReservedStage { .. }), "{error}");
    let records = [record("a", &[RBS], three_samples()), record("a", &[RBS], three_samples())];
    assert!(matches!(load(&records).unwrap_err(), AnalysisError::RunTwice { .. }));
}

#[test]
fn runs_are_named_as_shortly_as_is_clear() {
    let named = |folders: &[&str]| -> Vec<String> {
        let records: Vec<Record> =
            folders.iter().map(|folder| record(folder, &[RBS], three_samples())).collect();
        load(&records).unwrap().runs.into_iter().map(|run| run.name).collect()
    };
    assert_eq!(named(&["x/first", "x/second"]), ["first", "second"]);
    assert_eq!(named(&["one/run", "two/run"]), ["one/run", "two/run"]);
}

/// A program with figures made up.
fn program(high: u32, registers: Option<u64>) -> Program {
    let statistic = |value| Statistic {
        name: "Register Count".to_owned(),
        description: "made up".to_owned(),
        value: StatisticValue::Unsigned(value),
    };
    let executable = |value| Executable {
        name: "main".to_owned(),
        stages: vec!["compute".to_owned()],
        subgroup_size: 32,
        statistics: vec![statistic(value)],
    };
    Program {
        sort: "rbs".to_owned(),
        store: "local".to_owned(),
        low: high / 2 + 1,
        high,
        invocations: Some(64),
        declared_workgroup_bytes: Some(0),
        compile_ns: Some(2_500_000),
        from_cache: None,
        executables: registers.map(|value| vec![executable(value)]),
    }
}

#[test]
fn programs_have_rows_of_their_own() {
    let mut events = three_samples();
    let told = vec![program(16, Some(40)), program(32, None)];
    events.insert(1, Event::Programs { cell: 0, programs: told });
    let several = load(&[record("a", &[RBS], events)]).unwrap();
    let column = |name: &str| several.programs.column(name).unwrap().clone();
    assert_eq!(several.programs.height(), 2);
    let registers: Vec<Option<u64>> = column("registers").u64().unwrap().iter().collect();
    assert_eq!(registers, [Some(40), None]);
    assert_eq!(column("low").u64().unwrap().get(1), Some(17));
    assert_eq!(column("compile_ms").f64().unwrap().get(0), Some(2.5));
    assert_eq!((column("local_bytes").null_count(), column("from_cache").null_count()), (2, 2));
    // The cell's time is that of both programs.
    assert_eq!(column("resolve_ns").null_count(), 2);
    assert_eq!(several.program_statistics.height(), 1);
    let value = several.program_statistics.column("value").unwrap().f64().unwrap().get(0);
    assert_eq!(value, Some(40.0));

    let mut events = three_samples();
    events.insert(1, Event::Programs { cell: 0, programs: vec![program(16, Some(40))] });
    let one = load(&[record("a", &[RBS], events)]).unwrap();
    let resolve = one.programs.column("resolve_ns").unwrap().f64().unwrap().get(0);
    assert_eq!(resolve, Some(11.0));
    // Records from before programs were recorded.
    let none = load(&[record("a", &[RBS], three_samples())]).unwrap();
    assert_eq!((none.programs.height(), none.program_statistics.height()), (0, 0));
}

#[test]
fn tables_are_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut tables = load(&[record("a", &[RBS], three_samples())]).unwrap();
    tables.write(folder.path()).unwrap();
    for (name, frame) in [
        ("samples", &tables.samples),
        ("cells", &tables.cells),
        ("summary", &tables.summary),
        ("programs", &tables.programs),
        ("program_statistics", &tables.program_statistics),
        ("work", &tables.work),
    ] {
        let file = File::open(folder.path().join(format!("{name}.parquet"))).unwrap();
        assert!(ParquetReader::new(file).finish().unwrap().equals_missing(frame), "{name}");
        let csv = std::fs::read_to_string(folder.path().join(format!("{name}.csv"))).unwrap();
        assert_eq!(csv.lines().count(), frame.height() + 1, "{name}");
    }
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    assert!(matches!(tables.write(Path::new(&file)), Err(AnalysisError::Write { .. })));
}

#[test]
fn cells_of_one_view_are_compared_by_their_intervals() {
    let mut events = vec![verified(0, Verdict::Exact), verified(1, Verdict::Exact)];
    for index in 0..10 {
        let ns = u64::from(index);
        events.push(sample(0, index, &[("resolve", 100 + ns)], 1000 + ns));
        events.push(sample(1, index, &[("group", 1), ("resolve", 210 - ns)], 1005 - ns));
    }
    let first = record("a", &[RBS, INSERTION], events.clone());
    let second = record("b", &[RBS, INSERTION], events);
    let tables = load(&[first, second]).unwrap();
    let (rbs, insertion) = (&tables.results[0], &tables.results[1]);
    let ratio = compare(rbs, insertion, RESOLVE).unwrap();
    assert_eq!(ratio.word(), "faster");
    assert!((ratio.ratio - 104.5 / 206.5).abs() < 1e-12);
    assert!(ratio.low <= ratio.ratio && ratio.ratio <= ratio.high);
    assert_eq!(compare(insertion, rbs, RESOLVE).unwrap().word(), "slower");
    assert_eq!(compare(rbs, insertion, TOTAL).unwrap().word(), "same");
    let other_run = &tables.results[3];
    assert!(matches!(compare(rbs, other_run, TOTAL), Err(CompareError::OtherGroup(..))));
    assert!(matches!(compare(rbs, insertion, "scan"), Err(CompareError::NoTime { .. })));
}

#[test]
fn passes_are_rows_with_what_their_run_measured() {
    let raster = PassWork {
        stage: "capture".to_owned(),
        label: "draw".to_owned(),
        kind: PassKind::Raster,
        cleared_bytes: 0,
        color_bytes_per_fragment: 8,
        depth_stencil_bytes_per_fragment: 4,
        compute_invocations: None,
        counted: Some(RasterCounts { fragment_invocations: 5, ..RasterCounts::default() }),
    };
    let uncounted = PassWork { counted: None, ..raster.clone() };
    let compute = PassWork {
        stage: "clear".to_owned(),
        kind: PassKind::Compute,
        compute_invocations: Some(64),
        ..uncounted.clone()
    };
    let measured = Bandwidth {
        buffer_bytes: 32,
        copy_bytes_per_s: 2.5e9,
        fill_bytes_per_s: 1.5e9,
        attachment: None,
        repeats: 3,
    };
    let passes = vec![raster, compute, uncounted];
    let mut events = three_samples();
    events.push(Event::Bandwidth { measured });
    events.push(Event::Work { cell: 0, passes });
    let tables = load(&[record("a", &[RBS], events)]).unwrap();
    let work = &tables.work;
    let whole = |name: &str| work.column(name).unwrap().u64().unwrap().iter().collect::<Vec<_>>();
    // In the order of the passes, not of the stages' names.
    let stages: Vec<_> = work.column("stage").unwrap().str().unwrap().iter().flatten().collect();
    assert_eq!(stages, ["capture", "clear", "capture"]);
    assert_eq!(whole("fragment_invocations"), [Some(5), None, None]);
    assert_eq!(whole("attachment_bytes_at_most"), [Some(60), Some(0), None]);
    assert_eq!(whole("compute_invocations"), [None, Some(64), None]);
    assert_eq!(work.column("copy_bytes_per_s").unwrap().f64().unwrap().get(2), Some(2.5e9));
    assert_eq!(work.column("attachment_bytes_per_s").unwrap().null_count(), 3);
    assert_eq!(tables.results[0].work.len(), 3);
}
