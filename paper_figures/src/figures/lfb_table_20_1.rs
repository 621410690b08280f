//! Table 20.1 of the layered fragment buffer chapter: the time of each step of the two layouts, as
//! published and as measured.

use analysis::{CellResult, TOTAL, Tables, scene_name};

use super::Figure;
use super::lfb_views::{AS_PUBLISHED, LAYOUTS, LfbView, VIEWS};
use crate::FigureError;
use crate::axis::{number, three_digits};
use crate::chart::TableImage;
use crate::data::{Group, by_device, groups, slug, view_of};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::published::{self, Published};
use crate::technique_names::find;

/// Table 20.1 of the layered fragment buffer chapter.
pub(super) struct LfbTable20_1;

/// Schedules and stages measured, the one nearest to the chapter's first.
const VARIANTS: [(&str, &str); 4] =
    [AS_PUBLISHED, ("base", "fragment"), ("base", "compute"), ("bma-list", "compute")];

/// Sorts and floors that the steps are made of.
const SORTS: [&str; 3] = ["insertion", "unsorted", "passthrough"];

/// A row: its name, and whether the chapter has it.
struct Step {
    name: &'static str,
    value: fn(&Cells) -> Option<Measured>,
}

/// Milliseconds: the median, and its interval where it is of samples and no difference.
#[derive(Clone, Copy)]
struct Measured {
    ms: f64,
    interval_ms: Option<(f64, f64)>,
}

/// The cells of one layout, schedule and stage.
struct Cells<'a> {
    insertion: Option<&'a CellResult>,
    unsorted: Option<&'a CellResult>,
    passthrough: Option<&'a CellResult>,
}

impl<'a> Cells<'a> {
    fn of(group: &Group<'a>, layout: &str, (schedule, stage): (&str, &str)) -> Self {
        let [insertion, unsorted, passthrough] = SORTS.map(|sort| {
            let coordinate = format!("{layout}/{schedule}/{sort}/{stage}/peak");
            find(&group.cells, &coordinate).filter(|cell| !cell.times.is_empty())
        });
        Self { insertion, unsorted, passthrough }
    }

    fn any(&self) -> bool {
        [self.insertion, self.unsorted, self.passthrough].iter().any(Option::is_some)
    }
}

fn of(cell: Option<&CellResult>, stage: &str) -> Option<Measured> {
    let s = cell?.times.get(stage)?.summary;
    Some(Measured { ms: s.median / 1e6, interval_ms: Some((s.low / 1e6, s.high / 1e6)) })
}

/// The rows, in the order of the chapter, with ours between and below.
const STEPS: [Step; 9] = [
    Step { name: "Zero tables or pointers", value: |cells| of(cells.insertion, "clear") },
    Step { name: "Fragment count render", value: |cells| of(cells.insertion, "count") },
    Step { name: "Compute prefix sums", value: |cells| of(cells.insertion, "scan") },
    Step { name: "Main LFB render", value: |cells| of(cells.insertion, "capture") },
    Step { name: "Group or mask pixels", value: |cells| of(cells.insertion, "group") },
    Step { name: "Read & blend fragments", value: |cells| of(cells.unsorted, "resolve") },
    Step {
        name: "Sort in shader",
        value: |cells| {
            let (sorted, unsorted) =
                (of(cells.insertion, "resolve")?, of(cells.unsorted, "resolve")?);
            Some(Measured { ms: sorted.ms - unsorted.ms, interval_ms: None })
        },
    },
    Step { name: "Total", value: |cells| of(cells.insertion, TOTAL) },
    Step { name: "Read & blend, no array", value: |cells| of(cells.passthrough, "resolve") },
];

fn wanted(cell: &CellResult) -> bool {
    let technique = &cell.technique;
    let variant = (technique.schedule.as_str(), technique.shader_stage.as_str());
    VIEWS.iter().any(|view| view.is(scene_name(&cell.name.scene), &cell.name.view))
        && LAYOUTS.iter().any(|(_, capture)| *capture == technique.capture)
        && VARIANTS.contains(&variant)
        && SORTS.contains(&technique.sort.as_str())
        && technique.max == "peak"
        && technique.whole_pool()
}

impl Figure for LfbTable20_1 {
    fn name(&self) -> &'static str {
        "lfb-table-20-1"
    }

    fn source(&self) -> &'static str {
        "LFB 2012, Table 20.1"
    }

    fn needs(&self) -> &'static str {
        "a linearized or linked_list technique with insertion, unsorted or passthrough on dragon \
         front or atrium lfb"
    }

    fn draw(&self, tables: &Tables) -> Result<Vec<Output>, FigureError> {
        let published = published::table("lfb-table-20.1")?;
        let mut outputs = Vec::new();
        for (device, groups) in by_device(groups(tables, wanted)) {
            let found: Vec<(&LfbView, &Group)> = VIEWS
                .iter()
                .filter_map(|view| Some((view, view_of(&groups, view.scene, view.view)?)))
                .collect();
            let mut shown = vec![scenes(&found, &published)];
            shown.extend(found.iter().map(|(view, group)| block(view, group, &published)));
            outputs.push(Output {
                name: format!("{}-{}", self.name(), slug(&device)),
                title: "LFB 2012, Table 20.1: time of each step, ms".to_owned(),
                subtitle: format!("Published: {}, {} px", published.device, published.resolution),
                chart: Box::new(TableImage(shown.clone())),
                tables: shown,
                csv: csv(&found, &published),
                notes: notes(),
                stamps: found.iter().map(|(_, group)| Stamp::of(group.run)).collect(),
            });
        }
        Ok(outputs)
    }
}

