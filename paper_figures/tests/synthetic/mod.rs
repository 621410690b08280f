//! Synthetic records of a device that does not exist. No number here was measured.

pub(crate) mod approx;
pub(crate) mod bma;
pub(crate) mod compared;
pub(crate) mod compile;
pub(crate) mod flight;
pub(crate) mod lfb;
pub(crate) mod mechanism;
pub(crate) mod peel;
pub(crate) mod probe;
pub(crate) mod rbs;
pub(crate) mod spheres;
pub(crate) mod stability;
pub(crate) mod work;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_record::statistics::SplitMix64;
use oit_record::{
    Cell, DeviceInfo, Event, Host, Run, RunWriter, SCHEMA_VERSION, Verdict, Verification,
};

/// Views, with the depth of their deepest pixel.
pub(crate) const VIEWS: &[(&str, &str, u32)] = &[
    ("planes", "front", 128),
    ("planes", "back", 128),
    ("hairball", "inside-front", 200),
    ("hairball", "inside-back", 206),
    ("grid{layers=8}", "front", 8),
    ("grid{layers=24}", "front", 24),
    ("grid{layers=64}", "front", 64),
    ("dragon", "front", 12),
];

/// The views of Table 2 of the register-based block sort paper that are not among [`VIEWS`].
pub(crate) const RBS_VIEWS: &[(&str, &str, u32)] = &[
    ("powerplant", "rbs-v1", 424),
    ("powerplant", "rbs-v2", 250),
    ("powerplant", "rbs-v3", 118),
    ("atrium", "rbs-v1", 45),
    ("atrium", "rbs-v2", 27),
];

/// The technique that gets its picture wrong, in an impossibly short time.
pub(crate) const WRONG: &str = "linked_list/base/network+rbs/compute/peak";

/// A technique whose intervals are left to measurements.
pub(crate) const OPTIMAL: &str =
    "linked_list/bma-stencil/insertion/fragment/peak/ties-depth/intervals-optimal";

pub(crate) const WIDTH_PX: u32 = 96;
pub(crate) const HEIGHT_PX: u32 = 54;
const SAMPLES: u32 = 12;

fn techniques() -> Vec<String> {
    let mut all = Vec::new();
    for sort in ["insertion", "insertion_merge", "merge", "rbs"] {
        for schedule in ["base", "bma-stencil"] {
            all.push(format!("linked_list/{schedule}/{sort}/fragment/peak/ties-depth"));
        }
    }
    for capture in ["linked_list", "linearized"] {
        for sort in ["insertion", "rbs", "network+rbs", "passthrough"] {
            for schedule in ["base", "bma-list"] {
                all.push(format!("{capture}/{schedule}/{sort}/compute/peak"));
            }
        }
        all.push(format!("{capture}/base/insertion/fragment/peak"));
    }
    for max in [4, 8, 16, 32] {
        all.push(format!("linked_list/base/insertion/compute/max{max}"));
        all.push(format!("linked_list/bma-list/rbs/compute/max{max}"));
    }
    all.push(OPTIMAL.to_owned());
    all
}

/// `histogram[n]` pixels have `n` fragments: fewer the deeper, one at the peak at least.
fn histogram(scene: &str, peak: u32) -> Vec<u64> {
    let pixels = u64::from(WIDTH_PX * HEIGHT_PX);
    let mut histogram = vec![0; peak as usize + 1];
    if scene.starts_with("grid") {
        histogram[peak as usize] = pixels;
        return histogram;
    }
    for (depth, count) in histogram.iter_mut().enumerate().skip(1) {
        *count = pixels / (4 + depth as u64 * depth as u64) + 1;
    }
    histogram[0] = pixels - histogram.iter().sum::<u64>();
    histogram
}

/// Made-up nanoseconds of each stage.
fn stages(technique: &str, view: &str, peak: u32, rng: &mut SplitMix64) -> BTreeMap<String, u64> {
    let parts: Vec<&str> = technique.split('/').collect();
    let depth = parts[4].strip_prefix("max").map_or(peak, |max| max.parse().unwrap()).min(peak);
    let n = f64::from(depth);
    let reversed = view.contains("back");
    let sort = match parts[2] {
        "insertion" if reversed => n * n,
        "insertion" => n * 6.0,
        "merge" | "insertion_merge" => n * 16.0,
        "passthrough" => n,
        _ => n * 4.0,
    };
    let occupancy = if parts[1] == "base" { 1.0 + n / 60.0 } else { 1.0 };
    let stage = if parts[3] == "compute" { 0.3 } else { 1.0 };
    let mut noise = |ns: f64| (ns * (1.0 + (rng.below(401) as f64 - 200.0) / 10_000.0)) as u64;
    let mut stages = BTreeMap::new();
    stages.insert("clear".to_owned(), noise(3_000.0));
    if parts[0] == "linearized" {
        stages.insert("count".to_owned(), noise(40_000.0));
        stages.insert("scan".to_owned(), noise(9_000.0));
    }
    stages.insert("capture".to_owned(), noise(700.0 * f64::from(peak)));
    if parts[1] != "base" {
        stages.insert("group".to_owned(), noise(12_000.0));
    }
    stages.insert("resolve".to_owned(), noise((sort + n) * 90.0 * occupancy * stage));
    stages
}

