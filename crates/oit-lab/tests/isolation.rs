//! A worker that crashes or hangs costs the cell it was busy with, and no other; a run that is
//! killed goes on where it was. The worker here is a shell script that speaks the protocol.

use std::path::Path;

use oit_lab::{Experiment, Outcome, ProfileName, RunError, Setup, run};
use oit_record::{Event, Record};

const EXPERIMENT: &str = r#"
about = "a test"
source = "a test"
seed = 5

[profile.quick]
resolution = [8, 8]
samples = 4
warmup_ms = 0
timeout_s = 2
work = true

[profile.full]
resolution = [8, 8]
samples = 4
warmup_ms = 0
timeout_s = 2

[[sweep]]
sorts = ["insertion", "merge", "rbs"]
stages = ["compute"]
views = ["random_triangles:front"]
"#;

/// Answers every request as a worker would; `$1` is the cell whose sampling it does not survive,
/// `$2` what it does then.
const WORKER: &str = r#"
programs='"programs":[{"sort":"merge","store":"local","low":1,"high":8,"invocations":64,"declared_workgroup_bytes":0,"compile_ns":5,"from_cache":null,"executables":null}]'
verified='{"Prepared":{"verification":{"verdict":"exact","wrong_px":0,"max_error":0.0,"rmse":0.0,"max_alpha_error":0.0,"fragments_missing":0,"fragments_extra":0,"max_frags":8,"pool_initial":1,"pool_final":1,"pool_grown":0,"memory_bytes":0,"prepare_ms":0.0},'"$programs"'}}'
while read -r request; do
  case $request in
    '{"Open"'*) echo '{"Opened":{"id":"fake","backend":"fake","name":"fake","driver":"'"$WORKER_DRIVER"'","api":"","kind":"other","subgroup_size":null,"max_storage_buffer_bytes":0,"max_workgroup_bytes":0,"max_workgroup_invocations":0,"timestamp_period_ns":null,"memory_bytes":null,"unsupported":[]}}' ;;
    '{"View"'*) echo '{"Counted":{"triangles":1,"histogram":[63,1]}}' ;;
    '{"Prepare"'*'"check":"'*) echo "$verified" ;;
    '{"Prepare"'*) echo '{"Prepared":{"verification":null,'"$programs"'}}' ;;
    '"Bandwidth"') echo '{"Bandwidth":{"buffer_bytes":32,"copy_bytes_per_s":2.0,"fill_bytes_per_s":1.0,"repeats":3}}' ;;
    '{"Work"'*) echo '{"Work":[{"stage":"resolve","label":"fake","kind":"compute","compute_invocations":64}]}' ;;
    '{"Sample"'*)
      for cell in $(echo "$request" | tr -dc '0-9,' | tr ',' ' '); do
        if [ "$cell" = "$1" ]; then $2; fi
        echo '{"Sampled":{"stages_ns":[["resolve",5]],"parts_ns":[],"total_ns":7}}'
      done ;;
    '"Spent"') echo '{"Spent":{"scene_ms":0.0,"prepare_ms":0.0,"verify_ms":0.0,"render_ms":0.0}}' ;;
  esac
done
"#;

fn setup(out: &Path, cell: &str, then: &str, resume: bool) -> Setup {
    let words = ["sh", "-c", WORKER, "worker", cell, then];
    Setup {
        device: "fake".into(),
        profile: ProfileName::Quick,
        scenes: oit_scene::list(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes")))
            .expect("the scenes of this repository"),
        out: out.to_owned(),
        resume,
        cache: out.join("cache"),
        tuning: out.join("tuning"),
        commit: None,
        command: vec!["test".into()],
        worker: words.map(String::from).into(),
        worker_environment: Vec::new(),
    }
}

fn start(setup: &Setup) -> Result<Outcome, RunError> {
    let experiment = Experiment::parse(Path::new("isolation.toml"), EXPERIMENT.into());
    run(&experiment.expect("a good experiment"), setup, &|_| true, &mut |_| {})
}

/// The samples recorded for each of the three cells, in order.
fn samples(record: &Record) -> [Vec<u32>; 3] {
    let mut samples: [Vec<u32>; 3] = Default::default();
    for event in &record.events {
        if let Event::Sample { cell, sample, .. } = event {
            samples[*cell].push(*sample);
        }
    }
    samples.each_mut().map(|samples| {
        samples.sort_unstable();
        samples.clone()
    })
}

fn failure(record: &Record) -> (usize, String) {
    let mut failures = record.events.iter().filter_map(|event| match event {
        Event::Failed { cell, reason } => Some((*cell, reason.clone())),
        _ => None,
    });
    let failure = failures.next().expect("one cell failed");
    assert_eq!(failures.next(), None, "only one");
    failure
}

#[test]
fn a_crash_costs_one_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let outcome = start(&setup(folder.path(), "1", "exit 9", false)).expect("the run goes on");
    assert_eq!((outcome.exact, outcome.failed), (2, 1));
    let record = Record::read(folder.path()).expect("a good record");
    assert!(record.finished());
    let (cell, reason) = failure(&record);
    assert_eq!(cell, 1);
    assert!(reason.contains("exit status: 9"), "{reason}");
    let [first, _, last] = samples(&record);
    assert_eq!((first, last), (vec![0, 1, 2, 3], vec![0, 1, 2, 3]));
}

