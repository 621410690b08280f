//! Runs an experiment on a device: verifies, warms up, samples in interleaved order, records.

use std::collections::{BTreeSet, HashMap};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use oit_record::statistics::SplitMix64;
use oit_record::{
    Cell, DeviceInfo, Event, Record, RecordError, Run, RunWriter, SCHEMA_VERSION, Verdict,
    Verification,
};

use oit_scene::SceneEntry;

use crate::experiment::{Experiment, ExperimentError, PlannedCell, ProfileName};
use crate::kept;
use crate::provenance;
use crate::technique::Technique;
use crate::verify::Check;
use crate::worker::{Prepared, Reply, Request, Spent};

/// How a run is started.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The device's id.
    pub device: String,
    /// How much of the experiment.
    pub profile: ProfileName,
    /// The scenes there are.
    pub scenes: Vec<SceneEntry>,
    /// The run folder.
    pub out: PathBuf,
    /// Whether to go on with the run that is there.
    pub resume: bool,
    /// Where pipelines are kept.
    pub cache: PathBuf,
    /// The folder of tuning files, for techniques that leave a choice to them.
    pub tuning: PathBuf,
    /// The commit the program was built from, and whether it was dirty.
    pub commit: Option<(String, bool)>,
    /// The command line.
    pub command: Vec<String>,
    /// The program and its arguments that serve as worker.
    pub worker: Vec<String>,
    /// Variables that are set in the worker's environment, besides this process's own.
    pub worker_environment: Vec<(String, String)>,
}

/// Why a run stopped.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The experiment is at fault.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// The record cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The worker does not start, or not on this device.
    #[error("device {device}: {what}")]
    Device {
        /// The device.
        device: String,
        /// What happened.
        what: String,
    },
    /// The run that is there is another one.
    #[error("{}: this is another run: its {what} differs; it cannot be resumed", path.display())]
    Another {
        /// The run folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// Nothing to run.
    #[error("no cell is left{0}")]
    NoCell(String),
}

/// What a run tells while it goes.
#[derive(Clone, Debug)]
pub enum Progress {
    /// It starts: so many cells, on this device.
    Started {
        /// Cells.
        cells: usize,
        /// Views they are on.
        groups: usize,
        /// Steps in all: one to verify a cell, one a sample.
        steps: u64,
        /// Steps that an earlier part of the run did.
        done: u64,
        /// The device.
        device: Box<DeviceInfo>,
    },
    /// A view is opened.
    Group(String),
    /// A cell was verified.
    Verified(String, Box<Verification>),
    /// A cell will not be timed any further, with the reason.
    Dropped(String, String),
    /// So many steps were done.
    Steps(u64),
    /// It is complete.
    Finished(Outcome),
}

/// What a run came to.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Outcome {
    /// Cells that are exact.
    pub exact: usize,
    /// Cells whose errors are data.
    pub approximate: usize,
    /// Cells that should be exact and are not.
    pub wrong: usize,
    /// Cells the device cannot run.
    pub skipped: usize,
    /// Cells that broke.
    pub failed: usize,
    /// Wall seconds of this part of the run.
    pub wall_s: f64,
    /// Where the workers' time went.
    pub spent: Spent,
}

impl Outcome {
    /// The share of wall time spent outside the workers: on starting them, on talking to them and
    /// on recording.
    #[must_use]
    pub fn overhead(&self) -> f64 {
        1.0 - (self.spent.total_ms() / 1e3 / self.wall_s).min(1.0)
    }
}

