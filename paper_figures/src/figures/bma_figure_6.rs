//! Figure 6 of the backwards memory allocation paper: what an array that is too small does to the
//! picture.

use std::collections::BTreeMap;

use analysis::{CellResult, Tables};
use oit_image::{DETAIL_PX, viridis};
use oit_record::Verification;

use super::Figure;
use super::bma_views::{OUR_SCENES, devices};
use super::images::{self, Errors, Images, Rgb};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::canvas::Colour;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Picture, PictureRow, Pictures, Scale};
use crate::data::{Group, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::SERIES;

/// Figure 6 of the backwards memory allocation paper.
pub(super) struct BmaFigure6;

/// The error, in 255ths, from which the map has its brightest colour.
const BRIGHTEST: u16 = 64;

impl Figure for BmaFigure6 {
    fn name(&self) -> &'static str {
        "bma-figure-6"
    }

    fn source(&self) -> &'static str {
        "BMA 2013, Figure 6"
    }

    fn needs(&self) -> &'static str {
        "a technique at three sizes of array, one of them too small, on the view bma of atrium, smoke \
         or powerplant"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let mut outputs = Vec::new();
        for (device, groups) in devices(tables, wanted) {
            let found: BTreeMap<&str, Vec<Size>> = groups
                .iter()
                .map(|(paper, group)| (*paper, sizes(group)))
                .filter(|(_, sizes)| sizes.len() >= 3 && sizes.iter().any(|size| size.wrong_px > 0))
                .collect();
            if found.is_empty() {
                continue;
            }
            outputs.push(shares(&device, &groups, &found));
            for (paper, sizes) in &found {
                outputs.extend(pictures(&groups[paper], sizes)?);
            }
        }
        Ok(outputs)
    }
}

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    technique.schedule.starts_with("bma-")
        && technique.truncated()
        && technique.whole_pool()
        && cell.verification.is_some()
}

/// A technique at one size of its array.
struct Size<'a> {
    cell: &'a CellResult,
    max_frags: u32,
    wrong_px: u64,
    verification: &'a Verification,
}

/// The coordinate without its size.
fn family(cell: &CellResult) -> String {
    let t = &cell.technique;
    format!("{}/{}/{}/{}/{}", t.capture, t.schedule, t.sort, t.shader_stage, t.ties)
}

/// The sizes of the technique of a group that has the most of them, from small to large.
fn sizes<'a>(group: &Group<'a>) -> Vec<Size<'a>> {
    let mut families: BTreeMap<String, BTreeMap<u32, Size>> = BTreeMap::new();
    for &cell in &group.cells {
        let bma = cell.technique.schedule.starts_with("bma-") && cell.technique.whole_pool();
        let Some(verification) = cell.verification.as_ref().filter(|_| bma) else { continue };
        let (max_frags, wrong_px) = (verification.max_frags, verification.wrong_px);
        let size = Size { cell, max_frags, wrong_px, verification };
        families.entry(family(cell)).or_default().insert(max_frags, size);
    }
    let most = families.into_values().max_by_key(BTreeMap::len);
    most.map_or(Vec::new(), |sizes| sizes.into_values().collect())
}

fn share(size: &Size) -> f64 {
    let pixels = f64::from(size.cell.name.width_px) * f64::from(size.cell.name.height_px);
    100.0 * size.wrong_px as f64 / pixels
}

