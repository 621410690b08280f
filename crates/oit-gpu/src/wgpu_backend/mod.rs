//! The portable backend: the same plans on wgpu.
//!
//! wgpu sets the barriers itself and encodes anew at every run, and its Vulkan devices have robust
//! buffer access on: comparing its times with the vulkan backend's shows what that costs.

mod adapter;
mod formats;
mod pipeline;
mod prepared;

use crate::device::{POISON, no_resource, no_statistics, not_prepared};
use crate::limits::{Limits, chain};
use crate::pipeline_key::PipelineKey;
use crate::reflect::Shaders;
use crate::timing::Clock;
use crate::{
    Contents, Device, DeviceInfo, Format, GpuError, PassStatistics, Plan, PlanId, Target, Timing,
};
use pipeline::Pipelines;
use prepared::Prepared;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::pin::pin;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// Bytes of the buffers through which uploads, poison and read-backs go, piece by piece.
const STAGING_BYTES: u64 = 64 << 20;

/// Every wgpu device, in wgpu's order, or why it cannot be used.
///
/// # Errors
/// [`GpuError::Unsupported`] if there is none.
pub(crate) fn enumerate() -> Result<Vec<Result<DeviceInfo, GpuError>>, GpuError> {
    let describe = |(index, adapter)| adapter::open(adapter, index).map(|opened| opened.info);
    Ok(adapter::list()?.iter().enumerate().map(describe).collect())
}

/// A wgpu device.
pub struct Wgpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: DeviceInfo,
    limits: Limits,
    /// What went wrong since it was last looked at: wgpu reports errors to a handler.
    errors: Arc<Mutex<Vec<GpuError>>>,
    pipelines: Pipelines,
    shaders: Shaders,
    resources: Resources,
    plans: HashMap<usize, Prepared>,
    next_plan: usize,
    readable: Option<wgpu::Buffer>,
    poison: Option<wgpu::Buffer>,
}

/// What plans share: buffers and targets of the same name and size.
#[derive(Default)]
struct Resources {
    undefined: HashMap<(String, u64), wgpu::Buffer>,
    // The data is held, so that no other data can take its address.
    given: HashMap<usize, (Arc<[u8]>, wgpu::Buffer)>,
    targets: HashMap<(String, Format, u32, u32), wgpu::Texture>,
}

