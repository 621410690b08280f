//! The program as a person runs it, on the CPU backend.

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use oit_record::{Event, Record, Verdict};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn oit(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_oit"))
        .args(arguments)
        .current_dir(ROOT)
        .output()
        .expect("the program starts")
}

/// What the program prints where it succeeds.
fn ok(arguments: &[&str]) -> String {
    let output = oit(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    text(&output)
}

/// What the program prints where it fails.
fn fails(arguments: &[&str]) -> String {
    let output = oit(arguments);
    assert!(!output.status.success(), "{arguments:?}: {}", text(&output));
    text(&output)
}

fn text(output: &Output) -> String {
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    String::from_utf8_lossy(&text).into_owned()
}

const EXPERIMENT: &str = r#"about = "a test"
source = "a test"
seed = 1
[profile.quick]
resolution = [96, 54]
samples = 6
warmup_ms = 5
timeout_s = 60
[profile.full]
resolution = [96, 54]
samples = 40
warmup_ms = 5
timeout_s = 60
[[sweep]]
captures = ["linked_list", "linearized"]
schedules = ["all"]
sorts = ["all"]
stages = ["all"]
max_frags = ["peak", 8]
views = ["planes:front"]
"#;

fn write_experiment(folder: &Path) -> String {
    let path = folder.join("test.toml");
    std::fs::write(&path, EXPERIMENT).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn a_sweep_verifies_times_and_records_every_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (write_experiment(folder.path()), folder.path().join("run"));
    let output = oit(&["sweep", &file, "--device", "cpu", "--out", &out.to_string_lossy()]);
    assert!(output.status.success(), "{}", text(&output));
    let record = Record::read(&out).expect("a good record");
    assert!(record.finished());
    for (index, cell) in record.run.cells.iter().enumerate() {
        let of_cell = |event: &&Event| event.cell() == Some(index);
        let events: Vec<&Event> = record.events.iter().filter(of_cell).collect();
        match events[0] {
            // The CPU has the compute stage alone, and rs and network do not hold 128 fragments.
            Event::Skipped { reason, .. } => {
                let elsewhere = ["/fragment/", "/cuda/"];
                let elsewhere = elsewhere.iter().any(|stage| cell.technique.contains(stage));
                let expected = elsewhere || reason.contains("holds");
                assert!(expected && events.len() == 1, "{}: {reason}", cell.technique);
            }
            Event::Verified { result, .. } => {
                let rough = ["max8", "passthrough", "unsorted", "_early"];
                let approximate = rough.iter().any(|word| cell.technique.contains(word));
                let verdict = if approximate { Verdict::Approximate } else { Verdict::Exact };
                assert_eq!(result.verdict, verdict, "{}: {:?}", cell.technique, result.note);
                assert_eq!(events.len(), 1 + 6, "{}", cell.technique);
            }
            other => panic!("{}: {other:?}", cell.technique),
        }
    }
    let again = oit(&["sweep", &file, "--device", "cpu", "--out", &out.to_string_lossy()]);
    assert!(!again.status.success() && text(&again).contains("--resume"), "{}", text(&again));
}

/// Methods are verified, timed and recorded as well, and of approximate pictures also what an eye makes
/// of their errors, where that is asked.
#[test]
fn a_sweep_of_methods_records_their_errors() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("test.toml"), folder.path().join("run"));
    let (head, _) = EXPERIMENT.split_once("[[sweep]]").expect("a sweep");
    let sweep = "[[sweep]]\nmethods = [\"all\", \"dual_peel/passes2\"]\n\
                 sorts = [\"insertion\"]\nstages = [\"compute\"]\nviews = [\"planes:front\"]\n";
    let head = head.replacen("timeout_s = 60\n", "timeout_s = 60\nperceptual = true\n", 1);
    std::fs::write(&path, head + sweep).expect("written");
    let (file, run) = (path.to_string_lossy(), out.to_string_lossy());
    ok(&["sweep", &file, "--device", "cpu", "--out", &run]);
    let record = Record::read(&out).expect("a good record");
    assert!(record.finished());
    let mut approximate = 0;
    for event in &record.events {
        let Event::Verified { cell, result } = event else { continue };
        let technique = &record.run.cells[*cell].technique;
        let is_method = !technique.contains("/insertion/");
        assert_eq!(result.fragments_compared, !is_method, "{technique}");
        assert_ne!(result.verdict, Verdict::Wrong, "{technique}: {:?}", result.note);
        let is_approximate = result.verdict == Verdict::Approximate;
        let (ssim, flip) = (result.ssim, result.flip);
        assert_eq!((ssim.is_some(), flip.is_some()), (is_approximate, is_approximate));
        if technique == "weighted" || technique == "dual_peel/passes2" {
            assert!(is_approximate && ssim < Some(1.0) && flip > Some(0.0), "{technique}");
            approximate += 1;
        }
        let samples = record.events.iter().filter(|event| {
            matches!(event, Event::Sample { cell: of, stages_ns, .. }
                if of == cell && stages_ns.contains_key("resolve"))
        });
        assert_eq!(samples.count(), 6, "{technique}");
    }
    assert_eq!(approximate, 2);
}

