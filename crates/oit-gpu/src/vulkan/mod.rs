//! The instrument: plans on Vulkan 1.3, with dynamic rendering and synchronization2.
//!
//! One queue; between passes stands one full memory barrier, so a pass sees all that earlier ones
//! wrote and no pass overlaps the next. A plan's commands are recorded once, so that running it
//! costs the host one submission.

mod arrays;
mod exact;
mod executables;
mod formats;
mod gpu;
mod instance;
mod physical;
mod pipeline;
mod prepared;
mod sample_mask;
mod sharing;
mod statistics;
pub(crate) mod words;

use crate::device::{POISON, no_resource, no_sharing, no_statistics, not_prepared};
use crate::pipeline_key::PipelineKey;
use crate::reflect::Shaders;
use crate::{
    Compiled, Contents, Device, DeviceInfo, Format, GpuError, PassStatistics, Plan, PlanId,
    SharedBuffer, Target, Timing,
};
use ash::vk;
use gpu::{Buffer, Gpu, Image, Staging};
use instance::Instance;
use physical::Physical;
use pipeline::Pipelines;
use prepared::Prepared;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

/// Whether the environment asks for the validation layer: `OIT_VALIDATION=1`.
fn validation_is_asked_for() -> bool {
    std::env::var_os("OIT_VALIDATION").is_some_and(|value| value == "1")
}

/// Every Vulkan device, in the loader's order, or why it cannot be used.
///
/// # Errors
/// [`GpuError::Unsupported`] if there is no loader or no driver.
pub(crate) fn enumerate() -> Result<Vec<Result<DeviceInfo, GpuError>>, GpuError> {
    let instance = Instance::new(false)?;
    let describe = |(index, raw)| Physical::new(&instance, raw, index).map(|found| found.info);
    Ok(physical::list(&instance)?.into_iter().enumerate().map(describe).collect())
}

/// A Vulkan device.
pub struct Vulkan {
    // In the order in which they must go.
    plans: HashMap<usize, Prepared>,
    resources: Resources,
    staging: Option<Staging>,
    pipelines: Pipelines,
    shaders: Shaders,
    next_plan: usize,
    gpu: Rc<Gpu>,
}

/// What plans share: buffers and targets of the same name and size. Buffers that are shared with other
/// interfaces are others.
#[derive(Default)]
struct Resources {
    undefined: HashMap<(String, u64, bool), Rc<Buffer>>,
    // The data is held, so that no other data can take its address.
    given: HashMap<(usize, bool), Given>,
    targets: HashMap<(String, Format, u32, u32), Rc<Image>>,
}

/// Data, and the buffer that holds it.
type Given = (Arc<[u8]>, Rc<Buffer>);

impl Vulkan {
    /// Opens the device of this index in the loader's order. Compiled pipelines are kept in
    /// `cache_dir`. With `OIT_VALIDATION=1` in the environment, or with `validate`, the validation
    /// layer is enabled if it is installed, and its errors are printed to stderr.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there is no such device, or it cannot run plans.
    pub fn open(index: usize, cache_dir: &Path, validate: bool) -> Result<Self, GpuError> {
        let instance = Instance::new(validate || validation_is_asked_for())?;
        let devices = physical::list(&instance)?;
        let raw = *devices.get(index).ok_or_else(|| {
            GpuError::Unsupported(format!("vulkan:{index}: there are {} devices", devices.len()))
        })?;
        let physical = Physical::new(&instance, raw, index)?;
        let gpu = Gpu::new(instance, physical)?;
        Ok(Self {
            plans: HashMap::new(),
            resources: Resources::default(),
            staging: None,
            pipelines: Pipelines::new(&gpu, cache_dir)?,
            shaders: Shaders::default(),
            next_plan: 0,
            gpu,
        })
    }

    /// Whether the driver tells a pipeline's registers, spills and code size
    /// (`VK_KHR_pipeline_executable_properties`), and is asked to: with `OIT_STATISTICS=0` in the
    /// environment it is not.
    #[must_use]
    pub fn has_pipeline_executable_properties(&self) -> bool {
        self.gpu.executables.is_some()
    }

