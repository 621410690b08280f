//! Cells on a GPU: each technique is a plan.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::time::Instant;

use oit_capture::{CAPTURES, Capture, CaptureRequest, LfbReader, Lists, Usage, count_plan};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Buffer, Device, GpuError, Plan, PlanId, Timing};
use oit_image::Image;
use oit_record::{Bandwidth, DeviceInfo, PassWork, Unsupported};
use oit_spheres::{SphereBytes, Variation};

use crate::assemble::{Fragments, IMAGE, assemble, intervals, lists, programs, slots};
use crate::bandwidth::{BANDWIDTH_BYTES, measure_bandwidth};
use crate::cuda_stage::{CudaResolve, CudaStage, cuda_versions, shared_buffers};
use crate::engine::{
    CellError, Engine, FrameSize, Memory, Preparation, Ready, Source, ViewData, draws_itself,
};
use crate::method::MethodChoice;
use crate::technique::{PoolPolicy, Sorted, Stage, Technique};
use crate::work::pass_work;

/// A GPU and the view open on it.
pub(crate) struct GpuEngine {
    // What it imports goes before the device whose memory it is.
    cuda: CudaStage,
    device: Box<dyn Device>,
    info: DeviceInfo,
    view: Option<OpenView>,
}

struct OpenView {
    data: ViewData,
    histogram: DepthHistogram,
    counts: Vec<u32>,
    ready: Vec<ReadyPlan>,
    /// Stored fragments as each capture lays them out, and for which lists.
    stored: HashMap<(&'static str, Option<Lists>), Vec<Buffer>>,
    /// Its spheres for a device, once they were asked for.
    spheres: OnceCell<SphereBytes>,
}

/// A technique's plan, or its two where the first one's pool is too small.
struct ReadyPlan {
    attempt: Option<PlanId>,
    plan: PlanId,
    /// What resolves, where the plan does not.
    cuda: Option<CudaResolve>,
    /// What captured its fragments; `None` for methods, which keep none.
    capture: Option<&'static dyn Capture>,
    pool_slots: u64,
}

fn no_view() -> CellError {
    CellError::Failed("no view is open".into())
}

impl GpuEngine {
    pub(crate) fn new(device: Box<dyn Device>) -> Self {
        let mut info = device.info().clone();
        if device.uuid().is_some() {
            match cuda_versions() {
                Ok(versions) => info.cuda = Some(versions),
                Err(reason) => {
                    let feature = "cuda stage".into();
                    info.unsupported.push(Unsupported { feature, reason });
                }
            }
        }
        Self { cuda: CudaStage::default(), device, info, view: None }
    }

    fn view(&self) -> Result<&OpenView, CellError> {
        self.view.as_ref().ok_or_else(no_view)
    }

    fn ready(&self, ready: Ready) -> Result<(&ReadyPlan, FrameSize), CellError> {
        let view = self.view()?;
        let plan = view.ready.get(ready.0);
        let plan = plan.ok_or_else(|| CellError::Failed("no such prepared technique".into()))?;
        Ok((plan, view.data.size))
    }

    fn start(&mut self, plan: &Plan) -> Result<PlanId, CellError> {
        let id = self.device.prepare(plan)?;
        self.device.poison(id)?;
        self.device.run(id)?;
        Ok(id)
    }

    /// Sees to it that the open view's fragments are laid out as the technique's capture would leave
    /// them, if they were captured before. Returns where they are in [`OpenView::stored`].
    fn lay_out(&mut self, technique: &Sorted) -> Result<(&'static str, Option<Lists>), CellError> {
        let capture = technique.capture;
        let view = self.view.as_mut().ok_or_else(no_view)?;
        let lists = lists(technique, view.data.size, view.histogram.peak())?;
        let key = (capture.name(), lists.filter(|_| capture.needs_lists()));
        if let Source::Stored(lfb) = &view.data.source {
            view.stored.entry(key.clone()).or_insert_with(|| match &key.1 {
                Some(lists) => capture.upload_in_lists(lfb, lists),
                None => capture.upload(lfb),
            });
        }
        Ok(key)
    }

