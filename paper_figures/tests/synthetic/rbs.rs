//! A test fixture: sorts where every pixel has the same number of fragments, in compute and in CUDA, and
//! sorts in registers with what is told of their programs, all on a device that does not exist, with
//! times made up so that it is known what figures and claims must say. Nothing here was measured.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{Cell, Event, Executable, Program, RunWriter, Statistic, StatisticValue, Verdict};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// Fragments of every pixel.
pub(crate) const DEPTHS: [u32; 8] = [8, 16, 32, 64, 128, 256, 512, 1024];

/// The made-up time of passthrough, in nanoseconds: those of the others are multiples of it.
const FLOOR_NS: f64 = 50_000.0;

/// A sort's name, the most fragments it holds, and its time over passthrough's at so many fragments.
type Sort = (&'static str, u32, fn(f64) -> f64);

/// The sorts in compute, with made-up times.
const SORTS: &[Sort] = &[
    ("passthrough", 4096, |_| 1.0),
    ("unsorted", 4096, |_| 1.1),
    ("insertion", 4096, |n| 1.0 + n / 8.0),
    ("merge", 4096, |n| 4.0 + n / 40.0),
    ("heap", 4096, |n| 5.0 + n / 50.0),
    ("rbs8", 256, |n| 1.5 + n / 12.0),
    ("rbs16", 512, |n| 1.5 + n / 20.0),
    ("rbs", 1024, |n| 1.5 + n / 30.0),
    // Faster than the linear search from 1024 fragments on.
    ("rbs_heap", 1024, |n| 10.0 + n / 45.0),
    ("rbs_hier", 4096, |n| 9.0 + n / 35.0),
    ("network", 64, |n| 1.0 + n / 400.0),
    ("network_merge32", 1024, |n| 1.2 + n / 150.0),
    ("network_merge", 2048, |n| 1.2 + n / 200.0),
    ("cooperative16", 512, |n| 1.3 + n / 500.0),
];

/// Sorts in CUDA, with their time over that in compute.
const CUDA: &[(&str, f64)] = &[("insertion", 0.5), ("rbs", 1.25)];

/// Sorts with programs of their own: the made-up time over that of insertion, registers, local bytes
/// a fragment and code bytes a fragment.
const PROGRAMS: &[(&str, f64, u64, u64, u64)] = &[
    ("insertion", 1.0, 24, 8, 100),
    ("rs", 0.4, 80, 0, 2000),
    ("rs_inner", 0.7, 72, 0, 500),
    ("network", 0.3, 90, 0, 1500),
    ("bitonic", 0.5, 90, 0, 1800),
    ("odd_even", 0.45, 88, 0, 1700),
];

struct Made {
    technique: String,
    depth: u32,
    ns: f64,
    program: Option<Program>,
}

fn program(sort: &str, depth: u32, (registers, local, code): (u64, u64, u64)) -> Program {
    let figure = |name: &str, value| Statistic {
        name: name.to_owned(),
        description: "made up".to_owned(),
        value: StatisticValue::Unsigned(value),
    };
    let depth_64 = u64::from(depth);
    let executable = |stage: &str| Executable {
        name: stage.to_owned(),
        stages: vec![stage.to_owned()],
        subgroup_size: 32,
        statistics: vec![
            figure("Register Count", registers),
            figure("Stack Size", local * depth_64),
            figure("Binary Size", code * depth_64),
        ],
    };
    Program {
        sort: sort.to_owned(),
        store: "local".to_owned(),
        low: 1,
        high: depth,
        invocations: None,
        declared_workgroup_bytes: None,
        compile_ns: Some(1000 * code * depth_64),
        from_cache: Some(false),
        executables: Some(vec![executable("vertex"), executable("fragment")]),
    }
}

fn made() -> Vec<Made> {
    let mut all = Vec::new();
    for depth in DEPTHS {
        let ns = |of: fn(f64) -> f64| FLOOR_NS * of(f64::from(depth));
        for (sort, _, of) in SORTS.iter().filter(|(_, most, _)| *most >= depth) {
            for capture in ["linked_list", "linearized", "interleaved"] {
                let technique = format!("{capture}/bma-list/{sort}/compute/peak");
                all.push(Made { technique, depth, ns: ns(*of), program: None });
            }
            let Some((_, over)) = CUDA.iter().find(|(cuda, _)| cuda == sort) else { continue };
            for (stage, factor) in [("compute", 1.0), ("cuda", *over)] {
                let technique = format!("linked_list/base/{sort}/{stage}/peak");
                all.push(Made { technique, depth, ns: ns(*of) * factor, program: None });
            }
        }
        for (sort, over, registers, local, code) in PROGRAMS.iter().filter(|_| depth <= 32) {
            let technique = format!("linked_list/base/{sort}/fragment/peak");
            let program = program(sort, depth, (*registers, *local, *code));
            let ns = FLOOR_NS * over * f64::from(depth);
            all.push(Made { technique, depth, ns, program: Some(program) });
        }
    }
    all
}

/// Fragments of 64 bits and of 128, on one view: the capture, what it takes to resolve by insertion
/// and what by rbs.
const FRAGMENTS: [(&str, u64, u64); 3] = [
    ("linked_list", 400_000, 200_000),
    ("linked_list128", 1_200_000, 300_000),
    ("linked_list128_indirect", 600_000, 330_000),
];

/// Writes a run folder with [`FRAGMENTS`].
pub(crate) fn write_fragments(folder: &Path, device: &str) {
    let name =
        |capture: &str, sort: &str| format!("{capture}/base/{sort}/fragment/peak/ties-depth");
    let techniques = FRAGMENTS.iter().flat_map(|(capture, insertion, rbs)| {
        [(name(capture, "insertion"), *insertion), (name(capture, "rbs"), *rbs)]
    });
    // Nobody sorts whole fragments of 128 bits by a network.
    let networks =
        ["linked_list", "linked_list128_indirect"].map(|c| (name(c, "network"), 100_000));
    let all: Vec<(String, u64)> = techniques.chain(networks).collect();
    let cells = all.iter().map(|(technique, _)| Cell {
        technique: technique.clone(),
        scene: "planes".to_owned(),
        view: "front".to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    });
    let cells: Vec<Cell> = cells.collect();
    let mut writer = RunWriter::create(folder, &run_of(device, cells.clone())).unwrap();
    let histogram = super::histogram("planes", 60);
    let group = cells[0].group();
    writer.append(&Event::Counted { group, triangles: 16, spheres: None, histogram }).unwrap();
    for (cell, (technique, ns)) in all.iter().enumerate() {
        let result = verification(technique, 60);
        writer.append(&Event::Verified { cell, result }).unwrap();
        for sample in 0..3 {
            let stages_ns =
                BTreeMap::from([("resolve".to_owned(), *ns), ("capture".to_owned(), 900_000)]);
            let (parts_ns, total_ns) = (BTreeMap::new(), ns + 900_000);
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}

/// Writes the run folder.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let all = made();
    let cells = all.iter().map(|made| Cell {
        technique: made.technique.clone(),
        scene: format!("stack{{count={},order=\"random\",size=3.6}}", made.depth),
        view: "front".to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    });
    let cells: Vec<Cell> = cells.collect();
    let mut writer = RunWriter::create(folder, &run_of(device, cells.clone())).unwrap();
    let groups: BTreeMap<String, u32> =
        cells.iter().zip(&all).map(|(cell, made)| (cell.group(), made.depth)).collect();
    for (group, depth) in groups {
        let mut histogram = vec![0; depth as usize + 1];
        histogram[depth as usize] = u64::from(WIDTH_PX * HEIGHT_PX);
        writer.append(&Event::Counted { group, triangles: 16, spheres: None, histogram }).unwrap();
    }
    for (cell, made) in all.into_iter().enumerate() {
        if let Some(program) = made.program {
            writer.append(&Event::Programs { cell, programs: vec![program] }).unwrap();
        }
        let mut result = verification(&cells[cell].technique, made.depth);
        let unsorted = ["/passthrough/", "/unsorted/"].iter().any(|s| made.technique.contains(s));
        result.verdict = if unsorted { Verdict::Approximate } else { Verdict::Exact };
        result.rmse = 0.0;
        writer.append(&Event::Verified { cell, result }).unwrap();
        let ns = made.ns as u64;
        for sample in 0..3 {
            let stages_ns =
                BTreeMap::from([("resolve".to_owned(), ns), ("capture".to_owned(), 900)]);
            let (parts_ns, total_ns) = (BTreeMap::new(), ns + 1000);
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
