//! The tidy tables: built with polars, written as parquet and CSV.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use oit_record::statistics::{self, Summary};
use oit_record::{
    Bandwidth, Executable, PassWork, Program, RasterCounts, Record, Statistic, Verdict,
    Verification,
};
use polars::prelude::*;

use crate::cell::{RawSamples, collect};
use crate::run::total_fragments;
use crate::{
    AnalysisError, CellResult, ProgramFigures, RESOLVE, RunInfo, State, Timing, scene_name,
};

/// The seed of every bootstrap, so that the same records give the same tables.
pub const BOOTSTRAP_SEED: u64 = 2014;

/// What a cell is, in every table.
const KEY_COLUMNS: [&str; 22] = [
    "run",
    "device",
    "backend",
    "experiment",
    "profile",
    "cell",
    "technique",
    "capture",
    "schedule",
    "sort",
    "shader_stage",
    "max",
    "ties",
    "pool_percent",
    "pool_policy",
    "intervals",
    "method",
    "scene",
    "scene_name",
    "view",
    "width_px",
    "height_px",
];

/// Records as tables.
#[derive(Clone, Debug)]
pub struct Tables {
    /// The runs, in the order of the records.
    pub runs: Vec<RunInfo>,
    /// Every cell of every run with its times, for code that wants types and not frames.
    pub results: Vec<CellResult>,
    /// One row a sample and stage, `total` and the parts of stages (`resolve[16]`) among the stages:
    /// what a cell is, then `stage`, `sample`, `ns`. Cells of every state are here.
    pub samples: DataFrame,
    /// One row a cell: what it is, what became of it, errors, memory, pool, depth complexity.
    pub cells: DataFrame,
    /// One row a charted cell and stage, [`RESOLVE`] and [`crate::TOTAL`] among the stages: `n`,
    /// `median_ns`, quartiles, and the 95 % bootstrap interval of the median.
    pub summary: DataFrame,
    /// One row a resolve program of a cell whose record has them: its interval, strategy and store,
    /// the [`ProgramFigures`] its driver tells, how long it took to make, and, where the cell has no
    /// other program, the median of [`RESOLVE`]. What is not told is null.
    pub programs: DataFrame,
    /// One row a figure that a driver tells of an executable of a program, in its own words.
    pub program_statistics: DataFrame,
    /// One row a pass of a cell whose record has its work: what the plan says of it, what the device
    /// counts (null where it does not), and what the run measured of the device's bandwidth.
    pub work: DataFrame,
}

/// Builds the tables of `records`.
///
/// # Errors
/// Where a record contradicts itself, or the same folder is given twice.
pub fn load(records: &[Record]) -> Result<Tables, AnalysisError> {
    let runs = RunInfo::of(records)?;
    let mut collected = Vec::new();
    for (run, record) in records.iter().enumerate() {
        collected.extend(collect(record, run)?);
    }
    let cells = cells_frame(&runs, &collected)?;
    let raw = raw_frame(&runs, &collected)?;
    let keys = cells.clone().lazy().select(KEY_COLUMNS.map(col));
    let samples = with_keys(&keys, raw.clone(), &["stage", "sample", "ns"])?;

    let charted = cells.clone().lazy().filter(col("state").eq(lit(State::Charted.name())));
    let charted = raw.lazy().join(
        charted.select([col("run"), col("cell")]),
        [col("run"), col("cell")],
        [col("run"), col("cell")],
        JoinArgs::new(JoinType::Inner),
    );
    // What the papers call the resolve pass, sample by sample.
    let resolve = charted
        .clone()
        .filter(col("stage").eq(lit("group")).or(col("stage").eq(lit("resolve"))))
        .group_by([col("run"), col("cell"), col("sample")])
        .agg([col("ns").sum()])
        .select([col("run"), col("cell"), lit(RESOLVE).alias("stage"), col("sample"), col("ns")]);
    let grouped = concat([charted, resolve], UnionArgs::default())?
        .sort(["run", "cell", "stage", "sample"], SortMultipleOptions::default())
        .group_by_stable([col("run"), col("cell"), col("stage")])
        .agg([col("ns")])
        .collect()?;
    let timings = timings(&grouped)?;
    let summary = with_keys(
        &keys,
        summary_frame(&timings)?,
        &["stage", "n", "median_ns", "q1_ns", "q3_ns", "low_ns", "high_ns"],
    )?;

    let mut times: BTreeMap<(String, usize), BTreeMap<String, Timing>> = BTreeMap::new();
    for (run, cell, stage, timing) in timings {
        times.entry((run, cell as usize)).or_default().insert(stage, timing);
    }
    let mut results: Vec<CellResult> = collected.into_iter().map(|(result, _)| result).collect();
    for result in &mut results {
        let key = (runs[result.run].name.clone(), result.cell);
        result.times = times.remove(&key).unwrap_or_default();
    }
    let programs = with_keys(&keys, programs_frame(&runs, &results)?, &PROGRAM_COLUMNS)?;
    let program_statistics =
        with_keys(&keys, statistics_frame(&runs, &results)?, &STATISTIC_COLUMNS)?;
    let work = with_keys(&keys, work_frame(&runs, &results)?, &WORK_COLUMNS)?;
    Ok(Tables { runs, results, samples, cells, summary, programs, program_statistics, work })
}

