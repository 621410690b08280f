//! One sort on one page: what it is, whether it sorts, its times beside those of every other sort by
//! depth complexity and in whole frames, its programs, and what the order of submission does to it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use analysis::{
    BOOTSTRAP_SEED, CellResult, ProgramFigures, RESOLVE, RunInfo, State, TOTAL, Tables,
    scene_parameters,
};
use oit_record::statistics::{self, Comparison};
use oit_record::{Conformance, Program, Subject, SubjectPart};

use super::ratios::{family_name, wanted};

use crate::FigureError;
use crate::axis::three_digits;
use crate::chart::{Line, LinePanel, LinePoint, Lines, Scale};
use crate::data::{Group, slug, uniform_depth};
use crate::mechanism::{or_dash, or_empty};
use crate::output::{Csv, Output, Stamp, Table, Value};
use crate::style::{SERIES, sort_colour};

/// The page and its chart.
pub struct Page {
    /// The chart, with every number of the page for programs.
    pub output: Output,
    /// The page.
    pub markdown: String,
}

impl Page {
    /// Writes the chart, its numbers, and the page, all by the output's name.
    ///
    /// # Errors
    /// Where drawing fails or a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), FigureError> {
        fs::create_dir_all(folder)
            .map_err(|error| FigureError::Io { path: folder.to_owned(), error })?;
        self.output.write(folder)?;
        let path = folder.join(format!("{}.md", self.output.name));
        fs::write(&path, &self.markdown).map_err(|error| FigureError::Io { path, error })
    }
}

/// Whether a technique's sort is this one, possibly with another where it ends.
pub(super) fn is_sort(technique: &str, sort: &str) -> bool {
    technique == sort || technique.strip_prefix(sort).is_some_and(|rest| rest.starts_with('+'))
}

/// One page a run that has the sort.
///
/// # Errors
/// Where no run has it, or what lies beside a record is damaged.
pub fn compare_pages(tables: &Tables, sort: &str) -> Result<Vec<Page>, FigureError> {
    let cells = tables.results.iter().filter(|cell| wanted(cell));
    let has = cells.filter(|cell| is_sort(&cell.technique.sort, sort)).map(|cell| cell.run);
    let runs: BTreeSet<usize> = has.collect();
    if runs.is_empty() {
        let known: BTreeSet<&str> =
            tables.results.iter().map(|cell| cell.technique.sort.as_str()).collect();
        return Err(FigureError::Unknown {
            what: "sort in the records",
            name: sort.to_owned(),
            known: known.into_iter().collect::<Vec<_>>().join(", "),
        });
    }
    let alone = runs.len() == 1;
    let pages = runs.into_iter().map(|run| {
        let info = &tables.runs[run];
        let mut name = format!("compare-{}", slug(sort));
        if !alone {
            name += &format!("-{}-{}", slug(&info.device()), slug(&info.name));
        }
        page(tables, run, sort, name)
    });
    pages.collect()
}

/// Cells that differ in their sort alone, by the sort.
type Sorts<'a> = BTreeMap<&'a str, &'a CellResult>;

/// A view, and its cells by all that is no sort.
struct View<'a> {
    group: Group<'a>,
    /// Where it is a scene of one depth: the depth, the order of submission, and the fragments.
    uniform: Option<(u64, &'a str, u64)>,
    families: BTreeMap<String, Sorts<'a>>,
}

fn views<'a>(tables: &'a Tables, run: usize) -> Vec<View<'a>> {
    let mut views: Vec<View> = Vec::new();
    for cell in tables.results.iter().filter(|cell| cell.run == run && wanted(cell)) {
        let (name, info) = (cell.name.group(), &tables.runs[run]);
        let known = views.iter().position(|view| view.group.name() == name);
        let place = known.unwrap_or_else(|| {
            let group = Group {
                run: info,
                scene: &cell.name.scene,
                view: &cell.name.view,
                width_px: cell.name.width_px,
                height_px: cell.name.height_px,
                cells: Vec::new(),
            };
            let stack = analysis::scene_name(group.scene) == "stack";
            let uniform = uniform_depth(&group).filter(|_| stack).map(|(depth, pixels)| {
                let order = scene_parameters(group.scene).get("order").copied();
                // A scene's name has the parameters that are not its file's.
                let order = order.map_or("front_to_back", |order| order.trim_matches('"'));
                (depth, order, depth.saturating_mul(pixels))
            });
            views.push(View { group, uniform, families: BTreeMap::new() });
            views.len() - 1
        });
        let families = &mut views[place].families;
        let family = families.entry(family_name(&cell.technique)).or_default();
        family.insert(&cell.technique.sort, cell);
    }
    views
}