    /// Whether the validation layer is installed.
    #[must_use]
    pub fn has_validation_layer() -> bool {
        instance::has_validation_layer()
    }

    /// The errors that the validation layer has reported so far; `None` if it is not enabled.
    #[must_use]
    pub fn validation_errors(&self) -> Option<Vec<String>> {
        self.gpu.instance.validation_errors()
    }

    fn plan(&self, id: PlanId) -> Result<&Prepared, GpuError> {
        self.plans.get(&id.0).ok_or_else(|| not_prepared(id))
    }

    fn buffer(&mut self, buffer: &crate::Buffer, shared: bool) -> Result<Rc<Buffer>, GpuError> {
        let bytes = buffer.allocated_bytes();
        let make = if shared { Buffer::shared } else { Buffer::new };
        match &buffer.contents {
            Contents::Undefined => {
                let key = (buffer.name.clone(), bytes, shared);
                if let Some(known) = self.resources.undefined.get(&key) {
                    return Ok(known.clone());
                }
                let new = Rc::new(make(&self.gpu, &buffer.name, bytes)?);
                self.resources.undefined.insert(key, new.clone());
                Ok(new)
            }
            Contents::Data(data) => {
                let key = (Arc::as_ptr(data).addr(), shared);
                if let Some((_, known)) = self.resources.given.get(&key) {
                    return Ok(known.clone());
                }
                let new = Rc::new(make(&self.gpu, &buffer.name, bytes)?);
                staging(&mut self.staging, &self.gpu)?.upload(data, &new)?;
                self.resources.given.insert(key, (data.clone(), new.clone()));
                Ok(new)
            }
        }
    }

    fn target(&mut self, target: &Target) -> Result<Rc<Image>, GpuError> {
        let key = (target.name.clone(), target.format, target.width, target.height);
        if let Some(known) = self.resources.targets.get(&key) {
            return Ok(known.clone());
        }
        let new = Rc::new(Image::new(&self.gpu, target)?);
        self.resources.targets.insert(key, new.clone());
        Ok(new)
    }
}

/// The staging memory, made at its first use.
fn staging<'a>(slot: &'a mut Option<Staging>, gpu: &Rc<Gpu>) -> Result<&'a Staging, GpuError> {
    match slot {
        Some(staging) => Ok(staging),
        None => Ok(slot.insert(Staging::new(gpu)?)),
    }
}

impl Device for Vulkan {
    fn info(&self) -> &DeviceInfo {
        &self.gpu.physical.info
    }

    fn uuid(&self) -> Option<[u8; 16]> {
        Some(self.gpu.physical.uuid)
    }

    fn prepare(&mut self, plan: &Plan) -> Result<PlanId, GpuError> {
        self.prepare_shared(plan, &[])
    }

    fn prepare_shared(&mut self, plan: &Plan, shared: &[&str]) -> Result<PlanId, GpuError> {
        let has = |name: &str| plan.buffers.iter().any(|buffer| buffer.name == name);
        if let Some(unknown) = shared.iter().find(|name| !has(name)) {
            return Err(no_resource(&plan.name, unknown));
        }
        if let (Err(reason), [_, ..]) = (&self.gpu.physical.sharing, shared) {
            return Err(no_sharing(reason));
        }
        let reflections = crate::check::check(plan, &mut self.shaders)?;
        self.gpu.physical.limits.check(plan, &reflections)?;
        let mut pipelines = Vec::with_capacity(plan.passes.len());
        let mut compiled = Vec::new();
        for (pass, reflection) in plan.passes.iter().zip(&reflections) {
            pipelines.push(match (PipelineKey::of(plan, &pass.work), reflection) {
                (Some((key, shader)), Some(reflection)) => {
                    let is_compute = matches!(key, PipelineKey::Compute { .. });
                    let pipeline = self.pipelines.get(key, &shader.label, reflection)?;
                    compiled.push(Compiled {
                        shader: shader.label.clone(),
                        main: reflection.main.clone().filter(|_| is_compute),
                        compile_ns: Some(pipeline.compile_ns),
                        from_cache: pipeline.from_cache,
                        executables: pipeline.executables.clone(),
                    });
                    Some(pipeline)
                }
                _ => None,
            });
        }
        self.pipelines.store();
        let buffers: Result<_, _> = plan
            .buffers
            .iter()
            .map(|buffer| self.buffer(buffer, shared.contains(&&*buffer.name)))
            .collect();
        let targets: Result<_, _> = plan.targets.iter().map(|target| self.target(target)).collect();
        let mut prepared =
            Prepared::new(&self.gpu, plan, &reflections, pipelines, buffers?, targets?)?;
        prepared.compiled = compiled;
        let id = self.next_plan;
        self.next_plan += 1;
        self.plans.insert(id, prepared);
        Ok(PlanId(id))
    }

