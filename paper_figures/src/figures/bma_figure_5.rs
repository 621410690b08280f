//! Figure 5 of the backwards memory allocation paper: the histogram of depth complexity.

use std::collections::BTreeMap;

use analysis::{Tables, scene_name};

use super::Figure;
use super::bma_views::VIEWS;
use crate::FigureError;
use crate::chart::{DepthHistogram, HistogramSeries};
use crate::data::{Group, by_device, groups, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::SERIES;

/// Figure 5 of the backwards memory allocation paper.
pub(super) struct BmaFigure5;

impl Figure for BmaFigure5 {
    fn name(&self) -> &'static str {
        "bma-figure-5"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 5"
    }

    fn needs(&self) -> &'static str {
        "a count of a view whose pixels differ in depth complexity"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (device, groups) in by_device(groups(tables, |_| true)) {
            let counted: Vec<(Group, Vec<u64>)> = groups
                .into_iter()
                .filter_map(|group| {
                    let histogram = group.run.histogram(&group.name())?.to_vec();
                    Some((group, histogram))
                })
                .collect();
            let uniform = |histogram: &[u64]| {
                histogram.iter().skip(1).filter(|&&pixels| pixels > 0).count() < 2
            };
            let (flat, varied): (Vec<_>, Vec<_>) =
                counted.into_iter().partition(|(_, histogram)| uniform(histogram));
            // The paper's scenes are a chart of their own.
            let (mut paper, others): (Vec<_>, Vec<_>) =
                varied.into_iter().partition(|(group, _)| place(group).is_some());
            paper.sort_by_key(|(group, _)| place(group));
            // No more lines in a chart than there are colours to tell them apart.
            let parts = paper.chunks(SERIES.len()).chain(others.chunks(SERIES.len()));
            for (index, part) in parts.enumerate() {
                let suffix = if index == 0 { String::new() } else { format!("-{}", index + 1) };
                let name = format!("bma-figure-5-{}{suffix}", slug(&device));
                outputs.push(output(name, &device, part, &flat));
            }
        }
        Ok(outputs)
    }
}

/// Where a view stands among the paper's, if it is one of them.
fn place(group: &Group) -> Option<usize> {
    VIEWS.iter().position(|view| view.is(scene_name(group.scene), group.view))
}

fn output(
    name: String,
    device: &str,
    varied: &[(Group, Vec<u64>)],
    flat: &[(Group, Vec<u64>)],
) -> Output {
    let columns = vec!["scene", "view", "width_px", "height_px", "fragments", "pixels"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = ["scene", "view", "pixels", "covered", "fragments", "mean of covered", "peak"];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for (group, histogram) in varied {
        let (mut covered, mut fragments, mut peak) = (0_u64, 0_u64, 0_u64);
        for (depth, &pixels) in (0_u64..).zip(histogram).filter(|(_, pixels)| **pixels > 0) {
            csv.rows.push(vec![
                group.scene.to_owned(),
                group.view.to_owned(),
                group.width_px.to_string(),
                group.height_px.to_string(),
                depth.to_string(),
                pixels.to_string(),
            ]);
            if depth > 0 {
                covered = covered.saturating_add(pixels);
                fragments = fragments.saturating_add(depth.saturating_mul(pixels));
                peak = depth;
            }
        }
        table.rows.push(vec![
            group.scene.into(),
            group.view.into(),
            format!("{} × {}", group.width_px, group.height_px).into(),
            covered.to_string().into(),
            fragments.to_string().into(),
            format!("{:.1}", fragments as f64 / covered.max(1) as f64).into(),
            peak.to_string().into(),
        ]);
    }
    let series = varied.iter().zip(SERIES).map(|((group, histogram), colour)| HistogramSeries {
        label: format!("{} {} × {}", group.title(), group.width_px, group.height_px),
        colour: *colour,
        pixels: histogram.clone(),
    });
    let mut notes = Vec::new();
    if !flat.is_empty() {
        let mut views: BTreeMap<&str, usize> = BTreeMap::new();
        for (group, _) in flat {
            *views.entry(scene_name(group.scene)).or_default() += 1;
        }
        let names = views.into_iter().map(|(scene, count)| match count {
            1 => format!("{scene}, one view"),
            _ => format!("{scene}, {count} views"),
        });
        let names = names.collect::<Vec<String>>().join("; ");
        notes.push(format!("Not drawn, as all covered pixels have the same depth: {names}."));
    }
    Output {
        name,
        title: "BMA 2013, Figure 5: depth complexity histogram".to_owned(),
        subtitle: device.to_owned(),
        chart: Box::new(DepthHistogram(series.collect())),
        tables: vec![table],
        csv,
        notes,
        stamps: varied.iter().map(|(group, _)| Stamp::of(group.run)).collect(),
    }
}
