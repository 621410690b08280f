//! Synthetic records of the backwards memory allocation paper's experiments. No number here was
//! measured: a pixel's resolve costs its fragments times what the array costs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_image::{Image, write_png, write_png16_gray};
use oit_record::{Cell, Event, RunWriter, Verdict, Verification};

use super::{HEIGHT_PX, WIDTH_PX, histogram, run_of, verification, write_bump};

/// The paper's views, their deepest pixel, and the sizes of array of Table 2.
const VIEWS: [(&str, u32, [u32; 2]); 3] =
    [("atrium", 46, [64, 128]), ("smoke", 136, [256, 512]), ("powerplant", 278, [256, 512])];

const SAMPLES: u32 = 5;

/// What a fragment costs by its sort, in ns a pixel of eight.
const SORTS: [(&str, f64); 5] =
    [("insertion", 8.0), (OIT_SORT, 6.0), (BMA_OIT_SORT, 6.0), ("merge", 10.0), ("rbs", 4.0)];

/// The sorts of OIT and of BMA-OIT.
const OIT_SORT: &str = "insertion_merge64";
const BMA_OIT_SORT: &str = "insertion@16+merge";

fn techniques(sizes: [u32; 2]) -> Vec<String> {
    let mut all = Vec::new();
    for stage in ["fragment", "compute"] {
        let bma = if stage == "fragment" { "bma-stencil" } else { "bma-list" };
        for max in sizes.map(|size| format!("max{size}")) {
            for (schedule, sort) in [("base", OIT_SORT), (bma, BMA_OIT_SORT)] {
                all.push(format!("linked_list/{schedule}/{sort}/{stage}/{max}/ties-depth"));
            }
        }
        for (schedule, sort) in [("base-intervals", OIT_SORT), (bma, BMA_OIT_SORT)] {
            all.push(format!("linked_list/{schedule}/{sort}/{stage}/peak/ties-depth"));
        }
        for sort in ["insertion", "merge", "rbs"] {
            all.push(format!("linked_list/{bma}/{sort}/{stage}/peak/ties-depth"));
        }
    }
    for max in ["max8", "max32", "peak"] {
        all.push(format!("linked_list/bma-list/{BMA_OIT_SORT}/compute/{max}"));
    }
    all.push(STENCIL_COUNT.to_owned());
    all
}

/// Skipped on the power plant.
const STENCIL_COUNT: &str = "linked_list/bma-stencil-count/insertion/fragment/peak/ties-depth";

/// Nanoseconds of the resolve of each interval, and of the grouping of one.
pub(crate) fn intervals(technique: &str, histogram: &[u64]) -> BTreeMap<u32, u64> {
    let parts: Vec<&str> = technique.split('/').collect();
    let peak = histogram.len() as u32 - 1;
    let max = parts[4].strip_prefix("max").map_or(peak.next_power_of_two(), |n| n.parse().unwrap());
    let sort = SORTS.iter().find(|(sort, _)| *sort == parts[2]).unwrap().1;
    let mut uppers = vec![8];
    while uppers[uppers.len() - 1] < max {
        uppers.push(uppers[uppers.len() - 1] * 2);
    }
    let cost = |(place, &upper): (usize, &u32)| {
        let lower = if place == 0 { 1 } else { upper / 2 + 1 };
        let last = place + 1 == uppers.len();
        let array = if parts[1].starts_with("base") { max } else { upper };
        let ns: f64 = (lower..=if last { peak.max(upper) } else { upper })
            .filter_map(|depth| Some((depth, *histogram.get(depth as usize)?)))
            .map(|(depth, pixels)| f64::from(depth) * pixels as f64 * sort * f64::from(8 + array))
            .sum();
        (upper, ns as u64 + 100)
    };
    uppers.iter().enumerate().map(cost).collect()
}

fn verdict(technique: &str, peak: u32) -> Verification {
    let max = technique.split('/').nth(4).unwrap().strip_prefix("max");
    let max: u32 = max.map_or(peak.next_power_of_two(), |max| max.parse().unwrap());
    let wrong_px = if max < peak { u64::from(peak - max) } else { 0 };
    let verdict = if max < peak { Verdict::Approximate } else { Verdict::Exact };
    Verification { verdict, wrong_px, max_frags: max, ..verification(technique, peak) }
}

