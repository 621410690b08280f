//! The logical device: memory, buffers, images, and commands run once.

use super::instance::Instance;
use super::physical::Physical;
use super::sharing::{self, HANDLE};
use super::{executables, failure, formats};
use crate::device::no_sharing;
use crate::{GpuError, Target};
use ash::{ext, khr, vk};
use std::rc::Rc;

/// Bytes of the buffer through which uploads and read-backs go, piece by piece.
const STAGING_BYTES: u64 = 64 << 20;

/// What a plan's buffer may be used for: anything.
pub(super) const BUFFER_USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
        | vk::BufferUsageFlags::UNIFORM_BUFFER.as_raw()
        | vk::BufferUsageFlags::VERTEX_BUFFER.as_raw()
        | vk::BufferUsageFlags::INDEX_BUFFER.as_raw()
        | vk::BufferUsageFlags::INDIRECT_BUFFER.as_raw()
        | vk::BufferUsageFlags::TRANSFER_SRC.as_raw()
        | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
);

/// A logical device with one queue. Dropping it destroys it.
pub(super) struct Gpu {
    pub(super) device: ash::Device,
    pub(super) physical: Physical,
    queue: vk::Queue,
    pub(super) command_pool: vk::CommandPool,
    fence: vk::Fence,
    /// `None` where the driver tells nothing of its pipelines, or is not to be asked.
    pub(super) executables: Option<executables::Functions>,
    /// The functions of mesh shaders, where the device has them.
    pub(super) mesh: Option<ext::mesh_shader::Device>,
    /// The functions that export memory, where the device has them.
    pub(super) sharing: Option<sharing::Functions>,
    pub(super) instance: Rc<Instance>,
}

