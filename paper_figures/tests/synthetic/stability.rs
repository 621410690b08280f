//! A synthetic record of a stability experiment, one cell for each word of the rule. No number here was
//! measured.

use std::path::Path;

use oit_image::{Image, write_png};
use oit_record::{Cell, Change, Event, Run, RunWriter, Stability, Verdict, Verification};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

const SORTED: &str = "linked_list/bma-list/insertion/compute/peak";
const DROPPED: &str = "linked_list/bma-list/insertion/compute/peak/pool50-drop";

/// Scene, view, technique, and the word that its figures ask for.
pub(crate) const CELLS: &[(&str, &str, &str, &str)] = &[
    ("stack{count=8}", "front", SORTED, "right"),
    ("stack{count=8}", "front", DROPPED, "varies"),
    ("stack{count=8}", "front", "weighted", "off"),
    ("stack{count=8}", "front", "stochastic", "close"),
    ("stack{count=8}", "front", "depth_peel", "broke"),
    ("stack{count=8}", "front", "moments4", "not finite"),
    ("stack{count=8}", "front", "k_nearest", "lost"),
    ("stack{count=8,shuffle=1}", "front", SORTED, "right"),
    ("stack{count=8,shuffle=1}", "front", "multi_layer", "moves"),
    ("stack{count=9000}", "front", SORTED, "refused"),
    ("stack{count=9000}", "front", "depth_peel", "wrong"),
    ("shells", "drift@0", "weighted", ""),
    ("shells", "drift@3", "weighted", "flickers"),
    ("shells", "drift@6", "weighted", ""),
    ("shells", "drift@0", "hybrid", ""),
    ("shells", "drift@3", "hybrid", "steady"),
    ("nonfinite{kind=\"removed\"}", "front", SORTED, "right"),
    ("nonfinite{kind=\"nan\"}", "front", SORTED, "right"),
    ("nonfinite{kind=\"huge\"}", "front", SORTED, "drawn"),
];

fn result(place: usize, view: &str, word: &str) -> Option<Verification> {
    let whole = verification("linked_list/bma-list/insertion/compute/peak", 8);
    let change = |px: u64, max: f64| Some(Change { px, max, rms: max / 10.0 });
    let stability = Stability {
        runs: 21,
        pictures: if word == "varies" { 3 } else { 1 },
        hash: format!("{place:016x}"),
        change: match word {
            "moves" => change(12, 0.25),
            "flickers" => change(7, 0.125),
            "steady" => change(0, 0.002),
            // The last frame of a path flickers less.
            "" if view == "drift@6" => change(3, 0.01),
            _ => None,
        },
    };
    let (verdict, wrong_px, max_error) = match word {
        "right" | "drawn" => (Verdict::Exact, 0, 1e-8),
        "close" => (Verdict::Approximate, 0, 0.003),
        "wrong" => (Verdict::Wrong, 5, 0.75),
        "lost" => (Verdict::Approximate, 6, 0.5),
        "not finite" => (Verdict::Approximate, 4, f64::MAX),
        "refused" | "broke" => return None,
        _ => (Verdict::Approximate, 20, 0.125),
    };
    let repeat_differs_px = Some(if word == "varies" { 31 } else { 0 });
    let note = (verdict == Verdict::Wrong).then(|| "5 wrong pixels".to_owned());
    let stability = Some(stability);
    Some(Verification { verdict, wrong_px, max_error, note, repeat_differs_px, stability, ..whole })
}

/// Writes a run of the experiment `stability-test`, with the pictures of what breaks.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let cell = |&(scene, view, technique, _): &(&str, &str, &str, &str)| Cell {
        technique: technique.to_owned(),
        scene: scene.to_owned(),
        view: view.to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    };
    let cells: Vec<Cell> = CELLS.iter().map(cell).collect();
    let run = Run { experiment: "stability-test".to_owned(), ..run_of(device, cells.clone()) };
    let mut writer = RunWriter::create(folder, &run).unwrap();
    let mut counted: Vec<String> = Vec::new();
    for cell in &cells {
        let group = cell.group();
        if counted.contains(&group) {
            continue;
        }
        counted.push(group.clone());
        // One mesh draws a triangle that it must not.
        let pixels = if cell.scene.contains("huge") { 11 } else { 10 };
        let histogram = vec![u64::from(WIDTH_PX * HEIGHT_PX) - pixels, pixels];
        writer.append(&Event::Counted { group, triangles: 9, spheres: None, histogram }).unwrap();
    }
    for (place, ((_, view, _, word), name)) in CELLS.iter().zip(&cells).enumerate() {
        let event = match (*word, result(place, view, word)) {
            (_, Some(result)) => {
                if result.breaks() {
                    write_images(folder, name);
                }
                Event::Verified { cell: place, result }
            }
            ("refused", None) => {
                Event::Skipped { cell: place, reason: "9000 fragments on one pixel".to_owned() }
            }
            (_, None) => {
                Event::Failed { cell: place, reason: "the worker process ended".to_owned() }
            }
        };
        writer.append(&event).unwrap();
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}

fn write_images(folder: &Path, cell: &Cell) {
    let Cell { technique, scene, view, width_px, height_px } = cell;
    let name = format!("{scene}_{view}_{width_px}x{height_px}_{technique}");
    let safe = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let stem = folder.join("images").join(name.replace(|c: char| !safe(c), "_"));
    std::fs::create_dir_all(stem.parent().unwrap()).unwrap();
    for (ending, grey) in [("picture", 0.25), ("right", 0.75)] {
        let pixels = vec![[grey, grey, grey, 1.0]; (WIDTH_PX * HEIGHT_PX) as usize];
        let image = Image { width: WIDTH_PX, height: HEIGHT_PX, pixels };
        let path = format!("{}.{ending}.png", stem.display());
        write_png(Path::new(&path), &image, [1.0; 3]).unwrap();
    }
}