/// The views of one depth that tables by depth are made of: of one order, the first of these that
/// there is for a family.
const ORDERS: [&str; 3] = ["random", "front_to_back", "back_to_front"];

/// The views of one depth, of a family, by order and then by depth.
fn by_order<'v, 'a>(
    views: &'v [View<'a>],
    family: &str,
) -> BTreeMap<&'a str, BTreeMap<u64, &'v View<'a>>> {
    let mut orders: BTreeMap<&str, BTreeMap<u64, &View>> = BTreeMap::new();
    for view in views.iter().filter(|view| view.families.contains_key(family)) {
        if let Some((depth, order, _)) = view.uniform {
            orders.entry(order).or_default().insert(depth, view);
        }
    }
    orders
}

/// Everything by depth of one family, in one order of submission.
struct Depths<'v, 'a> {
    family: &'v str,
    order: &'a str,
    views: BTreeMap<u64, &'v View<'a>>,
}

impl<'a> Depths<'_, 'a> {
    fn cell(&self, depth: u64, sort: &str) -> Option<&'a CellResult> {
        own(self.views.get(&depth)?.families.get(self.family)?, sort)
    }

    /// The subject, then all others.
    fn sorts(&self, subject: &str) -> Vec<&'a str> {
        let families = self.views.values().filter_map(|view| view.families.get(self.family));
        let all: BTreeSet<&str> = families.flat_map(|sorts| sorts.keys().copied()).collect();
        let (mut first, rest): (Vec<&str>, Vec<&str>) =
            all.into_iter().partition(|sort| is_sort(sort, subject));
        first.extend(rest);
        first
    }

    fn columns(&self, first: &[&str]) -> Vec<String> {
        let depths = self.views.keys().map(|depth| format!("{depth} fragments"));
        first.iter().map(|head| (*head).to_owned()).chain(depths).collect()
    }
}

/// The cell of a sort: by its name, or of a choice that begins with it.
fn own<'a>(sorts: &Sorts<'a>, sort: &str) -> Option<&'a CellResult> {
    let longer = || sorts.iter().find(|(name, _)| is_sort(name, sort)).map(|(_, cell)| cell);
    sorts.get(sort).or_else(longer).copied()
}

/// A ratio of medians with its interval, by the written rule.
type Compared = (f64, f64, f64, Comparison);

/// Compares a stage of two cells of one run, of whatever view.
fn compared(a: &CellResult, b: &CellResult, stage: &str) -> Option<Compared> {
    let samples = |cell: &CellResult| -> Option<Vec<f64>> {
        Some(cell.times.get(stage)?.samples_ns.iter().map(|&ns| ns as f64).collect())
    };
    statistics::compare(&samples(a)?, &samples(b)?, BOOTSTRAP_SEED)
}

fn word(verdict: Comparison) -> &'static str {
    match verdict {
        Comparison::Faster => "faster",
        Comparison::Slower => "slower",
        Comparison::Same => "same",
    }
}

fn entry((ratio, low, high, verdict): Compared) -> Value {
    let text = format!("{ratio:.3} [{low:.3}, {high:.3}] {}", word(verdict));
    Value { text, marked: verdict == Comparison::Faster }
}

/// What is said of a cell without a time.
fn without_time(cell: Option<&CellResult>) -> Value {
    cell.map_or("–", |cell| match cell.state {
        State::Charted => "–",
        other => other.name(),
    })
    .into()
}

/// The text of a page, and its numbers.
struct Writer {
    text: String,
    csv: Csv,
}

impl Writer {
    fn heading(&mut self, text: &str) {
        self.text += &format!("## {text}\n\n");
    }

    fn say(&mut self, text: &str) {
        self.text += text;
        self.text += "\n\n";
    }

    fn table(&mut self, heading: &str, columns: Vec<String>, rows: Vec<Vec<Value>>) {
        if !heading.is_empty() {
            self.text += &format!("### {heading}\n\n");
        }
        self.text += &Table { heading: String::new(), columns, rows }.markdown();
        self.text.push('\n');
    }