    /// The technique's plan with this much room, made ready and run once, what the run came to, and
    /// the milliseconds until its pipelines were ready.
    fn attempt(
        &mut self,
        technique: &Sorted,
        pool_slots: u64,
    ) -> Result<(PlanId, Usage, f64), CellError> {
        let key = self.lay_out(technique)?;
        let view = self.view()?;
        let fragments = match &view.data.source {
            Source::Scene(scene) => Fragments::Drawn(&scene.geometry),
            Source::Stored(_) => Fragments::Stored(&view.stored[&key]),
        };
        let (size, total) = (view.data.size, view.histogram.total());
        let plan = assemble(technique, fragments, size, &view.histogram, pool_slots)?;
        let shared = shared_buffers(technique)?;
        let started = Instant::now();
        let id = match self.device.prepare_shared(&plan, &shared) {
            // The stage copies then, and tells why.
            Err(GpuError::Unsupported(_)) if !shared.is_empty() => self.device.prepare(&plan)?,
            prepared => prepared?,
        };
        let prepare_ms = started.elapsed().as_secs_f64() * 1e3;
        self.device.poison(id)?;
        self.device.run(id)?;
        let usage = with_reader(&mut *self.device, id, size, pool_slots, |reader| {
            technique.capture.usage(reader)
        })?;
        if usage.fragments != total {
            return Err(CellError::Failed(format!(
                "the capture met {} fragments and the count pass {total}",
                usage.fragments
            )));
        }
        Ok((id, usage, prepare_ms))
    }

    /// What a plan, and the attempt before it, take of the device.
    fn memory(
        &self,
        capture: Option<&dyn Capture>,
        attempt: Option<PlanId>,
        plan: PlanId,
    ) -> Result<Memory, CellError> {
        let sum = |resources: &mut dyn Iterator<Item = &(String, u64)>| {
            resources.map(|(_, bytes)| bytes).sum::<u64>()
        };
        let resources = self.device.resource_bytes(plan)?;
        let all_bytes = sum(&mut resources.iter());
        let lfb_bytes = capture.map(|capture| {
            let layout = capture.layout_wgsl();
            let is_read = |name: &str| layout.contains(&format!("> {name}:"));
            sum(&mut resources.iter().filter(|(name, _)| is_read(name)))
        });
        // What both have in common is there once.
        let first = match attempt {
            Some(attempt) => self.device.resource_bytes(attempt)?,
            None => Vec::new(),
        };
        let own = sum(&mut first.iter().filter(|resource| !resources.contains(resource)));
        Ok(Memory { all_bytes, lfb_bytes, peak_bytes: all_bytes + own })
    }

    fn prepare_sorted(&mut self, technique: &Sorted) -> Result<(Ready, Preparation), CellError> {
        let view = self.view()?;
        let whole = slots(technique, view.data.size, &view.counts, &view.histogram)?;
        let peak = view.histogram.peak();
        let max_frags = intervals(technique, peak)?.deepest();
        let is_stored = matches!(view.data.source, Source::Stored(_));
        let percent = u64::from(technique.pool.percent);
        if is_stored && percent != 100 {
            return Err(CellError::Unsupported("stored fragments are all there".into()));
        }
        let (size, peak) = (view.data.size, view.histogram.peak());
        let in_cuda = technique.stage == Stage::Cuda;
        if in_cuda {
            self.cuda.check(&*self.device, technique, size, peak)?;
        }
        let pool_initial = whole.saturating_mul(percent).div_ceil(100).max(1);
        let (mut plan, usage, mut prepare_ms) = self.attempt(technique, pool_initial)?;
        let (mut attempt, mut pool_slots) = (None, pool_initial);
        if usage.slots > pool_initial && technique.pool.policy == PoolPolicy::Grow {
            pool_slots = usage.slots.max(whole);
            let (second, again, more_ms) = self.attempt(technique, pool_slots)?;
            if again.slots > pool_slots {
                return Err(CellError::Failed(format!(
                    "{} slots were needed, then {}",
                    usage.slots, again.slots
                )));
            }
            attempt = Some(std::mem::replace(&mut plan, second));
            prepare_ms += more_ms;
        }
        let mut memory = self.memory(Some(technique.capture), attempt, plan)?;
        let mut cuda = None;
        if in_cuda {
            let started = Instant::now();
            let kernel = self.cuda.compile(&*self.device, technique, size, peak)?;
            prepare_ms += started.elapsed().as_secs_f64() * 1e3;
            let resolve = self.cuda.take(&mut *self.device, plan, technique, kernel, size)?;
            self.cuda.run(&resolve)?;
            let (copy, image) = self.cuda.memory_bytes(&resolve);
            memory.all_bytes += copy + image;
            memory.peak_bytes += copy + image;
            cuda = Some(resolve);
        }
        let preparation = Preparation {
            max_frags,
            pool_initial,
            pool_final: pool_slots,
            pool_grown: u32::from(attempt.is_some()),
            memory: Some(memory),
            prepare_ms,
            programs: programs(technique, peak, &self.device.compiled(plan)?)?,
            note: cuda.as_ref().map(CudaResolve::note),
        };
        let capture = Some(technique.capture);
        let view = self.view.as_mut().expect("it was open above");
        view.ready.push(ReadyPlan { attempt, plan, cuda, capture, pool_slots });
        Ok((Ready(view.ready.len() - 1), preparation))
    }