fn notes() -> Vec<String> {
    [
        "L: linearized. LL: linked list. Medians. The column base-stencil, fragment is nearest to \
         the chapter: one program, empty pixels masked.",
        "The chapter does not say how its last two steps were told apart. Here Read & blend is the \
         resolve with unsorted, which fills the array and blends from it; Sort in shader is what \
         the resolve with insertion takes more than that. All other steps, and the total, are of \
         insertion. Read & blend, no array, is passthrough.",
        "The chapter's atrium columns miss their totals by 7 ms, as if 95.05 and 88.08 stood in \
         each other's place. Our atrium is generated and not its model: compare ratios.",
    ]
    .map(str::to_owned)
    .to_vec()
}

fn scenes(found: &[(&LfbView, &Group)], published: &Published) -> Table {
    let columns = [
        "scene",
        "triangles\n2012",
        "triangles\nours",
        "fragments, M\n2012",
        "fragments, M\nours",
        "mean of\ncovered",
        "deepest\npixel",
        "empty\npixels",
    ];
    let mut table = Table { columns: columns.map(str::to_owned).to_vec(), ..Table::default() };
    for (view, group) in found {
        let fact = |name: &str| published.fact(name, view.paper).map_or("–".to_owned(), number);
        let name = group.name();
        let counted = group.run.counted.iter().find(|(known, _, _)| *known == name);
        let mut row = vec![format!("{}: {}", view.paper, group.title()).into()];
        row.push(fact("Triangles").into());
        row.push(counted.map_or("–".to_owned(), |(_, triangles, _)| triangles.to_string()).into());
        row.push(fact("Total Frags (M)").into());
        let histogram = counted.map_or(&[][..], |(_, _, histogram)| histogram);
        let total = group.run.total_fragments(&name).unwrap_or(0) as f64;
        let empty = histogram.first().copied().unwrap_or(0) as f64;
        let pixels = f64::from(group.width_px) * f64::from(group.height_px);
        row.push(format!("{:.2}", total / 1e6).into());
        row.push(format!("{:.2}", total / (pixels - empty).max(1.0)).into());
        row.push(histogram.iter().rposition(|&px| px > 0).unwrap_or(0).to_string().into());
        row.push(format!("{:.0} %", 100.0 * empty / pixels).into());
        table.rows.push(row);
    }
    table
}

fn block(view: &LfbView, group: &Group, published: &Published) -> Table {
    let measured: Vec<((&str, &str), Vec<Cells>)> = VARIANTS
        .iter()
        .map(|&variant| {
            let cells = LAYOUTS.map(|(_, capture)| Cells::of(group, capture, variant));
            (variant, Vec::from(cells))
        })
        .filter(|(_, cells)| cells.iter().any(Cells::any))
        .collect();
    let mut columns = vec!["step".to_owned()];
    columns.extend(LAYOUTS.map(|(layout, _)| format!("2012\nfragment\n{layout}")));
    for ((schedule, stage), _) in &measured {
        columns.extend(LAYOUTS.map(|(layout, _)| format!("{schedule}\n{stage}\n{layout}")));
    }
    let rows = STEPS.iter().map(|step| {
        let mut row = vec![Value::from(step.name)];
        for (layout, _) in LAYOUTS {
            // As they were printed.
            let ms = published.value(step.name, view.paper, layout);
            row.push(ms.map_or("–".to_owned(), |ms| format!("{ms:.2}")).into());
        }
        for cells in measured.iter().flat_map(|(_, cells)| cells) {
            let ms = (step.value)(cells).map(|value| value.ms);
            row.push(ms.map_or("–".to_owned(), three_digits).into());
        }
        row
    });
    Table {
        heading: format!("{}: {}, {}", view.paper, group.title(), group.conditions()),
        rows: rows.collect(),
        columns,
    }
}

fn csv(found: &[(&LfbView, &Group)], published: &Published) -> Csv {
    let columns = vec![
        "device",
        "scene",
        "view",
        "width_px",
        "height_px",
        "layout",
        "schedule",
        "shader_stage",
        "step",
        "published_ms",
        "median_ms",
        "low_ms",
        "high_ms",
        "run",
        "commit",
    ];
    let say = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
    let mut rows = Vec::new();
    for (view, group) in found {
        for variant in VARIANTS {
            for (layout, capture) in LAYOUTS {
                let cells = Cells::of(group, capture, variant);
                if !cells.any() {
                    continue;
                }
                for step in STEPS {
                    let value = (step.value)(&cells);
                    let interval = value.and_then(|value| value.interval_ms);
                    rows.push(vec![
                        group.run.device(),
                        group.scene.to_owned(),
                        group.view.to_owned(),
                        group.width_px.to_string(),
                        group.height_px.to_string(),
                        capture.to_owned(),
                        variant.0.to_owned(),
                        variant.1.to_owned(),
                        step.name.to_owned(),
                        say(published.value(step.name, view.paper, layout)),
                        say(value.map(|value| value.ms)),
                        say(interval.map(|(low, _)| low)),
                        say(interval.map(|(_, high)| high)),
                        group.run.name.clone(),
                        group.run.commit(),
                    ]);
                }
            }
        }
    }
    Csv { columns, rows }
}