/// Expands, filters and runs an experiment. `only` keeps the cells whose
/// `technique scene:view@size` it accepts.
///
/// # Errors
/// Where the experiment is at fault, the device does not start, or the record cannot be written;
/// what was recorded before stays.
pub fn run(
    experiment: &Experiment,
    setup: &Setup,
    only: &dyn Fn(&str) -> bool,
    progress: &mut dyn FnMut(Progress),
) -> Result<Outcome, RunError> {
    let mut cells = experiment.cells(setup.profile, &setup.scenes)?;
    let before = cells.len();
    cells.retain(|cell| only(&cell.name()));
    if cells.is_empty() {
        let why =
            if before > 0 { format!(" of {before}: --only keeps none") } else { String::new() };
        return Err(RunError::NoCell(why));
    }
    let started = Instant::now();
    let mut client = Client::start(setup)?;
    let (writer, record) = open_record(experiment, setup, &cells, &client.device)?;
    let mut session = Session {
        setup,
        samples: experiment.profile(setup.profile).samples,
        perceptual: experiment.profile(setup.profile).perceptual,
        repeats: experiment.profile(setup.profile).repeats,
        keep_breaks: experiment.profile(setup.profile).keep_breaks,
        work: experiment.profile(setup.profile).work,
        bandwidth: false,
        warmup_ms: experiment.profile(setup.profile).warmup_ms,
        frame_warmup_ms: experiment.profile(setup.profile).path.warmup_ms,
        warm: None,
        timeout: Duration::from_secs(experiment.profile(setup.profile).timeout_s),
        seed: experiment.seed,
        states: cells.iter().map(|_| CellState::default()).collect(),
        counted: BTreeSet::new(),
        cells,
        writer,
        spent: Spent::default(),
        progress,
    };
    let earlier_s = session.restore(&record.events);
    session.announce(&client.device);
    session.bandwidth(&mut client)?;
    for group in session.groups() {
        session.group(&group, &mut client)?;
    }
    session.spent += client.spent(session.timeout);
    let mut outcome = session.outcome();
    outcome.wall_s = started.elapsed().as_secs_f64();
    if !record.finished() {
        session.writer.append(&Event::Finished { wall_s: earlier_s + outcome.wall_s })?;
    }
    (session.progress)(Progress::Finished(outcome));
    Ok(outcome)
}

/// What `run.json` says of a run that starts now.
pub(crate) fn run_of(
    setup: &Setup,
    device: &DeviceInfo,
    experiment: &str,
    experiment_toml: &str,
    seed: u64,
    cells: Vec<Cell>,
) -> Run {
    Run {
        schema: SCHEMA_VERSION,
        experiment: experiment.to_owned(),
        experiment_toml: experiment_toml.to_owned(),
        profile: setup.profile.name().into(),
        device: device.clone(),
        host: provenance::host(),
        oit_version: env!("CARGO_PKG_VERSION").into(),
        git_commit: setup.commit.as_ref().map(|(commit, _)| commit.clone()),
        git_dirty: setup.commit.as_ref().map(|(_, dirty)| *dirty),
        command: setup.command.clone(),
        seed,
        started: provenance::now(),
        cells,
    }
}

fn open_record(
    experiment: &Experiment,
    setup: &Setup,
    cells: &[PlannedCell],
    device: &DeviceInfo,
) -> Result<(RunWriter, Record), RunError> {
    let cells = cells.iter().map(|cell| cell.cell.clone()).collect();
    let Experiment { name, toml, seed, .. } = experiment;
    let run = run_of(setup, device, name, toml, *seed, cells);
    if !setup.resume || !setup.out.join("run.json").exists() {
        let writer = RunWriter::create(&setup.out, &run)?;
        return Ok((writer, Record { folder: setup.out.clone(), run, events: Vec::new() }));
    }
    let (writer, record) = RunWriter::resume(&setup.out)?;
    let there = &record.run;
    let differs = [
        ("experiment", there.experiment_toml != run.experiment_toml),
        ("profile", there.profile != run.profile),
        ("list of cells", there.cells != run.cells),
        ("device", there.device != run.device),
        ("program", there.git_commit != run.git_commit),
    ];
    match differs.iter().find(|(_, differs)| *differs) {
        Some((what, _)) => Err(RunError::Another { path: setup.out.clone(), what }),
        None => Ok((writer, record)),
    }
}