#[test]
fn methods_are_listed_planned_and_rendered() {
    let list = ok(&["list", "methods"]);
    assert!(list.contains("dual_peel_stop") && list.contains("/kN, 1 to 256, 8 if not given"));
    let plan = ok(&["plan", "dual_peel/passes3", "--size", "64x32"]);
    assert!(plan.contains("dual_peel/passes3") && plan.contains("peel: layers 2 from"), "{plan}");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_string_lossy().into_owned();
    let render = |technique: &str| {
        let to = ["--device", "cpu", "--size", "64x32", "--out", &out, "--technique", technique];
        [&["render", "scenes/planes.toml"][..], &to].concat().join(" ")
    };
    let run = |technique: &str| {
        let line = render(technique);
        oit(&line.split(' ').collect::<Vec<_>>())
    };
    assert!(text(&run("depth_peel")).contains("depth_peel on cpu: Exact"));
    assert!(text(&run("hybrid/k2")).contains("hybrid/k2 on cpu: Approximate"));
    let wrong = run("hybrid/k2000");
    assert!(!wrong.status.success() && text(&wrong).contains("from 1 to 256"), "{}", text(&wrong));
}

#[test]
fn a_sweep_that_is_killed_resumes_with_nothing_lost_and_nothing_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (write_experiment(folder.path()), folder.path().join("run"));
    let out_name = out.to_string_lossy().into_owned();
    let arguments = ["sweep", &file, "--device", "cpu", "--profile", "full", "--out", &out_name];
    let mut child = Command::new(env!("CARGO_BIN_EXE_oit"))
        .args(arguments)
        .current_dir(ROOT)
        .spawn()
        .expect("the program starts");
    let started = Instant::now();
    let samples = || -> Vec<(usize, u32)> {
        let record = Record::read(&out);
        let events = record.map(|record| record.events).unwrap_or_default();
        let sample = |event: Event| match event {
            Event::Sample { cell, sample, .. } => Some((cell, sample)),
            _ => None,
        };
        events.into_iter().filter_map(sample).collect()
    };
    while samples().len() < 25 {
        assert!(started.elapsed() < Duration::from_secs(120), "it samples nothing");
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().expect("it is killed");
    child.wait().expect("it is gone");
    let before = samples();
    let resumed = oit(&[&arguments[..], &["--resume"]].concat());
    assert!(resumed.status.success(), "{}", text(&resumed));
    let after = samples();
    assert_eq!(after[..before.len()], before);
    let mut each = after.clone();
    each.sort_unstable();
    each.dedup();
    assert_eq!(each.len(), after.len(), "a sample was taken twice");
    assert_eq!(after.len() % 40, 0, "a sample is missing");
    assert!(Record::read(&out).expect("a good record").finished());
}

#[test]
fn a_record_of_another_schema_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("run.json"), "{\"schema\": 999}").expect("written");
    let error = Record::read(folder.path()).expect_err("another schema").to_string();
    assert!(error.contains("version 999"), "{error}");
}

#[test]
fn an_image_is_rendered_as_png_and_exr() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_string_lossy().into_owned();
    let output = oit(&[
        "render",
        "scenes/planes2.toml",
        "--device",
        "cpu",
        "--size",
        "96x54",
        "--out",
        &out,
    ]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("Exact"), "{}", text(&output));
    let path = folder.path().join("planes2-front.exr");
    let (image, counts) = oit_image::read_exr(&path).expect("a good EXR file");
    assert_eq!((image.width, image.height), (96, 54));
    assert_eq!(counts.expect("depth complexity").into_iter().max(), Some(128));
    for ending in [".png", "-depth.png"] {
        assert!(folder.path().join(format!("planes2-front{ending}")).exists());
    }
}

