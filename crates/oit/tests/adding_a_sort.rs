//! Does what docs/adding-a-sort.md says, to a copy of the workspace, and sees the new strategy in
//! the listing, the conformance suite and a sweep.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Copies a folder, leaving files that are the same already: cargo goes by their times.
fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).expect("a folder");
        for entry in fs::read_dir(from).expect("a folder") {
            let name = entry.expect("an entry").file_name();
            copy(&from.join(&name), &to.join(&name));
        }
    } else if fs::read(from).ok() != fs::read(to).ok() {
        fs::copy(from, to).expect("a copy");
    }
}

/// The fenced blocks of the page with the line before each.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let (mut before, mut inside): (String, Option<String>) = (String::new(), None);
    for line in page.lines() {
        match &mut inside {
            None if line.starts_with("```") => inside = Some(String::new()),
            None if !line.is_empty() => before = line.to_owned(),
            None => {}
            Some(_) if line == "```" => {
                blocks.push((before.clone(), inside.take().expect("inside")));
            }
            Some(text) => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
    blocks
}

fn run(program: &str, arguments: &[&str], folder: &Path, target: &Path) -> Output {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .expect("it starts");
    let text = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    let text = String::from_utf8_lossy(&text);
    assert!(output.status.success(), "{program} {arguments:?}:\n{text}");
    output
}

#[test]
fn a_strategy_added_as_the_page_says_appears_everywhere() {
    // A path that stays, so that a second run compiles only what changed.
    let copied = Path::new(env!("CARGO_TARGET_TMPDIR")).join("adding-a-sort");
    let target = copied.join("target");
    for part in [
        "Cargo.toml",
        "Cargo.lock",
        "crates",
        "analysis",
        "paper_figures/Cargo.toml",
        "paper_figures/src",
        "scenes",
    ] {
        let to = copied.join(part);
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        copy(&Path::new(ROOT).join(part), &to);
    }
    let page = fs::read_to_string(Path::new(ROOT).join("docs/adding-a-sort.md")).expect("the page");
    let registry: PathBuf = copied.join("crates/oit-sort/src/strategies/mod.rs");
    let mut files = 0;
    let (mut module, mut line) = (None, None);
    for (before, text) in blocks(&page) {
        if let Some(path) = before.strip_prefix("File `").and_then(|rest| rest.strip_suffix("`:")) {
            let path = copied.join(path);
            if fs::read_to_string(&path).ok().as_deref() != Some(&text) {
                fs::write(&path, text).expect("written");
            }
            files += 1;
        } else if text.starts_with("mod ") {
            module = Some(text);
        } else if text.trim_start().starts_with('&') {
            line = Some(text);
        }
    }
    assert_eq!(files, 2, "a template and a strategy");
    let (module, line) = (module.expect("the module's line"), line.expect("the registry's line"));
    let source = fs::read_to_string(&registry).expect("the registry");
    let source = source.replacen("mod ", &format!("{module}mod "), 1);
    let start = source.find("STRATEGIES").expect("the slice");
    let end = start + source[start..].find("];").expect("its end");
    let source = format!("{}{line}{}", &source[..end], &source[end..]);
    fs::write(&registry, source).expect("written");

    // Dependencies unoptimised: they are built once more here, since cargo would take the copy's
    // crates and this workspace's for the same in one target folder.
    let config = "profile.dev.package.'*'.opt-level=0";
    let build = ["build", "--locked", "--config", config, "--package", "oit"];
    run("cargo", &build, &copied, &target);
    let oit = target.join("debug/oit");
    let oit = oit.to_string_lossy();
    let listing = run(&oit, &["list", "sorts"], &copied, &target);
    assert!(String::from_utf8_lossy(&listing.stdout).contains("comb"));

    let test = ["test", "--locked", "--config", config, "--package", "oit-sort"];
    let test = [&test[..], &["--test", "conformance"]].concat();
    run("cargo", &test, &copied, &target);

    let experiment = copied.join("comb.toml");
    let text = "about = \"a test\"\nsource = \"a test\"\n\
        [profile.quick]\nresolution = [64, 36]\nsamples = 2\nwarmup_ms = 0\ntimeout_s = 60\n\
        [profile.full]\nresolution = [64, 36]\nsamples = 2\nwarmup_ms = 0\ntimeout_s = 60\n\
        [[sweep]]\nsorts = [\"all\"]\nstages = [\"compute\"]\nviews = [\"stack:front\"]\n";
    fs::write(&experiment, text).expect("written");
    let out = tempfile::tempdir().expect("a folder");
    let out_name = out.path().join("run").to_string_lossy().into_owned();
    let experiment = experiment.to_string_lossy();
    run(&oit, &["sweep", &experiment, "--device", "cpu", "--out", &out_name], &copied, &target);
    let record = oit_record::Record::read(Path::new(&out_name)).expect("a good record");
    let cell = record.run.cells.iter().position(|cell| cell.technique.contains("/comb/"));
    let cell = cell.expect("`all` sweeps the new strategy");
    let exact = record.events.iter().any(|event| {
        matches!(event, oit_record::Event::Verified { cell: of, result }
            if *of == cell && result.verdict == oit_record::Verdict::Exact)
    });
    assert!(exact, "it is exact");
}
