//! A flight along a camera path that nobody flew.

use std::collections::BTreeMap;
use std::path::Path;

use oit_record::{Cell, Event, RunWriter, Verdict};

use super::{run_of, verification};

/// Techniques, each with the milliseconds of its resolve on the first frame.
const TECHNIQUES: [(&str, u64); 3] = [
    ("linked_list/base/insertion_merge64/fragment/max64/ties-depth", 10),
    ("linked_list/base/insertion_merge64/fragment/max128/ties-depth", 14),
    ("linked_list/bma-stencil/insertion@16+merge/fragment/max128/ties-depth", 7),
];

/// `histogram[n]` pixels of each frame have `n` fragments. The third is too deep for an array of 64.
fn histogram(frame: u32) -> Vec<u64> {
    let mut histogram = vec![10; 41];
    if frame == 20 {
        histogram.resize(100, 0);
        histogram[99] = 5;
    }
    histogram
}

/// Writes a run of the frames 0, 10, 20 and 30 of the path `fly`. Frame times rise from frame to
/// frame, for all techniques alike.
pub(crate) fn write_run(folder: &Path, device: &str) {
    let cell = |frame: u32, technique: &str| Cell {
        technique: technique.to_owned(),
        scene: "atrium".to_owned(),
        view: format!("flythrough@{frame}"),
        width_px: 41,
        height_px: 10,
    };
    let frames = [0, 10, 20, 30];
    let all = frames.iter().flat_map(|&f| TECHNIQUES.map(|(technique, ms)| (f, technique, ms)));
    let all: Vec<(u32, &str, u64)> = all.collect();
    let cells = all.iter().map(|(frame, technique, _)| cell(*frame, technique)).collect();
    let mut writer = RunWriter::create(folder, &run_of(device, cells)).unwrap();
    for frame in frames {
        let (group, histogram) = (cell(frame, "").group(), histogram(frame));
        writer.append(&Event::Counted { group, triangles: 9, spheres: None, histogram }).unwrap();
    }
    for (index, (frame, technique, ms)) in all.iter().enumerate() {
        let mut result = verification(technique, 128);
        let too_deep = *frame == 20 && technique.contains("max64");
        result.verdict = if too_deep { Verdict::Approximate } else { Verdict::Exact };
        result.fragments_compared = *frame == 0 || too_deep;
        writer.append(&Event::Verified { cell: index, result }).unwrap();
        let resolve = (ms * 1_000_000) * u64::from(10 + frame) / 10;
        for sample in 0..3 {
            let stages_ns = BTreeMap::from([("resolve".to_owned(), resolve)]);
            let total_ns = 2 * resolve;
            let parts_ns = BTreeMap::new();
            let event = Event::Sample { cell: index, sample, stages_ns, parts_ns, total_ns };
            writer.append(&event).unwrap();
        }
    }
}