#[test]
fn a_worker_has_the_variables_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut setup = setup(folder.path(), "none", "", false);
    setup.worker_environment.push(("WORKER_DRIVER".into(), "1.2".into()));
    start(&setup).expect("the run goes on");
    let record = Record::read(folder.path()).expect("a good record");
    assert_eq!(record.run.device.driver, "1.2");
}

#[test]
fn a_hang_costs_one_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let setup = setup(folder.path(), "2", "sleep 600", false);
    let outcome = start(&setup).expect("the run goes on");
    assert_eq!((outcome.exact, outcome.failed), (2, 1));
    let record = Record::read(folder.path()).expect("a good record");
    let (cell, reason) = failure(&record);
    assert_eq!(cell, 2);
    assert!(reason.contains("hung"), "{reason}");
    let [first, second, _] = samples(&record);
    assert_eq!((first, second), (vec![0, 1, 2, 3], vec![0, 1, 2, 3]));
}

#[test]
fn a_killed_run_goes_on_with_the_first_sample_that_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    start(&setup(folder.path(), "none", "", false)).expect("it runs");
    let whole = Record::read(folder.path()).expect("a good record");
    let path = folder.path().join("events.jsonl");
    let text = std::fs::read_to_string(&path).expect("events");
    let lines: Vec<&str> = text.lines().collect();
    // Wherever a kill cuts the file, also in the middle of a line, what is left is taken up.
    for keep in 0..lines.len() {
        let torn =
            format!("{}\n{}", lines[..keep].join("\n"), &lines[keep][..lines[keep].len() / 2]);
        std::fs::write(&path, torn.trim_start_matches('\n')).expect("written");
        start(&setup(folder.path(), "none", "", true)).expect("it resumes");
        let record = Record::read(folder.path()).expect("a good record");
        assert_eq!(samples(&record), samples(&whole), "after {keep} lines");
        assert!(record.finished());
        let verified = |event: &&Event| matches!(event, Event::Verified { .. });
        assert_eq!(record.events.iter().filter(verified).count(), 3, "after {keep} lines");
        let programs = |event: &&Event| matches!(event, Event::Programs { .. });
        assert_eq!(record.events.iter().filter(programs).count(), 3, "after {keep} lines");
        let work = |event: &&Event| matches!(event, Event::Work { .. });
        assert_eq!(record.events.iter().filter(work).count(), 3, "after {keep} lines");
        let bandwidth = |event: &&Event| matches!(event, Event::Bandwidth { .. });
        assert_eq!(record.events.iter().filter(bandwidth).count(), 1, "after {keep} lines");
    }
}

#[test]
fn a_run_is_not_overwritten_and_another_is_not_resumed() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = setup(folder.path(), "none", "", false);
    start(&first).expect("it runs");
    let error = start(&first).expect_err("it is there already").to_string();
    assert!(error.contains("--resume"), "{error}");
    let other = Setup { profile: ProfileName::Full, ..setup(folder.path(), "none", "", true) };
    let error = start(&other).expect_err("another profile").to_string();
    assert!(error.contains("profile"), "{error}");
    // Of that one nobody asked for work.
    let full = tempfile::tempdir().expect("a folder");
    let other = Setup { profile: ProfileName::Full, ..setup(full.path(), "none", "", false) };
    start(&other).expect("it runs");
    let record = Record::read(full.path()).expect("a good record");
    let asked = |event: &Event| matches!(event, Event::Work { .. } | Event::Bandwidth { .. });
    assert!(!record.events.iter().any(asked));
}

#[test]
fn a_folder_that_cannot_be_written_is_an_error_before_anything_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "in the way").expect("written");
    let error = start(&setup(&file.join("run"), "none", "", false)).expect_err("a file in the way");
    assert!(matches!(error, RunError::Record(_)), "{error}");
}
