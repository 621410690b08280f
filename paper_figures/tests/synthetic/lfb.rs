//! Synthetic records of the layered fragment buffer chapter's experiments. No number here was
//! measured: times are made up of a cost a fragment, so that it is known what figures must show.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_record::statistics::SplitMix64;
use oit_record::{Cell, Event, RunWriter, Verdict, Verification};

use super::{HEIGHT_PX, WIDTH_PX, run_of, write_bump};

const SAMPLES: u32 = 6;
const PIXELS: u64 = (WIDTH_PX * HEIGHT_PX) as u64;

/// Every layout; the last only with lists.
const LAYOUTS: [&str; 15] = [
    "linked_list",
    "linked_list_subgroup",
    "linked_pages4",
    "linked_pages6",
    "array3d",
    "array3d_nearest",
    "linearized",
    "linearized_sweep",
    "linearized_lookback",
    "linearized_blend",
    "linearized_nearest",
    "linearized_unclipped",
    "linearized_late",
    "interleaved",
    "interleaved_lists",
];

/// Layers from which insertion sort takes more than half of the frame, by the costs below.
pub(crate) const HALF_FROM: f64 = 55.0;

/// Scene, view and histogram.
type View = (String, &'static str, Vec<u64>);

fn uniform(layers: u64, covered: u64) -> Vec<u64> {
    let mut histogram = vec![0; layers as usize + 1];
    (histogram[0], histogram[layers as usize]) = (PIXELS - covered, covered);
    histogram
}

/// As many pixels of each depth, and the rest empty.
fn spread(peak: u64, each: u64) -> Vec<u64> {
    let mut histogram = vec![each; peak as usize + 1];
    histogram[0] = PIXELS - each * peak;
    histogram
}

fn mesh_views() -> Vec<View> {
    vec![
        ("dragon".to_owned(), "front", spread(12, 120)),
        ("atrium".to_owned(), "lfb", spread(30, 170)),
    ]
}

fn total(histogram: &[u64]) -> u64 {
    (0..).zip(histogram).map(|(n, pixels)| n * pixels).sum()
}

/// Made-up nanoseconds a fragment: of capturing it.
fn capture_ns(layout: &str) -> f64 {
    match layout {
        "array3d" => 4.0,
        "linked_list" => 6.0,
        "linked_pages4" | "linked_pages6" => 8.0,
        _ => 4.5,
    }
}

/// Of reading, sorting and blending it, of `n` of a pixel.
fn resolve_ns(sort: &str, n: f64) -> f64 {
    match sort {
        "passthrough" => 1.5,
        "unsorted" => 5.0,
        "insertion" => 5.0 + 0.2 * n,
        "merge" => 9.0 + 1.5 * n.log2(),
        "insertion_merge" => 7.0 + 1.5 * n.log2(),
        _ => 5.0 + 0.4 * n.log2(),
    }
}

fn stages(technique: &str, histogram: &[u64], rng: &mut SplitMix64) -> BTreeMap<String, u64> {
    let parts: Vec<&str> = technique.split('/').collect();
    let (layout, schedule, sort, stage) = (parts[0], parts[1], parts[2], parts[3]);
    let fragments = total(histogram) as f64;
    let mut noise = |ns: f64| (ns * (1.0 + (rng.below(101) as f64 - 50.0) / 10_000.0)) as u64;
    let mut stages = BTreeMap::new();
    let mut charge = |stage: &str, ns: f64| stages.insert(stage.to_owned(), noise(ns));
    charge("clear", if layout.starts_with("linked") { 1_500.0 } else { 200.0 });
    if layout.starts_with("linearized") || layout.starts_with("interleaved") {
        let blend = layout == "linearized_blend";
        charge("count", fragments * if blend { 0.8 } else { 1.0 } + 200.0);
        charge("scan", 300.0);
    }
    charge("capture", fragments * capture_ns(layout));
    if schedule != "base" {
        charge("group", 500.0);
    }
    let resolve: f64 = (0_u32..)
        .zip(histogram)
        .skip(1)
        .map(|(n, &pixels)| f64::from(n) * pixels as f64 * resolve_ns(sort, f64::from(n)))
        .sum();
    // One program for all: empty pixels cost what an array of the greatest size costs.
    let empty = if schedule == "base" { histogram[0] as f64 * 20.0 } else { 0.0 };
    charge("resolve", resolve * if stage == "compute" { 0.3 } else { 1.0 } + empty);
    // A pool that grows renders twice.
    let pool = parts.last().and_then(|part| part.strip_prefix("pool")?.parse::<u32>().ok());
    if pool.is_some_and(|percent| percent < 100) {
        stages.entry("capture".to_owned()).and_modify(|ns| *ns *= 2);
    }
    stages
}

fn verification(technique: &str, histogram: &[u64]) -> Verification {
    let parts: Vec<&str> = technique.split('/').collect();
    let (fragments, peak) = (total(histogram), histogram.len() as u64 - 1);
    let pool = parts.last().and_then(|part| part.strip_prefix("pool"));
    let (percent, drop) = match pool.map(|pool| pool.trim_end_matches("-drop").parse::<u64>()) {
        Some(Ok(percent)) => (percent, pool.is_some_and(|pool| pool.ends_with("-drop"))),
        _ => (100, false),
    };
    let missing = if drop { fragments - fragments * percent.min(100) / 100 } else { 0 };
    let floor = ["passthrough", "unsorted"].contains(&parts[2]);
    let exact = !floor && missing == 0;
    let slots = match parts[0] {
        layout if layout.starts_with("array3d") => PIXELS * peak,
        layout if layout.starts_with("linked_pages") => fragments * 3 / 2,
        layout if layout.starts_with("interleaved") => fragments * 11 / 10,
        _ => fragments,
    };
    let padded = parts[0] == "linearized_sweep";
    let tables = 4 * if padded { PIXELS.next_power_of_two() } else { PIXELS };
    let lfb = tables + slots * if parts[0].starts_with("linked_list") { 12 } else { 8 };
    let nearest = parts[0].ends_with("nearest");
    Verification {
        verdict: if exact { Verdict::Exact } else { Verdict::Approximate },
        note: None,
        wrong_px: if exact { 0 } else { missing.min(PIXELS) / if nearest { 4 } else { 2 } },
        max_error: if exact { 1e-7 } else { missing as f64 / fragments as f64 },
        rmse: if exact { 0.0 } else { 0.1 },
        max_alpha_error: 0.0,
        fragments_missing: missing,
        fragments_extra: 0,
        fragments_compared: true,
        tied_px: 0,
        max_frags: peak.next_power_of_two() as u32,
        pool_initial: slots * percent / 100,
        pool_final: if drop { slots * percent / 100 } else { slots.max(slots * percent / 100) },
        pool_grown: u32::from(!drop && percent < 100),
        memory_bytes: lfb + PIXELS * 16,
        lfb_bytes: Some(lfb),
        peak_bytes: Some(lfb * 3 / 2 + PIXELS * 16),
        repeat_differs_px: Some(if missing > 0 && !nearest { 40 } else { 0 }),
        prepare_ms: 3.0,
        tuned: None,
        predicted_ns: None,
        ssim: None,
        flip: None,
        stability: None,
    }
}

/// Writes one run: techniques on views.
fn write(folder: &Path, device: &str, views: &[View], techniques: &[String]) -> PathBuf {
    let cell = |(scene, view, _): &View, technique: &String| Cell {
        technique: technique.clone(),
        scene: scene.clone(),
        view: (*view).to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    };
    let cells: Vec<(Cell, &[u64])> = views
        .iter()
        .flat_map(|view| techniques.iter().map(move |name| (cell(view, name), &*view.2)))
        .collect();
    let run = run_of(device, cells.iter().map(|(cell, _)| cell.clone()).collect());
    let mut writer = RunWriter::create(folder, &run).unwrap();
    for (scene, view, histogram) in views {
        let group = format!("{scene}:{view}@{WIDTH_PX}x{HEIGHT_PX}");
        let histogram = histogram.clone();
        writer.append(&Event::Counted { group, triangles: 100, spheres: None, histogram }).unwrap();
    }
    let mut rng = SplitMix64(20);
    for (cell, (name, histogram)) in cells.iter().enumerate() {
        let result = verification(&name.technique, histogram);
        writer.append(&Event::Verified { cell, result }).unwrap();
        for sample in 0..SAMPLES {
            let stages_ns = stages(&name.technique, histogram, &mut rng);
            let total_ns = stages_ns.values().sum::<u64>() + 100;
            let parts_ns = BTreeMap::new();
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
    folder.to_owned()
}

fn product(layouts: &[&str], schedules: &[&str], sorts: &[&str], ends: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    for layout in layouts {
        for schedule in schedules {
            // Lists of pixels are of the schedules that make them.
            if *layout == "interleaved_lists" && *schedule != "bma-list" {
                continue;
            }
            for sort in sorts {
                all.extend(ends.iter().map(|end| format!("{layout}/{schedule}/{sort}/{end}")));
            }
        }
    }
    all
}

const TWO: [&str; 2] = ["linearized", "linked_list"];

/// Writes the runs of the chapter's experiments into a folder.
pub(crate) fn write_runs(root: &Path, device: &str) {
    let floors = ["insertion", "unsorted", "passthrough"];
    let mut table = product(&TWO, &["base-stencil", "base"], &floors, &["fragment/peak"]);
    table.extend(product(&TWO, &["base", "bma-list"], &floors, &["compute/peak"]));
    let run = write(&root.join("lfb-table-20-1"), device, &mesh_views(), &table);
    write_bump(&run, "dragon_front", 12.0);
    write_bump(&run, "atrium_lfb", 40.0);

    let mut layouts = product(&LAYOUTS, &["base"], &["insertion"], &["fragment/peak"]);
    layouts.extend(product(&LAYOUTS, &["base"], &["passthrough"], &["compute/peak"]));
    layouts.extend(product(&LAYOUTS, &["bma-list"], &["network+rbs"], &["compute/peak"]));
    write(&root.join("lfb-layouts"), device, &mesh_views(), &layouts);

    let mut sizes = ["0.25", "0.5", "0.75", "1"]
        .map(|size| {
            let side: f64 = size.parse().unwrap();
            let covered = (PIXELS as f64 * side * side) as u64;
            (format!("grid{{size={size}}}"), "front", uniform(10, covered))
        })
        .to_vec();
    // And more layers of one size.
    for layers in [5, 20] {
        let covered = PIXELS / 4;
        sizes.push((
            format!("grid{{layers={layers},size=0.5}}"),
            "front",
            uniform(layers, covered),
        ));
    }
    let mut growing = product(&LAYOUTS, &["base-stencil"], &["insertion"], &["fragment/peak"]);
    growing.extend(product(&LAYOUTS, &["bma-list"], &["insertion"], &["compute/peak"]));
    write(&root.join("lfb-figure-20-11"), device, &sizes, &growing);

    let depths = [10_u64, 20, 40, 60, 100].map(|layers| {
        let scene =
            format!("grid{{layers={layers},size={:.3}}}", (40.0 / layers as f64).sqrt() / 2.0);
        (scene, "front", uniform(layers, 40_000 / layers))
    });
    let sorts = ["insertion", "merge", "insertion_merge", "unsorted", "passthrough", "network+rbs"];
    let mut deepening = product(&TWO, &["base-stencil"], &sorts, &["fragment/peak"]);
    deepening.extend(product(&TWO, &["bma-list"], &sorts, &["compute/peak"]));
    write(&root.join("lfb-figure-20-12"), device, &depths, &deepening);

    let stack = [("stack{count=8,size=3.6}".to_owned(), "front", uniform(8, PIXELS))];
    let ends = ["fragment/max256", "compute/max256"];
    let array = product(&TWO, &["base"], &["unsorted", "passthrough"], &ends);
    write(&root.join("lfb-array"), device, &stack, &array);

    let resolve = "bma-list/network+rbs/compute/peak";
    let mut overflow = Vec::new();
    for layout in ["linked_list", "linearized", "array3d"] {
        overflow.push(format!("{layout}/{resolve}"));
        overflow.extend([25, 50, 75, 150].map(|room| format!("{layout}/{resolve}/pool{room}")));
        overflow.extend(
            [25, 50, 75, 100, 150].map(|room| format!("{layout}/{resolve}/pool{room}-drop")),
        );
    }
    for layout in ["linearized_nearest", "array3d_nearest"] {
        overflow.extend(
            [25, 50, 75, 100, 150].map(|room| format!("{layout}/{resolve}/pool{room}-drop")),
        );
    }
    write(&root.join("lfb-overflow"), device, &mesh_views()[1..], &overflow);
}
