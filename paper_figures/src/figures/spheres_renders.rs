//! Figures 3.1 and 3.2 of the thesis on biomolecular scenes: renders of its scenes, with a detail pixel by
//! pixel and a map of errors.

use analysis::{CellResult, Tables};
use oit_image::false_color;

use super::Figure;
use super::images::{self, Errors, Rgb};
use crate::FigureError;
use crate::axis::number;
use crate::canvas::Colour;
use crate::chart::{Picture, PictureRow, Pictures};
use crate::data::{Group, groups_with};
use crate::output::{Csv, Output, Stamp, Table};

/// Pictures of ways of drawing spheres.
pub(super) struct SpheresRenders;

/// The error, in 255ths, from which the map has its brightest colour.
const BRIGHTEST: u16 = 32;

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
        let picture = |Rgb { width, bytes }: Rgb, title: &str| Picture {
            title: title.to_owned(),
            width,
            rgb: bytes,
        };
        let Errors { width, values } = kept.error;
        let colour = |error: u16| false_color(u32::from(error.min(BRIGHTEST)), BRIGHTEST.into());
        let map = Picture {
            title: "Errors of colour, rims of spheres included".to_owned(),
            width,
            rgb: values.into_iter().flat_map(colour).collect(),
        };
        rows.push(PictureRow {
            title: format!(
                "{name}: {} pixels wrong beside {} at rims, by up to {}",
                said.wrong_px,
                said.tied_px,
                number(said.max_error)
            ),
            pictures: vec![
                picture(kept.picture, "Its picture"),
                picture(kept.detail, "A detail, pixel by pixel"),
                map,
            ],
        });
    }
    let scale = (0..BRIGHTEST).map(|step| {
        let [red, green, blue] = false_color(u32::from(step) + 1, BRIGHTEST.into());
        Colour(red, green, blue)
    });
    let ends = [
        "Errors: black none, then 1/255".to_owned(),
        format!("{BRIGHTEST}/255 and more, of a colour channel"),
    ];
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
        chart: Box::new(Pictures { rows, scale: (scale.collect(), ends) }),
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
