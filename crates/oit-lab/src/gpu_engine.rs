//! Cells on a GPU: each technique is a plan.

use std::time::Instant;

use oit_capture::{CAPTURES, Capture, CaptureRequest, LfbReader, count_plan};
use oit_fragments::{DepthHistogram, Lfb};
use oit_gpu::{Device, GpuError, Plan, PlanId, Timing};
use oit_image::Image;
use oit_record::DeviceInfo;

use crate::assemble::{IMAGE, assemble, intervals};
use crate::engine::{CellError, Engine, FrameSize, Preparation, Ready, ViewData};
use crate::technique::Technique;

/// A GPU and the view open on it.
pub(crate) struct GpuEngine {
    device: Box<dyn Device>,
    view: Option<OpenView>,
}

struct OpenView {
    data: ViewData,
    histogram: DepthHistogram,
    counts: Vec<u32>,
    ready: Vec<ReadyPlan>,
}

struct ReadyPlan {
    plan: PlanId,
    capture: &'static dyn Capture,
    pool_fragments: u64,
}

impl GpuEngine {
    pub(crate) fn new(device: Box<dyn Device>) -> Self {
        Self { device, view: None }
    }

    fn view(&self) -> Result<&OpenView, CellError> {
        self.view.as_ref().ok_or_else(|| CellError::Failed("no view is open".into()))
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
}

/// Reads the buffers of a plan that has run.
fn with_reader<T>(
    device: &mut dyn Device,
    plan: PlanId,
    size: FrameSize,
    pool_fragments: u64,
    use_it: impl FnOnce(&mut LfbReader) -> T,
) -> T {
    let mut read = |name: &str| device.read(plan, name);
    use_it(&mut LfbReader {
        width_px: size.width_px,
        height_px: size.height_px,
        pool_slots: pool_fragments,
        read: &mut read,
    })
}

impl Engine for GpuEngine {
    fn info(&self) -> &DeviceInfo {
        self.device.info()
    }

    fn open_view(&mut self, data: ViewData) -> Result<DepthHistogram, CellError> {
        self.device.reset();
        self.view = None;
        let plan = count_plan(&data.geometry, data.size.width_px, data.size.height_px);
        let id = self.start(&plan)?;
        let bytes = self.device.read(id, "counts")?;
        let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
        let histogram = DepthHistogram::from_counts(counts.iter().copied());
        self.view =
            Some(OpenView { data, histogram: histogram.clone(), counts, ready: Vec::new() });
        Ok(histogram)
    }

    fn reference(&mut self) -> Result<(Lfb, Vec<u32>), CellError> {
        let view = self.view()?;
        let (size, counts) = (view.data.size, view.counts.clone());
        let pool_fragments = view.histogram.total().max(1);
        let capture = CAPTURES[0];
        let passes = capture.build(&CaptureRequest {
            geometry: &view.data.geometry,
            width_px: size.width_px,
            height_px: size.height_px,
            pool_slots: pool_fragments,
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
        let lfb = with_reader(&mut *self.device, id, size, pool_fragments, |reader| {
            capture.unpack(reader)
        })?;
        Ok((lfb, counts))
    }

    fn prepare(&mut self, technique: &Technique) -> Result<(Ready, Preparation), CellError> {
        let view = self.view()?;
        let (peak, total) = (view.histogram.peak(), view.histogram.total());
        let (geometry, size) = (view.data.geometry.clone(), view.data.size);
        let max_frags = intervals(technique, peak)?.deepest();
        let pool_initial = (total * u64::from(technique.pool_percent)).div_ceil(100).max(1);
        let (mut pool_fragments, mut pool_grown) = (pool_initial, 0);
        let mut prepare_ms = 0.0;
        loop {
            let plan = assemble(technique, &geometry, size, peak, pool_fragments)?;
            let started = Instant::now();
            let id = self.device.prepare(&plan)?;
            prepare_ms += started.elapsed().as_secs_f64() * 1e3;
            self.device.poison(id)?;
            self.device.run(id)?;
            let needed = with_reader(&mut *self.device, id, size, pool_fragments, |reader| {
                technique.capture.usage(reader)
            })?
            .slots;
            if needed != total {
                return Err(CellError::Failed(format!(
                    "the capture met {needed} fragments and the count pass {total}"
                )));
            }
            if needed > pool_fragments {
                pool_fragments = needed;
                pool_grown += 1;
                continue;
            }
            let preparation = Preparation {
                max_frags,
                pool_initial,
                pool_final: pool_fragments,
                pool_grown,
                memory_bytes: plan.bytes(),
                prepare_ms,
            };
            let capture = technique.capture;
            let view = self.view.as_mut().expect("it was open above");
            view.ready.push(ReadyPlan { plan: id, capture, pool_fragments });
            return Ok((Ready(view.ready.len() - 1), preparation));
        }
    }

    fn run(&mut self, ready: Ready) -> Result<Timing, CellError> {
        let plan = self.ready(ready)?.0.plan;
        Ok(self.device.run(plan)?)
    }

    fn picture(&mut self, ready: Ready) -> Result<Image, CellError> {
        let (plan, size) = self.ready(ready)?;
        let plan = plan.plan;
        let bytes = self.device.read(plan, IMAGE)?;
        let pixels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        if pixels.len() as u64 != size.pixels() {
            let what = format!("{} pixels read, {} expected", pixels.len(), size.pixels());
            return Err(GpuError::Device(what).into());
        }
        Ok(Image { width: size.width_px, height: size.height_px, pixels })
    }

    fn captured(&mut self, ready: Ready) -> Result<Lfb, CellError> {
        let (plan, size) = self.ready(ready)?;
        let (id, capture, pool) = (plan.plan, plan.capture, plan.pool_fragments);
        let unpacked =
            with_reader(&mut *self.device, id, size, pool, |reader| capture.unpack(reader))?;
        Ok(unpacked)
    }
}