    /// A row of numbers: a ratio of two cells, one of them the subject.
    fn ratio(&mut self, a: &CellResult, b: &CellResult, stage: &str, compared: Compared) {
        let (ratio, low, high, verdict) = compared;
        let mut row = cell_fields(a);
        row.extend([b.name.technique.clone(), b.name.scene.clone(), stage.to_owned()]);
        row.extend(["", "", "", ""].map(str::to_owned));
        row.extend([ratio, low, high].map(|value| format!("{value}")));
        row.push(word(verdict).to_owned());
        row.extend(["", "", "", "", "", ""].map(str::to_owned));
        self.csv.rows.push(row);
    }

    /// A row of numbers: a cell's time, and what is told of its program.
    fn time(&mut self, cell: &CellResult, stage: &str, program: Option<&Program>) {
        let mut row = cell_fields(cell);
        row.extend([String::new(), String::new(), stage.to_owned()]);
        match cell.times.get(stage).map(|timing| timing.summary) {
            Some(s) => {
                row.push(s.samples.to_string());
                row.extend([s.median, s.low, s.high].map(|ns| format!("{ns}")));
            }
            None => row.extend(["", "", "", ""].map(str::to_owned)),
        }
        row.extend(["", "", ""].map(str::to_owned));
        row.push(cell.state.name().to_owned());
        let told = figures(cell, program);
        row.extend(
            [told.registers, told.local_bytes, told.workgroup_bytes, told.binary_bytes]
                .map(or_empty),
        );
        row.push(or_empty(program.and_then(|program| program.compile_ns)));
        let cached = program.and_then(|program| program.from_cache);
        row.push(cached.map(|cached| cached.to_string()).unwrap_or_default());
        self.csv.rows.push(row);
    }
}

const COLUMNS: &[&str] = &[
    "scene",
    "view",
    "technique",
    "sort",
    "compared_with",
    "compared_scene",
    "stage",
    "n",
    "median_ns",
    "low_ns",
    "high_ns",
    "ratio",
    "ratio_low",
    "ratio_high",
    "verdict_or_state",
    "registers",
    "local_bytes",
    "workgroup_bytes",
    "binary_bytes",
    "compile_ns",
    "from_cache",
];

fn cell_fields(cell: &CellResult) -> Vec<String> {
    let name = &cell.name;
    let fields = [&name.scene, &name.view, &name.technique, &cell.technique.sort];
    fields.map(Clone::clone).to_vec()
}

fn figures(cell: &CellResult, program: Option<&Program>) -> ProgramFigures {
    program.map_or_else(ProgramFigures::default, |program| {
        ProgramFigures::of(program, &cell.technique.shader_stage)
    })
}

/// The program that resolves the pixels of this depth, where all have it.
fn program(cell: &CellResult, depth: u64) -> Option<&Program> {
    let mut programs = cell.programs.iter();
    programs.find(|program| (u64::from(program.low)..=program.high.into()).contains(&depth))
}

fn about(page: &mut Writer, subject: Option<&Subject>) {
    page.heading("What it is");
    let Some(subject) = subject else {
        page.say("The run does not say.");
        return;
    };
    for SubjectPart { name, summary, citation, store, stores, limit, .. } in &subject.parts {
        let limit = limit.map_or("no limit".to_owned(), |limit| format!("up to {limit} fragments"));
        page.say(&format!("`{name}`: {summary}"));
        page.say(&format!(
            "From: {citation}. Measured in the store {store}, of {}; {limit}.",
            stores.join(", ")
        ));
    }
}

