//! Cells on the CPU: the twins of every capture, schedule, sort and method.

use std::time::Instant;

use oit_capture::{
    Capture, Drawn, rasterize, rasterize_counts, rasterize_sphere_counts, rasterize_spheres,
};
use oit_fragments::{DepthHistogram, Element, Lfb};
use oit_gpu::{Part, Timing};
use oit_image::Image;
use oit_record::{DeviceInfo, Unsupported};
use oit_sort::Scratch;
use oit_spheres::{SphereBytes, Variation, twin};
use rayon::prelude::*;

use crate::assemble::{array, intervals, needs_lists, sort_spec};
use crate::engine::{
    CellError, Engine, FrameSize, Preparation, Ready, Source, ViewData, draws_itself,
};
use crate::method::MethodChoice;
use crate::technique::{Pool, Sorted, Stage, Technique};

/// The twins, and the view open on them.
pub(crate) struct CpuEngine {
    info: DeviceInfo,
    view: Option<(ViewData, DepthHistogram)>,
    ready: Vec<Technique>,
    last: Option<LastRun>,
}

/// What the last run left. Only the last: a deep frame's fragments fill a good part of memory.
struct LastRun {
    ready: Ready,
    picture: Vec<[f32; 4]>,
    /// `None` for methods.
    captured: Option<Lfb>,
}

/// A run: its times, its picture, and the fragments that it captured.
type Ran = (Timing, Vec<[f32; 4]>, Option<Lfb>);

impl CpuEngine {
    pub(crate) fn new() -> Self {
        Self { info: cpu_info(), view: None, ready: Vec::new(), last: None }
    }

    fn view(&self) -> Result<&(ViewData, DepthHistogram), CellError> {
        self.view.as_ref().ok_or_else(|| CellError::Failed("no view is open".into()))
    }

    fn last(&self, ready: Ready) -> Result<&LastRun, CellError> {
        let last = self.last.as_ref().filter(|last| last.ready == ready);
        last.ok_or_else(|| CellError::Failed("another technique has run since".into()))
    }

    /// Refuses what the twins cannot run; the array size of the deepest program.
    fn check(&self, technique: &Sorted) -> Result<u32, CellError> {
        if technique.stage != Stage::Compute {
            let reason = &self.info.unsupported[0].reason;
            return Err(CellError::Unsupported(reason.clone()));
        }
        if technique.pool != Pool::WHOLE {
            return Err(CellError::Unsupported("the CPU backend has no pool to run out of".into()));
        }
        if technique.capture.element() != Element::Narrow {
            return Err(CellError::Unsupported("the twins sort fragments of 64 bits".into()));
        }
        needs_lists(technique)?;
        let (_, histogram) = self.view()?;
        let intervals = intervals(technique, histogram.peak())?;
        for interval in intervals.iter() {
            sort_spec(technique, array(technique, &intervals, interval))?;
        }
        Ok(intervals.deepest())
    }

    fn run_sorted(&self, technique: &Sorted) -> Result<Ran, CellError> {
        let (view, histogram) = self.view()?;
        let peak = histogram.peak();
        let mut picture = vec![[0.0; 4]; view.size.pixels() as usize];
        let started = Instant::now();
        let captured = capture_twin(view, technique.capture);
        let mut stages = vec![("capture", ns(started))];
        let lists = if technique.schedule.has_intervals() {
            let grouping = Instant::now();
            let lists = intervals(technique, peak)?.group(captured.counts());
            stages.push(("group", ns(grouping)));
            lists
        } else {
            vec![(0..captured.pixels() as u32).collect()]
        };
        let resolving = Instant::now();
        let parts = resolve(technique, peak, &captured, &lists, &mut picture)?;
        stages.push(("resolve", ns(resolving)));
        let total_ns = ns(started);
        Ok((Timing { stages, parts, total_ns }, picture, Some(captured)))
    }

    /// A twin goes by fragments, which are rasterised anew in each run.
    fn run_method(&self, choice: &MethodChoice) -> Result<Ran, CellError> {
        let started = Instant::now();
        let fragments = submitted(&self.view()?.0);
        let mut stages = vec![("capture", ns(started))];
        let resolving = Instant::now();
        let picture = choice.twin(&fragments);
        stages.push(("resolve", ns(resolving)));
        let total_ns = ns(started);
        Ok((Timing { stages, parts: Vec::new(), total_ns }, picture, None))
    }

    fn run_spheres(&self, variation: &Variation) -> Result<Ran, CellError> {
        let view = &self.view()?.0;
        let (scene, spheres) = view.sphere_scene(variation)?;
        // A copy for a device, of which the twin reads the spheres: none of its work.
        let bytes = SphereBytes::new(spheres);
        let request = scene.sphere_request(&bytes, view.size);
        let started = Instant::now();
        let picture = twin(variation, &request).map_err(CellError::Unsupported)?;
        let total_ns = ns(started);
        let stages = vec![("draw", total_ns)];
        Ok((Timing { stages, parts: Vec::new(), total_ns }, picture, None))
    }
}

