//! The process that touches the device. It answers one line of JSON a request, so that a hang or a
//! crash costs the cell it happened in and not the run.

use std::collections::HashMap;
use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use oit_fragments::{DepthHistogram, Lfb};
use oit_record::{Bandwidth, DeviceInfo, PassWork, Program, Verdict, Verification};
use oit_spheres::Variation;
use serde::{Deserialize, Serialize};

use crate::engine::{
    CellError, Engine, FrameSize, Preparation, Ready, ViewData, ViewError, open_engine,
};
use crate::experiment::Overrides;
use crate::kept;
use crate::spheres::SphereVerifier;
use crate::stability::{Changes, sequence};
use crate::stored::{is_stored, load_stored};
use crate::technique::Technique;
use crate::tuner::Tuner;
use crate::verify::{Check, Verifier};

/// What the runner asks.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Request {
    /// Open a device. Answered by [`Reply::Opened`].
    Open { device: String, cache: PathBuf, tuning: PathBuf },
    /// Open a view of a scene. Answered by [`Reply::Counted`].
    View {
        scene: PathBuf,
        overrides: String,
        view: String,
        width_px: u32,
        height_px: u32,
        /// Whether its fragments are counted, and can be captured.
        #[serde(default = "yes")]
        counted: bool,
        /// Where the picture of the fragments per pixel goes, if one is wanted.
        counts: Option<PathBuf>,
    },
    /// Make a technique ready under this cell's number, and compare it with the oracle if asked.
    /// Answered by [`Reply::Prepared`].
    Prepare {
        cell: usize,
        technique: String,
        check: Option<Check>,
        /// Whether what an eye makes of its errors is computed too, if it is compared and has some.
        perceptual: bool,
        /// How often it is repeated to see whether its picture stays, if it is compared.
        repeats: Option<u32>,
        /// Where its pictures are kept once it is compared, if they are: see [`kept::keep`].
        images: Option<PathBuf>,
        /// Where its picture and the right one are kept if it breaks: see [`kept::keep_break`].
        breaks: Option<PathBuf>,
    },
    /// Count the work of this cell's passes. Answered by [`Reply::Work`].
    Work { cell: usize },
    /// Measure what the device's memory moves; the open view is forgotten. Answered by
    /// [`Reply::Bandwidth`].
    Bandwidth,
    /// Run these cells in turn until that many milliseconds have passed and they no longer get
    /// faster. Answered by [`Reply::Done`].
    WarmUp { cells: Vec<usize>, at_least_ms: u64 },
    /// Time each of these cells once, in this order. Answered by one [`Reply::Sampled`] each.
    Sample { cells: Vec<usize> },
    /// Where the time went. Answered by [`Reply::Spent`].
    Spent,
}

fn yes() -> bool {
    true
}

/// What the worker answers.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Reply {
    /// The device.
    Opened(Box<DeviceInfo>),
    /// A view's fragments.
    Counted {
        triangles: u64,
        #[serde(default)]
        spheres: Option<u64>,
        histogram: Vec<u64>,
    },
    /// A technique is ready.
    Prepared(Box<Prepared>),
    /// The work of a cell's passes.
    Work(Vec<PassWork>),
    /// What memory moves.
    Bandwidth(Box<Bandwidth>),
    /// One timing.
    Sampled { stages_ns: Vec<(String, u64)>, parts_ns: Vec<(String, u64)>, total_ns: u64 },
    /// Done.
    Done,
    /// Milliseconds spent.
    Spent(Spent),
    /// The device cannot do it.
    Unsupported(String),
    /// It broke.
    Failed(String),
}

/// A cell made ready.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Prepared {
    /// How it compares with the oracle, if that was asked.
    pub(crate) verification: Option<Verification>,
    /// Its resolve programs.
    #[serde(default)]
    pub(crate) programs: Vec<Program>,
}

/// Where a worker's time went, in milliseconds.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Spent {
    /// Reading and generating scenes.
    pub scene_ms: f64,
    /// Compiling pipelines and allocating.
    pub prepare_ms: f64,
    /// Counting, first runs, and comparing with the oracle.
    pub verify_ms: f64,
    /// Warm-up and timed runs.
    pub render_ms: f64,
}

impl std::ops::AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.scene_ms += other.scene_ms;
        self.prepare_ms += other.prepare_ms;
        self.verify_ms += other.verify_ms;
        self.render_ms += other.render_ms;
    }
}

impl Spent {
    /// All of it.
    #[must_use]
    pub fn total_ms(&self) -> f64 {
        self.scene_ms + self.prepare_ms + self.verify_ms + self.render_ms
    }
}

