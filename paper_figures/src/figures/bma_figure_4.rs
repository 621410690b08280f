//! Figure 4 of the backwards memory allocation paper: the depth complexity of its three scenes.

use analysis::Tables;

use super::Figure;
use super::bma_views::{OUR_SCENES, VIEWS};
use super::counts;
use crate::FigureError;
use crate::chart::{DepthMap, DepthMaps, MapScale};
use crate::data::{by_device, slug, view_of};
use crate::output::{Csv, Output, Stamp, Table};
use crate::published;

/// Figure 4 of the backwards memory allocation paper.
pub(super) struct BmaFigure4;

impl Figure for BmaFigure4 {
    fn name(&self) -> &'static str {
        "bma-figure-4"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 4"
    }

    fn needs(&self) -> &'static str {
        "counts/SCENE_VIEW_WIDTHxHEIGHT.png in a run folder, of the view bma of atrium, smoke or \
         powerplant"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("bma-table-2")?;
        let mut outputs = Vec::new();
        for (device, groups) in by_device(counts::views(tables)) {
            let columns =
                vec!["scene", "view", "width_px", "height_px", "peak", "mean", "empty_px"];
            let mut csv = Csv { columns, rows: Vec::new() };
            let columns = ["scene", "view", "pixels", "mean", "empty", "peak\nours", "peak\n2013"];
            let mut table =
                Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
            let (mut maps, mut stamps) = (Vec::new(), Vec::new());
            for view in &VIEWS {
                let Some(group) = view_of(&groups, view.scene, view.view) else { continue };
                let Some(counts) = counts::read(group)? else { continue };
                let share = 100.0 * counts.empty_px as f64 / counts.pixels.len().max(1) as f64;
                csv.rows.push(vec![
                    group.scene.to_owned(),
                    group.view.to_owned(),
                    group.width_px.to_string(),
                    group.height_px.to_string(),
                    counts.peak.to_string(),
                    format!("{}", counts.mean),
                    counts.empty_px.to_string(),
                ]);
                let peak = published.fact("Peak Depth", view.paper);
                table.rows.push(vec![
                    group.scene.into(),
                    group.view.into(),
                    format!("{} × {}", group.width_px, group.height_px).into(),
                    format!("{:.2}", counts.mean).into(),
                    format!("{share:.1} %").into(),
                    counts.peak.to_string().into(),
                    peak.map_or("–".to_owned(), |peak| format!("{peak}")).into(),
                ]);
                maps.push(DepthMap {
                    title: format!("{}: peak {}", group.title(), counts.peak),
                    width_px: group.width_px as usize,
                    scale: MapScale::FalseColour {
                        max_frags: u32::from(counts.peak).max(8).next_power_of_two(),
                    },
                    counts: counts.pixels,
                });
                stamps.push(Stamp::of(group.run));
            }
            if maps.is_empty() {
                continue;
            }
            outputs.push(Output {
                name: format!("bma-figure-4-{}", slug(&device)),
                title: "BMA 2013, Figure 4: depth complexity of the three scenes".to_owned(),
                subtitle: device,
                stamps: stamps.into_iter().collect(),
                chart: Box::new(DepthMaps(maps)),
                tables: vec![table],
                csv,
                notes: vec![format!(
                    "Fragments of each pixel in false colour, relative to the array that holds the \
                     deepest: 8 or more, a power of two. Black: none. Published peaks are those of \
                     Table 2. {OUR_SCENES}"
                )],
            });
        }
        Ok(outputs)
    }
}