#[test]
fn a_wrong_word_is_answered_with_the_right_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = write_experiment(folder.path());
    for (arguments, words) in [
        (vec!["sweep", file.as_str(), "--device", "vulcan:0"], vec!["vulcan:0", "cpu"]),
        (vec!["sweep", "experiments/none.toml"], vec!["experiments/none.toml"]),
        (vec!["compare", "insertoin"], vec!["insertoin", "insertion"]),
        (vec!["render", "scenes/planes.toml", "--view", "frnt"], vec!["frnt", "front"]),
        (vec!["render", "scenes/planes.toml", "--set", "layrs=3"], vec!["layrs"]),
        (vec!["render", "scenes/planes.toml", "--size", "12"], vec!["12", "1920x1080"]),
        (vec!["list", "sort"], vec!["sort", "sorts"]),
    ] {
        let output = oit(&arguments);
        let text = text(&output);
        assert!(!output.status.success(), "{arguments:?}");
        assert!(words.iter().all(|word| text.contains(word)), "{arguments:?}\n{text}");
        assert!(!text.contains("panicked"), "{text}");
    }
}

#[test]
fn a_plan_is_printed_without_a_device() {
    let output = oit(&["plan", "linked_list/bma-list/rbs/compute/peak", "--shaders"]);
    let text = text(&output);
    assert!(output.status.success(), "{text}");
    for word in ["group_pixels", "capture", "resolve", "fn sort_and_blend"] {
        assert!(text.contains(word), "no {word} in\n{text}");
    }
}

/// Whether pictures stay: an experiment that asks for it gets hashes, the change from view to view, and
/// pictures of what breaks.
#[test]
fn frames_are_repeated_and_followed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let sweep = EXPERIMENT.find("[[sweep]]").expect("the cells");
    let head = EXPERIMENT[..sweep]
        .replace("samples = 6", "samples = 1\nrepeats = 3\nkeep_breaks = true")
        .replace(
            "timeout_s = 60\n[profile.full]",
            "timeout_s = 60\npath.frames = 3\n[profile.full]",
        );
    let techniques = "techniques = [\"linked_list/base/insertion/compute/peak\", \
        \"linked_list/base/passthrough/compute/peak\"]\nmethods = [\"weighted\"]\n";
    let cells = format!(
        "[[sweep]]\n{techniques}views = [\"stack:front\"]\n\
         scene = [{{ alpha = 1.0 }}, {{ alpha = 1.0, shuffle = 1 }}, {{ alpha = 0.5, shuffle = 1 }}]\n\
         [[sweep]]\n{techniques}views = [\"random_triangles:drift@*\"]\n"
    );
    std::fs::write(path("stays.toml"), head + &cells).expect("written");
    ok(&["sweep", &path("stays.toml"), "--device", "cpu", "--out", &path("run")]);
    let record = Record::read(&folder.path().join("run")).expect("a good record");
    let results = record.events.iter().filter_map(|event| match event {
        Event::Verified { cell, result } => Some((&record.run.cells[*cell], result)),
        _ => None,
    });
    let results: Vec<_> = results.collect();
    assert_eq!(results.len(), 3 * 3 + 3 * 3);
    let of = |scene: &str, view: &str, technique: &str| {
        let is = |cell: &oit_record::Cell| {
            cell.scene == scene && cell.view == view && cell.technique.contains(technique)
        };
        let found = results.iter().find(|(cell, _)| is(cell));
        let (_, result) = found.unwrap_or_else(|| panic!("{scene} {view} {technique}"));
        (*result, result.stability.as_ref().expect("it was asked for"))
    };
    for (cell, result) in &results {
        let stability = result.stability.as_ref().expect("it was asked for");
        assert_eq!((stability.runs, stability.pictures), (4, 1), "{cell:?}");
        assert_eq!(result.repeat_differs_px, Some(0), "{cell:?}");
    }
    // Another order of triangles: the same picture where fragments are sorted, another where not.
    let (plain, shuffled) = ("stack{alpha=1.0}", "stack{alpha=1.0,shuffle=1}");
    let hash = |scene: &str, technique: &str| of(scene, "front", technique).1.hash.clone();
    assert_eq!(hash(plain, "insertion"), hash(shuffled, "insertion"));
    assert_ne!(hash(plain, "passthrough"), hash(shuffled, "passthrough"));
    let change = |scene: &str, view: &str, technique: &str| of(scene, view, technique).1.change;
    assert_eq!(change(plain, "front", "insertion"), None);
    let still = change(shuffled, "front", "insertion").expect("the same view came before");
    assert_eq!((still.px, still.max), (0, 0.0));
    let moved = change(shuffled, "front", "passthrough").expect("the same view came before");
    assert!(moved.px > 100 && moved.max > 0.1, "{moved:?}");
    // Another opacity is another sequence.
    assert_eq!(change("stack{alpha=0.5,shuffle=1}", "front", "insertion"), None);
    // Along a path the picture changes, and that of an exact technique as the right one does.
    let frames: Vec<String> = [0, 3, 6].map(|frame| format!("drift@{frame}")).to_vec();
    assert_eq!(change("random_triangles", &frames[0], "weighted"), None);
    for frame in &frames[1..] {
        let exact = change("random_triangles", frame, "insertion").expect("a frame came before");
        assert!(exact.px == 0 && exact.max < 1e-6, "{exact:?}");
        let weighted = change("random_triangles", frame, "weighted").expect("a frame came before");
        assert!(weighted.px > 0 && weighted.rms > 1e-4, "{weighted:?}");
    }
    let hash = |frame: &str| of("random_triangles", frame, "insertion").1.hash.clone();
    assert_ne!(hash(&frames[0]), hash(&frames[1]));
    // Pictures are kept of what breaks, and of nothing else.
    let broken = results.iter().filter(|(_, result)| result.breaks()).count();
    let (lost, _) = of(plain, "front", "passthrough");
    assert!(lost.breaks() && lost.max_error > 0.5, "{lost:?}");
    let kept = std::fs::read_dir(folder.path().join("run/images")).expect("kept").count();
    assert_eq!(kept, 2 * broken);
    assert!(broken < results.len() / 2, "{broken}");
}

