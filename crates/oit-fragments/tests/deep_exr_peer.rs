//! Deep images against the OpenEXR project's own Python package: it reads what is written here, and
//! what it writes is read here.
//!
//! Where the package is missing the tests are listed as ignored; with `OIT_REQUIRE_OPENEXR=1` that
//! is a failure. `OIT_PYTHON` names another interpreter than `python3`.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use libtest_mimic::{Arguments, Failed, Trial, run};
use oit_fragments::deep_exr::{Compression, LineOrder, SampleType, Window, read, write};
use oit_fragments::{Fragment, Lfb};
use serde::{Deserialize, Serialize};

/// As in `deep_exr_peer.py`.
#[derive(Serialize, Deserialize)]
struct Image {
    compression: String,
    decreasing: bool,
    window: [i32; 4],
    channels: BTreeMap<String, Samples>,
}

#[derive(Serialize, Deserialize)]
struct Samples {
    /// None where there is no sample to tell by.
    #[serde(rename = "type")]
    kind: Option<String>,
    pixels: Vec<Vec<f64>>,
}

fn main() -> ExitCode {
    let absent = python("check", None, "").err();
    let required = std::env::var("OIT_REQUIRE_OPENEXR").is_ok_and(|value| value == "1");
    if let Some(why) = &absent {
        eprintln!("skipped: the Python package OpenEXR cannot be used: {why}");
    }
    let mut trials = Vec::new();
    for (name, compression) in [("NONE", Compression::None), ("ZIPS", Compression::Zips)] {
        trials.push(Trial::test(format!("openexr_reads_ours_{name}"), move || {
            openexr_reads_ours(name, compression)
        }));
        for kind in ["half", "float"] {
            for decreasing in [false, true] {
                let order = if decreasing { "decreasing" } else { "increasing" };
                trials.push(Trial::test(
                    format!("openexrs_is_read_{name}_{kind}_{order}"),
                    move || openexrs_is_read(name, compression, kind, decreasing),
                ));
            }
        }
    }
    let trials = trials
        .into_iter()
        .map(|trial| trial.with_ignored_flag(absent.is_some() && !required))
        .collect();
    run(&Arguments::from_args(), trials).exit_code()
}

