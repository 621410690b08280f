//! Figure 5 of the register-based block sort paper: depth complexity in false colour.

use analysis::Tables;

use super::Figure;
use super::counts::{self, Counts};
use crate::FigureError;
use crate::chart::{DepthMap, DepthMaps, MapScale};
use crate::data::{Group, by_device, slug};
use crate::output::{Csv, Output, Stamp, Table};

/// Figure 5 of the register-based block sort paper.
pub(super) struct RbsFigure5;

impl Figure for RbsFigure5 {
    fn name(&self) -> &'static str {
        "rbs-figure-5"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, Figure 5 (also BMA 2013, Figure 4)"
    }

    fn needs(&self) -> &'static str {
        "counts/SCENE_VIEW_WIDTHxHEIGHT.png in a run folder, of pixels that differ in depth complexity"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (device, groups) in by_device(counts::views(tables)) {
            let mut found: Vec<(Group, Counts)> = Vec::new();
            for group in groups {
                let Some(counts) = counts::read(&group)? else { continue };
                // One colour all over says no more than its title; nor do the same squares in all
                // sizes and numbers.
                let mut depths = counts.pixels.iter().filter(|&&count| count > 0);
                let first = depths.next();
                if depths.any(|count| Some(count) != first) {
                    found.push((group, counts));
                }
            }
            if !found.is_empty() {
                outputs.push(output(&device, found));
            }
        }
        Ok(outputs)
    }
}

fn output(device: &str, found: Vec<(Group, Counts)>) -> Output {
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
    let mut maps = Vec::new();
    let stamps = found.iter().map(|(group, _)| Stamp::of(group.run)).collect();
    for (group, counts) in found {
        let max_frags = u32::from(counts.peak).max(1).next_power_of_two();
        csv.rows.push(vec![
            group.scene.to_owned(),
            group.view.to_owned(),
            group.width_px.to_string(),
            group.height_px.to_string(),
            counts.peak.to_string(),
            max_frags.to_string(),
            format!("{}", counts.mean),
            counts.empty_px.to_string(),
        ]);
        table.rows.push(vec![
            group.scene.into(),
            group.view.into(),
            format!("{} × {}", group.width_px, group.height_px).into(),
            counts.peak.to_string().into(),
            max_frags.to_string().into(),
            format!("{:.1}", counts.mean).into(),
            counts.empty_px.to_string().into(),
        ]);
        maps.push(DepthMap {
            title: format!("{}: peak {} of {max_frags}", group.title(), counts.peak),
            width_px: group.width_px as usize,
            counts: counts.pixels,
            scale: MapScale::FalseColour { max_frags },
        });
    }
    Output {
        name: format!("rbs-figure-5-{}", slug(device)),
        title: "RBS 2014, Figure 5: depth complexity".to_owned(),
        subtitle: device.to_owned(),
        stamps,
        chart: Box::new(DepthMaps(maps)),
        tables: vec![table],
        csv,
        notes: vec![
            "Fragments of each pixel in false colour, relative to max_frags: the next power of two \
             of the deepest pixel, as in the paper. Black: none."
                .to_owned(),
        ],
    }
}