#[test]
fn a_device_is_tuned_by_its_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let sweep = EXPERIMENT.find("[[sweep]]").expect("the cells");
    let cells = "[[sweep]]\nschedules = [\"bma\"]\nsorts = [\"insertion\", \"rs\"]\n\
        stages = [\"compute\"]\nviews = [\"stack:front\"]\nscene = { count = 8 }\n";
    std::fs::write(path("stack.toml"), EXPERIMENT[..sweep].to_owned() + cells).expect("written");
    let (run, tuning) = (path("run"), path("tuning"));
    ok(&["sweep", &path("stack.toml"), "--device", "cpu", "--out", &run]);
    assert!(ok(&["tune", &run, "--out", &tuning]).contains("the fastest up to 8"));
    let render = |technique: &str| {
        let scene = ["render", "scenes/stack.toml", "--set", "count=8", "--size", "96x54"];
        let rest =
            ["--device", "cpu", "--tuning", &tuning, "--out", &run, "--technique", technique];
        oit(&[&scene[..], &rest].concat())
    };
    let auto = text(&render("linked_list/bma-list/auto/compute/peak"));
    let chosen = ["insertion@8", "rs@8"].map(|sort| format!("bma-list/{sort}/compute/peak on cpu"));
    assert!(chosen.iter().any(|chosen| auto.contains(chosen)) && auto.contains("Exact"), "{auto}");
    let refused = render("linked_list/bma-list/auto/compute/peak/intervals-optimal");
    assert!(
        !refused.status.success() && text(&refused).contains("cost of an interval"),
        "{}",
        text(&refused)
    );
    let nothing = fails(&["tune", "experiments/recorded/nvidia-h200-vulkan/rbs-table-2"]);
    assert!(nothing.contains("no exact cell of bma"), "{nothing}");
}