fn verification(technique: &str, peak: u32) -> Verification {
    let parts: Vec<&str> = technique.split('/').collect();
    let max = parts[4].strip_prefix("max").map(|max| max.parse::<u32>().unwrap());
    let rmse = match max {
        Some(max) if max < peak => 0.2 * f64::from(peak - max) / f64::from(peak),
        Some(_) => 0.0,
        None if parts[2] == "passthrough" => 0.3,
        None => 0.0,
    };
    let verdict = match () {
        () if technique == WRONG => Verdict::Wrong,
        () if max.is_some() || parts[2] == "passthrough" => Verdict::Approximate,
        () => Verdict::Exact,
    };
    Verification {
        verdict,
        note: (verdict == Verdict::Wrong).then(|| "12 px differ".to_owned()),
        wrong_px: if verdict == Verdict::Exact { 0 } else { 12 },
        max_error: rmse * 2.0,
        rmse,
        max_alpha_error: rmse,
        fragments_missing: 0,
        fragments_extra: 0,
        fragments_compared: true,
        tied_px: 0,
        max_frags: peak.next_power_of_two(),
        pool_initial: 1000,
        pool_final: 1000,
        pool_grown: 0,
        memory_bytes: if parts[0] == "linked_list" { 12_500_000 } else { 10_000_000 },
        lfb_bytes: None,
        peak_bytes: None,
        repeat_differs_px: None,
        prepare_ms: 3.0,
        tuned: (technique == OPTIMAL).then(|| technique.replace("-optimal", "4-12-256")),
        predicted_ns: Some(if technique == OPTIMAL { 900.0 } else { 1000.0 }),
        ssim: None,
        flip: None,
        stability: None,
    }
}

/// The run of a device named so.
fn run_of(device: &str, cells: Vec<Cell>) -> Run {
    Run {
        schema: SCHEMA_VERSION,
        experiment: "synthetic".to_owned(),
        experiment_toml: String::new(),
        profile: "quick".to_owned(),
        device: DeviceInfo {
            id: "test:0".to_owned(),
            backend: "test".to_owned(),
            name: device.to_owned(),
            driver: "test driver 1.0".to_owned(),
            api: "Test 1.0".to_owned(),
            ..DeviceInfo::default()
        },
        host: Host::default(),
        oit_version: "0.0.0".to_owned(),
        git_commit: Some("0123456789abcdef0123456789abcdef01234567".to_owned()),
        git_dirty: Some(false),
        command: ["oit", "sweep", "experiments/synthetic.toml"].map(str::to_owned).to_vec(),
        seed: 1,
        started: "2026-01-01T00:00:00Z".to_owned(),
        cells,
    }
}

/// Writes a run folder of a device named so.
pub(crate) fn write_run(root: &Path, folder: &str, device: &str) -> PathBuf {
    write_views(&root.join(folder), device, VIEWS, &techniques())
}

/// Writes a run of the paper's own techniques on the rest of its views.
pub(crate) fn write_rbs_views(folder: &Path, device: &str) -> PathBuf {
    let mut techniques = techniques();
    techniques.retain(|technique| technique.ends_with("/ties-depth") && technique != OPTIMAL);
    write_views(folder, device, RBS_VIEWS, &techniques)
}

fn write_views(
    folder: &Path,
    device: &str,
    views: &[(&str, &str, u32)],
    techniques: &[String],
) -> PathBuf {
    let folder = folder.to_owned();
    let cells: Vec<(Cell, u32)> = views
        .iter()
        .flat_map(|&(scene, view, peak)| {
            techniques.iter().cloned().map(move |technique| {
                let (scene, view) = (scene.to_owned(), view.to_owned());
                let (width_px, height_px) = (WIDTH_PX, HEIGHT_PX);
                (Cell { technique, scene, view, width_px, height_px }, peak)
            })
        })
        .collect();
    let run = run_of(device, cells.iter().map(|(cell, _)| cell.clone()).collect());
    let mut writer = RunWriter::create(&folder, &run).unwrap();
    for &(scene, view, peak) in views {
        let group = format!("{scene}:{view}@{WIDTH_PX}x{HEIGHT_PX}");
        let histogram = histogram(scene, peak);
        writer.append(&Event::Counted { group, triangles: 100, spheres: None, histogram }).unwrap();
    }
    let mut rng = SplitMix64(7);
    for (cell, (name, peak)) in cells.iter().enumerate() {
        let result = verification(&name.technique, *peak);
        writer.append(&Event::Verified { cell, result }).unwrap();
        for sample in 0..SAMPLES {
            let mut stages_ns = stages(&name.technique, &name.view, *peak, &mut rng);
            if name.technique == WRONG {
                stages_ns.values_mut().for_each(|ns| *ns = 1);
            }
            let total_ns = stages_ns.values().sum::<u64>() + 500;
            let parts_ns = BTreeMap::new();
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
    folder
}

/// Writes the map of counts that belongs to the hairball from inside.
pub(crate) fn write_counts(run: &Path) -> PathBuf {
    write_bump(run, "hairball_inside-front", 200.0)
}

/// Writes a map of counts that rises to a peak in the middle.
pub(crate) fn write_bump(run: &Path, view: &str, peak: f64) -> PathBuf {
    let counts = run.join("counts");
    std::fs::create_dir_all(&counts).unwrap();
    let path = counts.join(format!("{view}_{WIDTH_PX}x{HEIGHT_PX}.png"));
    let value = |index: u32| {
        let (x, y) = (f64::from(index % WIDTH_PX), f64::from(index / WIDTH_PX));
        let (dx, dy) = (x / f64::from(WIDTH_PX) - 0.5, y / f64::from(HEIGHT_PX) - 0.5);
        (peak * (1.0 - 3.0 * (dx * dx + dy * dy))).max(0.0) as u32
    };
    let pixels: Vec<u32> = (0..WIDTH_PX * HEIGHT_PX).map(value).collect();
    oit_image::write_png16_gray(&path, WIDTH_PX, HEIGHT_PX, &pixels).unwrap();
    path
}