/// What is known of a cell.
#[derive(Clone, Default)]
struct CellState {
    verdict: Option<Verdict>,
    /// Whether its programs are recorded.
    programs: bool,
    /// Whether the work of its passes is.
    work: bool,
    sampled: BTreeSet<u32>,
    end: Option<End>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Skipped,
    Failed,
}

struct Session<'a> {
    setup: &'a Setup,
    samples: u32,
    perceptual: bool,
    /// How often a frame is repeated to see whether its picture stays.
    repeats: Option<u32>,
    /// Whether pictures are kept of cells that break.
    keep_breaks: bool,
    /// Whether the work of passes is asked for.
    work: bool,
    /// Whether the device's bandwidth is recorded.
    bandwidth: bool,
    warmup_ms: u64,
    /// Of a frame of a camera path that follows another.
    frame_warmup_ms: Option<u64>,
    /// The scene and the camera path of the view sampled last, if it was a frame of one.
    warm: Option<(String, String)>,
    timeout: Duration,
    seed: u64,
    cells: Vec<PlannedCell>,
    states: Vec<CellState>,
    counted: BTreeSet<String>,
    writer: RunWriter,
    spent: Spent,
    progress: &'a mut dyn FnMut(Progress),
}

impl Session<'_> {
    /// Takes up what an earlier part of the run recorded; returns its wall seconds.
    fn restore(&mut self, events: &[Event]) -> f64 {
        let mut wall_s = 0.0;
        for event in events {
            match event {
                Event::Counted { group, .. } => {
                    self.counted.insert(group.clone());
                }
                Event::Verified { cell, result } => {
                    self.states[*cell].verdict = Some(result.verdict);
                }
                Event::Programs { cell, .. } => self.states[*cell].programs = true,
                Event::Work { cell, .. } => self.states[*cell].work = true,
                Event::Bandwidth { .. } => self.bandwidth = true,
                Event::Sample { cell, sample, .. } => {
                    self.states[*cell].sampled.insert(*sample);
                }
                Event::Skipped { cell, .. } => self.states[*cell].end = Some(End::Skipped),
                Event::Failed { cell, .. } => self.states[*cell].end = Some(End::Failed),
                Event::Finished { wall_s: earlier } => wall_s = *earlier,
                Event::Clocks { .. } => {}
            }
        }
        wall_s
    }

    fn announce(&mut self, device: &DeviceInfo) {
        let per_cell = 1 + u64::from(self.samples);
        let done = |state: &CellState| match (state.end, state.verdict) {
            (Some(_), _) | (_, Some(Verdict::Wrong)) => per_cell,
            (None, verdict) => u64::from(verdict.is_some()) + state.sampled.len() as u64,
        };
        let started = Progress::Started {
            cells: self.cells.len(),
            groups: self.groups().len(),
            steps: per_cell * self.cells.len() as u64,
            done: self.states.iter().map(done).sum(),
            device: Box::new(device.clone()),
        };
        (self.progress)(started);
    }

    /// The cells of each view, in order.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for cell in 0..self.cells.len() {
            match groups.last_mut() {
                Some(group) if self.group_name(group[0]) == self.group_name(cell) => {
                    group.push(cell);
                }
                _ => groups.push(vec![cell]),
            }
        }
        groups
    }

    fn group_name(&self, cell: usize) -> String {
        self.cells[cell].cell.group()
    }

    fn name(&self, cell: usize) -> String {
        self.cells[cell].name()
    }

    /// Whether a cell is still to be sampled: it is not wrong and has not ended.
    fn live(&self, cell: usize) -> bool {
        let state = &self.states[cell];
        state.end.is_none() && state.verdict.is_some_and(|verdict| verdict != Verdict::Wrong)
    }

    fn unfinished(&self, cell: usize) -> bool {
        let state = &self.states[cell];
        state.end.is_none()
            && state.verdict != Some(Verdict::Wrong)
            && (state.verdict.is_none() || state.sampled.len() < self.samples as usize)
    }

    fn group(&mut self, group: &[usize], client: &mut Client) -> Result<(), RunError> {
        let mut cells: Vec<usize> =
            group.iter().copied().filter(|&cell| self.unfinished(cell)).collect();
        if cells.is_empty() {
            return Ok(());
        }
        let name = self.group_name(cells[0]);
        (self.progress)(Progress::Group(name));
        if !self.open(&cells, client)? {
            return Ok(());
        }
        for &cell in &cells {
            // Losing a worker on an earlier cell may have ended the others too.
            if self.unfinished(cell) {
                self.prepare(cell, &cells, client)?;
            }
        }
        for &cell in &cells {
            if self.live(cell) {
                self.count_work(cell, &cells, client)?;
            }
        }
        cells.retain(|&cell| self.live(cell));
        if cells.is_empty() {
            return Ok(());
        }
        let PlannedCell { cell, camera_path, in_full, .. } = &self.cells[cells[0]];
        let path = camera_path.clone().map(|path| (cell.scene.clone(), path));
        // To ask for the clocks takes longer than to sample a frame: of a path's frames those are
        // asked at that are verified in full.
        let ask_clocks = *in_full;
        let follows = path.is_some() && path == self.warm;
        self.warm_up(&cells, follows, client)?;
        if ask_clocks {
            self.clocks(cells[0], "before", client)?;
        }
        for sample in 0..self.samples {
            self.round(sample, &cells, client)?;
        }
        self.warm = path;
        if ask_clocks { self.clocks(cells[0], "after", client) } else { Ok(()) }
    }

    /// Opens the view of these cells. Where that fails, every cell ends with the reason.
    fn open(&mut self, cells: &[usize], client: &mut Client) -> Result<bool, RunError> {
        let planned = &self.cells[cells[0]];
        let overrides = toml::to_string(&planned.overrides).unwrap_or_default();
        let request = Request::View {
            scene: planned.scene.clone(),
            overrides,
            view: planned.cell.view.clone(),
            width_px: planned.size.width_px,
            height_px: planned.size.height_px,
            // Ways of drawing spheres need no counts.
            counted: cells
                .iter()
                .any(|&cell| !matches!(self.cells[cell].technique, Technique::Spheres(_))),
            // Hundreds of frames would come to hundreds of megabytes: of these there are histograms.
            counts: planned
                .camera_path
                .is_none()
                .then(|| self.setup.out.join("counts").join(counts_file(&planned.cell))),
        };
        // A scene may be large: reading it is given ten times a cell's time.
        let reply = client.ask(&request, self.timeout * 10);
        match reply {
            Ok(Reply::Counted { triangles, spheres, histogram }) => {
                let group = self.group_name(cells[0]);
                if self.counted.insert(group.clone()) {
                    let counted = Event::Counted { group, triangles, spheres, histogram };
                    self.writer.append(&counted)?;
                }
                Ok(true)
            }
            other => {
                for &cell in cells {
                    self.end(cell, reason(&other))?;
                }
                if matches!(other, Err(_) | Ok(Reply::Failed(_))) {
                    self.restart(client)?;
                }
                Ok(false)
            }
        }
    }

    /// Makes a cell ready, verifying it unless that was done before.
    fn prepare(
        &mut self,
        cell: usize,
        group: &[usize],
        client: &mut Client,
    ) -> Result<(), RunError> {
        let technique = self.cells[cell].cell.technique.clone();
        let check = if self.cells[cell].in_full { Check::All } else { Check::Picture };
        let check = self.states[cell].verdict.is_none().then_some(check);
        let keep = self.cells[cell].keep_images;
        let stem = || kept::stem(&self.setup.out, &self.cells[cell].cell);
        let (images, breaks) = (keep.then(stem), self.keep_breaks.then(stem));
        let (perceptual, repeats) = (self.perceptual, self.repeats);
        let request =
            Request::Prepare { cell, technique, check, perceptual, repeats, images, breaks };
        let reply = client.ask(&request, self.timeout);
        match reply {
            Ok(Reply::Prepared(prepared)) => {
                let Prepared { verification, programs } = *prepared;
                if !programs.is_empty() && !self.states[cell].programs {
                    self.states[cell].programs = true;
                    self.writer.append(&Event::Programs { cell, programs })?;
                }
                let Some(result) = verification else { return Ok(()) };
                self.states[cell].verdict = Some(result.verdict);
                self.writer.append(&Event::Verified { cell, result: result.clone() })?;
                let wrong = result.verdict == Verdict::Wrong;
                let steps = 1 + if wrong { u64::from(self.samples) } else { 0 };
                let name = self.name(cell);
                (self.progress)(Progress::Verified(name, Box::new(result)));
                (self.progress)(Progress::Steps(steps));
                Ok(())
            }
            other => {
                let broke = other.is_err();
                self.end(cell, reason(&other))?;
                if broke { self.recover(group, client) } else { Ok(()) }
            }
        }
    }

    /// Records what the device's memory moves, where the profile asks for it and no earlier part of the
    /// run did. A device that cannot do it is left without, and so is one on which it breaks: what is
    /// measured of cells does not depend on it.
    fn bandwidth(&mut self, client: &mut Client) -> Result<(), RunError> {
        if !self.work || self.bandwidth {
            return Ok(());
        }
        let reply = client.ask(&Request::Bandwidth, self.timeout);
        match reply {
            Ok(Reply::Bandwidth(measured)) => {
                self.bandwidth = true;
                Ok(self.writer.append(&Event::Bandwidth { measured: *measured })?)
            }
            Ok(Reply::Unsupported(_)) => Ok(()),
            other => {
                (self.progress)(Progress::Dropped("bandwidth".into(), reason(&other).1));
                if other.is_err() { self.restart(client) } else { Ok(()) }
            }
        }
    }

    /// Records the work of a cell's passes, where the profile asks for it and it was not done before.
    fn count_work(
        &mut self,
        cell: usize,
        group: &[usize],
        client: &mut Client,
    ) -> Result<(), RunError> {
        if !self.work || !self.cells[cell].in_full || self.states[cell].work {
            return Ok(());
        }
        let reply = client.ask(&Request::Work { cell }, self.timeout);
        match reply {
            Ok(Reply::Work(passes)) => {
                self.states[cell].work = true;
                Ok(self.writer.append(&Event::Work { cell, passes })?)
            }
            // It has no passes to count, which is no reason not to time it.
            Ok(Reply::Unsupported(_)) => Ok(()),
            other => {
                let broke = other.is_err();
                self.end(cell, reason(&other))?;
                if broke { self.recover(group, client) } else { Ok(()) }
            }
        }
    }

    /// Runs the view's live cells until the device is warm, which it nearly is where the view
    /// `follows` another of the same camera path.
    fn warm_up(
        &mut self,
        cells: &[usize],
        follows: bool,
        client: &mut Client,
    ) -> Result<(), RunError> {
        let of_frame = self.frame_warmup_ms.filter(|_| follows);
        let at_least_ms = of_frame.unwrap_or(self.warmup_ms);
        if at_least_ms == 0 {
            return Ok(());
        }
        let request = Request::WarmUp { cells: cells.to_vec(), at_least_ms };
        let allowed = self.timeout * cells.len() as u32 + Duration::from_millis(10 * at_least_ms);
        if let Ok(Reply::Done) = client.ask(&request, allowed) {
            return Ok(());
        }
        // Which cell broke shows when it is sampled; what is needed here is a worker that answers.
        self.recover(cells, client)
    }

    /// One sample of each live cell of the view, in this round's order.
    fn round(&mut self, sample: u32, cells: &[usize], client: &mut Client) -> Result<(), RunError> {
        loop {
            let missing =
                |&cell: &usize| self.live(cell) && !self.states[cell].sampled.contains(&sample);
            let mut order: Vec<usize> = cells.iter().copied().filter(missing).collect();
            if order.is_empty() {
                return Ok(());
            }
            SplitMix64(self.seed ^ (u64::from(sample) << 32) ^ cells[0] as u64).shuffle(&mut order);
            client.send(&Request::Sample { cells: order.clone() });
            for cell in order {
                match client.receive(self.timeout) {
                    Ok(Reply::Sampled { stages_ns, parts_ns, total_ns }) => {
                        self.states[cell].sampled.insert(sample);
                        self.writer.append(&Event::Sample {
                            cell,
                            sample,
                            stages_ns: stages_ns.into_iter().collect(),
                            parts_ns: parts_ns.into_iter().collect(),
                            total_ns,
                        })?;
                        (self.progress)(Progress::Steps(1));
                    }
                    other => {
                        let broke = other.is_err();
                        self.end(cell, reason(&other))?;
                        if broke {
                            self.recover(cells, client)?;
                            break;
                        }
                    }
                }
            }
        }
    }

    fn clocks(&mut self, cell: usize, when: &str, client: &Client) -> Result<(), RunError> {
        if !client.device.name.contains("NVIDIA") {
            return Ok(());
        }
        let provenance::Clocks { shader_mhz, memory_mhz } = provenance::clocks();
        let group = self.group_name(cell);
        let when = when.to_owned();
        Ok(self.writer.append(&Event::Clocks { group, when, shader_mhz, memory_mhz })?)
    }

    /// Ends a cell with a reason.
    fn end(&mut self, cell: usize, (end, reason): (End, String)) -> Result<(), RunError> {
        let state = &mut self.states[cell];
        let done = u64::from(state.verdict.is_some()) + state.sampled.len() as u64;
        state.end = Some(end);
        self.writer.append(&match end {
            End::Skipped => Event::Skipped { cell, reason: reason.clone() },
            End::Failed => Event::Failed { cell, reason: reason.clone() },
        })?;
        let name = self.name(cell);
        (self.progress)(Progress::Dropped(name, reason));
        (self.progress)(Progress::Steps(1 + u64::from(self.samples) - done));
        Ok(())
    }

    fn restart(&mut self, client: &mut Client) -> Result<(), RunError> {
        *client = Client::start(self.setup)?;
        Ok(())
    }

    /// After a worker was lost: a new one, with the view's live cells ready again.
    fn recover(&mut self, group: &[usize], client: &mut Client) -> Result<(), RunError> {
        self.restart(client)?;
        let pending: Vec<usize> =
            group.iter().copied().filter(|&cell| self.unfinished(cell)).collect();
        if pending.is_empty() || !self.open(&pending, client)? {
            return Ok(());
        }
        for cell in pending {
            if self.live(cell) {
                self.prepare(cell, group, client)?;
            }
        }
        Ok(())
    }

    fn outcome(&self) -> Outcome {
        let count = |test: &dyn Fn(&CellState) -> bool| {
            self.states.iter().filter(|state| test(state)).count()
        };
        let verdict = |verdict| move |s: &CellState| s.end.is_none() && s.verdict == Some(verdict);
        Outcome {
            exact: count(&verdict(Verdict::Exact)),
            approximate: count(&verdict(Verdict::Approximate)),
            wrong: count(&verdict(Verdict::Wrong)),
            skipped: count(&|state| state.end == Some(End::Skipped)),
            failed: count(&|state| state.end == Some(End::Failed)),
            wall_s: 0.0,
            spent: self.spent,
        }
    }
}

