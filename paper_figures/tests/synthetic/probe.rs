//! A synthetic record of the array probe. No number here was measured: the time of an array in
//! workgroup memory doubles with every eight entries, and that of a local one stays.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{Cell, Event, RunWriter, Verdict, Verification};

use super::{HEIGHT_PX, WIDTH_PX, run_of};

/// Sizes of every line.
const SIZES: [u32; 5] = [1, 8, 16, 24, 32];

/// How many times as long as with one entry the synthetic workgroup array of `size` takes.
pub(crate) fn slowdown(size: u32) -> u64 {
    1 << (size / 8)
}

/// Writes a run of the probe.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let mut cells = Vec::new();
    for form in ["array-probe", "array-probe-unset"] {
        for place in ["local/fragment", "local/compute", "workgroup/compute"] {
            for size in SIZES {
                let technique = format!("{form}/{place}/size{size}");
                let (scene, view) = ("none".to_owned(), "none".to_owned());
                let (width_px, height_px) = (WIDTH_PX, HEIGHT_PX);
                cells.push((Cell { technique, scene, view, width_px, height_px }, size));
            }
        }
    }
    let run = run_of(device, cells.iter().map(|(cell, _)| cell.clone()).collect());
    let mut writer = RunWriter::create(folder, &run).unwrap();
    for (cell, (name, size)) in cells.iter().enumerate() {
        let unset = name.technique.starts_with("array-probe-unset");
        let result = Verification {
            verdict: if unset { Verdict::Approximate } else { Verdict::Exact },
            note: unset.then(|| "not compared".to_owned()),
            wrong_px: 0,
            max_error: 0.0,
            rmse: 0.0,
            max_alpha_error: 0.0,
            fragments_missing: 0,
            fragments_extra: 0,
            fragments_compared: true,
            tied_px: 0,
            max_frags: *size,
            pool_initial: 0,
            pool_final: 0,
            pool_grown: 0,
            memory_bytes: 16 * u64::from(WIDTH_PX * HEIGHT_PX),
            lfb_bytes: None,
            peak_bytes: None,
            repeat_differs_px: Some(0),
            tuned: None,
            predicted_ns: None,
            ssim: None,
            flip: None,
            stability: None,
            prepare_ms: 1.0,
        };
        writer.append(&Event::Verified { cell, result }).unwrap();
        let workgroup = name.technique.contains("/workgroup/");
        let ns = 100_000 * if workgroup { slowdown(*size) } else { 1 };
        for sample in 0..5 {
            let total_ns = ns + u64::from(sample);
            let stages_ns = BTreeMap::from([("probe".to_owned(), total_ns)]);
            let parts_ns = BTreeMap::new();
            writer.append(&Event::Sample { cell, sample, stages_ns, parts_ns, total_ns }).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