fn correctness(page: &mut Writer, subject: Option<&Subject>, own_cells: &[&CellResult]) {
    page.heading("Correct or not");
    for part in subject.iter().flat_map(|subject| &subject.parts) {
        let Conformance { compared, up_to, programs, lists, lacking, wrong } = &part.conformance;
        let verdict = match wrong {
            Some(what) => format!("**wrong**: {what}"),
            None if *programs == 0 => "nothing was run".to_owned(),
            None => "every list was sorted".to_owned(),
        };
        let mut text = format!(
            "Conformance of `{}`: {verdict} ({compared}; {programs} programs of up to {up_to} \
             fragments, {lists} lists).",
            part.name
        );
        if let Some(reason) = lacking {
            text += &format!(" Not run on this device {reason}.");
        }
        page.say(&text);
    }
    if subject.is_none() {
        page.say("The conformance suite was not run, or not by `oit compare`.");
    }
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for cell in own_cells {
        let verdict = match (cell.state, &cell.verification) {
            (State::Charted, Some(found)) => match found.verdict {
                oit_record::Verdict::Exact => "exact",
                _ => "approximate",
            },
            (state, _) => state.name(),
        };
        *verdicts.entry(verdict).or_default() += 1;
    }
    let verdicts: Vec<String> =
        verdicts.iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
    page.say(&format!("Of its cells, compared with the oracle: {}.", verdicts.join(", ")));
    for cell in own_cells.iter().filter(|cell| cell.state != State::Charted) {
        let why = cell.reason.as_deref().unwrap_or("no reason is recorded").replace('\n', " ");
        let (name, state) = (&cell.name, cell.state.name());
        page.say(&format!("- {state}: `{}` on {}: {why}", name.technique, name.group()));
    }
}

fn times(page: &mut Writer, all: &[Depths], subject: &str) {
    page.heading("Time per interval");
    if all.is_empty() {
        page.say("The run holds no views on which all pixels have one depth.");
        return;
    }
    page.say(
        "Resolve with grouping where every pixel has as many fragments. The sort itself in ns a \
         fragment; then its time over the other's with the 95 % interval: faster where the whole \
         interval lies below 1, slower where above, else same. passthrough sorts nothing: it is the \
         floor.",
    );
    for depths in all {
        let mut rows = Vec::new();
        for (place, sort) in depths.sorts(subject).into_iter().enumerate() {
            let is_subject = place == 0 && is_sort(sort, subject);
            let mut row: Vec<Value> = vec![sort.into()];
            for (&depth, view) in &depths.views {
                let cell = depths.cell(depth, sort);
                if let Some(cell) = cell {
                    page.time(cell, RESOLVE, program(cell, depth));
                }
                let mut value = without_time(cell);
                if let (true, Some(cell), Some((_, _, fragments))) =
                    (is_subject, cell, view.uniform)
                    && let Some(timing) = cell.times.get(RESOLVE)
                {
                    let ns = timing.summary.median / fragments.max(1) as f64;
                    value = format!("{} ns", three_digits(ns)).into();
                } else if let (false, Some(other), Some(own)) =
                    (is_subject, cell, depths.cell(depth, subject))
                    && let Some(ratio) = compared(own, other, RESOLVE)
                {
                    page.ratio(own, other, RESOLVE, ratio);
                    value = entry(ratio);
                }
                row.push(value);
            }
            rows.push(row);
        }
        let heading = format!("{}, order {}", depths.family, depths.order.replace('_', " "));
        page.table(&heading, depths.columns(&["sort"]), rows);
    }
}

fn programs(page: &mut Writer, all: &[Depths], subject: &str) {
    page.heading("Registers, spill and size");
    page.say(
        "What the driver tells of the program of each interval: registers of an invocation / local \
         bytes / workgroup bytes / bytes of code. Local bytes are arrays that are not in registers, \
         and spills. – is what it does not tell.",
    );
    // What a program has is no matter of its interval's pixels.
    let entry_of = |cell: &CellResult, depth: u64| -> Value {
        let told = figures(cell, program(cell, depth));
        let all = [told.registers, told.local_bytes, told.workgroup_bytes, told.binary_bytes];
        all.map(or_dash).join(" / ").into()
    };
    by_sort(page, all, subject, &entry_of);
    page.heading("Time to compile");
    page.say(
        "Milliseconds that the driver took to make the program, by the host's clock. \"cache\" is \
         one that was found in the pipeline cache, and no time to compile. The driver's own caches \
         do not show.",
    );
    let entry_of = |cell: &CellResult, depth: u64| -> Value {
        let Some(program) = program(cell, depth) else { return "–".into() };
        let Some(ns) = program.compile_ns else { return "–".into() };
        let ms = three_digits(ns as f64 / 1e6);
        if program.from_cache == Some(true) { format!("{ms} (cache)").into() } else { ms.into() }
    };
    by_sort(page, all, subject, &entry_of);
}

