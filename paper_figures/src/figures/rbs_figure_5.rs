//! Figure 5 of the register-based block sort paper: depth complexity in false colour. The counts lie
//! beside the record, in `counts/SCENE_VIEW_WIDTHxHEIGHT.png`: 16-bit grey, one value a pixel.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use analysis::Tables;

use super::Figure;
use crate::FigureError;
use crate::chart::{DepthMap, DepthMaps};
use crate::data::{Group, by_device, groups, slug};
use crate::output::{Csv, Output, Stamp, Table};

/// Figure 5 of the register-based block sort paper.
pub(super) struct RbsFigure5;

impl Figure for RbsFigure5 {
    fn name(&self) -> &'static str {
        "rbs-figure-5"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Figure 5 (also BMA 2013, Figure 4, and LFB 2012, Figure 20.9)"
    }

    fn needs(&self) -> &'static str {
        "counts/SCENE_VIEW_WIDTHxHEIGHT.png in a run folder, of pixels that differ in depth complexity"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (device, groups) in by_device(groups(tables, |_| true)) {
            let mut found: Vec<(Group, DepthMap)> = Vec::new();
            for group in groups {
                let path = counts_path(&group);
                if path.exists() {
                    let map = read(&path, &group)?;
                    // One colour all over says no more than its title.
                    if map.counts.iter().any(|count| Some(count) != map.counts.first()) {
                        found.push((group, map));
                    }
                }
            }
            if !found.is_empty() {
                outputs.push(output(&device, found));
            }
        }
        Ok(outputs)
    }
}

/// Where the counts of a group lie.
fn counts_path(group: &Group) -> PathBuf {
    let name = format!("{}_{}_{}x{}", group.scene, group.view, group.width_px, group.height_px);
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    group.run.folder.join("counts").join(name + ".png")
}

/// Reads a map of counts.
fn read(path: &Path, group: &Group) -> Result<DepthMap, FigureError> {
    let wrong = |reason: String| FigureError::Sidecar { path: path.to_owned(), reason };
    let file = File::open(path).map_err(|error| wrong(error.to_string()))?;
    let decoder = png::Decoder::new(BufReader::new(file));
    let mut reader = decoder.read_info().map_err(|error| wrong(error.to_string()))?;
    let (width, height) = (reader.info().width, reader.info().height);
    if (width, height) != (group.width_px, group.height_px) {
        let (wide, high) = (group.width_px, group.height_px);
        return Err(wrong(format!("{width} x {height} px, the record has {wide} x {high}")));
    }
    if reader.output_color_type() != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(wrong("not 16-bit grey".to_owned()));
    }
    let size = reader.output_buffer_size().ok_or_else(|| wrong("too large".to_owned()))?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|error| wrong(error.to_string()))?;
    let counts: Vec<u16> =
        bytes.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    let peak = u32::from(counts.iter().copied().max().unwrap_or(0));
    let max_frags = peak.max(1).next_power_of_two();
    let title = format!("{}: peak {peak} of {max_frags}", group.title());
    Ok(DepthMap { title, width_px: width as usize, counts, max_frags })
}

fn output(device: &str, found: Vec<(Group, DepthMap)>) -> Output {
    let mut csv = Csv {
        columns: vec![
            "scene",
            "view",
            "width_px",
            "height_px",
            "peak",
            "max_frags",
            "mean",
            "empty_px",
        ],
        rows: Vec::new(),
    };
    let columns = ["scene", "view", "pixels", "peak", "max_frags", "mean", "empty"];
    let columns = columns.map(str::to_owned).to_vec();
    let mut table = Table { columns, ..Table::default() };
    for (group, map) in &found {
        let total: u64 = map.counts.iter().map(|&count| u64::from(count)).sum();
        let mean = total as f64 / map.counts.len().max(1) as f64;
        let empty = map.counts.iter().filter(|&&count| count == 0).count();
        let peak = map.counts.iter().max().copied().unwrap_or(0);
        csv.rows.push(vec![
            group.scene.to_owned(),
            group.view.to_owned(),
            group.width_px.to_string(),
            group.height_px.to_string(),
            peak.to_string(),
            map.max_frags.to_string(),
            format!("{mean}"),
            empty.to_string(),
        ]);
        table.rows.push(vec![
            group.scene.into(),
            group.view.into(),
            format!("{} × {}", group.width_px, group.height_px).into(),
            peak.to_string().into(),
            map.max_frags.to_string().into(),
            format!("{mean:.1}").into(),
            empty.to_string().into(),
        ]);
    }
    Output {
        name: format!("rbs-figure-5-{}", slug(device)),
        title: "RBS 2014, Figure 5: depth complexity".to_owned(),
        subtitle: device.to_owned(),
        stamps: found.iter().map(|(group, _)| Stamp::of(group.run)).collect(),
        chart: Box::new(DepthMaps(found.into_iter().map(|(_, map)| map).collect())),
        tables: vec![table],
        csv,
        notes: vec![
            "Fragments of each pixel in false colour, relative to max_frags: the next power of two \
             of the deepest pixel, as in the paper. Black: none."
                .to_owned(),
        ],
    }
}