    fn prepare_method(&mut self, choice: &MethodChoice) -> Result<(Ready, Preparation), CellError> {
        let view = self.view()?;
        let Source::Scene(scene) = &view.data.source else { return Err(draws_itself(choice)) };
        let plan = choice.plan(&scene.geometry, view.data.size, &view.histogram)?;
        self.prepare_whole(&plan)
    }

    fn prepare_spheres(
        &mut self,
        variation: &Variation,
    ) -> Result<(Ready, Preparation), CellError> {
        let view = self.view()?;
        let (scene, spheres) = view.data.sphere_scene(variation)?;
        let bytes = view.spheres.get_or_init(|| SphereBytes::new(spheres));
        let request = scene.sphere_request(bytes, view.data.size);
        let plan = variation.plan(&request).map_err(CellError::Unsupported)?;
        self.prepare_whole(&plan)
    }

    /// Makes the plan of a technique that is one whole ready, and runs it once.
    fn prepare_whole(&mut self, plan: &Plan) -> Result<(Ready, Preparation), CellError> {
        let started = Instant::now();
        let plan = self.device.prepare(plan)?;
        let prepare_ms = started.elapsed().as_secs_f64() * 1e3;
        self.device.poison(plan)?;
        self.device.run(plan)?;
        let preparation = Preparation {
            max_frags: 0,
            pool_initial: 0,
            pool_final: 0,
            pool_grown: 0,
            memory: Some(self.memory(None, None, plan)?),
            prepare_ms,
            programs: Vec::new(),
            note: None,
        };
        let view = self.view.as_mut().expect("it was open above");
        let ready = ReadyPlan { attempt: None, plan, cuda: None, capture: None, pool_slots: 0 };
        view.ready.push(ready);
        Ok((Ready(view.ready.len() - 1), preparation))
    }
}

/// Reads the buffers of a plan that has run.
fn with_reader<T>(
    device: &mut dyn Device,
    plan: PlanId,
    size: FrameSize,
    pool_slots: u64,
    use_it: impl FnOnce(&mut LfbReader) -> T,
) -> T {
    let mut read = |name: &str| device.read(plan, name);
    use_it(&mut LfbReader {
        width_px: size.width_px,
        height_px: size.height_px,
        pool_slots,
        read: &mut read,
    })
}

/// The time of two runs as that of one.
fn both(first: Timing, second: Timing) -> Timing {
    fn sum<T: PartialEq>(mut first: Vec<(T, u64)>, second: Vec<(T, u64)>) -> Vec<(T, u64)> {
        for (what, ns) in second {
            match first.iter_mut().find(|(known, _)| *known == what) {
                Some((_, sum)) => *sum += ns,
                None => first.push((what, ns)),
            }
        }
        first
    }
    Timing {
        stages: sum(first.stages, second.stages),
        parts: sum(first.parts, second.parts),
        total_ns: first.total_ns + second.total_ns,
    }
}

impl Engine for GpuEngine {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn open_view(&mut self, data: ViewData) -> Result<DepthHistogram, CellError> {
        self.cuda.reset();
        self.device.reset();
        self.view = None;
        let counts: Vec<u32> = match &data.source {
            _ if !data.counted => Vec::new(),
            Source::Scene(scene) => {
                let FrameSize { width_px, height_px } = data.size;
                let id = self.start(&count_plan(&scene.geometry, width_px, height_px))?;
                bytemuck::pod_collect_to_vec(&self.device.read(id, "counts")?)
            }
            Source::Stored(lfb) => lfb.counts().collect(),
        };
        let histogram = DepthHistogram::from_counts(counts.iter().copied());
        self.view = Some(OpenView {
            data,
            histogram: histogram.clone(),
            counts,
            ready: Vec::new(),
            stored: HashMap::new(),
            spheres: OnceCell::new(),
        });
        Ok(histogram)
    }