/// What the script prints.
fn python(verb: &str, file: Option<&Path>, input: &str) -> Result<String, String> {
    let interpreter = std::env::var_os("OIT_PYTHON").unwrap_or_else(|| OsString::from("python3"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/deep_exr_peer.py");
    let mut child = Command::new(&interpreter)
        .arg(script)
        .arg(verb)
        .args(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{}: {error}", interpreter.display()))?;
    // A script that fails before it has read all says why on its own.
    let _ = child.stdin.take().expect("it is piped").write_all(input.as_bytes());
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        return Err(message.trim().lines().last().unwrap_or("it failed").to_owned());
    }
    String::from_utf8(output.stdout).map_err(|error| error.to_string())
}

/// A buffer with empty pixels, an empty row, a deep pixel, and depths outside 0 to 1. Rows are wide
/// and alike enough for ZIPS to compress counts and samples, and one too short for it to gain.
fn sample_lfb() -> Lfb {
    let (width, height) = (40u32, 6u32);
    let mut state = 7u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    let mut lists = Vec::new();
    for pixel in 0..width * height {
        let count = match pixel / width {
            1 => 0,
            2 => 4,
            3 if pixel % width == 5 => 200,
            3 => 0,
            4 => u32::from(pixel % width == 39),
            _ => next() % 5,
        };
        let list = (0..count).map(|i| {
            let depth = if pixel / width == 2 { i as f32 } else { next() as f32 / 2e7 - 0.2 };
            Fragment::new(depth, (next() ^ next() << 16).to_le_bytes())
        });
        lists.push(list.collect::<Vec<_>>());
    }
    Lfb::from_lists(width, height, &lists)
}

fn check(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}

fn openexr_reads_ours(name: &str, compression: Compression) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("ours.exr");
    let lfb = sample_lfb();
    write(&path, &lfb, compression, false)?;
    let image: Image = serde_json::from_str(&python("dump", Some(&path), "")?)?;

    check(image.compression == name && !image.decreasing, || image.compression.clone())?;
    check(image.window == [0, 0, 39, 5], || format!("{:?}", image.window))?;
    let names: Vec<_> = image.channels.keys().map(String::as_str).collect();
    check(names == ["A", "B", "G", "R", "Z"], || format!("{names:?}"))?;
    for (name, samples) in &image.channels {
        check(samples.kind.as_deref() == Some("float"), || format!("{name}: {:?}", samples.kind))?;
        let value = |f: &Fragment| {
            let [r, g, b, a] = f.rgba8().map(|c| f64::from(c) / 255.0);
            match name.as_str() {
                "A" => a as f32,
                "R" => (r * a) as f32,
                "G" => (g * a) as f32,
                "B" => (b * a) as f32,
                _ => f.depth(),
            }
        };
        check(samples.pixels.len() == lfb.pixels(), || format!("{} pixels", samples.pixels.len()))?;
        for (pixel, found) in samples.pixels.iter().enumerate() {
            let found: Vec<_> = found.iter().map(|&sample| sample as f32).collect();
            let expected: Vec<_> = lfb.pixel(pixel).iter().map(value).collect();
            check(found == expected, || {
                format!("{name} of pixel {pixel} is {found:?}, not {expected:?}")
            })?;
        }
    }
    Ok(())
}

fn openexrs_is_read(
    name: &str,
    compression: Compression,
    kind: &str,
    decreasing: bool,
) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("theirs.exr");
    let source = sample_lfb();
    let channel = |kind: &str, value: &dyn Fn(&Fragment) -> f64| Samples {
        kind: Some(kind.to_owned()),
        pixels: (0..source.pixels())
            .map(|pixel| source.pixel(pixel).iter().map(value).collect())
            .collect(),
    };
    let premultiplied = |i: usize| {
        move |f: &Fragment| f64::from(f.rgba8()[i]) / 255.0 * f64::from(f.rgba8()[3]) / 255.0
    };
    let mut channels = BTreeMap::new();
    channels.insert("A".to_owned(), channel(kind, &|f| f64::from(f.rgba8()[3]) / 255.0));
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.insert(name.to_owned(), channel(kind, &premultiplied(i)));
    }
    channels.insert("Z".to_owned(), channel("float", &|f| f64::from(f.depth())));
    channels.insert("ZBack".to_owned(), channel(kind, &|_| 1.0));
    channels.insert("id".to_owned(), channel("uint", &|f| f64::from(f.rgba)));
    let image =
        Image { compression: name.to_owned(), decreasing, window: [-3, 100, 36, 105], channels };
    python("make", Some(&path), &serde_json::to_string(&image)?)?;

    let (info, lfb) = read(&path)?;
    check(info.compression == compression, || format!("{:?}", info.compression))?;
    let order = if decreasing { LineOrder::Decreasing } else { LineOrder::Increasing };
    check(info.line_order == order, || format!("{:?}", info.line_order))?;
    check(info.data_window == Window { min: [-3, 100], max: [36, 105] }, || {
        format!("{:?}", info.data_window)
    })?;
    check(info.skipped == ["ZBack", "id"] && info.missing.is_empty(), || {
        format!("{:?}", info.skipped)
    })?;
    let types: Vec<_> = info.channels.iter().map(|channel| channel.sample_type).collect();
    let colour = if kind == "half" { SampleType::Half } else { SampleType::Float };
    let expected_types =
        [colour, colour, colour, colour, SampleType::Float, colour, SampleType::Uint];
    check(types == expected_types, || format!("{types:?}"))?;

    check(lfb.offsets() == source.offsets(), || "other counts".to_owned())?;
    // A half has 11 bits, enough for 8 of colour even after a division.
    for (i, (found, meant)) in lfb.fragments().iter().zip(source.fragments()).enumerate() {
        let (rgba, expected) = (found.rgba8(), meant.rgba8());
        let expected = if expected[3] == 0 { [0; 4] } else { expected };
        let same = rgba == expected && found.depth_key == meant.depth_key;
        check(same, || format!("fragment {i} is {found:?}, not {meant:?}"))?;
    }
    let bound = if kind == "half" { 5e-4 } else { 1e-7 };
    check(info.largest_error < bound, || format!("off by {}", info.largest_error))
}
