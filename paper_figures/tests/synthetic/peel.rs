//! A synthetic record of peeling. No number here was measured: a pass takes 0.1 ms, and what is
//! forwarded in small floats is lost from the sixteenth layer on.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{Cell, Event, RunWriter, Verdict, Verification};

use super::{HEIGHT_PX, WIDTH_PX, run_of, verification};

/// Methods, and how many layers a pass of them peels.
const METHODS: [(&str, u32); 3] = [("depth_peel", 1), ("dual_peel", 2), ("dual_peel_forward11", 2)];

/// Writes a run of stacks of 4, 8 and 16 layers.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let mut cells = Vec::new();
    for count in [4_u32, 8, 16] {
        for (method, layers) in METHODS {
            let cell = Cell {
                technique: method.to_owned(),
                scene: format!("stack{{count={count}}}"),
                view: "front".to_owned(),
                width_px: WIDTH_PX,
                height_px: HEIGHT_PX,
            };
            cells.push((cell, count, count.div_ceil(layers)));
        }
    }
    let run = run_of(device, cells.iter().map(|(cell, ..)| cell.clone()).collect());
    let mut writer = RunWriter::create(folder, &run).unwrap();
    for (index, (cell, count, passes)) in cells.iter().enumerate() {
        if index % METHODS.len() == 0 {
            let mut histogram = vec![0; *count as usize + 1];
            histogram[*count as usize] = 100;
            histogram[0] = u64::from(WIDTH_PX * HEIGHT_PX) - 100;
            let group = cell.group();
            writer
                .append(&Event::Counted { group, triangles: 9, spheres: None, histogram })
                .unwrap();
        }
        let approximate = cell.technique == "dual_peel_forward11";
        let max_error = match (approximate, count) {
            (false, _) => 1e-9,
            (true, 16) => 0.5,
            (true, _) => 0.001,
        };
        let result = Verification {
            verdict: if approximate { Verdict::Approximate } else { Verdict::Exact },
            max_error,
            rmse: max_error / 2.0,
            fragments_compared: false,
            max_frags: 0,
            ..verification("linked_list/base/insertion/compute/peak", *count)
        };
        writer.append(&Event::Verified { cell: index, result }).unwrap();
        for sample in 0..5 {
            let total_ns = 100_000 * u64::from(*passes) + u64::from(sample);
            let stages_ns = BTreeMap::from([("peel".to_owned(), total_ns)]);
            let parts_ns = BTreeMap::new();
            writer
                .append(&Event::Sample { cell: index, sample, stages_ns, parts_ns, total_ns })
                .unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
