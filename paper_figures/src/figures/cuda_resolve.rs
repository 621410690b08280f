//! The same kernels in CUDA and in WGSL: the resolve time of the one over that of the other, sort by
//! sort.

use std::collections::{BTreeMap, BTreeSet};

use analysis::{CellResult, RESOLVE, Ratio, Tables, compare};

use super::Figure;
use super::ratios::wanted;
use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{RatioBar, RatioBars, RatioPanel};
use crate::data::{Group, by_device, groups_with, random_depth, slug};
use crate::output::{Csv, Output, Stamp, Table};
use crate::style::sort_colour;

/// CUDA beside WGSL.
pub(super) struct CudaResolve;

impl Figure for CudaResolve {
    fn name(&self) -> &'static str {
        "cuda-resolve"
    }

    fn source(&self) -> &'static str {
        "RBS 2014, section 4 (CUDA-IS, CUDA-IMS, CUDA-RBS-L): the same kernels in CUDA and in compute"
    }

    fn needs(&self) -> &'static str {
        "a view with a sort in CUDA and in the compute stage, all else equal"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let in_cuda = |cell: &CellResult| wanted(cell) && cell.technique.shader_stage == "cuda";
        let groups = groups_with(tables, in_cuda, |group| pairs(group).next().is_some());
        let mut outputs = Vec::new();
        for (device, groups) in by_device(groups) {
            // Layers of one depth, and views of scenes.
            for (what, title, layers) in
                [("layers", "pixels of one depth", true), ("views", "views of scenes", false)]
            {
                let groups = groups.iter().filter(|group| random_depth(group).is_some() == layers);
                let mut groups: Vec<&Group> = groups.collect();
                groups.sort_by_key(|group| random_depth(group));
                outputs.extend(output(&device, (what, title), &groups)?);
            }
        }
        Ok(outputs)
    }
}

/// A sort in CUDA and in compute.
fn pairs<'a>(group: &Group<'a>) -> impl Iterator<Item = (&'a CellResult, &'a CellResult)> {
    let timed = |cell: &&CellResult| wanted(cell) && cell.times.contains_key(RESOLVE);
    let cells: Vec<&CellResult> = group.cells.iter().copied().filter(timed).collect();
    let of_cuda: Vec<&CellResult> =
        cells.iter().copied().filter(|cell| cell.technique.shader_stage == "cuda").collect();
    of_cuda.into_iter().filter_map(move |cuda| {
        let same = |other: &&&CellResult| {
            let (a, b) = (&cuda.technique, &other.technique);
            b.shader_stage == "compute"
                && (&a.capture, &a.schedule, &a.sort, &a.ties)
                    == (&b.capture, &b.schedule, &b.sort, &b.ties)
        };
        Some((cuda, cells.iter().find(same).copied()?))
    })
}

fn output(
    device: &str,
    (what, title): (&str, &str),
    groups: &[&Group],
) -> Result<Option<Output>, FigureError> {
    let columns = vec![
        "scene",
        "view",
        "fragments",
        "capture",
        "sort",
        "ties",
        "cuda_ms",
        "compute_ms",
        "cuda_over_compute",
        "low",
        "high",
        "verdict",
        "run",
    ];
    let mut csv = Csv { columns, rows: Vec::new() };
    let columns = [
        "view",
        "capture",
        "sort",
        "CUDA\nms",
        "WGSL\nms",
        "CUDA over\nWGSL",
        "95 % interval",
        "CUDA is",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    let mut panels: BTreeMap<(String, usize), RatioPanel> = BTreeMap::new();
    let (mut stamps, mut conditions) = (BTreeSet::new(), BTreeSet::new());
    for (place, group) in groups.iter().enumerate() {
        let depth = random_depth(group);
        let view = depth.map_or_else(|| group.title(), |depth| format!("{depth} fragments"));
        for (cuda, compute) in pairs(group) {
            let technique = &cuda.technique;
            let one = compare(cuda, compute, RESOLVE)?;
            let Ratio { ratio, low, high, .. } = one;
            let ms = [cuda, compute].map(|cell| cell.median_ms(RESOLVE).unwrap_or(f64::NAN));
            csv.rows.push(vec![
                group.scene.to_owned(),
                group.view.to_owned(),
                depth.map(|depth| depth.to_string()).unwrap_or_default(),
                technique.capture.clone(),
                technique.sort.clone(),
                technique.ties.clone(),
                format!("{}", ms[0]),
                format!("{}", ms[1]),
                format!("{ratio}"),
                format!("{low}"),
                format!("{high}"),
                one.word().to_owned(),
                group.run.name.clone(),
            ]);
            table.rows.push(vec![
                view.clone().into(),
                technique.capture.clone().into(),
                technique.sort.clone().into(),
                three_digits(ms[0]).into(),
                three_digits(ms[1]).into(),
                format!("{ratio:.3}").into(),
                format!("{low:.3} to {high:.3}").into(),
                one.word().into(),
            ]);
            let panel = panels.entry((technique.capture.clone(), place)).or_insert_with(|| {
                let title = format!("{}, {view}", technique.capture);
                RatioPanel { title, bars: Vec::new() }
            });
            panel.bars.push(RatioBar {
                label: technique.sort.clone(),
                colour: sort_colour(&technique.sort),
                ratio,
                low,
                high,
                annotation: format!("{}  {}", three_digits(ratio), one.word()),
            });
        }
        stamps.insert(Stamp::of(group.run));
        conditions.insert(group.conditions());
    }
    if panels.is_empty() {
        return Ok(None);
    }
    let sides = ("CUDA is faster".to_owned(), "WGSL is faster".to_owned());
    let axis_title = "resolve time in CUDA over that in WGSL, log scale".to_owned();
    let panels = panels.into_values().collect();
    Ok(Some(Output {
        name: format!("cuda-resolve-{what}-{}", slug(device)),
        title: format!("The same resolve in CUDA and in WGSL: {title}"),
        subtitle: conditions.into_iter().collect::<Vec<String>>().join("; "),
        chart: Box::new(RatioBars { axis_title, sides, panels }),
        tables: vec![table],
        csv,
        notes: vec![
            "The same captures of the same run, one program for all pixels in both. Whiskers: 95 % \
             bootstrap interval of the ratio of medians. passthrough reads and blends unsorted. The \
             paper's techniques in CUDA are those of sorts insertion, insertion_merge and rbs on linked \
             lists; it compared them with fragment shaders."
                .to_owned(),
        ],
        stamps,
    }))
}