/// The picture of a view's fragments per pixel, beside the events: a 16-bit grey PNG.
fn counts_file(cell: &Cell) -> String {
    let Cell { scene, view, width_px, height_px, .. } = cell;
    let name = format!("{scene}_{view}_{width_px}x{height_px}.png");
    name.replace(|c: char| !c.is_ascii_alphanumeric() && !matches!(c, '.' | '_' | '-'), "_")
}

/// What an answer that is not the one hoped for means for the cell.
fn reason(reply: &Result<Reply, String>) -> (End, String) {
    match reply {
        Ok(Reply::Unsupported(reason)) => (End::Skipped, reason.clone()),
        Ok(Reply::Failed(reason)) | Err(reason) => (End::Failed, reason.clone()),
        Ok(other) => (End::Failed, format!("the worker answered {other:?}")),
    }
}

/// A worker process and the pipes to it.
struct Client {
    child: Child,
    input: Option<ChildStdin>,
    replies: Receiver<String>,
    device: DeviceInfo,
}

impl Client {
    fn start(setup: &Setup) -> Result<Self, RunError> {
        let failed = |what: String| RunError::Device { device: setup.device.clone(), what };
        let [program, arguments @ ..] = setup.worker.as_slice() else {
            return Err(failed("no worker program is named".into()));
        };
        let mut child = Command::new(program)
            .args(arguments)
            .envs(setup.worker_environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| failed(format!("{program}: {error}")))?;
        let input = child.stdin.take();
        let output = child.stdout.take().ok_or_else(|| failed("it has no output".into()))?;
        let (sender, replies) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines() {
                let Ok(line) = line else { break };
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let mut client = Self { child, input, replies, device: DeviceInfo::default() };
        let open = Request::Open {
            device: setup.device.clone(),
            cache: setup.cache.clone(),
            tuning: setup.tuning.clone(),
        };
        match client.ask(&open, Duration::from_secs(120)) {
            Ok(Reply::Opened(info)) => client.device = *info,
            other => return Err(failed(reason(&other).1)),
        }
        Ok(client)
    }

    /// A pipe that is broken shows when the answer does not come.
    fn send(&mut self, request: &Request) {
        if let (Some(input), Ok(mut line)) = (&mut self.input, serde_json::to_vec(request)) {
            line.push(b'\n');
            let _ = input.write_all(&line).and_then(|()| input.flush());
        }
    }

    /// The next answer; an error where the worker died or did not answer in time. It is then gone.
    fn receive(&mut self, timeout: Duration) -> Result<Reply, String> {
        match self.replies.recv_timeout(timeout) {
            Ok(line) => serde_json::from_str(&line)
                .map_err(|error| format!("the worker answered {line:?}: {error}")),
            Err(RecvTimeoutError::Timeout) => {
                let _ = self.child.kill();
                let _ = self.child.wait();
                Err(format!("no answer within {} s: given up as hung", timeout.as_secs()))
            }
            Err(RecvTimeoutError::Disconnected) => match self.child.wait() {
                Ok(status) => Err(format!("the worker process ended: {status}")),
                Err(error) => Err(format!("the worker process is gone: {error}")),
            },
        }
    }

    fn ask(&mut self, request: &Request, timeout: Duration) -> Result<Reply, String> {
        self.send(request);
        self.receive(timeout)
    }

    fn spent(&mut self, timeout: Duration) -> Spent {
        match self.ask(&Request::Spent, timeout) {
            Ok(Reply::Spent(spent)) => spent,
            _ => Spent::default(),
        }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // Closing its input ends the worker, which then writes its pipeline cache.
        drop(self.input.take());
        let patience = Instant::now();
        while patience.elapsed() < Duration::from_secs(10) {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The samples of a run's cells, by cell and stage (and `total`), in nanoseconds.
#[must_use]
pub fn samples_by_cell(record: &Record) -> HashMap<usize, HashMap<String, Vec<f64>>> {
    let mut samples: HashMap<usize, HashMap<String, Vec<f64>>> = HashMap::new();
    for event in &record.events {
        if let Event::Sample { cell, stages_ns, total_ns, .. } = event {
            let of_cell = samples.entry(*cell).or_default();
            for (stage, ns) in stages_ns {
                of_cell.entry(stage.clone()).or_default().push(*ns as f64);
            }
            of_cell.entry("total".into()).or_default().push(*total_ns as f64);
        }
    }
    samples
}

/// Where a run's folder is, if none is named: one for each experiment, device and profile.
#[must_use]
pub fn default_folder(
    root: &Path,
    experiment: &str,
    device: &str,
    profile: ProfileName,
) -> PathBuf {
    root.join(format!("{experiment}-{}-{}", device.replace(':', "-"), profile.name()))
}