impl Gpu {
    pub(super) fn new(instance: Rc<Instance>, physical: Physical) -> Result<Rc<Self>, GpuError> {
        let has = &physical.features;
        let features = vk::PhysicalDeviceFeatures::default()
            .fragment_stores_and_atomics(has.fragment_stores_and_atomics != 0)
            .vertex_pipeline_stores_and_atomics(has.vertex_pipeline_stores_and_atomics != 0)
            .full_draw_index_uint32(has.full_draw_index_uint32 != 0)
            .independent_blend(has.independent_blend != 0)
            .depth_clamp(has.depth_clamp != 0)
            .geometry_shader(has.geometry_shader != 0)
            .tessellation_shader(has.tessellation_shader != 0)
            .large_points(has.large_points != 0)
            .shader_tessellation_and_geometry_point_size(
                has.shader_tessellation_and_geometry_point_size != 0,
            )
            .pipeline_statistics_query(has.pipeline_statistics_query != 0)
            .multi_draw_indirect(has.multi_draw_indirect != 0)
            .draw_indirect_first_instance(has.draw_indirect_first_instance != 0)
            .shader_int64(has.shader_int64 != 0);
        let mut f12 = vk::PhysicalDeviceVulkan12Features::default()
            .shader_buffer_int64_atomics(physical.buffer_int64_atomics)
            .shader_subgroup_extended_types(physical.subgroup_extended_types);
        let mut f13 = vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true)
            .subgroup_size_control(true)
            .compute_full_subgroups(true);
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&[1.0])];
        let asks = physical.has_executable_properties && !executables::are_refused();
        let stages = physical.limits.stages;
        let mut extensions = Vec::new();
        let mut mesh = vk::PhysicalDeviceMeshShaderFeaturesEXT::default()
            .mesh_shader(stages.mesh)
            .task_shader(stages.task);
        let mut properties = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut f12)
            .push_next(&mut f13);
        if asks {
            extensions.push(khr::pipeline_executable_properties::NAME.as_ptr());
            create = create.push_next(&mut properties);
        }
        if stages.mesh {
            extensions.push(ext::mesh_shader::NAME.as_ptr());
            create = create.push_next(&mut mesh);
        }
        if physical.sharing.is_ok() {
            extensions.push(khr::external_memory_fd::NAME.as_ptr());
        }
        let create = create.enabled_extension_names(&extensions);
        // SAFETY: the physical device is of this instance; what is enabled it has, or, like the
        // features of 1.3 named here, every device of its version must have.
        let device = unsafe { instance.raw.create_device(physical.raw, &create, None) }
            .map_err(|error| failure("opening the device", error))?;
        // From here on `Drop` cleans up; null handles are ignored by the destroying functions.
        // SAFETY: the queue was asked for above.
        let queue = unsafe { device.get_device_queue(physical.queue_family, 0) };
        let executables = asks.then(|| executables::Functions::new(&instance.raw, &device));
        let mesh = stages.mesh.then(|| ext::mesh_shader::Device::new(&instance.raw, &device));
        let sharing =
            physical.sharing.is_ok().then(|| sharing::Functions::new(&instance.raw, &device));
        let mut gpu = Self {
            device,
            mesh,
            sharing,
            physical,
            queue,
            command_pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            executables,
            instance,
        };
        let pool =
            vk::CommandPoolCreateInfo::default().queue_family_index(gpu.physical.queue_family);
        // SAFETY: the device is alive.
        gpu.command_pool = unsafe { gpu.device.create_command_pool(&pool, None) }
            .map_err(|error| failure("creating a command pool", error))?;
        let fence = vk::FenceCreateInfo::default();
        // SAFETY: the device is alive.
        gpu.fence = unsafe { gpu.device.create_fence(&fence, None) }
            .map_err(|error| failure("creating a fence", error))?;
        Ok(Rc::new(gpu))
    }

    /// A new command buffer, being recorded. Its first command waits for all that ran before.
    pub(super) fn begin(
        &self,
        flags: vk::CommandBufferUsageFlags,
    ) -> Result<vk::CommandBuffer, GpuError> {
        let allocate = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.command_pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is alive.
        let commands = unsafe { self.device.allocate_command_buffers(&allocate) }
            .map_err(|error| failure("allocating commands", error))?[0];
        let begin = vk::CommandBufferBeginInfo::default().flags(flags);
        // SAFETY: the command buffer is new.
        unsafe { self.device.begin_command_buffer(commands, &begin) }
            .map_err(|error| failure("recording commands", error))?;
        self.barrier(commands);
        Ok(commands)
    }

    /// Makes all that was written before visible to all commands that follow.
    pub(super) fn barrier(&self, commands: vk::CommandBuffer) {
        self.barrier_before(commands, vk::PipelineStageFlags2::ALL_COMMANDS);
    }

    fn barrier_before(&self, commands: vk::CommandBuffer, next: vk::PipelineStageFlags2) {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(next)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded, outside rendering.
        unsafe { self.device.cmd_pipeline_barrier2(commands, &dependency) };
    }

    /// Moves an image from one layout to another, after all before and before all that follows.
    pub(super) fn transition(
        &self,
        commands: vk::CommandBuffer,
        image: &Image,
        from: vk::ImageLayout,
        to: vk::ImageLayout,
    ) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(formats::aspects(image.format))
            .level_count(1)
            .layer_count(1);
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(all)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(all)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw)
            .subresource_range(range)];
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the command buffer is being recorded, outside rendering; the image is alive.
        unsafe { self.device.cmd_pipeline_barrier2(commands, &dependency) };
    }

    /// Submits recorded commands and waits for them.
    pub(super) fn submit(&self, commands: vk::CommandBuffer) -> Result<(), GpuError> {
        let infos = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&infos)];
        let fences = [self.fence];
        // SAFETY: the commands are recorded and not in flight, since every submission is waited
        // for here; the fence is unsignalled.
        unsafe {
            self.device
                .queue_submit2(self.queue, &submits, self.fence)
                .map_err(|error| failure("submitting", error))?;
            self.device
                .wait_for_fences(&fences, true, u64::MAX)
                .map_err(|error| failure("waiting for the device", error))?;
            self.device.reset_fences(&fences).map_err(|error| failure("resetting a fence", error))
        }
    }

    /// Records commands, runs them and forgets them.
    pub(super) fn once(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), GpuError> {
        let commands = self.begin(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT)?;
        record(commands);
        self.barrier_before(commands, vk::PipelineStageFlags2::HOST);
        // SAFETY: the command buffer is being recorded.
        let done = unsafe { self.device.end_command_buffer(commands) }
            .map_err(|error| failure("recording commands", error))
            .and_then(|()| self.submit(commands));
        // SAFETY: the commands have run, or the device is lost.
        unsafe { self.device.free_command_buffers(self.command_pool, &[commands]) };
        done
    }

    /// Memory that fulfils the requirements, of a type with the first of these properties that
    /// there is. What else is asked of it, `allocate` says.
    fn allocate(
        &self,
        what: &str,
        needs: vk::MemoryRequirements,
        preferences: &[vk::MemoryPropertyFlags],
        allocate: vk::MemoryAllocateInfo<'_>,
    ) -> Result<vk::DeviceMemory, GpuError> {
        let types = self.physical.memory.memory_types_as_slice();
        let of = |wanted: vk::MemoryPropertyFlags| {
            types.iter().enumerate().position(|(index, memory)| {
                needs.memory_type_bits & (1 << index) != 0 && memory.property_flags.contains(wanted)
            })
        };
        let index = preferences.iter().find_map(|&wanted| of(wanted)).ok_or_else(|| {
            GpuError::Unsupported(format!("{what}: the device has no memory of that kind"))
        })?;
        let allocate = allocate.allocation_size(needs.size).memory_type_index(index as u32);
        // SAFETY: the type is one of the device's.
        unsafe { self.device.allocate_memory(&allocate, None) }
            .map_err(|error| failure(&format!("allocating {} bytes for {what}", needs.size), error))
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: all that was made from the device holds an `Rc` of it and so is gone.
        unsafe {
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.command_pool, None);
            self.device.destroy_device(None);
        }
    }
}