impl Wgpu {
    /// Opens the device of this index in wgpu's order. Compiled pipelines are kept in `cache_dir`
    /// where wgpu can give them out.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there is no such device.
    pub fn open(index: usize, cache_dir: &Path) -> Result<Self, GpuError> {
        let adapters = adapter::list()?;
        let adapter = adapters.get(index).ok_or_else(|| {
            GpuError::Unsupported(format!("wgpu:{index}: there are {} devices", adapters.len()))
        })?;
        let adapter::Opened { device, queue, info, limits, cache_name } =
            adapter::open(adapter, index)?;
        let errors: Arc<Mutex<Vec<GpuError>>> = Arc::default();
        let slot = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            slot.lock().unwrap_or_else(PoisonError::into_inner).push(failure(&error));
        }));
        let pipelines = Pipelines::new(&device, cache_dir, cache_name.as_deref());
        let opened = Self {
            device,
            queue,
            info,
            limits,
            errors,
            pipelines,
            shaders: Shaders::default(),
            resources: Resources::default(),
            plans: HashMap::new(),
            next_plan: 0,
            readable: None,
            poison: None,
        };
        opened.outcome()?;
        Ok(opened)
    }

    /// The first error since this was last called.
    fn outcome(&self) -> Result<(), GpuError> {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        match std::mem::take(&mut *errors).into_iter().next() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Submits and waits.
    fn submit(&self, encoder: Option<wgpu::CommandEncoder>) -> Result<(), GpuError> {
        let commands = encoder.map(wgpu::CommandEncoder::finish);
        self.outcome()?;
        // A lost device makes wgpu panic here.
        catch_unwind(AssertUnwindSafe(|| {
            self.queue.submit(commands);
            self.device.poll(wgpu::PollType::wait_indefinitely())
        }))
        .map_err(|_| GpuError::Device("the device was lost".to_owned()))?
        .map_err(|error| GpuError::Device(format!("waiting for the device: {error}")))?;
        self.outcome()
    }

    /// Hands the first bytes of a readable buffer over.
    fn map<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let slice = buffer.slice(..bytes);
        let mapped = Arc::new(Mutex::new(None));
        let slot = mapped.clone();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        });
        self.submit(None)?;
        let result = mapped.lock().unwrap_or_else(PoisonError::into_inner).take();
        if !matches!(result, Some(Ok(()))) {
            return Err(GpuError::Device("a buffer could not be mapped".to_owned()));
        }
        let taken = slice
            .get_mapped_range()
            .map(|view| take(&view))
            .map_err(|error| GpuError::Device(error.to_string()));
        buffer.unmap();
        taken
    }

    fn plan(&self, id: PlanId) -> Result<&Prepared, GpuError> {
        self.plans.get(&id.0).ok_or_else(|| not_prepared(id))
    }

    fn buffer(&mut self, buffer: &crate::Buffer) -> Result<wgpu::Buffer, GpuError> {
        let size = buffer.allocated_bytes();
        match &buffer.contents {
            Contents::Undefined => {
                let key = (buffer.name.clone(), size);
                if let Some(known) = self.resources.undefined.get(&key) {
                    return Ok(known.clone());
                }
                let new = self.new_buffer(size)?;
                self.resources.undefined.insert(key, new.clone());
                Ok(new)
            }
            Contents::Data(data) => {
                let key = Arc::as_ptr(data).addr();
                if let Some((_, known)) = self.resources.given.get(&key) {
                    return Ok(known.clone());
                }
                let new = self.new_buffer(size)?;
                self.upload(data, &new)?;
                self.resources.given.insert(key, (data.clone(), new.clone()));
                Ok(new)
            }
        }
    }

    fn new_buffer(&self, size: u64) -> Result<wgpu::Buffer, GpuError> {
        let new = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::UNIFORM
                | wgpu::BufferUsages::VERTEX
                | wgpu::BufferUsages::INDEX
                | wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.outcome().map(|()| new)
    }

    /// Writes bytes to the start of a buffer, in pieces, so that wgpu's own staging stays small.
    fn upload(&self, data: &[u8], to: &wgpu::Buffer) -> Result<(), GpuError> {
        let mut offset = 0;
        for piece in data.chunks(STAGING_BYTES as usize) {
            // wgpu writes multiples of 4 bytes; buffers are rounded up to one.
            let (whole, rest) = piece.split_at(piece.len() / 4 * 4);
            self.queue.write_buffer(to, offset, whole);
            if !rest.is_empty() {
                let mut last = [0; 4];
                last[..rest.len()].copy_from_slice(rest);
                self.queue.write_buffer(to, offset + whole.len() as u64, &last);
            }
            offset += piece.len() as u64;
            self.submit(None)?;
        }
        Ok(())
    }

    fn target(&mut self, target: &Target) -> Result<wgpu::Texture, GpuError> {
        let key = (target.name.clone(), target.format, target.width, target.height);
        if let Some(known) = self.resources.targets.get(&key) {
            return Ok(known.clone());
        }
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let new = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: target.width,
                height: target.height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: formats::format(target.format),
            usage: match target.format.is_color() {
                true => usage | wgpu::TextureUsages::TEXTURE_BINDING,
                false => usage,
            },
            view_formats: &[],
        });
        self.outcome()?;
        self.resources.targets.insert(key, new.clone());
        Ok(new)
    }

    fn pipeline(
        &mut self,
        plan: &Plan,
        work: &crate::Work,
        reflection: Option<&Arc<crate::Reflection>>,
    ) -> Result<Option<Rc<pipeline::Pipeline>>, GpuError> {
        let (Some((key, shader)), Some(reflection)) = (PipelineKey::of(plan, work), reflection)
        else {
            return Ok(None);
        };
        if let Some(known) = self.pipelines.known(&key) {
            return Ok(Some(known));
        }
        let new = Rc::new(self.pipelines.compile(&self.device, &key, shader, reflection));
        self.outcome()?;
        self.pipelines.keep(key, new.clone());
        Ok(Some(new))
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn read_buffer(&mut self, from: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let readable = match &self.readable {
            Some(readable) => readable.clone(),
            None => {
                let new = self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: STAGING_BYTES,
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                });
                self.outcome()?;
                self.readable.insert(new).clone()
            }
        };
        let mut data = Vec::with_capacity(bytes as usize);
        while (data.len() as u64) < bytes {
            let offset = data.len() as u64;
            let wanted = (bytes - offset).min(STAGING_BYTES);
            let copied = wanted.next_multiple_of(4);
            let mut encoder = self.encoder();
            encoder.copy_buffer_to_buffer(from, offset, &readable, 0, copied);
            self.submit(Some(encoder))?;
            self.map(&readable, copied, |piece| {
                data.extend_from_slice(&piece[..wanted as usize]);
            })?;
        }
        Ok(data)
    }
}

