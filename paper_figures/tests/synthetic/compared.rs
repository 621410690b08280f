//! A test fixture: a run of `oit compare`, of a device that does not exist, with times made up so that it
//! is known what the page must say.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_record::{
    Cell, Conformance, Event, Executable, Program, RunWriter, Statistic, StatisticValue, Subject,
    SubjectPart, Verdict,
};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// Depths, each with its made-up registers.
const DEPTHS: &[(u32, u64)] = &[(8, 20), (16, 28)];
const ORDERS: &[&str] = &["front_to_back", "back_to_front", "random"];

fn program(sort: &str, depth: u32, registers: u64) -> Program {
    let figure = |name: &str, value| Statistic {
        name: name.to_owned(),
        description: "made up".to_owned(),
        value: StatisticValue::Unsigned(value),
    };
    let executable = Executable {
        name: "compute".to_owned(),
        stages: vec!["compute".to_owned()],
        subgroup_size: 32,
        statistics: vec![
            figure("Register Count", registers),
            figure("Stack Size", 0),
            figure("Binary Size", 100 * registers),
        ],
    };
    Program {
        sort: sort.to_owned(),
        store: "registers".to_owned(),
        low: depth / 2 + 1,
        high: depth,
        invocations: Some(64),
        declared_workgroup_bytes: None,
        compile_ns: Some(2_000_000),
        from_cache: Some(depth > 8),
        executables: (sort == "network").then(|| vec![executable]),
    }
}

/// Writes the run folder: `network` takes half of the time of insertion and that of rbs, in reverse
/// three times as long, and heap is wrong.
pub(crate) fn write_run(root: &Path, device: &str) -> PathBuf {
    let folder = root.join("compare");
    let mut all: Vec<(Cell, u64, Option<Program>)> = Vec::new();
    let cell = |sort: &str, scene: String| Cell {
        technique: format!("linked_list/bma-list/{sort}/compute/peak"),
        scene,
        view: "front".to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    };
    for &(depth, registers) in DEPTHS {
        for &order in ORDERS {
            for (sort, share) in [("insertion", 2), ("network", 1), ("rbs", 1), ("heap", 1)] {
                let scene = format!("stack{{count={depth},order=\"{order}\"}}");
                let reverse = if order == "back_to_front" { 3 } else { 1 };
                let ns = u64::from(depth) * 1000 * share * reverse;
                let program = program(sort, depth, registers);
                all.push((cell(sort, scene), ns, Some(program)));
            }
        }
    }
    all.push((cell("network+rbs_hier", "planes".to_owned()), 100_000, None));
    all.push((cell("insertion", "planes".to_owned()), 200_000, None));
    let cells: Vec<Cell> = all.iter().map(|(cell, ..)| cell.clone()).collect();
    let part = SubjectPart {
        name: "network".to_owned(),
        summary: "A made-up summary.".to_owned(),
        citation: "a made-up citation".to_owned(),
        store: "registers".to_owned(),
        stores: vec!["registers".to_owned()],
        limit: Some(64),
        conformance: Conformance {
            compared: "compute programs with the CPU twin".to_owned(),
            up_to: 16,
            programs: 8,
            lists: 1000,
            ..Conformance::default()
        },
    };
    let subject =
        Subject { sort: "network".to_owned(), device: "test:0".to_owned(), parts: vec![part] };
    subject.write(&folder).unwrap();
    let mut writer = RunWriter::create(&folder, &run_of(device, cells)).unwrap();
    for (cell, (name, ns, program)) in all.into_iter().enumerate() {
        let peak = program.as_ref().map_or(20, |program| program.high);
        let mut histogram = vec![0; peak as usize + 1];
        histogram[peak as usize] = u64::from(WIDTH_PX * HEIGHT_PX);
        if program.is_none() {
            // No scene of one depth.
            histogram[1] = 5;
        }
        let group = name.group();
        writer.append(&Event::Counted { group, triangles: 16, spheres: None, histogram }).unwrap();
        let programs = program.into_iter().collect();
        writer.append(&Event::Programs { cell, programs }).unwrap();
        let mut result = verification(&name.technique, peak);
        let wrong = name.technique.contains("heap");
        (result.verdict, result.rmse) = (if wrong { Verdict::Wrong } else { Verdict::Exact }, 0.0);
        writer.append(&Event::Verified { cell, result }).unwrap();
        for sample in 0..if wrong { 0 } else { 5 } {
            let stages_ns =
                BTreeMap::from([("capture".to_owned(), 1_000_000), ("resolve".to_owned(), ns)]);
            let (parts_ns, total_ns) = (BTreeMap::new(), 1_000_000 + ns);
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
    folder
}
