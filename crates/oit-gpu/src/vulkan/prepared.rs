//! A plan made ready: its resources, descriptors and recorded commands.

use super::gpu::{Buffer, Gpu, Image};
use super::pipeline::{Pipeline, descriptor_type};
use super::{failure, formats};
use crate::device::no_resource;
use crate::plan::DRAW_STRIDE_BYTES;
use crate::reflect::{Access, Kind, Reflection};
use crate::timing::Stages;
use crate::{
    Compiled, Contents, Dispatch, Draw, GpuError, Load, Pass, Plan, Raster, Target, Timing, Work,
};
use ash::vk;
use std::rc::Rc;
use std::sync::Arc;

/// A plan made ready. Its commands are recorded once and submitted at every run.
pub(super) struct Prepared {
    pub(super) gpu: Rc<Gpu>,
    /// The plan, without its data: the device holds that.
    pub(super) plan: Plan,
    reflections: Vec<Option<Arc<Reflection>>>,
    sets: Vec<Vec<vk::DescriptorSet>>,
    pub(super) buffers: Vec<NamedBuffer>,
    pub(super) targets: Vec<(Target, Rc<Image>)>,
    /// What became of the shaders.
    pub(super) compiled: Vec<Compiled>,
    // Kept alive for the recorded commands.
    pipelines: Vec<Option<Rc<Pipeline>>>,
    stages: Stages,
    descriptors: vk::DescriptorPool,
    queries: vk::QueryPool,
    commands: vk::CommandBuffer,
}

/// A buffer of the plan, on the device.
pub(super) struct NamedBuffer {
    pub(super) name: String,
    /// The plan's size; the device's is rounded up.
    pub(super) bytes: u64,
    /// Whether passes may write it.
    pub(super) undefined: bool,
    pub(super) buffer: Rc<Buffer>,
}

impl Prepared {
    pub(super) fn new(
        gpu: &Rc<Gpu>,
        plan: &Plan,
        reflections: &[Option<Arc<Reflection>>],
        pipelines: Vec<Option<Rc<Pipeline>>>,
        buffers: Vec<Rc<Buffer>>,
        targets: Vec<Rc<Image>>,
    ) -> Result<Self, GpuError> {
        let named = |(buffer, raw): (&crate::Buffer, Rc<Buffer>)| NamedBuffer {
            name: buffer.name.clone(),
            bytes: buffer.bytes,
            undefined: matches!(buffer.contents, Contents::Undefined),
            buffer: raw,
        };
        let mut kept = plan.clone();
        for buffer in &mut kept.buffers {
            if let Contents::Data(data) = &mut buffer.contents {
                *data = Arc::new([]);
            }
        }
        let mut prepared = Self {
            gpu: gpu.clone(),
            plan: kept,
            reflections: reflections.to_vec(),
            sets: Vec::new(),
            buffers: plan.buffers.iter().zip(buffers).map(named).collect(),
            targets: plan.targets.iter().cloned().zip(targets).collect(),
            compiled: Vec::new(),
            pipelines,
            stages: Stages::new(plan),
            descriptors: vk::DescriptorPool::null(),
            queries: vk::QueryPool::null(),
            commands: vk::CommandBuffer::null(),
        };
        prepared.sets = prepared.descriptors(plan, reflections)?;
        if gpu.physical.clock.is_some() {
            let create = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(prepared.stages.stamps());
            // SAFETY: the device is alive.
            prepared.queries = unsafe { gpu.device.create_query_pool(&create, None) }
                .map_err(|error| failure("creating timestamps", error))?;
        }
        prepared.commands = gpu.begin(vk::CommandBufferUsageFlags::empty())?;
        prepared.record(prepared.commands, None);
        // SAFETY: the command buffer is being recorded.
        unsafe { gpu.device.end_command_buffer(prepared.commands) }
            .map_err(|error| failure("recording the plan", error))?;
        Ok(prepared)
    }