/// A table for each family: sorts down, depths across.
fn by_sort(
    page: &mut Writer,
    all: &[Depths],
    subject: &str,
    entry_of: &dyn Fn(&CellResult, u64) -> Value,
) {
    for depths in all {
        let row = |sort: &str| -> Vec<Value> {
            let entries = depths.views.keys().map(|&depth| {
                depths.cell(depth, sort).map_or_else(|| "–".into(), |cell| entry_of(cell, depth))
            });
            [sort.into()].into_iter().chain(entries).collect()
        };
        let rows = depths.sorts(subject).into_iter().map(row).collect();
        page.table(depths.family, depths.columns(&["sort"]), rows);
    }
}

fn orders(page: &mut Writer, views: &[View], families: &BTreeSet<&str>, subject: &str) {
    page.heading("Effect of the order of submission");
    page.say(
        "Resolve with grouping where triangles come back to front or in random order, over that of \
         front to back, of the same sort. A linked list is read in the reverse of the order in which \
         it was filled. The views are timed one after the other, so drift of the device between \
         them is in these ratios.",
    );
    for family in families {
        let orders = by_order(views, family);
        let Some(front) = orders.get("front_to_back") else { continue };
        let depths = Depths { family, order: "front_to_back", views: front.clone() };
        let mut rows = Vec::new();
        for sort in depths.sorts(subject) {
            for (order, others) in orders.iter().filter(|(order, _)| **order != depths.order) {
                let others = Depths { family, order, views: others.clone() };
                let mut row: Vec<Value> = vec![sort.into(), order.replace('_', " ").into()];
                for &depth in depths.views.keys() {
                    let pair = others.cell(depth, sort).zip(depths.cell(depth, sort));
                    let value = pair.and_then(|(a, b)| {
                        let ratio = compared(a, b, RESOLVE)?;
                        page.ratio(a, b, RESOLVE, ratio);
                        Some(Value { marked: false, ..entry(ratio) })
                    });
                    row.push(value.unwrap_or_else(|| "–".into()));
                }
                rows.push(row);
            }
        }
        if !rows.is_empty() {
            page.table(family, depths.columns(&["sort", "order"]), rows);
        }
    }
}

fn scenes(page: &mut Writer, views: &[View], subject: &str) {
    page.heading("Whole frames");
    let whole: Vec<&View> = views.iter().filter(|view| view.uniform.is_none()).collect();
    if whole.is_empty() {
        page.say("No scene was measured.");
        return;
    }
    page.say(
        "The sort's time over the other's, of the resolve with grouping and of the whole frame. Where \
         a sort does not hold the deepest pixels, another goes on where it ends, as its name says.",
    );
    for view in whole {
        for (family, sorts) in &view.families {
            let Some(own) = own(sorts, subject) else { continue };
            let ms = |cell: &CellResult, stage: &str| -> Value {
                cell.median_ms(stage)
                    .map_or_else(|| without_time(Some(cell)), |ms| three_digits(ms).into())
            };
            let mut rows: Vec<Vec<Value>> = Vec::new();
            let others = sorts.values().filter(|cell| cell.cell != own.cell);
            for cell in std::iter::once(&own).chain(others) {
                let mut row: Vec<Value> =
                    vec![cell.technique.sort.as_str().into(), ms(cell, RESOLVE), ms(cell, TOTAL)];
                for stage in [RESOLVE, TOTAL] {
                    page.time(cell, stage, None);
                    let ratio = compared(own, cell, stage).filter(|_| cell.cell != own.cell);
                    if let Some(ratio) = ratio {
                        page.ratio(own, cell, stage, ratio);
                    }
                    row.push(ratio.map_or_else(|| "".into(), entry));
                }
                rows.push(row);
            }
            let columns = ["sort", "resolve, ms", "frame, ms", "resolve over it", "frame over it"];
            let heading = format!("{}: {family}", view.group.title());
            page.table(&heading, columns.map(str::to_owned).to_vec(), rows);
        }
    }
}

/// A line through the resolve times of a sort, ns a fragment.
fn line(depths: &Depths, sort: &str, label: &str, colour: crate::canvas::Colour) -> Option<Line> {
    let points = depths.views.iter().filter_map(|(&depth, view)| {
        let s = depths.cell(depth, sort)?.times.get(RESOLVE)?.summary;
        let fragments = view.uniform?.2.max(1) as f64;
        let y = [s.median, s.low, s.high].map(|ns| ns / fragments);
        (y[1] > 0.0).then_some(LinePoint { x: depth as f64, y, hollow: false })
    });
    let points: Vec<LinePoint> = points.collect();
    (!points.is_empty()).then(|| Line { label: label.to_owned(), colour, points })
}

