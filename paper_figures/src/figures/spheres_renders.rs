//! Figures 3.1 and 3.2 of the thesis on biomolecular scenes: renders of its scenes, with a detail pixel by
//! pixel and a map of errors.

use analysis::{CellResult, Tables};

use super::Figure;
use super::images;
use crate::FigureError;
use crate::axis::number;
use crate::chart::{PictureRow, Pictures};
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table};

/// Pictures of ways of drawing spheres.
pub(super) struct SpheresRenders;

impl Figure for SpheresRenders {
    fn name(&self) -> &'static str {
        "spheres-renders"
    }

    fn source(&self) -> &'static str {
        "Biomolecular scenes 2018, Figures 3.1 and 3.2"
    }

    fn needs(&self) -> &'static str {
        "pictures kept of a way of drawing spheres"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let kept = |cell: &CellResult| {
            cell.name.technique.starts_with("spheres/")
                && images::are_kept(&tables.runs[cell.run], &cell.name)
        };
        let enough = |group: &Group| group.cells.iter().any(|cell| kept(cell));
        groups_with(tables, kept, enough).iter().map(output).collect()
    }
}

fn output(group: &Group) -> Result<Output, FigureError> {
    let heads = ["technique", "wrong_px", "undecided_px", "max_error", "rmse"];
    let mut csv = Csv { columns: heads.to_vec(), rows: Vec::new() };
    let mut rows = Vec::new();
    for cell in &group.cells {
        let (Some(kept), Some(said)) =
            (images::read(group.run, &cell.name)?, cell.verification.as_ref())
        else {
            continue;
        };
        let name = cell.name.technique.trim_start_matches("spheres/");
        csv.rows.push(vec![
            cell.name.technique.clone(),
            said.wrong_px.to_string(),
            said.tied_px.to_string(),
            format!("{}", said.max_error),
            format!("{}", said.rmse),
        ]);
        rows.push(PictureRow {
            title: format!(
                "{name}: {} pixels wrong beside {} at rims, by up to {}",
                said.wrong_px,
                said.tied_px,
                number(said.max_error)
            ),
            pictures: [
                Some(kept.picture.titled("Its picture")),
                (!kept.detail.is_blank()).then(|| kept.detail.titled("A detail, pixel by pixel")),
                Some(kept.error.map("Errors of colour, rims of spheres included")),
            ]
            .into_iter()
            .flatten()
            .collect(),
        });
    }
    let table = Table {
        heading: String::new(),
        columns: heads.map(str::to_owned).to_vec(),
        rows: csv.rows.iter().map(|row| row.iter().cloned().map(Into::into).collect()).collect(),
    };
    Ok(Output {
        name: format!("spheres-renders-{}-{}", group.slug(), group.device_slug()),
        title: format!("Biomolecular scenes 2018, Figures 3.1 and 3.2: {}", group.title()),
        subtitle: match group.run.spheres.get(&group.name()) {
            Some(spheres) => format!("{}; {spheres} spheres in full detail", group.conditions()),
            None => group.conditions(),
        },
        chart: Box::new(Pictures { rows, scale: images::error_scale() }),
        tables: vec![table],
        csv,
        notes: vec![
            "Pictures are over white. The map is against the oracle's picture, which has one sample a \
             pixel: at the rims of spheres, where a step of a 64th of a pixel meets another sphere, it \
             decides nothing, and errors there are in no figure but the map."
                .to_owned(),
        ],
        stamps: [Stamp::of(group.run)].into(),
    })
}