impl Tables {
    /// Writes `samples`, `cells`, `summary`, `programs`, `program_statistics` and `work` to a folder,
    /// each as parquet and CSV.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&mut self, folder: &Path) -> Result<(), AnalysisError> {
        let error = |path: &Path| {
            let path = path.to_owned();
            |error| AnalysisError::Write { path, error }
        };
        fs::create_dir_all(folder).map_err(error(folder))?;
        let frames = [
            ("samples", &mut self.samples),
            ("cells", &mut self.cells),
            ("summary", &mut self.summary),
            ("programs", &mut self.programs),
            ("program_statistics", &mut self.program_statistics),
            ("work", &mut self.work),
        ];
        for (name, frame) in frames {
            let path = folder.join(format!("{name}.parquet"));
            let mut file = File::create(&path).map_err(error(&path))?;
            ParquetWriter::new(&mut file)
                .with_compression(ParquetCompression::Uncompressed)
                .finish(frame)?;
            let path = folder.join(format!("{name}.csv"));
            let mut file = File::create(&path).map_err(error(&path))?;
            CsvWriter::new(&mut file).finish(frame)?;
        }
        Ok(())
    }

    /// Every cell of one run and one group (scene, view, resolution).
    pub fn group<'a>(&'a self, run: usize, group: &'a str) -> impl Iterator<Item = &'a CellResult> {
        self.results.iter().filter(move |cell| cell.run == run && cell.name.group() == group)
    }
}

/// What orders the rows of a cell.
const ORDERING: [&str; 5] = ["pass", "stage", "sample", "program", "place"];

/// The columns of [`Tables::programs`] after those that say what a cell is.
const PROGRAM_COLUMNS: [&str; 15] = [
    "program",
    "strategy",
    "store",
    "low",
    "high",
    "invocations",
    "declared_workgroup_bytes",
    "registers",
    "local_bytes",
    "workgroup_bytes",
    "binary_bytes",
    "occupancy",
    "compile_ms",
    "from_cache",
    "resolve_ns",
];

/// The columns of [`Tables::program_statistics`] after those that say what a cell is.
const STATISTIC_COLUMNS: [&str; 12] = [
    "program",
    "place",
    "strategy",
    "store",
    "low",
    "high",
    "executable",
    "stages",
    "subgroup_size",
    "statistic",
    "value",
    "description",
];

/// The columns of [`Tables::work`] after those that say what a cell is.
const WORK_COLUMNS: [&str; 22] = [
    "pass",
    "stage",
    "label",
    "kind",
    "cleared_bytes",
    "color_bytes_per_fragment",
    "depth_stencil_bytes_per_fragment",
    "compute_invocations",
    "input_vertices",
    "input_primitives",
    "vertex_invocations",
    "tessellation_patches",
    "tessellation_invocations",
    "geometry_invocations",
    "geometry_primitives",
    "clipping_invocations",
    "clipping_primitives",
    "fragment_invocations",
    "attachment_bytes_at_most",
    "copy_bytes_per_s",
    "fill_bytes_per_s",
    "attachment_bytes_per_s",
];

/// Puts the columns that say what a cell is before `columns` of `frame`, and sorts the rows.
fn with_keys(keys: &LazyFrame, frame: DataFrame, columns: &[&str]) -> PolarsResult<DataFrame> {
    let on = [col("run"), col("cell")];
    let all = KEY_COLUMNS.iter().chain(columns).map(|&name| col(name)).collect::<Vec<_>>();
    let order: Vec<&str> = ["run", "cell"]
        .into_iter()
        .chain(columns.iter().copied().filter(|name| ORDERING.contains(name)))
        .collect();
    let join = JoinArgs::new(JoinType::Inner);
    frame
        .lazy()
        .join(keys.clone(), on.clone(), on, join)
        .select(all)
        .sort(order, SortMultipleOptions::default())
        .collect()
}