/// A buffer with memory of its own.
pub(super) struct Buffer {
    gpu: Rc<Gpu>,
    pub(super) raw: vk::Buffer,
    pub(super) memory: vk::DeviceMemory,
    /// The size of its allocation.
    pub(super) memory_bytes: u64,
    /// `None` where its memory is not shared.
    pub(super) shared: Option<Shared>,
}

/// Of a buffer whose memory is shared.
#[derive(Clone, Copy)]
pub(super) struct Shared {
    /// Whether the allocation is a dedicated one.
    pub(super) dedicated: bool,
}

impl Buffer {
    /// A buffer in device memory, for any use.
    pub(super) fn new(gpu: &Rc<Gpu>, name: &str, bytes: u64) -> Result<Self, GpuError> {
        let what = format!("buffer {name:?}");
        Self::with(gpu, &what, bytes, BUFFER_USAGE, &[vk::MemoryPropertyFlags::DEVICE_LOCAL])
    }

    /// The same in memory that [`sharing::handle`] gives away.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the device does not share memory.
    pub(super) fn shared(gpu: &Rc<Gpu>, name: &str, bytes: u64) -> Result<Self, GpuError> {
        let sharing = gpu.physical.sharing.as_ref().map_err(|reason| no_sharing(reason))?;
        let what = format!("shared buffer {name:?}");
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(HANDLE);
        let create = vk::BufferCreateInfo::default()
            .size(bytes)
            .usage(BUFFER_USAGE)
            .push_next(&mut external);
        let mut buffer = Self::unbound(gpu, &what, &create)?;
        let mut alone = vk::MemoryDedicatedRequirements::default();
        let mut needs = vk::MemoryRequirements2::default().push_next(&mut alone);
        let info = vk::BufferMemoryRequirementsInfo2::default().buffer(buffer.raw);
        // SAFETY: the buffer is alive.
        unsafe { gpu.device.get_buffer_memory_requirements2(&info, &mut needs) };
        let needs = needs.memory_requirements;
        let dedicated = sharing.dedicated_only || alone.requires_dedicated_allocation != 0;
        let mut export = vk::ExportMemoryAllocateInfo::default().handle_types(HANDLE);
        let mut for_it = vk::MemoryDedicatedAllocateInfo::default().buffer(buffer.raw);
        let mut allocate = vk::MemoryAllocateInfo::default().push_next(&mut export);
        if dedicated {
            allocate = allocate.push_next(&mut for_it);
        }
        let local = [vk::MemoryPropertyFlags::DEVICE_LOCAL];
        buffer.bind(&what, needs, gpu.allocate(&what, needs, &local, allocate)?)?;
        buffer.shared = Some(Shared { dedicated });
        Ok(buffer)
    }