/// Writes the run, its maps of counts, and the pictures of the three sizes of array.
pub(crate) fn write_run(root: &Path, device: &str) -> PathBuf {
    let folder = root.join("bma");
    let mut cells = Vec::new();
    for (scene, peak, sizes) in VIEWS {
        for technique in techniques(sizes) {
            let (scene, view) = (scene.to_owned(), "bma".to_owned());
            let (width_px, height_px) = (WIDTH_PX, HEIGHT_PX);
            cells.push((Cell { technique, scene, view, width_px, height_px }, peak));
        }
    }
    let run = run_of(device, cells.iter().map(|(cell, _)| cell.clone()).collect());
    let mut writer = RunWriter::create(&folder, &run).unwrap();
    for (scene, peak, _) in VIEWS {
        let group = format!("{scene}:bma@{WIDTH_PX}x{HEIGHT_PX}");
        let histogram = histogram(scene, peak);
        writer
            .append(&Event::Counted { group, triangles: 13_468, spheres: None, histogram })
            .unwrap();
        write_bump(&folder, &format!("{scene}_bma"), f64::from(peak));
    }
    for (cell, (name, peak)) in cells.iter().enumerate() {
        let histogram = histogram(&name.scene, *peak);
        if name.technique == STENCIL_COUNT && name.scene == "powerplant" {
            let reason = "the stencil counts 255 fragments at most".to_owned();
            writer.append(&Event::Skipped { cell, reason }).unwrap();
            continue;
        }
        let result = verdict(&name.technique, *peak);
        writer.append(&Event::Verified { cell, result }).unwrap();
        for sample in 0..SAMPLES {
            let event = timing(cell, sample, &name.technique, &histogram);
            writer.append(&event).unwrap();
        }
        if !name.technique.contains("ties-depth") {
            write_images(&folder, name);
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
    folder
}

fn timing(cell: usize, sample: u32, technique: &str, histogram: &[u64]) -> Event {
    let resolves = intervals(technique, histogram);
    let named = |(upper, ns): (&u32, &u64)| (format!("resolve[{upper}]"), ns + u64::from(sample));
    let base = technique.contains("/base/");
    let parts_ns: BTreeMap<String, u64> =
        if base { BTreeMap::new() } else { resolves.iter().map(named).collect() };
    let resolve = resolves.values().sum::<u64>() + u64::from(sample);
    let mut stages_ns = BTreeMap::from([("resolve".to_owned(), resolve)]);
    let count = technique.contains("stencil-count");
    stages_ns.insert("capture".to_owned(), if count { 9_000 } else { 10_000 });
    if !base {
        stages_ns.insert("group".to_owned(), 10 * resolves.len() as u64);
    }
    let total_ns = stages_ns.values().sum::<u64>() + 100;
    Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }
}

/// The stem of a cell's pictures.
pub(crate) fn images(folder: &Path, cell: &Cell) -> PathBuf {
    let Cell { technique, scene, view, width_px, height_px } = cell;
    let name = format!("{scene}_{view}_{width_px}x{height_px}_{technique}");
    let name = name.replace(['/', '@', '+'], "_");
    folder.join("images").join(name)
}

/// Writes made-up pictures of a cell.
pub(crate) fn write_images(folder: &Path, cell: &Cell) {
    let stem = images(folder, cell);
    std::fs::create_dir_all(stem.parent().unwrap()).unwrap();
    let path = |ending: &str| PathBuf::from(format!("{}.{ending}.png", stem.display()));
    let image = |width: u32, height: u32| {
        let pixel = |i: u32| [(i % width) as f32 / width as f32, 0.5, 0.5, 1.0];
        Image { width, height, pixels: (0..width * height).map(pixel).collect() }
    };
    // Scaled down by two; the detail is a part of it; errors are not scaled down.
    write_png(&path("picture"), &image(WIDTH_PX / 2, HEIGHT_PX / 2), [1.0; 3]).unwrap();
    write_png(&path("detail"), &image(40, 25), [1.0; 3]).unwrap();
    let errors: Vec<u32> = (0..WIDTH_PX * HEIGHT_PX).map(|i| i % 97).collect();
    write_png16_gray(&path("error"), WIDTH_PX, HEIGHT_PX, &errors).unwrap();
}