/// What the CPU backend says of itself.
#[must_use]
pub fn cpu_info() -> DeviceInfo {
    let reason = "the CPU backend runs the twins of compute programs";
    DeviceInfo {
        id: "cpu".into(),
        backend: "cpu".into(),
        name: crate::provenance::host().cpu,
        driver: format!("rayon, {} threads", rayon::current_num_threads()),
        api: "CPU".into(),
        kind: "cpu".into(),
        subgroup_size: Some((1, 1)),
        max_storage_buffer_bytes: isize::MAX as u64,
        max_workgroup_bytes: 0,
        max_workgroup_invocations: 1,
        timestamp_period_ns: Some(1.0),
        memory_bytes: None,
        cuda: None,
        unsupported: vec![Unsupported { feature: "fragment stage".into(), reason: reason.into() }],
    }
}

fn ns(started: Instant) -> u64 {
    u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

/// The fragments of a view, in submission order.
fn submitted(view: &ViewData) -> Lfb {
    let FrameSize { width_px, height_px } = view.size;
    match &view.source {
        Source::Scene(scene) => match &scene.geometry.drawn {
            Drawn::Mesh(_) => {
                rasterize(&scene.mesh, &scene.shading, &scene.camera, width_px, height_px)
            }
            Drawn::Spheres(spheres) => rasterize_spheres(spheres),
        },
        Source::Stored(lfb) => (**lfb).clone(),
    }
}

/// Fragments of each pixel, without shading any.
fn counts(view: &ViewData) -> Vec<u32> {
    let FrameSize { width_px, height_px } = view.size;
    match &view.source {
        Source::Scene(scene) => match &scene.geometry.drawn {
            Drawn::Mesh(_) => rasterize_counts(&scene.mesh, &scene.camera, width_px, height_px),
            Drawn::Spheres(spheres) => rasterize_sphere_counts(spheres),
        },
        Source::Stored(lfb) => lfb.counts().collect(),
    }
}

fn capture_twin(view: &ViewData, capture: &dyn Capture) -> Lfb {
    let mut lfb = submitted(view);
    capture.order(&mut lfb);
    lfb
}

/// Resolves every list with its interval's program. Pixels in no list stay as they are.
fn resolve(
    technique: &Sorted,
    peak: u32,
    lfb: &Lfb,
    lists: &[Vec<u32>],
    picture: &mut [[f32; 4]],
) -> Result<Vec<(Part, u64)>, CellError> {
    let intervals = intervals(technique, peak)?;
    let mut parts = Vec::new();
    for (interval, list) in intervals.iter().zip(lists) {
        let started = Instant::now();
        let (strategy, spec) = sort_spec(technique, array(technique, &intervals, interval))?;
        let colours: Vec<[f32; 4]> = list
            .par_iter()
            .with_min_len(256)
            .map_init(Scratch::default, |scratch, &pixel| {
                oit_sort::resolve(strategy, &spec, lfb.pixel(pixel as usize), scratch)
            })
            .collect();
        for (&pixel, colour) in list.iter().zip(colours) {
            picture[pixel as usize] = colour;
        }
        if technique.schedule.has_intervals() {
            parts.push((("resolve", interval.high), ns(started)));
        }
    }
    Ok(parts)
}

impl Engine for CpuEngine {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn open_view(&mut self, data: ViewData) -> Result<DepthHistogram, CellError> {
        self.ready.clear();
        self.last = None;
        let counts = if data.counted { counts(&data) } else { Vec::new() };
        let histogram = DepthHistogram::from_counts(counts);
        self.view = Some((data, histogram.clone()));
        Ok(histogram)
    }

    fn reference(&mut self) -> Result<(Lfb, Vec<u32>), CellError> {
        let view = &self.view()?.0;
        Ok((submitted(view), counts(view)))
    }

    fn prepare(&mut self, technique: &Technique) -> Result<(Ready, Preparation), CellError> {
        let (view, histogram) = self.view()?;
        let (max_frags, pool) = match technique {
            Technique::Sorted(sorted) => (self.check(sorted)?, histogram.total()),
            Technique::Method(choice) if matches!(view.source, Source::Stored(_)) => {
                return Err(draws_itself(choice));
            }
            Technique::Method(_) => (0, 0),
            Technique::Spheres(variation) => {
                view.sphere_scene(variation)?;
                (0, 0)
            }
        };
        let preparation = Preparation {
            max_frags,
            pool_initial: pool,
            pool_final: pool,
            pool_grown: 0,
            memory: None,
            prepare_ms: 0.0,
            programs: Vec::new(),
            note: None,
        };
        self.ready.push(technique.clone());
        let ready = Ready(self.ready.len() - 1);
        self.run(ready)?;
        Ok((ready, preparation))
    }

    fn run(&mut self, ready: Ready) -> Result<Timing, CellError> {
        let technique = self.ready.get(ready.0);
        let technique =
            technique.ok_or_else(|| CellError::Failed("no such prepared technique".into()))?;
        let (timing, picture, captured) = match technique {
            Technique::Sorted(sorted) => self.run_sorted(sorted)?,
            Technique::Method(choice) => self.run_method(choice)?,
            Technique::Spheres(variation) => self.run_spheres(variation)?,
        };
        self.last = Some(LastRun { ready, picture, captured });
        Ok(timing)
    }

    fn picture(&mut self, ready: Ready) -> Result<Image, CellError> {
        let size = self.view()?.0.size;
        let pixels = self.last(ready)?.picture.clone();
        Ok(Image { width: size.width_px, height: size.height_px, pixels })
    }

    fn captured(&mut self, ready: Ready) -> Result<Lfb, CellError> {
        let captured = self.last(ready)?.captured.clone();
        captured.ok_or_else(|| CellError::Failed("a method captures no fragments".into()))
    }
}