fn column<T>(name: &str, values: Vec<T>) -> Column
where
    Series: NamedFrom<Vec<T>, [T]>,
    Vec<T>: AsRef<[T]>,
{
    Series::new(name.into(), values).into()
}

fn raw_frame(runs: &[RunInfo], collected: &[(CellResult, RawSamples)]) -> PolarsResult<DataFrame> {
    let mut rows: Vec<(&str, u32, &str, u32, u64)> = Vec::new();
    for (result, raw) in collected {
        for (&sample, stages) in raw {
            for (stage, ns) in stages {
                let run = runs[result.run].name.as_str();
                rows.push((run, result.cell as u32, stage, sample, *ns));
            }
        }
    }
    DataFrame::new(
        rows.len(),
        vec![
            column("run", rows.iter().map(|row| row.0).collect()),
            column("cell", rows.iter().map(|row| row.1).collect()),
            column("stage", rows.iter().map(|row| row.2).collect()),
            column("sample", rows.iter().map(|row| row.3).collect()),
            column("ns", rows.iter().map(|row| row.4).collect()),
        ],
    )
}

fn cells_frame(
    runs: &[RunInfo],
    collected: &[(CellResult, RawSamples)],
) -> PolarsResult<DataFrame> {
    let cells: Vec<&CellResult> = collected.iter().map(|(result, _)| result).collect();
    let text = |name: &str, of: &dyn Fn(&CellResult) -> String| {
        // An empty part is a part that the technique does not have.
        let values = cells.iter().map(|cell| Some(of(cell)).filter(|text| !text.is_empty()));
        column(name, values.collect::<Vec<Option<String>>>())
    };
    let whole = |name: &str, of: &dyn Fn(&CellResult) -> u32| {
        column(name, cells.iter().map(|cell| of(cell)).collect::<Vec<u32>>())
    };
    let checked = |name: &str, of: &dyn Fn(&Verification) -> u64| {
        let values = cells.iter().map(|cell| cell.verification.as_ref().map(of));
        column(name, values.collect::<Vec<Option<u64>>>())
    };
    // What records may lack: older ones, and those of the CPU backend.
    let recorded = |name: &str, of: &dyn Fn(&Verification) -> Option<u64>| {
        let values = cells.iter().map(|cell| cell.verification.as_ref().and_then(of));
        column(name, values.collect::<Vec<Option<u64>>>())
    };
    let measured = |name: &str, of: &dyn Fn(&Verification) -> f64| {
        let values = cells.iter().map(|cell| cell.verification.as_ref().map(of));
        column(name, values.collect::<Vec<Option<f64>>>())
    };
    // What is computed where an experiment asks for it.
    let seen = |name: &str, of: &dyn Fn(&Verification) -> Option<f64>| {
        let values = cells.iter().map(|cell| cell.verification.as_ref().and_then(of));
        column(name, values.collect::<Vec<Option<f64>>>())
    };
    let counted = |name: &str, of: &dyn Fn(&[u64]) -> u64| {
        let values = cells.iter().map(|cell| runs[cell.run].histogram(&cell.name.group()).map(of));
        column(name, values.collect::<Vec<Option<u64>>>())
    };
    let run = |cell: &CellResult| &runs[cell.run];
    let dirty = cells.iter().map(|cell| run(cell).run.git_dirty).collect::<Vec<Option<bool>>>();
    let verdict = |cell: &CellResult| match cell.verification.as_ref().map(|v| v.verdict) {
        None => String::new(),
        Some(Verdict::Exact) => "exact".to_owned(),
        Some(Verdict::Approximate) => "approximate".to_owned(),
        Some(Verdict::Wrong) => "wrong".to_owned(),
    };
    DataFrame::new(
        cells.len(),
        vec![
            text("run", &|cell| run(cell).name.clone()),
            text("device", &|cell| run(cell).run.device.name.clone()),
            text("backend", &|cell| run(cell).run.device.backend.clone()),
            text("experiment", &|cell| run(cell).run.experiment.clone()),
            text("profile", &|cell| run(cell).run.profile.clone()),
            whole("cell", &|cell| cell.cell as u32),
            text("technique", &|cell| cell.name.technique.clone()),
            text("capture", &|cell| cell.technique.capture.clone()),
            text("schedule", &|cell| cell.technique.schedule.clone()),
            text("sort", &|cell| cell.technique.sort.clone()),
            text("shader_stage", &|cell| cell.technique.shader_stage.clone()),
            text("max", &|cell| cell.technique.max.clone()),
            text("ties", &|cell| cell.technique.ties.clone()),
            text("pool_percent", &|cell| cell.technique.pool_percent.clone()),
            text("pool_policy", &|cell| cell.technique.pool_policy.clone()),
            text("intervals", &|cell| cell.technique.intervals.clone()),
            text("method", &|cell| cell.technique.method.clone()),
            text("scene", &|cell| cell.name.scene.clone()),
            text("scene_name", &|cell| scene_name(&cell.name.scene).to_owned()),
            text("view", &|cell| cell.name.view.clone()),
            whole("width_px", &|cell| cell.name.width_px),
            whole("height_px", &|cell| cell.name.height_px),
            text("driver", &|cell| run(cell).run.device.driver.clone()),
            text("api", &|cell| run(cell).run.device.api.clone()),
            text("commit", &|cell| run(cell).run.git_commit.clone().unwrap_or_default()),
            column("dirty", dirty),
            text("started", &|cell| run(cell).run.started.clone()),
            text("state", &|cell| cell.state.name().to_owned()),
            text("reason", &|cell| cell.reason.clone().unwrap_or_default()),
            text("verdict", &verdict),
            whole("samples", &|cell| cell.samples as u32),
            checked("wrong_px", &|v| v.wrong_px),
            measured("max_error", &|v| v.max_error),
            measured("rmse", &|v| v.rmse),
            measured("max_alpha_error", &|v| v.max_alpha_error),
            seen("ssim", &|v| v.ssim),
            seen("flip", &|v| v.flip),
            checked("fragments_missing", &|v| v.fragments_missing),
            checked("fragments_extra", &|v| v.fragments_extra),
            checked("tied_px", &|v| v.tied_px),
            checked("max_frags", &|v| u64::from(v.max_frags)),
            checked("pool_initial", &|v| v.pool_initial),
            checked("pool_final", &|v| v.pool_final),
            checked("pool_grown", &|v| u64::from(v.pool_grown)),
            checked("memory_bytes", &|v| v.memory_bytes),
            recorded("lfb_bytes", &|v| v.lfb_bytes),
            recorded("peak_bytes", &|v| v.peak_bytes),
            recorded("repeat_differs_px", &|v| v.repeat_differs_px),
            recorded("pictures", &|v| v.stability.as_ref().map(|s| u64::from(s.pictures))),
            recorded("change_px", &|v| v.stability.as_ref()?.change.map(|change| change.px)),
            measured("prepare_ms", &|v| v.prepare_ms),
            text("tuned", &|cell| {
                cell.verification.as_ref().and_then(|v| v.tuned.clone()).unwrap_or_default()
            }),
            column(
                "predicted_ns",
                cells
                    .iter()
                    .map(|cell| cell.verification.as_ref().and_then(|v| v.predicted_ns))
                    .collect::<Vec<Option<f64>>>(),
            ),
            counted("peak_depth", &|histogram| {
                histogram.iter().rposition(|&pixels| pixels > 0).unwrap_or(0) as u64
            }),
            counted("total_fragments", &total_fragments),
        ],
    )
}