    fn export(&self, plan: PlanId, buffer: &str) -> Result<SharedBuffer, GpuError> {
        let Prepared { buffers, plan, .. } = self.plan(plan)?;
        let named = buffers.iter().find(|named| named.name == buffer);
        let named = named.ok_or_else(|| no_resource(&plan.name, buffer))?;
        Ok(SharedBuffer {
            handle: sharing::handle(&self.gpu, buffer, &named.buffer)?,
            uuid: self.gpu.physical.uuid,
            memory_bytes: named.buffer.memory_bytes,
            dedicated: named.buffer.shared.is_some_and(|shared| shared.dedicated),
            // Every buffer has memory of its own.
            offset_bytes: 0,
            bytes: named.bytes,
        })
    }

    fn planned(&self, plan: PlanId) -> Result<&Plan, GpuError> {
        Ok(&self.plan(plan)?.plan)
    }

    fn run(&mut self, plan: PlanId) -> Result<Timing, GpuError> {
        self.plan(plan)?.run()
    }

    fn statistics(&mut self, plan: PlanId) -> Result<Vec<PassStatistics>, GpuError> {
        if self.gpu.physical.features.pipeline_statistics_query == 0 {
            return Err(no_statistics(&self.gpu.physical.info.name));
        }
        self.plan(plan)?.statistics()
    }

    fn poison(&mut self, plan: PlanId) -> Result<(), GpuError> {
        let prepared = self.plan(plan)?;
        self.gpu.once(|commands| {
            for named in prepared.buffers.iter().filter(|buffer| buffer.undefined) {
                let buffer = named.buffer.raw;
                let word = u32::from_ne_bytes([POISON; 4]);
                // SAFETY: the buffer is alive and its size a multiple of 4.
                unsafe {
                    let device = &self.gpu.device;
                    device.cmd_fill_buffer(commands, buffer, 0, vk::WHOLE_SIZE, word);
                }
            }
        })
    }

    fn read(&mut self, plan: PlanId, resource: &str) -> Result<Vec<u8>, GpuError> {
        let prepared = self.plans.get(&plan.0).ok_or_else(|| not_prepared(plan))?;
        let staging = staging(&mut self.staging, &self.gpu)?;
        if let Some(named) = prepared.buffers.iter().find(|buffer| buffer.name == resource) {
            return staging.download(&named.buffer, named.bytes);
        }
        match prepared.targets.iter().find(|(target, _)| target.name == resource) {
            Some((target, image)) => staging.download_image(image, target),
            None => Err(no_resource(&prepared.plan.name, resource)),
        }
    }

    fn compiled(&self, plan: PlanId) -> Result<Vec<Compiled>, GpuError> {
        Ok(self.plan(plan)?.compiled.clone())
    }

    fn resource_bytes(&self, plan: PlanId) -> Result<Vec<(String, u64)>, GpuError> {
        let Prepared { buffers, targets, .. } = self.plan(plan)?;
        let buffers = buffers.iter().map(|named| (named.name.clone(), named.buffer.memory_bytes));
        let targets =
            targets.iter().map(|(target, image)| (target.name.clone(), image.memory_bytes));
        Ok(buffers.chain(targets).collect())
    }

    fn reset(&mut self) {
        self.plans.clear();
        self.resources = Resources::default();
    }
}

/// A Vulkan error as the trait gives it.
fn failure(doing: &str, error: vk::Result) -> GpuError {
    let text = format!("{doing}: {error}");
    match error {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            GpuError::OutOfMemory(text)
        }
        _ => GpuError::Device(text),
    }
}