impl Device for Wgpu {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn prepare(&mut self, plan: &Plan) -> Result<PlanId, GpuError> {
        let reflections = crate::check::check(plan, &mut self.shaders)?;
        self.limits.check(plan, &reflections)?;
        let mut pipelines = Vec::with_capacity(plan.passes.len());
        for (pass, reflection) in plan.passes.iter().zip(&reflections) {
            pipelines.push(self.pipeline(plan, &pass.work, reflection.as_ref())?);
        }
        self.pipelines.store();
        let buffers: Result<_, _> = plan.buffers.iter().map(|buffer| self.buffer(buffer)).collect();
        let targets: Result<_, _> = plan.targets.iter().map(|target| self.target(target)).collect();
        let timed = self.info.timestamp_period_ns.is_some();
        let prepared =
            Prepared::new(&self.device, plan, &reflections, pipelines, buffers?, targets?, timed);
        self.outcome()?;
        let id = self.next_plan;
        self.next_plan += 1;
        self.plans.insert(id, prepared);
        Ok(PlanId(id))
    }

    fn planned(&self, plan: PlanId) -> Result<&Plan, GpuError> {
        Ok(&self.plan(plan)?.plan)
    }

    fn run(&mut self, plan: PlanId) -> Result<Timing, GpuError> {
        let prepared = self.plan(plan)?;
        let mut encoder = self.encoder();
        prepared.encode(&mut encoder);
        self.submit(Some(encoder))?;
        let (Some(stamps), Some(period_ns)) = (&prepared.stamps, self.info.timestamp_period_ns)
        else {
            return Ok(Timing::default());
        };
        let size = stamps.readable.size();
        let ticks: Vec<u64> =
            self.map(&stamps.readable, size, bytemuck::pod_collect_to_vec::<u8, u64>)?;
        if !ticks.is_sorted() {
            // wgpu does not tell how many bits of a timestamp count, so it cannot be undone.
            let what = "the timestamp counter wrapped around; run it again".to_owned();
            return Err(GpuError::Device(what));
        }
        Ok(prepared.stages.timing(&ticks, Clock { mask: u64::MAX, period_ns }))
    }