/// Each program of each cell, with its place among the cell's.
fn programs(results: &[CellResult]) -> impl Iterator<Item = (&CellResult, u32, &Program)> {
    results.iter().flat_map(|cell| (0..).zip(&cell.programs).map(move |(at, p)| (cell, at, p)))
}

fn programs_frame(runs: &[RunInfo], results: &[CellResult]) -> PolarsResult<DataFrame> {
    let rows: Vec<_> = programs(results).collect();
    let told: Vec<ProgramFigures> = rows
        .iter()
        .map(|(cell, _, program)| ProgramFigures::of(program, &cell.technique.shader_stage))
        .collect();
    let text = |name: &str, of: &dyn Fn(&Program) -> String| {
        column(name, rows.iter().map(|row| of(row.2)).collect::<Vec<String>>())
    };
    let whole = |name: &str, of: &dyn Fn(&Program) -> Option<u64>| {
        column(name, rows.iter().map(|row| of(row.2)).collect::<Vec<Option<u64>>>())
    };
    let figure = |name: &str, of: fn(&ProgramFigures) -> Option<u64>| {
        column(name, told.iter().map(of).collect::<Vec<Option<u64>>>())
    };
    let compile_ms = rows.iter().map(|row| row.2.compile_ns.map(|ns| ns as f64 / 1e6));
    // Where a cell has several programs, their times are one sum.
    let resolve_ns = rows.iter().map(|(cell, _, _)| {
        let timing = cell.times.get(RESOLVE).filter(|_| cell.programs.len() == 1)?;
        Some(timing.summary.median)
    });
    DataFrame::new(
        rows.len(),
        vec![
            column("run", rows.iter().map(|row| runs[row.0.run].name.clone()).collect::<Vec<_>>()),
            column("cell", rows.iter().map(|row| row.0.cell as u32).collect::<Vec<u32>>()),
            column("program", rows.iter().map(|row| row.1).collect::<Vec<u32>>()),
            text("strategy", &|program| program.sort.clone()),
            text("store", &|program| program.store.clone()),
            whole("low", &|program| Some(program.low.into())),
            whole("high", &|program| Some(program.high.into())),
            whole("invocations", &|program| program.invocations.map(u64::from)),
            whole("declared_workgroup_bytes", &|program| program.declared_workgroup_bytes),
            figure("registers", |told| told.registers),
            figure("local_bytes", |told| told.local_bytes),
            figure("workgroup_bytes", |told| told.workgroup_bytes),
            figure("binary_bytes", |told| told.binary_bytes),
            figure("occupancy", |told| told.occupancy),
            column("compile_ms", compile_ms.collect::<Vec<Option<f64>>>()),
            column("from_cache", rows.iter().map(|row| row.2.from_cache).collect::<Vec<_>>()),
            column("resolve_ns", resolve_ns.collect::<Vec<Option<f64>>>()),
        ],
    )
}