fn panel(title: String, lines: Vec<Line>) -> Option<LinePanel> {
    let points = || lines.iter().flat_map(|line| &line.points);
    points().next()?;
    let mut x =
        Scale::logarithmic("fragments of every pixel, log scale", points().map(|point| point.x));
    x.ticks = points().map(|point| point.x).collect();
    x.ticks.sort_by(f64::total_cmp);
    x.ticks.dedup();
    let y = Scale::logarithmic(
        "resolve with grouping, ns a fragment, log scale",
        points().flat_map(|point| point.y),
    );
    Some(LinePanel { title, x, y, across: None, lines })
}

fn chart(all: &[Depths], views: &[View], subject: &str) -> Lines {
    let mut panels = Vec::new();
    for depths in all {
        let sorts = depths.sorts(subject);
        let lines = sorts.iter().filter_map(|sort| line(depths, sort, sort, sort_colour(sort)));
        let title = format!("{}, order {}", depths.family, depths.order.replace('_', " "));
        panels.extend(panel(title, lines.collect()));
    }
    for depths in all {
        let orders = by_order(views, depths.family);
        if orders.len() < 2 {
            continue;
        }
        let lines = orders.into_iter().zip(SERIES.iter().cycle()).filter_map(
            |((order, views), &colour)| {
                let depths = Depths { family: depths.family, order, views };
                line(&depths, subject, &order.replace('_', " "), colour)
            },
        );
        panels.extend(panel(format!("{subject} by order: {}", depths.family), lines.collect()));
    }
    Lines(panels)
}

fn page(tables: &Tables, run: usize, sort: &str, name: String) -> Result<Page, FigureError> {
    let info: &RunInfo = &tables.runs[run];
    let sidecar = |error: oit_record::RecordError| FigureError::Sidecar {
        path: info.folder.clone(),
        reason: error.to_string(),
    };
    let subject = Subject::read(&info.folder).map_err(sidecar)?;
    let subject = subject.filter(|subject| subject.sort == sort);
    let views = views(tables, run);
    let families: BTreeSet<&str> = views
        .iter()
        .flat_map(|view| &view.families)
        .filter(|(_, sorts)| own(sorts, sort).is_some())
        .map(|(family, _)| family.as_str())
        .collect();
    let depths = families.iter().filter_map(|&family| {
        let mut orders = by_order(&views, family);
        let order = ORDERS.into_iter().find(|order| orders.contains_key(order))?;
        let (order, views) = orders.remove_entry(order)?;
        Some(Depths { family, order, views })
    });
    let depths: Vec<Depths> = depths.collect();
    let in_families = views.iter().flat_map(|view| view.families.values());
    let own_cells: Vec<&CellResult> = in_families.filter_map(|sorts| own(sorts, sort)).collect();

    let title = format!("{sort} against other sorts");
    let subtitle = format!("{}, {} profile", info.device(), info.run.profile);
    let mut page = Writer {
        text: format!("# {title}\n\n{subtitle}\n\n![Chart]({name}.svg)\n\n"),
        csv: Csv { columns: COLUMNS.to_vec(), rows: Vec::new() },
    };
    about(&mut page, subject.as_ref());
    correctness(&mut page, subject.as_ref(), &own_cells);
    times(&mut page, &depths, sort);
    programs(&mut page, &depths, sort);
    orders(&mut page, &views, &families, sort);
    scenes(&mut page, &views, sort);
    let stamp = Stamp::of(info);
    page.say(&format!(
        "Numbers: [CSV]({name}.csv). Chart: [SVG]({name}.svg), [PNG]({name}.png).\n\nMade from: {}",
        stamp.line()
    ));
    let output = Output {
        name,
        title,
        subtitle,
        chart: Box::new(chart(&depths, &views, sort)),
        tables: Vec::new(),
        csv: page.csv,
        notes: vec![
            "Medians with 95 % bootstrap intervals. passthrough reads and blends unsorted: the floor."
                .to_owned(),
        ],
        stamps: [stamp].into(),
    };
    Ok(Page { output, markdown: page.text })
}