    fn statistics(&mut self, plan: PlanId) -> Result<Vec<PassStatistics>, GpuError> {
        let feature = wgpu::Features::PIPELINE_STATISTICS_QUERY;
        if !self.device.features().contains(feature) {
            return Err(no_statistics(&self.info.name));
        }
        let prepared = self.plan(plan)?;
        let mut encoder = self.encoder();
        let readable = prepared.encode_counting(&self.device, &mut encoder);
        self.submit(Some(encoder))?;
        let counts: Vec<u64> =
            self.map(&readable, readable.size(), bytemuck::pod_collect_to_vec::<u8, u64>)?;
        let each = counts.chunks_exact(4);
        let passes = prepared.raster_passes().zip(each);
        let statistics = passes.map(|(pass, counts)| PassStatistics {
            pass,
            vertex_invocations: counts[0],
            clipping_invocations: counts[1],
            clipping_primitives: counts[2],
            fragment_invocations: counts[3],
            ..PassStatistics::default()
        });
        Ok(statistics.collect())
    }

    fn poison(&mut self, plan: PlanId) -> Result<(), GpuError> {
        let poison = match &self.poison {
            Some(poison) => poison.clone(),
            None => {
                let new = self.new_buffer(STAGING_BYTES)?;
                self.upload(&vec![POISON; STAGING_BYTES as usize], &new)?;
                self.poison.insert(new).clone()
            }
        };
        let prepared = self.plan(plan)?;
        let mut encoder = self.encoder();
        for (buffer, raw) in prepared.plan.buffers.iter().zip(&prepared.buffers) {
            if matches!(buffer.contents, Contents::Data(_)) {
                continue;
            }
            for offset in (0..raw.size()).step_by(STAGING_BYTES as usize) {
                let size = (raw.size() - offset).min(STAGING_BYTES);
                encoder.copy_buffer_to_buffer(&poison, 0, raw, offset, size);
            }
        }
        self.submit(Some(encoder))
    }

    fn read(&mut self, plan: PlanId, resource: &str) -> Result<Vec<u8>, GpuError> {
        let prepared = self.plan(plan)?;
        if let (Some(buffer), Some(raw)) =
            (prepared.plan.buffer(resource), prepared.buffer(resource).cloned())
        {
            let bytes = buffer.bytes;
            return self.read_buffer(&raw, bytes);
        }
        let index = prepared.plan.targets.iter().position(|target| target.name == resource);
        let index = index.ok_or_else(|| no_resource(&prepared.plan.name, resource))?;
        let mut encoder = self.encoder();
        let (readable, padded_bytes) = prepared.encode_read(&self.device, &mut encoder, index);
        self.submit(Some(encoder))?;
        let target = &prepared.plan.targets[index];
        let row_bytes = (u64::from(target.width) * target.format.bytes()) as usize;
        self.map(&readable, readable.size(), |bytes| {
            bytes.chunks(padded_bytes as usize).flat_map(|row| &row[..row_bytes]).copied().collect()
        })
    }

    fn resource_bytes(&self, plan: PlanId) -> Result<Vec<(String, u64)>, GpuError> {
        let prepared = self.plan(plan)?;
        // wgpu adds a byte to what may hold vertices, so that an empty end of it can be bound, and
        // rounds up.
        let rounded = |bytes: u64| (bytes + 1).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let buffers = prepared.plan.buffers.iter().zip(&prepared.buffers);
        let buffers = buffers.map(|(buffer, raw)| (buffer.name.clone(), rounded(raw.size())));
        let targets = prepared.plan.targets.iter();
        let targets = targets.map(|target| (target.name.clone(), target.bytes()));
        Ok(buffers.chain(targets).collect())
    }

    fn reset(&mut self) {
        self.plans.clear();
        self.resources = Resources::default();
        // wgpu frees at the next poll; a device that is lost says so at the next use.
        drop(self.submit(None));
    }
}

impl Drop for Wgpu {
    fn drop(&mut self) {
        self.pipelines.store();
    }
}

/// A wgpu error as the trait gives it.
fn failure(error: &wgpu::Error) -> GpuError {
    let text = chain(error);
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory(text),
        wgpu::Error::Validation { .. } | wgpu::Error::Internal { .. } => GpuError::Device(text),
    }
}

/// The value of a future that is ready at once, as all of wgpu's are outside the browser.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
        std::thread::yield_now();
    }
}