fn statistics_frame(runs: &[RunInfo], results: &[CellResult]) -> PolarsResult<DataFrame> {
    let mut rows = Vec::new();
    for (cell, at, program) in programs(results) {
        let executables = program.executables.iter().flatten();
        let told = executables.flat_map(|one| one.statistics.iter().map(move |told| (one, told)));
        rows.extend((0_u32..).zip(told).map(|(place, told)| (cell, at, place, program, told)));
    }
    let text = |name: &str, of: &dyn Fn(&Program, &Executable, &Statistic) -> String| {
        let values = rows.iter().map(|(_, _, _, program, (one, told))| of(program, one, told));
        column(name, values.collect::<Vec<String>>())
    };
    let runs = rows.iter().map(|row| runs[row.0.run].name.clone());
    let width = rows.iter().map(|row| row.4.0.subgroup_size);
    DataFrame::new(
        rows.len(),
        vec![
            column("run", runs.collect::<Vec<String>>()),
            column("cell", rows.iter().map(|row| row.0.cell as u32).collect::<Vec<u32>>()),
            column("program", rows.iter().map(|row| row.1).collect::<Vec<u32>>()),
            column("place", rows.iter().map(|row| row.2).collect::<Vec<u32>>()),
            text("strategy", &|program, _, _| program.sort.clone()),
            text("store", &|program, _, _| program.store.clone()),
            column("low", rows.iter().map(|row| row.3.low).collect::<Vec<u32>>()),
            column("high", rows.iter().map(|row| row.3.high).collect::<Vec<u32>>()),
            text("executable", &|_, one, _| one.name.clone()),
            text("stages", &|_, one, _| one.stages.join("+")),
            column("subgroup_size", width.collect::<Vec<u32>>()),
            text("statistic", &|_, _, told| told.name.clone()),
            column("value", rows.iter().map(|row| row.4.1.value.number()).collect::<Vec<f64>>()),
            text("description", &|_, _, told| told.description.clone()),
        ],
    )
}