/// Captured on the CPU, where the order of fragments is that of submission: through a trace and a
/// deep image and back the fragments stay what they are, and so does the picture.
#[test]
fn traces_and_deep_images_hold_a_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (trace, deep, back) = (path("a.oitt"), path("a.exr"), path("b.oitt"));
    let save = ["trace", "save", "scenes/random_triangles.toml", &trace, "--device", "cpu"];
    let save = [&save[..], &["--size", "80x45"]].concat();
    let text = ok(&save);
    assert!(text.contains("80x45") && text.contains("fragments"), "{text}");
    // Nothing is overwritten unasked.
    assert!(fails(&save).contains("a.oitt"));
    ok(&[&save[..], &["--overwrite"]].concat());
    let info = ok(&["trace", "info", &trace]);
    assert!(info.contains("random_triangles") && info.contains("order = \"submission\""), "{info}");

    ok(&["trace", "convert", &trace, &deep]);
    ok(&["trace", "convert", &deep, &back]);
    assert!(ok(&["trace", "info", &deep]).contains("Z"));
    let fragments = |file: &str| oit_lab::load_stored(file.as_ref()).expect("undamaged").lfb;
    assert_eq!(fragments(&trace), fragments(&deep));
    assert_eq!(fragments(&trace), fragments(&back));

    let out = path("renders");
    let render = ["--device", "cpu", "--out", &out, "--technique"];
    let render = [&render[..], &["linearized/bma-list/insertion/compute/peak"]].concat();
    let drawn = ["render", "scenes/random_triangles.toml", "--view", "front", "--size", "80x45"];
    ok(&[&drawn[..], &render].concat());
    ok(&[&["render", &deep][..], &render].concat());
    let bytes = |name: &str| std::fs::read(folder.path().join("renders").join(name)).expect(name);
    assert!(bytes("random_triangles-front.png") == bytes("a-stored.png"), "another picture");

    let replay = ["trace", "replay", &back, "--device", "cpu", "--samples", "2", "--sorts"];
    let text = ok(&[&replay[..], &["insertion,rbs", "--out", &path("run")]].concat());
    assert!(text.contains("4 exact") && text.contains("linked_list/bma-list/rbs"), "{text}");

    // Damage is an error, whatever is asked of the file.
    let mut damaged = std::fs::read(&trace).expect("the trace");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&trace, damaged).expect("written");
    for command in ["info", "replay"] {
        assert!(fails(&["trace", command, &trace]).contains("a.oitt"), "{command}");
    }
    let text = fails(&["trace", "convert", &deep, &path("a.png")]);
    assert!(text.contains("a.png") && text.contains(".oitt or .exr"), "{text}");
}

#[test]
fn a_sort_is_checked_and_then_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let command = ["compare", "network", "--against", "insertion,rbs", "--device", "cpu"];
    let sizes = ["--depths", "8,128", "--size", "32x18", "--samples", "3"];
    let scenes = ["--scenes", "random_triangles:front", "--out", &out];
    let all = [&command[..], &sizes, &scenes].concat();
    let text = ok(&all);
    assert!(text.contains("network: the CPU twin"), "{text}");
    // It holds no 128, and in a scene another goes on where it ends.
    assert!(text.contains("network+rbs_hier") && !text.contains("count=128"), "{text}");
    let verdicts = ["faster", "slower", "same"];
    let rivals = text.lines().filter(|line| verdicts.iter().any(|word| line.contains(word)));
    // Of 4 + 2 families each has two rivals; two lines of the heading say the words too.
    assert_eq!(rivals.filter(|line| line.contains(" ms ")).count(), 6 * 2, "{text}");
    let found = oit_record::Subject::read(out.as_ref()).expect("undamaged").expect("is there");
    let of = &found.parts[0];
    assert_eq!((found.wrong(), of.conformance.up_to, of.limit), (None, 64, Some(64)));
    assert!(of.conformance.lists > 600, "{of:?}");
    let record = Record::read(out.as_ref()).expect("a good record");
    let cells = |words: &[&str]| {
        let named = |cell: &&oit_record::Cell| {
            let name = format!("{} {}", cell.technique, cell.group());
            words.iter().all(|word| name.contains(word))
        };
        record.run.cells.iter().filter(named).count()
    };
    // Three orders of lists and one of runs; then two captures of the scene.
    assert_eq!((cells(&["count=8"]), cells(&["count=128"])), (4 * 3, 0));
    assert_eq!((cells(&["random_triangles"]), cells(&["network+rbs_hier"])), (6, 2));
    let again = fails(&all);
    assert!(again.contains("--resume"), "{again}");
    let depth = fails(&[&command[..], &["--depths", "9"]].concat());
    assert!(depth.contains("no depth is 9"), "{depth}");
    let view = fails(&[&command[..], &["--scenes", "planes:frnt"]].concat());
    assert!(view.contains("frnt"), "{view}");
}