/// What of a cell that is made ready is asked besides: see [`Request::Prepare`].
#[derive(Clone, Copy)]
struct Asked<'a> {
    check: Option<Check>,
    perceptual: bool,
    repeats: Option<u32>,
    images: Option<&'a Path>,
    breaks: Option<&'a Path>,
}

/// The last picture of a cell that was compared, and the right one.
struct Look<'a> {
    engine: &'a mut dyn Engine,
    ready: Ready,
    right: &'a [[f64; 4]],
}

impl Look<'_> {
    /// Does what is asked of it besides: what an eye makes of its errors, and pictures that are kept.
    /// `counts` are the fragments of each pixel.
    fn at(
        self,
        asked: Asked,
        counts: impl FnOnce() -> Vec<u32>,
        result: &mut Verification,
    ) -> Result<(), CellError> {
        let failed = |error: oit_image::ImageError| CellError::Failed(error.to_string());
        let Self { engine, ready, right } = self;
        if asked.perceptual && result.verdict == Verdict::Approximate {
            let seen = oit_image::perceptual(&engine.picture(ready)?, right).map_err(failed)?;
            (result.ssim, result.flip) = (Some(seen.ssim), Some(seen.flip));
        }
        if let Some(stem) = asked.breaks.filter(|_| result.breaks()) {
            kept::keep_break(stem, &engine.picture(ready)?, right).map_err(failed)?;
        }
        if let Some(stem) = asked.images {
            kept::keep(stem, &engine.picture(ready)?, right, &counts()).map_err(failed)?;
        }
        Ok(())
    }
}

#[derive(Default)]
struct Worker {
    engine: Option<Box<dyn Engine>>,
    tuner: Option<Tuner>,
    view: Option<(DepthHistogram, FrameSize)>,
    scene: Option<((PathBuf, String), oit_scene::Scene)>,
    verifier: Option<Verifier>,
    changes: Changes,
    spheres: Option<SphereVerifier>,
    ready: HashMap<usize, Ready>,
    spent: Spent,
}

/// Milliseconds since then.
pub(crate) fn ms(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// Clocks rise under load: runs rounds, each of which gives its nanoseconds, until they stop getting
/// faster, for ten times the given time at most; none where that is 0.
pub(crate) fn until_warm<E>(
    at_least_ms: u64,
    mut round: impl FnMut() -> Result<u64, E>,
) -> Result<(), E> {
    let started = Instant::now();
    let mut last_ns = u64::MAX;
    while at_least_ms > 0 && ms(started) < 10.0 * at_least_ms as f64 {
        let round_ns = round()?;
        let falling = round_ns as f64 <= 0.99 * last_ns as f64;
        last_ns = round_ns;
        if !falling && ms(started) >= at_least_ms as f64 {
            break;
        }
    }
    Ok(())
}

/// Answers requests from standard input on standard output until it ends.
///
/// # Errors
/// Where a pipe breaks or a request is not of the protocol.
pub fn serve() -> io::Result<()> {
    let mut worker = Worker::default();
    let mut out = io::stdout().lock();
    for line in io::stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let mut answer = |reply: &Reply| -> io::Result<()> {
            let mut line = serde_json::to_vec(reply)?;
            line.push(b'\n');
            out.write_all(&line)?;
            out.flush()
        };
        if let Request::Sample { cells } = &request {
            for &cell in cells {
                answer(&worker.sample(cell).unwrap_or_else(Reply::from))?;
            }
        } else {
            answer(&worker.answer(request).unwrap_or_else(Reply::from))?;
        }
    }
    Ok(())
}

fn write_counts(path: &Path, lfb: &Lfb) -> Result<(), oit_image::ImageError> {
    if let Some(folder) = path.parent() {
        // Where this fails, so does the write, and says why.
        let _ = std::fs::create_dir_all(folder);
    }
    let counts: Vec<u32> = lfb.counts().collect();
    oit_image::write_png16_gray(path, lfb.width(), lfb.height(), &counts)
}

impl From<CellError> for Reply {
    fn from(error: CellError) -> Self {
        match error {
            CellError::Unsupported(reason) => Self::Unsupported(reason),
            CellError::Failed(reason) => Self::Failed(reason),
        }
    }
}

impl Worker {
    fn engine(&mut self) -> Result<&mut (dyn Engine + 'static), CellError> {
        self.engine.as_deref_mut().ok_or_else(|| CellError::Failed("no device is open".into()))
    }