    fn with(
        gpu: &Rc<Gpu>,
        what: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        preferences: &[vk::MemoryPropertyFlags],
    ) -> Result<Self, GpuError> {
        let create = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        let mut buffer = Self::unbound(gpu, what, &create)?;
        // SAFETY: the buffer is alive.
        let needs = unsafe { gpu.device.get_buffer_memory_requirements(buffer.raw) };
        let allocate = vk::MemoryAllocateInfo::default();
        buffer.bind(what, needs, gpu.allocate(what, needs, preferences, allocate)?)?;
        Ok(buffer)
    }

    /// A buffer that has no memory yet.
    fn unbound(
        gpu: &Rc<Gpu>,
        what: &str,
        create: &vk::BufferCreateInfo<'_>,
    ) -> Result<Self, GpuError> {
        // SAFETY: the device is alive; the size is not zero.
        let raw = unsafe { gpu.device.create_buffer(create, None) }
            .map_err(|error| failure(&format!("creating {what}"), error))?;
        let memory = vk::DeviceMemory::null();
        Ok(Self { gpu: gpu.clone(), raw, memory, memory_bytes: 0, shared: None })
    }

    /// Gives an unbound buffer its memory, which is as it requires.
    fn bind(
        &mut self,
        what: &str,
        needs: vk::MemoryRequirements,
        memory: vk::DeviceMemory,
    ) -> Result<(), GpuError> {
        (self.memory, self.memory_bytes) = (memory, needs.size);
        // SAFETY: the buffer is new and unbound, and the memory as it requires.
        unsafe { self.gpu.device.bind_buffer_memory(self.raw, memory, 0) }
            .map_err(|error| failure(&format!("binding the memory of {what}"), error))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for, so nothing uses the buffer.
        unsafe {
            self.gpu.device.destroy_buffer(self.raw, None);
            self.gpu.device.free_memory(self.memory, None);
        }
    }
}

/// A target with memory of its own. Between commands it stays in [`formats::layout`].
pub(super) struct Image {
    gpu: Rc<Gpu>,
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    memory: vk::DeviceMemory,
    /// The size of its allocation.
    pub(super) memory_bytes: u64,
    pub(super) format: vk::Format,
}

impl Image {
    pub(super) fn new(gpu: &Rc<Gpu>, target: &Target) -> Result<Self, GpuError> {
        let what = format!("target {:?}", target.name);
        let format = formats::format(target.format, gpu.physical.stencil_format);
        let usage = match target.format.is_color() {
            // Every device samples the formats of colour: Vulkan requires it.
            true => vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            false => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        };
        let create = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: target.width, height: target.height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage | vk::ImageUsageFlags::TRANSFER_SRC);
        // SAFETY: the device is alive; the format can be drawn to and the size is in its limits.
        let raw = unsafe { gpu.device.create_image(&create, None) }
            .map_err(|error| failure(&format!("creating {what}"), error))?;
        let (view, memory) = (vk::ImageView::null(), vk::DeviceMemory::null());
        let mut image = Self { gpu: gpu.clone(), raw, view, memory, memory_bytes: 0, format };
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(formats::aspects(format))
            .level_count(1)
            .layer_count(1);
        let view = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(range);
        // SAFETY: the image is new and unbound, and the memory as it requires.
        unsafe {
            let needs = gpu.device.get_image_memory_requirements(raw);
            let local = [vk::MemoryPropertyFlags::DEVICE_LOCAL];
            let allocate = vk::MemoryAllocateInfo::default();
            image.memory = gpu.allocate(&what, needs, &local, allocate)?;
            image.memory_bytes = needs.size;
            gpu.device
                .bind_image_memory(raw, image.memory, 0)
                .map_err(|error| failure(&format!("binding the memory of {what}"), error))?;
            image.view = gpu
                .device
                .create_image_view(&view, None)
                .map_err(|error| failure(&format!("viewing {what}"), error))?;
        }
        let layout = formats::layout(target.format);
        gpu.once(|commands| {
            gpu.transition(commands, &image, vk::ImageLayout::UNDEFINED, layout);
        })?;
        Ok(image)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for, so nothing uses the image.
        unsafe {
            self.gpu.device.destroy_image_view(self.view, None);
            self.gpu.device.destroy_image(self.raw, None);
            self.gpu.device.free_memory(self.memory, None);
        }
    }
}

