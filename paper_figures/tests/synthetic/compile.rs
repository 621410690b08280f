//! Synthetic records of runs with a known pipeline cache. No number here was measured: a program takes
//! a millisecond an entry of its array to compile, and a hundredth of that from the cache.

use std::path::Path;

use oit_record::{Cell, Event, Program, RunWriter};

use super::run_of;

/// Writes a run on an empty cache, or on what it left. `option` is how it names the cache, if it does.
pub(crate) fn write_run(folder: &Path, device: &str, cached: bool, option: Option<&str>) {
    let mut cells = Vec::new();
    for sort in ["insertion", "rbs"] {
        for size in [8, 16, 32_u32] {
            let technique = format!("linked_list/base/{sort}/compute/max{size}");
            let (scene, view) = ("stack".to_owned(), "front".to_owned());
            let cell = Cell { technique, scene, view, width_px: 64, height_px: 36 };
            cells.push((cell, sort, size));
        }
    }
    let mut run = run_of(device, cells.iter().map(|(cell, ..)| cell.clone()).collect());
    run.command.extend(option.map(str::to_owned));
    let mut writer = RunWriter::create(folder, &run).unwrap();
    for (cell, (_, sort, size)) in cells.iter().enumerate() {
        let ns = u64::from(*size) * if cached { 10_000 } else { 1_000_000 };
        let program = Program {
            sort: (*sort).to_owned(),
            store: "local".to_owned(),
            low: 1,
            high: *size,
            invocations: Some(64),
            declared_workgroup_bytes: Some(0),
            compile_ns: Some(ns),
            from_cache: Some(cached),
            executables: None,
        };
        writer.append(&Event::Programs { cell, programs: vec![program] }).unwrap();
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