    fn answer(&mut self, request: Request) -> Result<Reply, CellError> {
        match request {
            Request::Open { device, cache, tuning } => {
                let engine = open_engine(&device, &cache)?;
                let info = engine.info().clone();
                self.tuner = Some(Tuner::open(&tuning, &info));
                self.engine = Some(engine);
                Ok(Reply::Opened(Box::new(info)))
            }
            Request::View { scene, overrides, view, width_px, height_px, counted, counts } => {
                let size = FrameSize { width_px, height_px };
                let counts = counts.as_deref().filter(|_| counted);
                self.view(&(scene, overrides), &view, size, counted, counts)
            }
            Request::Prepare { cell, technique, check, perceptual, repeats, images, breaks } => {
                let (images, breaks) = (images.as_deref(), breaks.as_deref());
                let asked = Asked { check, perceptual, repeats, images, breaks };
                let prepared = self.prepare(cell, &technique, asked)?;
                Ok(Reply::Prepared(Box::new(prepared)))
            }
            Request::Work { cell } => {
                let ready = self.prepared(cell)?;
                let started = Instant::now();
                let passes = self.engine()?.work(ready)?;
                self.spent.verify_ms += ms(started);
                Ok(Reply::Work(passes))
            }
            Request::Bandwidth => self.bandwidth(),
            Request::WarmUp { cells, at_least_ms } => self.warm_up(&cells, at_least_ms),
            Request::Spent => Ok(Reply::Spent(self.spent)),
            Request::Sample { .. } => unreachable!("answered one by one in `serve`"),
        }
    }

    /// A view of a scene file, or of fragments that are stored in a file.
    fn view_data(
        &mut self,
        key: &(PathBuf, String),
        view: &str,
        size: FrameSize,
        counted: bool,
    ) -> Result<ViewData, CellError> {
        let failed = |error: &dyn std::fmt::Display| CellError::Failed(error.to_string());
        if is_stored(&key.0) {
            self.scene = None;
            let stored = load_stored(&key.0).map_err(|error| failed(&error))?;
            let data = ViewData::stored(stored.lfb);
            if data.size != size {
                let FrameSize { width_px, height_px } = data.size;
                let what = format!("{} is {width_px}x{height_px}", key.0.display());
                return Err(CellError::Failed(what));
            }
            return Ok(data);
        }
        // Views of one scene follow each other: its mesh is made once.
        if self.scene.as_ref().is_none_or(|(loaded, _)| loaded != key) {
            self.scene = None;
            let overrides: Overrides = toml::from_str(&key.1).map_err(|error| failed(&error))?;
            let scene = oit_scene::load(&key.0, &overrides).map_err(|error| match error {
                oit_scene::SceneError::MissingAsset { .. } => {
                    CellError::Unsupported(error.to_string())
                }
                other => failed(&other),
            })?;
            self.scene = Some((key.clone(), scene));
        }
        let (_, scene) = self.scene.as_ref().expect("loaded above");
        let open = if counted { ViewData::new } else { ViewData::uncounted };
        open(scene, view, size).map_err(|error| match error {
            ViewError::Spheres(_) => CellError::Unsupported(error.to_string()),
            ViewError::Scene(_) => failed(&error),
        })
    }

    fn view(
        &mut self,
        key: &(PathBuf, String),
        view: &str,
        size: FrameSize,
        counted: bool,
        counts: Option<&Path>,
    ) -> Result<Reply, CellError> {
        self.ready.clear();
        self.verifier = None;
        self.spheres = None;
        self.view = None;
        let started = Instant::now();
        let data = self.view_data(key, view, size, counted)?;
        self.spheres = SphereVerifier::new(&data);
        let spheres = data.spheres();
        self.spent.scene_ms += ms(started);
        let (triangles, size) = (data.triangles(), data.size);
        let started = Instant::now();
        let engine = self.engine()?;
        let histogram = engine.open_view(data)?;
        if counted {
            let verifier = Verifier::new(engine)?;
            if let Some(counts) = counts.filter(|counts| !counts.exists()) {
                write_counts(counts, verifier.reference())
                    .map_err(|error| CellError::Failed(error.to_string()))?;
            }
            self.verifier = Some(verifier);
        }
        self.changes.open(sequence(key, view, size));
        self.view = Some((histogram.clone(), size));
        self.spent.verify_ms += ms(started);
        Ok(Reply::Counted { triangles, spheres, histogram: histogram.pixels })
    }