/// The share of wrong pixels against the size of the array.
fn shares(
    device: &str,
    groups: &BTreeMap<&str, Group>,
    found: &BTreeMap<&str, Vec<Size>>,
) -> Output {
    let columns = vec![
        "scene",
        "view",
        "width_px",
        "height_px",
        "technique",
        "max_frags",
        "wrong_px",
        "wrong_percent",
        "max_error",
        "rmse",
        "repeat_differs_px",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns =
        ["view", "array", "wrong pixels", "share", "largest error", "root mean square error"];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let mut lines = Vec::new();
    for ((paper, sizes), colour) in found.iter().zip(SERIES) {
        let group = &groups[paper];
        for size in sizes {
            let v = size.verification;
            csv.rows.push(vec![
                group.scene.to_owned(),
                group.view.to_owned(),
                group.width_px.to_string(),
                group.height_px.to_string(),
                size.cell.name.technique.clone(),
                size.max_frags.to_string(),
                v.wrong_px.to_string(),
                format!("{}", share(size)),
                format!("{}", v.max_error),
                format!("{}", v.rmse),
                v.repeat_differs_px.map_or(String::new(), |px| px.to_string()),
            ]);
            // The last digits of a right picture are no error.
            let error =
                |value: f64| if v.wrong_px == 0 { "–".into() } else { three_digits(value) };
            table.rows.push(vec![
                group.title().into(),
                size.max_frags.to_string().into(),
                v.wrong_px.to_string().into(),
                format!("{} %", number(share(size))).into(),
                error(v.max_error).into(),
                error(v.rmse).into(),
            ]);
        }
        let point = |size: &Size| LinePoint {
            x: f64::from(size.max_frags),
            y: [share(size); 3],
            hollow: size.wrong_px == 0,
        };
        lines.push(Line {
            label: group.title(),
            colour: *colour,
            points: sizes.iter().map(point).collect(),
        });
    }
    let all = || found.values().flatten();
    let mut ticks: Vec<u32> = all().map(|size| size.max_frags).collect();
    ticks.sort_unstable();
    ticks.dedup();
    let heads = || ticks.iter().map(|&size| f64::from(size));
    let mut x = Scale::logarithmic("fragments that the largest array holds, log scale", heads());
    x.ticks = heads().collect();
    let y = Scale::from_zero("percent of all pixels, off by more than 1/255", all().map(share));
    let technique = all().next().map_or(String::new(), |size| family(size.cell));
    Output {
        name: format!("bma-figure-6-{}", slug(device)),
        title: "BMA 2013, Figure 6: pixels wrong because the array is too small".to_owned(),
        subtitle: format!("{device}; {technique} order"),
        chart: Box::new(Lines(vec![LinePanel {
            title: "Pixels wrong".to_owned(),
            x,
            y,
            across: None,
            lines,
        }])),
        tables: vec![table],
        csv,
        notes: vec![
            "Of pixels deeper than the array, the fragments that the list has first are kept, which \
             are those drawn last. Hollow: no pixel is wrong."
                .to_owned(),
            format!("The paper shows pictures with 32 and with 64, and no numbers. {OUR_SCENES}"),
        ],
        stamps: found.keys().map(|paper| Stamp::of(groups[paper].run)).collect(),
    }
}

fn error_colour(error: u16) -> [u8; 3] {
    if error == 0 {
        [0; 3]
    } else {
        viridis(f64::from(error.min(BRIGHTEST)) / f64::from(BRIGHTEST))
    }
}

/// The pictures of a view that were kept, the right one first.
fn pictures(group: &Group, sizes: &[Size]) -> Result<Option<Output>, FigureError> {
    let mut rows = Vec::new();
    let columns = vec!["technique", "max_frags", "wrong_percent", "max_error", "block_px"];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = ["array", "wrong pixels", "largest error", "a pixel of the whole is"];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for size in sizes.iter().rev() {
        let Some(kept) = images::read(group.run, &size.cell.name)? else { continue };
        let Images { picture, detail, error } = kept;
        let block = images::block_px(group.width_px, picture.width);
        let error_block = images::block_px(group.width_px, error.width);
        let (percent, most) = (number(share(size)), size.verification.max_error);
        let most_text = if size.wrong_px == 0 { "–".to_owned() } else { three_digits(most) };
        csv.rows.push(vec![
            size.cell.name.technique.clone(),
            size.max_frags.to_string(),
            percent.clone(),
            format!("{most}"),
            block.to_string(),
        ]);
        table.rows.push(vec![
            size.max_frags.to_string().into(),
            format!("{percent} %").into(),
            most_text.clone().into(),
            format!("the mean of {block} × {block}").into(),
        ]);
        let whole = |Rgb { width, bytes }: Rgb, title: String| Picture { title, width, rgb: bytes };
        let Errors { width, values } = error;
        let map = Picture {
            title: format!("Errors, the largest of {error_block} × {error_block} pixels"),
            width,
            rgb: values.into_iter().flat_map(error_colour).collect(),
        };
        let (wide, high) = DETAIL_PX;
        rows.push(PictureRow {
            title: match size.wrong_px {
                0 => format!("Arrays up to {}: no pixel wrong", size.max_frags),
                _ => format!(
                    "Arrays up to {}: {percent} % of pixels wrong, by up to {most_text}",
                    size.max_frags
                ),
            },
            pictures: vec![
                whole(picture, format!("The picture, scaled down by {block}")),
                whole(
                    detail,
                    format!("{wide} × {high} pixels of it, those with the most fragments"),
                ),
                map,
            ],
        });
    }
    if rows.is_empty() {
        return Ok(None);
    }
    let scale = (0..64_u16).map(|step| {
        let [red, green, blue] = error_colour(1 + step * (BRIGHTEST - 1) / 63);
        Colour(red, green, blue)
    });
    let ends = [
        "Errors: black none, then 1/255".to_owned(),
        format!("{BRIGHTEST}/255 and more, of a colour channel"),
    ];
    Ok(Some(Output {
        name: format!("bma-figure-6-{}-{}", group.slug(), group.device_slug()),
        title: format!("BMA 2013, Figure 6: arrays too small for a picture: {}", group.title()),
        subtitle: group.conditions(),
        chart: Box::new(Pictures { rows, scale: (scale.collect(), ends) }),
        tables: vec![table],
        csv,
        notes: vec![format!("Pictures are over white. {OUR_SCENES}")],
        stamps: [Stamp::of(group.run)].into(),
    }))
}