/// Memory that both host and device see, through which bytes come and go.
pub(super) struct Staging {
    buffer: Buffer,
    mapped: *mut u8,
}

impl Staging {
    pub(super) fn new(gpu: &Rc<Gpu>) -> Result<Self, GpuError> {
        let visible =
            vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        // Reading memory that is not cached takes many times as long.
        let preferences = [visible | vk::MemoryPropertyFlags::HOST_CACHED, visible];
        let buffer = Buffer::with(gpu, "staging", STAGING_BYTES, usage, &preferences)?;
        let flags = vk::MemoryMapFlags::empty();
        // SAFETY: the memory is host-visible and not mapped.
        let mapped = unsafe { gpu.device.map_memory(buffer.memory, 0, STAGING_BYTES, flags) }
            .map_err(|error| failure("mapping the staging memory", error))?;
        Ok(Self { buffer, mapped: mapped.cast() })
    }

    /// Writes bytes to the start of a buffer.
    pub(super) fn upload(&self, data: &[u8], to: &Buffer) -> Result<(), GpuError> {
        let gpu = &self.buffer.gpu;
        let mut offset = 0;
        for piece in data.chunks(STAGING_BYTES as usize) {
            let size = piece.len() as u64;
            // SAFETY: the mapping is `STAGING_BYTES` long, a piece no longer, and nothing runs.
            unsafe { self.mapped.copy_from_nonoverlapping(piece.as_ptr(), piece.len()) };
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: offset, size }];
            // SAFETY: both ranges are inside their buffers.
            gpu.once(|commands| unsafe {
                gpu.device.cmd_copy_buffer(commands, self.buffer.raw, to.raw, &region);
            })?;
            offset += size;
        }
        Ok(())
    }

    /// The first bytes of a buffer.
    pub(super) fn download(&self, from: &Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let gpu = &self.buffer.gpu;
        let mut data = Vec::with_capacity(bytes as usize);
        while (data.len() as u64) < bytes {
            let src_offset = data.len() as u64;
            let size = (bytes - src_offset).min(STAGING_BYTES);
            let region = [vk::BufferCopy { src_offset, dst_offset: 0, size }];
            // SAFETY: both ranges are inside their buffers.
            gpu.once(|commands| unsafe {
                gpu.device.cmd_copy_buffer(commands, from.raw, self.buffer.raw, &region);
            })?;
            data.extend_from_slice(self.bytes(size));
        }
        Ok(data)
    }

    /// The pixels of a target, row by row from the top.
    pub(super) fn download_image(
        &self,
        image: &Image,
        target: &Target,
    ) -> Result<Vec<u8>, GpuError> {
        let gpu = &self.buffer.gpu;
        let row_bytes = u64::from(target.width) * target.format.bytes();
        let rows_at_once = (STAGING_BYTES / row_bytes).max(1) as u32;
        let layout = formats::layout(target.format);
        let transfer = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let mut data = Vec::with_capacity((row_bytes * u64::from(target.height)) as usize);
        let mut row = 0;
        while row < target.height {
            let rows = rows_at_once.min(target.height - row);
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(formats::aspect(target.format))
                .layer_count(1);
            let region = [vk::BufferImageCopy::default()
                .image_subresource(layers)
                .image_offset(vk::Offset3D { x: 0, y: row as i32, z: 0 })
                .image_extent(vk::Extent3D { width: target.width, height: rows, depth: 1 })];
            gpu.once(|commands| {
                gpu.transition(commands, image, layout, transfer);
                // SAFETY: the rows are inside the image and fit the staging buffer, since no
                // device has a row of 64 MiB.
                unsafe {
                    let to = self.buffer.raw;
                    gpu.device.cmd_copy_image_to_buffer(commands, image.raw, transfer, to, &region);
                }
                gpu.transition(commands, image, transfer, layout);
            })?;
            data.extend_from_slice(self.bytes(row_bytes * u64::from(rows)));
            row += rows;
        }
        Ok(data)
    }

    fn bytes(&self, bytes: u64) -> &[u8] {
        // SAFETY: the mapping is `STAGING_BYTES` long, no piece is longer, and nothing runs.
        unsafe { std::slice::from_raw_parts(self.mapped, bytes as usize) }
    }
}