    fn reference(&mut self) -> Result<(Lfb, Vec<u32>), CellError> {
        let view = self.view()?;
        if !view.data.counted {
            return Err(CellError::Failed("the view's fragments were not counted".into()));
        }
        let (size, counts) = (view.data.size, view.counts.clone());
        let scene = match &view.data.source {
            Source::Scene(scene) => scene,
            Source::Stored(lfb) => return Ok(((**lfb).clone(), counts)),
        };
        let pool_slots = view.histogram.total().max(1);
        let capture = CAPTURES[0];
        let passes = capture.build(&CaptureRequest {
            geometry: &scene.geometry,
            width_px: size.width_px,
            height_px: size.height_px,
            pool_slots,
            histogram: &view.histogram,
            counts: false,
            lists: None,
            mark: None,
        });
        let plan = Plan {
            name: format!("reference capture: {}", capture.name()),
            buffers: passes.buffers,
            targets: passes.targets,
            passes: passes.passes,
        };
        let id = self.start(&plan)?;
        let lfb =
            with_reader(&mut *self.device, id, size, pool_slots, |reader| capture.unpack(reader))?;
        Ok((lfb, counts))
    }

    fn prepare(&mut self, technique: &Technique) -> Result<(Ready, Preparation), CellError> {
        match technique {
            Technique::Sorted(sorted) => self.prepare_sorted(sorted),
            Technique::Method(choice) => self.prepare_method(choice),
            Technique::Spheres(variation) => self.prepare_spheres(variation),
        }
    }

    fn run(&mut self, ready: Ready) -> Result<Timing, CellError> {
        let ready = self.ready(ready)?.0;
        let (attempt, plan, cuda) = (ready.attempt, ready.plan, ready.cuda.clone());
        let first = attempt.map(|attempt| self.device.run(attempt)).transpose()?;
        let mut timing = self.device.run(plan)?;
        if let Some(resolve) = cuda {
            let ns = self.cuda.run(&resolve)?;
            timing.stages.push(("resolve", ns));
            timing.total_ns += ns;
        }
        Ok(match first {
            Some(first) => both(first, timing),
            None => timing,
        })
    }

    fn picture(&mut self, ready: Ready) -> Result<Image, CellError> {
        let (ready, size) = self.ready(ready)?;
        let (plan, in_cuda) = (ready.plan, ready.cuda.is_some());
        let bytes = if in_cuda { self.cuda.picture()? } else { self.device.read(plan, IMAGE)? };
        let pixels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        if pixels.len() as u64 != size.pixels() {
            let what = format!("{} pixels read, {} expected", pixels.len(), size.pixels());
            return Err(GpuError::Device(what).into());
        }
        Ok(Image { width: size.width_px, height: size.height_px, pixels })
    }

    fn captured(&mut self, ready: Ready) -> Result<Lfb, CellError> {
        let (plan, size) = self.ready(ready)?;
        let (id, capture, pool) = (plan.plan, plan.capture, plan.pool_slots);
        let capture =
            capture.ok_or_else(|| CellError::Failed("a method captures no fragments".into()))?;
        let unpacked =
            with_reader(&mut *self.device, id, size, pool, |reader| capture.unpack(reader))?;
        Ok(unpacked)
    }

    fn work(&mut self, ready: Ready) -> Result<Vec<PassWork>, CellError> {
        let ready = self.ready(ready)?.0;
        let (attempt, plan) = (ready.attempt, ready.plan);
        let mut passes = Vec::new();
        for plan in attempt.into_iter().chain([plan]) {
            passes.extend(pass_work(&mut *self.device, plan)?);
        }
        Ok(passes)
    }

    fn bandwidth(&mut self) -> Result<Bandwidth, CellError> {
        self.view = None;
        self.cuda.reset();
        Ok(measure_bandwidth(&mut *self.device, &BANDWIDTH_BYTES)?)
    }
}