#[test]
fn a_sort_is_compared_on_a_trace_without_a_gpu() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let trace = path("a.oitt");
    let stack = ["trace", "save", "scenes/stack.toml", &trace, "--set", "count=16"];
    ok(&[&stack[..], &["--size", "32x18", "--device", "cpu"]].concat());
    let command = ["compare", "insertion", "--against", "network,passthrough", "--trace", &trace];
    let out = path("run");
    let text = ok(&[&command[..], &["--samples", "3", "--out", &out]].concat());
    // Squares in order, nearest first: 15 comparisons of 16 fragments, and of a network its 63.
    assert!(text.contains("## 9 to 16 fragments"), "{text}");
    let row = |sort: &str, each: &str| text.contains(&format!("| {sort} | {each} |"));
    assert!(row("network", "3.94") && row("passthrough", "0.00"), "{text}");
    assert!(row("insertion", "0.94") || row("insertion", "7.50"), "{text}");
    let csv = std::fs::read_to_string(folder.path().join("run/twins.csv")).expect("written");
    assert_eq!(csv.lines().count(), 1 + 3 * 3, "{csv}");
    assert!(fails(&[&command[..], &["--out", &out]].concat()).contains("is there already"));
    let no_trace = fails(&["compare", "insertion", "--trace", "scenes/stack.toml"]);
    assert!(no_trace.contains(".oitt"), "{no_trace}");
}

/// A run of one view on the CPU, to advise from.
fn recorded(folder: &Path) -> String {
    let path = folder.join("records/run").to_string_lossy().into_owned();
    ok(&[
        "pareto",
        "scenes/planes2.toml",
        "--device",
        "cpu",
        "--size",
        "48x32",
        "--techniques",
        "linked_list/base/insertion/compute/peak,linked_list/bma-list/rbs/compute/peak",
        "--methods",
        "weighted",
        "--samples",
        "2",
        "--out",
        &path,
    ]);
    folder.join("records").to_string_lossy().into_owned()
}

#[test]
fn advice_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let records = recorded(folder.path());
    let view = ["advise", "scenes/planes2.toml", "--size", "48x32", "--on", "cpu"];
    let advise = |more: &[&str]| ok(&[&view[..], &["--records", &records], more].concat());
    let text = advise(&["--check", "--samples", "2"]);
    for word in
        ["measured on this view in run", "intervals", "pool", "Checked on", "exact", "keeps within"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    // A weighted sum is far off here, so that it is chosen only where anything goes.
    assert!(text.contains("its error is above the bound\n          weighted: "), "{text}");
    let loose = advise(&["--max-error", "1", "--all"]);
    assert!(!loose.contains("its error is above the bound"), "{loose}");
    // Of another scene nothing is known of, nor of this one where it is held out.
    let lone = fails(&[&view[..], &["--records", &records, "--hold-out"]].concat());
    assert!(lone.contains("measured on another scene"), "{lone}");
    let tight = fails(&[&view[..], &["--records", &records, "--max-memory", "1KiB"]].concat());
    assert!(tight.contains("it takes more memory"), "{tight}");
}

#[test]
fn advice_that_cannot_be_given_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().to_string_lossy().into_owned();
    let scene = "scenes/planes2.toml";
    let cases: [(&[&str], &str); 9] = [
        (&["advise"], "<SCENE>"),
        (&["advise", "scenes/plane2.toml", "--on", "cpu"], "plane2"),
        (&["advise", scene, "--view", "frnt", "--on", "cpu", "--size", "8x8"], "front"),
        (&["advise", scene, "--size", "8"], "is no size"),
        (&["advise", scene, "--max-error", "2"], "from 0 to 1"),
        (&["advise", scene, "--max-error", "1/x"], "from 0 to 1"),
        (&["advise", scene, "--max-memory", "5 apples"], "512MiB"),
        (&["advise", scene, "--device", "geforce 256"], "there are records of NVIDIA H200"),
        (&["advise", scene, "--records", &empty], "hold no times"),
    ];
    for (arguments, word) in cases {
        let text = fails(arguments);
        assert!(text.contains(word), "{arguments:?}: {text}");
        assert!(!text.contains("panicked"), "{text}");
    }
    let cases: [(&[&str], &str); 3] = [
        (&["pareto", scene, "--view", "frnt"], "front"),
        (&["pareto", scene, "--methods", "weigted"], "weighted"),
        (&["pareto", scene, "--techniques", "linked_lst/base/rbs/compute/peak"], "linked_list"),
    ];
    for (arguments, word) in cases {
        let text = fails(arguments);
        assert!(text.contains(word), "{arguments:?}: {text}");
    }
}

#[test]
fn advice_is_tested_on_records() {
    let text = ok(&["advise", "--regret", "--device", "nvidia-h200-vulkan"]);
    assert!(text.contains("exact") && text.contains("The most regretted:"), "{text}");
}