    /// Runs the recorded commands, waits, and reads the timestamps.
    pub(super) fn run(&self) -> Result<Timing, GpuError> {
        self.gpu.submit(self.commands)?;
        let Some(clock) = self.gpu.physical.clock else { return Ok(Timing::default()) };
        let mut ticks = vec![0_u64; self.stages.stamps() as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the commands have written every query of the pool.
        unsafe { self.gpu.device.get_query_pool_results(self.queries, 0, &mut ticks, flags) }
            .map_err(|error| failure("reading timestamps", error))?;
        Ok(self.stages.timing(&ticks, clock))
    }

    fn buffer(&self, name: &str) -> Result<&Buffer, GpuError> {
        let named = self.buffers.iter().find(|buffer| buffer.name == name);
        named.map(|named| &*named.buffer).ok_or_else(|| no_resource(&self.plan.name, name))
    }

    fn image(&self, name: &str) -> Result<&Image, GpuError> {
        let named = self.targets.iter().find(|(target, _)| target.name == name);
        named.map(|(_, image)| &**image).ok_or_else(|| no_resource(&self.plan.name, name))
    }

    /// The descriptor sets of every pass.
    fn descriptors(
        &mut self,
        plan: &Plan,
        reflections: &[Option<Arc<Reflection>>],
    ) -> Result<Vec<Vec<vk::DescriptorSet>>, GpuError> {
        let mut sets = vec![Vec::new(); plan.passes.len()];
        let set_count = self.pipelines.iter().flatten().map(|p| p.sets.len() as u32).sum();
        if set_count == 0 {
            return Ok(sets);
        }
        let bindings: u32 =
            reflections.iter().flatten().map(|reflection| reflection.bindings.len() as u32).sum();
        let sizes = [
            vk::DescriptorType::UNIFORM_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::SAMPLED_IMAGE,
        ]
        .map(|ty| vk::DescriptorPoolSize { ty, descriptor_count: bindings.max(1) });
        let create = vk::DescriptorPoolCreateInfo::default().max_sets(set_count).pool_sizes(&sizes);
        // SAFETY: the device is alive.
        self.descriptors = unsafe { self.gpu.device.create_descriptor_pool(&create, None) }
            .map_err(|error| failure("creating a descriptor pool", error))?;
        for (index, pass) in plan.passes.iter().enumerate() {
            let (Some(pipeline), Some(reflection)) = (&self.pipelines[index], &reflections[index])
            else {
                continue;
            };
            if pipeline.sets.is_empty() {
                continue;
            }
            let allocate = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(self.descriptors)
                .set_layouts(&pipeline.sets);
            // SAFETY: the pool and the layouts are alive, and the pool was made large enough.
            sets[index] = unsafe { self.gpu.device.allocate_descriptor_sets(&allocate) }
                .map_err(|error| failure("allocating descriptors", error))?;
            for binding in reflection.bindings_of(Kind::of(&pass.work)) {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(sets[index][binding.group as usize])
                    .dst_binding(binding.binding)
                    .descriptor_type(descriptor_type(binding.access));
                // What is written points to one of these.
                let (buffers, images);
                let write = match binding.access {
                    Access::Texture | Access::UintTexture => {
                        images = [vk::DescriptorImageInfo::default()
                            .image_view(self.image(&binding.name)?.view)
                            .image_layout(formats::READ_LAYOUT)];
                        write.image_info(&images)
                    }
                    _ => {
                        buffers = [vk::DescriptorBufferInfo::default()
                            .buffer(self.buffer(&binding.name)?.raw)
                            .range(vk::WHOLE_SIZE)];
                        write.buffer_info(&buffers)
                    }
                };
                // SAFETY: the set has this binding, and what it names lives as long as the set.
                unsafe { self.gpu.device.update_descriptor_sets(&[write], &[]) };
            }
        }
        Ok(sets)
    }

    /// Records the passes with timestamps between the stages, or, with a pool of as many queries as
    /// there are passes, with what each raster pass counts.
    pub(super) fn record(&self, commands: vk::CommandBuffer, counts: Option<vk::QueryPool>) {
        let device = &self.gpu.device;
        let timed = self.gpu.physical.clock.is_some() && counts.is_none();
        let stamp = |query| {
            if timed {
                let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
                // SAFETY: the pool has as many queries as the plan has stamps.
                unsafe { device.cmd_write_timestamp2(commands, stage, self.queries, query) };
            }
        };
        if timed {
            // SAFETY: the pool has as many queries as the plan has stamps.
            unsafe {
                device.cmd_reset_query_pool(commands, self.queries, 0, self.stages.stamps());
            }
        }
        stamp(0);
        for (run, passes) in self.stages.runs.iter().enumerate() {
            for index in passes.clone() {
                let pass = &self.plan.passes[index];
                let read = self.read_by(pass, self.reflections[index].as_deref());
                let counts = counts.filter(|_| matches!(pass.work, Work::Raster(_)));
                for (layout, image) in &read {
                    self.gpu.transition(commands, image, *layout, formats::READ_LAYOUT);
                }
                if let Some(pool) = counts {
                    // SAFETY: the pool has a query a pass, reset before.
                    unsafe {
                        let flags = vk::QueryControlFlags::empty();
                        device.cmd_begin_query(commands, pool, index as u32, flags);
                    }
                }
                self.record_pass(commands, pass, index);
                if let Some(pool) = counts {
                    // SAFETY: the query was begun above.
                    unsafe { device.cmd_end_query(commands, pool, index as u32) };
                }
                self.gpu.barrier(commands);
                for (layout, image) in &read {
                    self.gpu.transition(commands, image, formats::READ_LAYOUT, *layout);
                }
            }
            stamp(run as u32 + 1);
        }
    }

    /// The targets that a pass's shader reads, and the layouts in which they stay between passes.
    fn read_by(
        &self,
        pass: &Pass,
        reflection: Option<&Reflection>,
    ) -> Vec<(vk::ImageLayout, &Image)> {
        let bindings = reflection.into_iter().flat_map(|r| r.bindings_of(Kind::of(&pass.work)));
        let named = |name: &str| self.targets.iter().find(|(target, _)| target.name == name);
        bindings
            .filter(|binding| binding.access.is_target())
            .filter_map(|binding| named(&binding.name))
            .map(|(target, image)| (formats::layout(target.format), &**image))
            .collect()
    }

    fn record_pass(&self, commands: vk::CommandBuffer, pass: &Pass, index: usize) {
        let device = &self.gpu.device;
        let sets = &self.sets[index];
        // The plan was checked: every name below is one of its resources.
        let raw = |name: &str| {
            let named = self.buffers.iter().find(|buffer| buffer.name == name);
            named.map_or(vk::Buffer::null(), |named| named.buffer.raw)
        };
        let bind = |point| {
            let Some(pipeline) = &self.pipelines[index] else { return };
            // SAFETY: pipeline, layout and sets are of the same reflection and are kept alive.
            unsafe {
                device.cmd_bind_pipeline(commands, point, pipeline.raw);
                if !sets.is_empty() {
                    let layout = pipeline.layout;
                    device.cmd_bind_descriptor_sets(commands, point, layout, 0, sets, &[]);
                }
            }
        };
        match &pass.work {
            Work::Clear { buffer } => {
                // SAFETY: the buffer is alive and its size a multiple of 4.
                unsafe { device.cmd_fill_buffer(commands, raw(buffer), 0, vk::WHOLE_SIZE, 0) };
            }
            Work::Compute { dispatch, .. } => {
                bind(vk::PipelineBindPoint::COMPUTE);
                match dispatch {
                    // SAFETY: the counts are in the device's limits.
                    Dispatch::Workgroups([x, y, z]) => unsafe {
                        device.cmd_dispatch(commands, *x, *y, *z);
                    },
                    // SAFETY: three `u32` at this offset are inside the buffer.
                    Dispatch::Indirect { buffer, offset_bytes } => unsafe {
                        device.cmd_dispatch_indirect(commands, raw(buffer), *offset_bytes);
                    },
                }
            }
            Work::Raster(raster) => {
                let Some((width, height)) = self.begin_rendering(commands, raster) else { return };
                bind(vk::PipelineBindPoint::GRAPHICS);
                // A negative height puts y = 1 at the top, as wgpu has it.
                let viewport = [vk::Viewport {
                    x: 0.0,
                    y: height as f32,
                    width: width as f32,
                    height: -(height as f32),
                    min_depth: 0.0,
                    max_depth: 1.0,
                }];
                let extent = vk::Extent2D { width, height };
                let scissor = [vk::Rect2D { offset: vk::Offset2D::default(), extent }];
                let stencil = raster.depth_stencil.as_ref().and_then(|target| target.stencil);
                let reference = stencil.map_or(0, |stencil| u32::from(stencil.reference));
                // SAFETY: rendering has begun with a pipeline of these dynamic states; vertices
                // and indices are buffers of the plan.
                unsafe {
                    device.cmd_set_viewport(commands, 0, &viewport);
                    device.cmd_set_scissor(commands, 0, &scissor);
                    let both = vk::StencilFaceFlags::FRONT_AND_BACK;
                    device.cmd_set_stencil_reference(commands, both, reference);
                    match &raster.draw {
                        Draw::Vertices { count, instances } => {
                            device.cmd_draw(commands, *count, *instances, 0, 0);
                        }
                        Draw::Indexed { vertices, indices, count, .. } => {
                            device.cmd_bind_vertex_buffers(commands, 0, &[raw(vertices)], &[0]);
                            let ty = vk::IndexType::UINT32;
                            device.cmd_bind_index_buffer(commands, raw(indices), 0, ty);
                            device.cmd_draw_indexed(commands, *count, 1, 0, 0, 0);
                        }
                        Draw::VerticesIndirect { arguments, offset_bytes, draws } => {
                            let (raw, at) = (raw(arguments), *offset_bytes);
                            let stride = DRAW_STRIDE_BYTES;
                            device.cmd_draw_indirect(commands, raw, at, *draws, stride);
                        }
                        Draw::MeshIndirect { arguments, offset_bytes, .. } => {
                            if let Some(mesh) = &self.gpu.mesh {
                                let (raw, at) = (raw(arguments), *offset_bytes);
                                mesh.cmd_draw_mesh_tasks_indirect(commands, raw, at, 1, 0);
                            }
                        }
                        Draw::IndexedIndirect {
                            vertices,
                            indices,
                            arguments,
                            offset_bytes,
                            ..
                        } => {
                            device.cmd_bind_vertex_buffers(commands, 0, &[raw(vertices)], &[0]);
                            let ty = vk::IndexType::UINT32;
                            device.cmd_bind_index_buffer(commands, raw(indices), 0, ty);
                            let (raw, at) = (raw(arguments), *offset_bytes);
                            device.cmd_draw_indexed_indirect(commands, raw, at, 1, 0);
                        }
                    }
                    device.cmd_end_rendering(commands);
                }
            }
        }
    }

    /// Begins drawing to the targets; their size in pixels.
    fn begin_rendering(&self, commands: vk::CommandBuffer, raster: &Raster) -> Option<(u32, u32)> {
        let find = |name: &str| self.targets.iter().find(|(target, _)| target.name == name);
        let mut size = None;
        let is_uint = |name: &str| find(name).is_some_and(|(target, _)| target.format.is_uint());
        let mut attachment = |name: &str, clear: Option<vk::ClearValue>| {
            let (target, image) = find(name)?;
            size = Some((target.width, target.height));
            let load_op = match clear {
                Some(_) => vk::AttachmentLoadOp::CLEAR,
                None => vk::AttachmentLoadOp::LOAD,
            };
            Some(
                vk::RenderingAttachmentInfo::default()
                    .image_view(image.view)
                    .image_layout(formats::layout(target.format))
                    .load_op(load_op)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .clear_value(clear.unwrap_or_default()),
            )
        };
        let colors: Vec<_> = raster
            .color
            .iter()
            .filter_map(|color| {
                let clear = match color.load {
                    // Infinity becomes the largest.
                    Load::Clear(values) if is_uint(&color.target) => {
                        let uint32 = values.map(|value| value as u32);
                        Some(vk::ClearValue { color: vk::ClearColorValue { uint32 } })
                    }
                    Load::Clear(float32) => {
                        Some(vk::ClearValue { color: vk::ClearColorValue { float32 } })
                    }
                    Load::Keep => None,
                };
                attachment(&color.target, clear)
            })
            .collect();
        let clear = |depth, stencil| vk::ClearValue {
            depth_stencil: vk::ClearDepthStencilValue { depth, stencil },
        };
        let (mut depth, mut stencil) = (None, None);
        if let Some(target) = &raster.depth_stencil {
            depth = target.depth.and_then(|depth| match depth.load {
                Load::Clear(value) => attachment(&target.target, Some(clear(value, 0))),
                Load::Keep => attachment(&target.target, None),
            });
            stencil = target.stencil.and_then(|stencil| {
                let value = stencil.clear.map(|value| clear(0.0, u32::from(value)));
                attachment(&target.target, value)
            });
        }
        let (width, height) = size?;
        let area =
            vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let mut rendering = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors);
        if let Some(depth) = &depth {
            rendering = rendering.depth_attachment(depth);
        }
        if let Some(stencil) = &stencil {
            rendering = rendering.stencil_attachment(stencil);
        }
        // SAFETY: the views are alive and in the layouts named; the command buffer is being
        // recorded, outside rendering.
        unsafe { self.gpu.device.cmd_begin_rendering(commands, &rendering) };
        Some((width, height))
    }
}

impl Drop for Prepared {
    fn drop(&mut self) {
        // SAFETY: every run is waited for, so nothing uses them; null handles are ignored, but
        // for command buffers.
        unsafe {
            if self.commands != vk::CommandBuffer::null() {
                self.gpu.device.free_command_buffers(self.gpu.command_pool, &[self.commands]);
            }
            self.gpu.device.destroy_query_pool(self.queries, None);
            self.gpu.device.destroy_descriptor_pool(self.descriptors, None);
        }
    }
}
