//! Figure 20.9 of the layered fragment buffer chapter: the depth complexity of its two scenes, in
//! grey.

use analysis::Tables;

use super::Figure;
use super::counts;
use super::lfb_views::VIEWS;
use crate::FigureError;
use crate::chart::{DepthMap, DepthMaps, MapScale};
use crate::data::{by_device, slug, view_of};
use crate::output::{Csv, Output, Stamp, Table};

/// Figure 20.9 of the layered fragment buffer chapter.
pub(super) struct LfbFigure20_9;

impl Figure for LfbFigure20_9 {
    fn name(&self) -> &'static str {
        "lfb-figure-20-9"
    }

    fn source(&self) -> &'static str {
        "LFB 2012, Figure 20.9"
    }

    fn needs(&self) -> &'static str {
        "counts/SCENE_VIEW_WIDTHxHEIGHT.png in a run folder, of dragon front or atrium lfb"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (device, groups) in by_device(counts::views(tables)) {
            let mut csv = Csv {
                columns: vec![
                    "scene",
                    "view",
                    "width_px",
                    "height_px",
                    "white",
                    "peak",
                    "mean",
                    "mean_of_covered",
                    "empty_px",
                    "above_white_px",
                ],
                rows: Vec::new(),
            };
            let columns =
                ["scene", "view", "pixels", "peak", "mean", "mean of covered", "empty", "white"];
            let mut table =
                Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
            let (mut maps, mut stamps) = (Vec::new(), Vec::new());
            for view in &VIEWS {
                let Some(group) = view_of(&groups, view.scene, view.view) else { continue };
                let Some(counts) = counts::read(group)? else { continue };
                let pixels = counts.pixels.len().max(1);
                let covered = (pixels - counts.empty_px).max(1);
                let of_covered = counts.mean * pixels as f64 / covered as f64;
                let more = counts.pixels.iter().filter(|&&count| u32::from(count) > view.white);
                let more = more.count();
                csv.rows.push(vec![
                    group.scene.to_owned(),
                    group.view.to_owned(),
                    group.width_px.to_string(),
                    group.height_px.to_string(),
                    view.white.to_string(),
                    counts.peak.to_string(),
                    format!("{}", counts.mean),
                    format!("{of_covered}"),
                    counts.empty_px.to_string(),
                    more.to_string(),
                ]);
                let percent =
                    |count: usize| format!("{:.1} %", 100.0 * count as f64 / pixels as f64);
                table.rows.push(vec![
                    group.scene.into(),
                    group.view.into(),
                    format!("{} × {}", group.width_px, group.height_px).into(),
                    counts.peak.to_string().into(),
                    format!("{:.2}", counts.mean).into(),
                    format!("{of_covered:.2}").into(),
                    percent(counts.empty_px).into(),
                    format!("{}; {} deeper", view.white, percent(more)).into(),
                ]);
                maps.push(DepthMap {
                    title: format!("{}: peak {}", group.title(), counts.peak),
                    width_px: group.width_px as usize,
                    counts: counts.pixels,
                    scale: MapScale::Grey { white: view.white },
                });
                stamps.push(Stamp::of(group.run));
            }
            if maps.is_empty() {
                continue;
            }
            outputs.push(Output {
                name: format!("lfb-figure-20-9-{}", slug(&device)),
                title: "LFB 2012, Figure 20.9: depth complexity".to_owned(),
                subtitle: device,
                stamps: stamps.into_iter().collect(),
                chart: Box::new(DepthMaps(maps)),
                tables: vec![table],
                csv,
                notes: vec![
                    "Black is no fragment; white is 8 fragments and more of the dragon and 32 and \
                     more of the atrium, as in the paper. Our atrium is generated and not the \
                     paper's model."
                        .to_owned(),
                ],
            });
        }
        Ok(outputs)
    }
}
