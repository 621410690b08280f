//! A synthetic record of approximate methods with their pictures. No number here was measured: a
//! method's error is made up, and the error of samples falls with their square root.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{Cell, Event, RunWriter, Verdict, Verification};

use super::bma::write_images;
use super::{HEIGHT_PX, WIDTH_PX, histogram, run_of, verification};

/// What is exact.
const EXACT: &str = "linked_list/bma-list/network+rbs/compute/peak";

/// Techniques and the root mean square errors of their pictures.
const ERRORS: [(&str, f64); 9] = [
    (EXACT, 0.0),
    ("linked_list/bma-list/network+rbs/compute/max8", 0.05),
    ("k_nearest/k8", 0.04),
    ("hybrid/k8", 0.002),
    ("stochastic/samples4", 0.08),
    ("stochastic/samples16", 0.04),
    ("stochastic/samples64", 0.02),
    ("moments4", 0.01),
    ("moments8", 0.02),
];

/// Writes a run on the views that the claims are of.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let views = [("atrium", "rbs-v2", 27), ("smoke", "bma", 138), ("planes2", "front", 128)];
    write_views(folder, device, &views);
}

/// Writes a run on more scenes than all other synthetic records have.
pub(crate) fn write_many_scenes(folder: &Path, device: &str) {
    let scenes = [
        "atrium",
        "dragon",
        "grid",
        "hairball",
        "planes",
        "planes2",
        "powerplant",
        "smoke",
        "stack",
        "shells",
        "cyclic",
        "random_triangles",
    ];
    write_views(folder, device, &scenes.map(|scene| (scene, "any", 24)));
}

fn write_views(folder: &Path, device: &str, views: &[(&str, &str, u32)]) {
    let cell = |technique: &str, scene: &str, view: &str| Cell {
        technique: technique.to_owned(),
        scene: scene.to_owned(),
        view: view.to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
    };
    let cells: Vec<(Cell, f64)> = views
        .iter()
        .flat_map(|(scene, view, _)| ERRORS.map(|(name, rmse)| (cell(name, scene, view), rmse)))
        .collect();
    let run = run_of(device, cells.iter().map(|(cell, _)| cell.clone()).collect());
    let mut writer = RunWriter::create(folder, &run).unwrap();
    for &(scene, view, peak) in views {
        let (group, histogram) = (cell("", scene, view).group(), histogram(scene, peak));
        writer.append(&Event::Counted { group, triangles: 9, spheres: None, histogram }).unwrap();
    }
    for (index, (cell, rmse)) in cells.iter().enumerate() {
        if cell.view == "rbs-v2" {
            write_images(folder, cell);
        }
        let exact = *rmse == 0.0;
        let result = Verification {
            verdict: if exact { Verdict::Exact } else { Verdict::Approximate },
            // Rounding of an exact picture, which is no error.
            max_error: if exact { 1e-7 } else { rmse * 3.0 },
            rmse: if exact { 1e-8 } else { *rmse },
            max_alpha_error: if cell.technique == "k_nearest/k8" { 0.25 } else { 1e-7 },
            fragments_compared: false,
            ssim: (!exact).then_some(1.0 - rmse),
            flip: (!exact).then_some(2.0 * rmse),
            ..verification(EXACT, 128)
        };
        writer.append(&Event::Verified { cell: index, result }).unwrap();
        for sample in 0..5 {
            let total_ns = 100_000 + u64::from(sample);
            let stages_ns = BTreeMap::from([("capture".to_owned(), total_ns)]);
            let parts_ns = BTreeMap::new();
            let timed = Event::Sample { cell: index, sample, stages_ns, parts_ns, total_ns };
            writer.append(&timed).unwrap();
        }
    }
    writer.append(&Event::Finished { wall_s: 1.0 }).unwrap();
}
