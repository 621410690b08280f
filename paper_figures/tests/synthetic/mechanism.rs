//! A test fixture: programs of arrays of several sizes on a device that does not exist, with figures
//! and times made up so that it is known what the figures on the mechanism must show. Nothing here
//! was measured, whatever the device is called.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oit_record::{Cell, Event, Executable, Program, RunWriter, Statistic, StatisticValue, Verdict};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// Array sizes, each with its made-up registers.
pub(crate) const SIZES: &[(u32, u64)] = &[(8, 32), (16, 40), (32, 64), (64, 128)];

const SCENE: &str = "stack{count=8,order=\"random\",size=3.6}";

fn told(registers: u64, sort: &str) -> Vec<Executable> {
    let figure = |name: &str, value| Statistic {
        name: name.to_owned(),
        description: "made up".to_owned(),
        value: StatisticValue::Unsigned(value),
    };
    let local = if sort == "insertion" { 8 * registers } else { 0 };
    let executable = |stage: &str, registers| Executable {
        name: stage.to_owned(),
        stages: vec![stage.to_owned()],
        subgroup_size: 32,
        statistics: vec![
            figure("Register Count", registers),
            figure("Stack Size", local),
            figure("Binary Size", 100 * registers),
        ],
    };
    vec![executable("vertex", 16), executable("fragment", registers)]
}

/// Writes the run folder. Times are made up as warps would have it, those of `rbs` twice those of
/// `insertion`, so that times relative to the smallest array are as the model says.
pub(crate) fn write_run(root: &Path, folder: &str, device: &str, is_told: bool) -> PathBuf {
    let folder = root.join(folder);
    let sorts = ["insertion", "rbs"];
    let all = sorts.iter().flat_map(|sort| SIZES.iter().map(move |size| (*sort, *size)));
    let all: Vec<(&str, (u32, u64))> = all.collect();
    let cells = all.iter().map(|(sort, (size, _))| Cell {
        technique: format!("linked_list/base/{sort}/fragment/max{size}"),
        scene: SCENE.to_owned(),
        view: "front".to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    });
    let cells: Vec<Cell> = cells.collect();
    let mut writer = RunWriter::create(&folder, &run_of(device, cells.clone())).unwrap();
    let mut histogram = vec![0; 9];
    histogram[8] = u64::from(WIDTH_PX * HEIGHT_PX);
    writer
        .append(&Event::Counted {
            group: cells[0].group(),
            triangles: 16,
            spheres: None,
            histogram,
        })
        .unwrap();
    for (cell, (sort, (size, registers))) in all.into_iter().enumerate() {
        let program = Program {
            sort: sort.to_owned(),
            store: "local".to_owned(),
            low: 1,
            high: size,
            invocations: None,
            declared_workgroup_bytes: None,
            compile_ns: Some(2_000_000),
            from_cache: Some(false),
            executables: is_told.then(|| told(registers, sort)),
        };
        writer.append(&Event::Programs { cell, programs: vec![program] }).unwrap();
        let mut result = verification(&cells[cell].technique, 8);
        (result.verdict, result.rmse) = (Verdict::Exact, 0.0);
        writer.append(&Event::Verified { cell, result }).unwrap();
        // Warps by 32, 40, 64 and 128 registers: 64, 48, 32, 16.
        let warps = [64, 48, 32, 16][SIZES.iter().position(|known| known.0 == size).unwrap()];
        let ns = 192_000_u64 / warps * if sort == "rbs" { 2 } else { 1 };
        for sample in 0..5 {
            let stages_ns = BTreeMap::from([("resolve".to_owned(), ns)]);
            let parts_ns = BTreeMap::new();
            let event = Event::Sample { cell, sample, stages_ns, parts_ns, total_ns: ns };
            writer.append(&event).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
    folder
}