    fn prepare(
        &mut self,
        cell: usize,
        technique: &str,
        asked: Asked,
    ) -> Result<Prepared, CellError> {
        let technique: Technique =
            technique.parse().map_err(|error| CellError::Failed(format!("{error}")))?;
        let (Some(tuner), Some((histogram, size))) = (&self.tuner, &self.view) else {
            return Err(CellError::Failed("no view is open".into()));
        };
        let chosen = tuner.choose(&technique, histogram, *size)?;
        let predicted_ns = tuner.predicted_ns(&chosen, histogram, *size);
        let tuned = Some(chosen.to_string()).filter(|name| *name != technique.to_string());
        let started = Instant::now();
        let prepared = self.prepare_and_verify(&chosen, asked);
        let prepare_ms =
            prepared.as_ref().map_or(0.0, |(_, preparation, _)| preparation.prepare_ms);
        self.spent.prepare_ms += prepare_ms;
        self.spent.verify_ms += ms(started) - prepare_ms;
        let (ready, preparation, verification) = prepared?;
        self.ready.insert(cell, ready);
        let verification =
            verification.map(|result| Verification { tuned, predicted_ns, ..result });
        Ok(Prepared { verification, programs: preparation.programs })
    }

    /// The technique, what making it ready came to, and how it compares.
    fn prepare_and_verify(
        &mut self,
        technique: &Technique,
        asked: Asked,
    ) -> Result<(Ready, Preparation, Option<Verification>), CellError> {
        let (ready, preparation) = self.engine()?.prepare(technique)?;
        if let Technique::Spheres(variation) = technique {
            let verification = match asked.check {
                Some(_) => Some(self.verify_spheres(variation, ready, &preparation, asked)?),
                None => None,
            };
            return Ok((ready, preparation, verification));
        }
        let verification = match (asked.check, &mut self.verifier, &mut self.engine) {
            (Some(check), Some(verifier), Some(engine)) => {
                verifier.repeat(asked.repeats);
                let mut result =
                    verifier.verify_by(check, &mut **engine, technique, ready, &preparation)?;
                if let Some(stability) = &mut result.stability {
                    let (picture, right) = (engine.picture(ready)?, verifier.picture());
                    stability.change = self.changes.next(technique, &picture, right);
                }
                let counts = || verifier.reference().counts().collect();
                let look = Look { engine: &mut **engine, ready, right: verifier.picture() };
                look.at(asked, counts, &mut result)?;
                Some(result)
            }
            _ => None,
        };
        Ok((ready, preparation, verification))
    }

    fn verify_spheres(
        &mut self,
        variation: &Variation,
        ready: Ready,
        preparation: &Preparation,
        asked: Asked,
    ) -> Result<Verification, CellError> {
        let (Some(engine), Some(verifier)) = (&mut self.engine, &mut self.spheres) else {
            return Err(CellError::Failed("no view of spheres is open".into()));
        };
        let mut result =
            verifier.verify(&mut **engine, variation, ready, preparation, asked.repeats)?;
        let right = verifier.expected(variation.detail).picture();
        let right: Vec<[f64; 4]> = right.iter().map(|pixel| pixel.map(f64::from)).collect();
        let look = Look { engine: &mut **engine, ready, right: &right };
        look.at(asked, || vec![0; right.len()], &mut result)?;
        Ok(result)
    }

    fn prepared(&self, cell: usize) -> Result<Ready, CellError> {
        let ready = self.ready.get(&cell).copied();
        ready.ok_or_else(|| CellError::Failed("it was not prepared".into()))
    }

    fn bandwidth(&mut self) -> Result<Reply, CellError> {
        self.ready.clear();
        self.verifier = None;
        self.spheres = None;
        self.view = None;
        let started = Instant::now();
        let measured = self.engine()?.bandwidth()?;
        self.spent.verify_ms += ms(started);
        Ok(Reply::Bandwidth(Box::new(measured)))
    }

    fn run(&mut self, cell: usize) -> Result<oit_gpu::Timing, CellError> {
        let ready = self.prepared(cell)?;
        let started = Instant::now();
        let timing = self.engine()?.run(ready)?;
        self.spent.render_ms += ms(started);
        Ok(timing)
    }

    fn sample(&mut self, cell: usize) -> Result<Reply, CellError> {
        let timing = self.run(cell)?;
        let stages_ns = timing.stages.iter().map(|(stage, ns)| ((*stage).to_owned(), *ns));
        let parts_ns = timing.parts.iter();
        let parts_ns = parts_ns.map(|((stage, part), ns)| (format!("{stage}[{part}]"), *ns));
        Ok(Reply::Sampled {
            stages_ns: stages_ns.collect(),
            parts_ns: parts_ns.collect(),
            total_ns: timing.total_ns,
        })
    }

    fn warm_up(&mut self, cells: &[usize], at_least_ms: u64) -> Result<Reply, CellError> {
        until_warm(at_least_ms, || {
            let mut round_ns = 0;
            for &cell in cells {
                round_ns += self.run(cell)?.total_ns;
            }
            Ok::<u64, CellError>(round_ns)
        })?;
        Ok(Reply::Done)
    }
}