fn work_frame(runs: &[RunInfo], results: &[CellResult]) -> PolarsResult<DataFrame> {
    let rows: Vec<(&CellResult, u32, &PassWork)> = results
        .iter()
        .flat_map(|cell| (0..).zip(&cell.work).map(move |(at, pass)| (cell, at, pass)))
        .collect();
    let text = |name: &str, of: &dyn Fn(&CellResult, &PassWork) -> String| {
        column(name, rows.iter().map(|row| of(row.0, row.2)).collect::<Vec<String>>())
    };
    let bytes = |name: &str, of: &dyn Fn(&PassWork) -> Option<u64>| {
        column(name, rows.iter().map(|row| of(row.2)).collect::<Vec<Option<u64>>>())
    };
    let counted = |name: &str, of: fn(&RasterCounts) -> Option<u64>| {
        bytes(name, &|pass| pass.counted.as_ref().and_then(of))
    };
    let measured = |name: &str, of: fn(&Bandwidth) -> Option<f64>| {
        let values = rows.iter().map(|row| runs[row.0.run].bandwidth.as_ref().and_then(of));
        column(name, values.collect::<Vec<Option<f64>>>())
    };
    DataFrame::new(
        rows.len(),
        vec![
            text("run", &|cell, _| runs[cell.run].name.clone()),
            column("cell", rows.iter().map(|row| row.0.cell as u32).collect::<Vec<u32>>()),
            column("pass", rows.iter().map(|row| row.1).collect::<Vec<u32>>()),
            text("stage", &|_, pass| pass.stage.clone()),
            text("label", &|_, pass| pass.label.clone()),
            text("kind", &|_, pass| pass.kind.name().to_owned()),
            bytes("cleared_bytes", &|pass| Some(pass.cleared_bytes)),
            bytes("color_bytes_per_fragment", &|pass| Some(pass.color_bytes_per_fragment)),
            bytes("depth_stencil_bytes_per_fragment", &|pass| {
                Some(pass.depth_stencil_bytes_per_fragment)
            }),
            bytes("compute_invocations", &|pass| pass.compute_invocations),
            counted("input_vertices", |told| told.input_vertices),
            counted("input_primitives", |told| told.input_primitives),
            counted("vertex_invocations", |told| Some(told.vertex_invocations)),
            counted("tessellation_patches", |told| told.tessellation_patches),
            counted("tessellation_invocations", |told| told.tessellation_invocations),
            counted("geometry_invocations", |told| told.geometry_invocations),
            counted("geometry_primitives", |told| told.geometry_primitives),
            counted("clipping_invocations", |told| Some(told.clipping_invocations)),
            counted("clipping_primitives", |told| Some(told.clipping_primitives)),
            counted("fragment_invocations", |told| Some(told.fragment_invocations)),
            bytes("attachment_bytes_at_most", &PassWork::attachment_bytes_at_most),
            measured("copy_bytes_per_s", |told| Some(told.copy_bytes_per_s)),
            measured("fill_bytes_per_s", |told| Some(told.fill_bytes_per_s)),
            measured("attachment_bytes_per_s", |told| told.attachment.map(|of| of.bytes_per_s)),
        ],
    )
}

/// Reads the grouped frame back, and summarises every group.
fn timings(grouped: &DataFrame) -> PolarsResult<Vec<(String, u32, String, Timing)>> {
    let (runs, cells) = (grouped.column("run")?.str()?, grouped.column("cell")?.u32()?);
    let (stages, lists) = (grouped.column("stage")?.str()?, grouped.column("ns")?.list()?);
    let mut timings = Vec::new();
    for row in 0..grouped.height() {
        let (Some(run), Some(cell)) = (runs.get(row), cells.get(row)) else { continue };
        let (Some(stage), Some(list)) = (stages.get(row), lists.get_as_series(row)) else {
            continue;
        };
        let samples_ns: Vec<u64> = list.u64()?.iter().flatten().collect();
        let values: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
        let Some(summary) = statistics::summarize(&values, BOOTSTRAP_SEED) else { continue };
        timings.push((run.to_owned(), cell, stage.to_owned(), Timing { samples_ns, summary }));
    }
    Ok(timings)
}

fn summary_frame(timings: &[(String, u32, String, Timing)]) -> PolarsResult<DataFrame> {
    let of = |name: &str, of: fn(&Summary) -> f64| {
        column(name, timings.iter().map(|row| of(&row.3.summary)).collect::<Vec<f64>>())
    };
    DataFrame::new(
        timings.len(),
        vec![
            column("run", timings.iter().map(|row| row.0.clone()).collect::<Vec<String>>()),
            column("cell", timings.iter().map(|row| row.1).collect::<Vec<u32>>()),
            column("stage", timings.iter().map(|row| row.2.clone()).collect::<Vec<String>>()),
            column("n", timings.iter().map(|row| row.3.summary.samples as u32).collect::<Vec<_>>()),
            of("median_ns", |summary| summary.median),
            of("q1_ns", |summary| summary.q1),
            of("q3_ns", |summary| summary.q3),
            of("low_ns", |summary| summary.low),
            of("high_ns", |summary| summary.high),
        ],
    )
}
