//! A physical device: what it is, what it can do, and what of that the backend enables.

use super::gpu::BUFFER_USAGE;
use super::instance::{Instance, version_text};
use super::sharing::{self, Sharing};
use super::{failure, formats};
use crate::features::Features;
use crate::limits::{Limits, StageLimits};
use crate::timing::Clock;
use crate::{Format, GpuError};
use ash::{ext, khr, vk};
use naga::valid::{Capabilities, ShaderStages, SubgroupOperationSet};
use oit_record::{DeviceInfo, Unsupported};
use std::collections::HashSet;
use std::ffi::{CStr, CString};

/// A physical device and what its driver says of it.
pub(super) struct Physical {
    pub(super) raw: vk::PhysicalDevice,
    pub(super) info: DeviceInfo,
    /// The same in all interfaces of the driver.
    pub(super) uuid: [u8; 16],
    pub(super) limits: Limits,
    pub(super) queue_family: u32,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    /// `None` if the queue has no timestamps.
    pub(super) clock: Option<Clock>,
    /// The format of [`Format::Stencil8`] here.
    pub(super) stencil_format: vk::Format,
    pub(super) features: vk::PhysicalDeviceFeatures,
    pub(super) buffer_int64_atomics: bool,
    pub(super) subgroup_extended_types: bool,
    /// Names the device and its driver, for the pipeline cache.
    pub(super) cache_name: String,
    pub(super) has_executable_properties: bool,
    /// How buffers can be shared with CUDA, or why they cannot.
    pub(super) sharing: Result<Sharing, String>,
}

/// All physical devices, in the loader's order.
pub(super) fn list(instance: &Instance) -> Result<Vec<vk::PhysicalDevice>, GpuError> {
    // SAFETY: the instance is alive.
    unsafe { instance.raw.enumerate_physical_devices() }
        .map_err(|error| failure("listing the devices", error))
}

impl Physical {
    /// Asks a physical device what it is.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if it cannot run plans at all.
    pub(super) fn new(
        instance: &Instance,
        raw: vk::PhysicalDevice,
        index: usize,
    ) -> Result<Self, GpuError> {
        let vulkan = &instance.raw;
        // SAFETY: `raw` was listed by this instance, here and below.
        let basic = unsafe { vulkan.get_physical_device_properties(raw) };
        let name = text(basic.device_name_as_c_str());
        if basic.api_version < vk::API_VERSION_1_3 {
            let version = version_text(basic.api_version);
            return Err(GpuError::Unsupported(format!(
                "{name} is of Vulkan {version}, and 1.3 is needed"
            )));
        }
        let mut p11 = vk::PhysicalDeviceVulkan11Properties::default();
        let mut p12 = vk::PhysicalDeviceVulkan12Properties::default();
        let mut p13 = vk::PhysicalDeviceVulkan13Properties::default();
        // SAFETY: as above.
        let extensions = unsafe { vulkan.enumerate_device_extension_properties(raw) }
            .map_err(|error| failure("listing the extensions", error))?;
        let extensions: HashSet<CString> = extensions
            .iter()
            .filter_map(|extension| Some(extension.extension_name_as_c_str().ok()?.to_owned()))
            .collect();
        let mut mesh_limits = vk::PhysicalDeviceMeshShaderPropertiesEXT::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut p11)
            .push_next(&mut p12)
            .push_next(&mut p13);
        // A driver is only asked of what it knows.
        let has_mesh = extensions.contains(ext::mesh_shader::NAME);
        if has_mesh {
            properties = properties.push_next(&mut mesh_limits);
        }
        // SAFETY: the chain holds structures of Vulkan 1.3, and of an extension that the device has.
        unsafe { vulkan.get_physical_device_properties2(raw, &mut properties) };
        let properties = properties.properties;
        let mut mesh_features = vk::PhysicalDeviceMeshShaderFeaturesEXT::default();
        let mut f12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut f12);
        if has_mesh {
            features = features.push_next(&mut mesh_features);
        }
        if extensions.contains(khr::pipeline_executable_properties::NAME) {
            features = features.push_next(&mut executables);
        }
        // SAFETY: the chain holds structures of Vulkan 1.3 and of extensions that the device has.
        unsafe { vulkan.get_physical_device_features2(raw, &mut features) };
        let features = features.features;
        // SAFETY: as above.
        let memory = unsafe { vulkan.get_physical_device_memory_properties(raw) };
        // SAFETY: as above.
        let families = unsafe { vulkan.get_physical_device_queue_family_properties(raw) };
        let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let (queue_family, family) = families
            .iter()
            .enumerate()
            .find(|(_, family)| family.queue_flags.contains(wanted))
            .ok_or_else(|| {
                GpuError::Unsupported(format!("{name} has no queue of graphics and compute"))
            })?;
        let bits = family.timestamp_valid_bits;
        let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
        let period_ns = f64::from(properties.limits.timestamp_period);
        let clock = (bits > 0).then_some(Clock { mask, period_ns });

        let format_features = |format| {
            // SAFETY: as above.
            unsafe { vulkan.get_physical_device_format_properties(raw, format) }
                .optimal_tiling_features
        };
        let stencil_format = formats::STENCIL
            .into_iter()
            .find(|&format| {
                let attachment = vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT;
                format_features(format).contains(attachment)
            })
            .unwrap_or(vk::Format::S8_UINT);
        let mut limits = limits(&name, &properties.limits, &features, &f12, &p11, &p13, |format| {
            format_features(formats::format(format, stencil_format))
        });
        limits.stages = StageLimits {
            mesh: mesh_features.mesh_shader != 0,
            task: mesh_features.task_shader != 0,
            // Of whichever stage is first.
            mesh_workgroups: [0, 1, 2].map(|side: usize| {
                let mesh = mesh_limits.max_mesh_work_group_count[side];
                mesh.min(mesh_limits.max_task_work_group_count[side])
            }),
            mesh_workgroups_total: mesh_limits
                .max_mesh_work_group_total_count
                .min(mesh_limits.max_task_work_group_total_count),
            ..limits.stages
        };
        let has_executable_properties = executables.pipeline_executable_info != 0;
        let blends = limits.blendable.contains(&Format::R32Float);
        let mut unsupported =
            unsupported(&extensions, &features, &f12, &p11, clock.is_some(), blends);
        let sharing = sharing::ask(vulkan, raw, &extensions, BUFFER_USAGE);
        if let Err(reason) = &sharing {
            let feature = "memory shared with CUDA".to_owned();
            unsupported.push(Unsupported { feature, reason: reason.clone() });
        }
        let device_heaps = memory.memory_heaps_as_slice().iter();
        let memory_bytes = device_heaps
            .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|heap| heap.size)
            .max();
        let driver =
            format!("{} {}", text(p12.driver_name_as_c_str()), text(p12.driver_info_as_c_str()));
        let info = DeviceInfo {
            id: format!("vulkan:{index}"),
            backend: "vulkan".to_owned(),
            name,
            driver: driver.trim().to_owned(),
            api: format!("Vulkan {}", version_text(properties.api_version)),
            kind: kind(properties.device_type).to_owned(),
            subgroup_size: Some((p13.min_subgroup_size, p13.max_subgroup_size)),
            max_storage_buffer_bytes: limits.storage_binding_bytes.min(limits.buffer_bytes),
            max_workgroup_bytes: limits.workgroup_bytes,
            max_workgroup_invocations: limits.workgroup_invocations,
            timestamp_period_ns: clock.map(|clock| clock.period_ns),
            memory_bytes,
            cuda: None,
            unsupported,
        };
        let uuid = properties.pipeline_cache_uuid;
        let uuid: String = uuid.iter().map(|byte| format!("{byte:02x}")).collect();
        let (vendor, device) = (properties.vendor_id, properties.device_id);
        Ok(Self {
            raw,
            info,
            uuid: p11.device_uuid,
            limits,
            queue_family: queue_family as u32,
            memory,
            clock,
            stencil_format,
            features,
            buffer_int64_atomics: f12.shader_buffer_int64_atomics != 0,
            subgroup_extended_types: f12.shader_subgroup_extended_types != 0,
            cache_name: format!("vulkan-{vendor:04x}-{device:04x}-{uuid}.bin"),
            has_executable_properties,
            sharing,
        })
    }
}

/// A text of the driver's; empty where it does not end.
pub(super) fn text(text: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
}

fn kind(device_type: vk::PhysicalDeviceType) -> &'static str {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete-gpu",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated-gpu",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual-gpu",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    }
}

fn limits(
    device: &str,
    limits: &vk::PhysicalDeviceLimits,
    features: &vk::PhysicalDeviceFeatures,
    f12: &vk::PhysicalDeviceVulkan12Features<'_>,
    p11: &vk::PhysicalDeviceVulkan11Properties<'_>,
    p13: &vk::PhysicalDeviceVulkan13Properties<'_>,
    format_features: impl Fn(Format) -> vk::FormatFeatureFlags,
) -> Limits {
    let drawable = |format: &Format| {
        let attachment = match format.is_color() {
            true => vk::FormatFeatureFlags::COLOR_ATTACHMENT,
            false => vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT,
        };
        format_features(*format).contains(attachment)
    };
    let blendable = |format: &Format| {
        format_features(*format).contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
    };
    let stages = p11.subgroup_supported_stages;
    let mut subgroup_stages = ShaderStages::empty();
    subgroup_stages.set(ShaderStages::COMPUTE, stages.contains(vk::ShaderStageFlags::COMPUTE));
    subgroup_stages.set(ShaderStages::FRAGMENT, stages.contains(vk::ShaderStageFlags::FRAGMENT));
    let mut subgroup_operations = SubgroupOperationSet::empty();
    for (operations, feature) in [
        (SubgroupOperationSet::BASIC, vk::SubgroupFeatureFlags::BASIC),
        (SubgroupOperationSet::VOTE, vk::SubgroupFeatureFlags::VOTE),
        (SubgroupOperationSet::ARITHMETIC, vk::SubgroupFeatureFlags::ARITHMETIC),
        (SubgroupOperationSet::BALLOT, vk::SubgroupFeatureFlags::BALLOT),
        (SubgroupOperationSet::SHUFFLE, vk::SubgroupFeatureFlags::SHUFFLE),
        (SubgroupOperationSet::SHUFFLE_RELATIVE, vk::SubgroupFeatureFlags::SHUFFLE_RELATIVE),
        (SubgroupOperationSet::QUAD_FRAGMENT_COMPUTE, vk::SubgroupFeatureFlags::QUAD),
    ] {
        subgroup_operations.set(operations, p11.subgroup_supported_operations.contains(feature));
    }
    let mut capabilities = Features::ALL.capabilities;
    capabilities.set(Capabilities::SHADER_INT64, features.shader_int64 != 0);
    let atomics =
        Capabilities::SHADER_INT64_ATOMIC_MIN_MAX | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS;
    capabilities.set(atomics, f12.shader_buffer_int64_atomics != 0 && features.shader_int64 != 0);
    Limits {
        device: device.to_owned(),
        buffer_bytes: p13.max_buffer_size.min(p11.max_memory_allocation_size),
        // NVIDIA's driver 580 allows 4 GiB, but says that an array of 2 GiB and more has no elements.
        storage_binding_bytes: u64::from(limits.max_storage_buffer_range).min((1 << 31) - 4),
        uniform_binding_bytes: u64::from(limits.max_uniform_buffer_range),
        storage_bindings_per_stage: limits.max_per_stage_descriptor_storage_buffers,
        uniform_bindings_per_stage: limits.max_per_stage_descriptor_uniform_buffers,
        textures_per_stage: limits.max_per_stage_descriptor_sampled_images,
        groups: limits.max_bound_descriptor_sets,
        workgroups: limits.max_compute_work_group_count,
        workgroup_size: limits.max_compute_work_group_size,
        workgroup_invocations: limits.max_compute_work_group_invocations,
        workgroup_bytes: u64::from(limits.max_compute_shared_memory_size),
        // Found when a pipeline is made: see `not_compiled`.
        function_array_bytes: u64::MAX,
        target_px: [
            limits.max_image_dimension2_d,
            limits.max_framebuffer_width,
            limits.max_framebuffer_height,
            limits.max_viewport_dimensions[0],
            limits.max_viewport_dimensions[1],
        ]
        .into_iter()
        .fold(u32::MAX, u32::min),
        color_attachments: limits.max_color_attachments.min(limits.max_fragment_output_attachments),
        color_bytes: u32::MAX,
        indirect_draws: match features.multi_draw_indirect {
            0 => 1,
            _ => limits.max_draw_indirect_count,
        },
        stages: StageLimits {
            glsl: true,
            geometry: features.geometry_shader != 0,
            tessellation: features.tessellation_shader != 0,
            patch_vertices: limits.max_tessellation_patch_size,
            point_size: features.shader_tessellation_and_geometry_point_size != 0,
            ..StageLimits::default()
        },
        first_instance: features.draw_indirect_first_instance != 0,
        drawable: Format::ALL.into_iter().filter(drawable).collect(),
        blendable: Format::ALL.into_iter().filter(blendable).collect(),
        fragment_writes: features.fragment_stores_and_atomics != 0,
        vertex_writes: features.vertex_pipeline_stores_and_atomics != 0,
        unclipped: features.depth_clamp != 0,
        independent_blend: features.independent_blend != 0,
        features: Features { capabilities, subgroup_stages, subgroup_operations },
        subgroup_size: (p13.min_subgroup_size, p13.max_subgroup_size),
        chooses_subgroup_size: p13
            .required_subgroup_size_stages
            .contains(vk::ShaderStageFlags::COMPUTE),
    }
}

/// What techniques may need and the device lacks.
fn unsupported(
    extensions: &HashSet<CString>,
    features: &vk::PhysicalDeviceFeatures,
    f12: &vk::PhysicalDeviceVulkan12Features<'_>,
    p11: &vk::PhysicalDeviceVulkan11Properties<'_>,
    has_timestamps: bool,
    has_float32_blending: bool,
) -> Vec<Unsupported> {
    let subgroups = |stage| {
        p11.subgroup_supported_stages.contains(stage)
            && p11.subgroup_supported_operations.contains(
                vk::SubgroupFeatureFlags::BASIC
                    | vk::SubgroupFeatureFlags::BALLOT
                    | vk::SubgroupFeatureFlags::SHUFFLE
                    | vk::SubgroupFeatureFlags::ARITHMETIC,
            )
    };
    let int64_atomics = features.shader_int64 != 0 && f12.shader_buffer_int64_atomics != 0;
    let no_feature = |name: &str| format!("the driver lacks the feature {name}");
    let extension = |feature, name: &CStr| {
        let reason = format!("the driver lacks {}", name.to_string_lossy());
        (feature, extensions.contains(name), reason)
    };
    [
        ("timestamps", has_timestamps, "the queue has no valid timestamp bits".to_owned()),
        (
            "fragment stores and atomics",
            features.fragment_stores_and_atomics != 0,
            no_feature("fragmentStoresAndAtomics"),
        ),
        (
            "subgroups in compute",
            subgroups(vk::ShaderStageFlags::COMPUTE),
            "the driver lacks ballot, shuffle or arithmetic in compute shaders".to_owned(),
        ),
        (
            "subgroups in fragment",
            subgroups(vk::ShaderStageFlags::FRAGMENT),
            "the driver lacks ballot, shuffle or arithmetic in fragment shaders".to_owned(),
        ),
        (
            "32-bit float blending",
            has_float32_blending,
            "the driver cannot blend into R32_SFLOAT".to_owned(),
        ),
        ("unclipped depth", features.depth_clamp != 0, no_feature("depthClamp")),
        (
            "several indirect draws in a pass",
            features.multi_draw_indirect != 0,
            no_feature("multiDrawIndirect"),
        ),
        (
            "first instance of indirect draws",
            features.draw_indirect_first_instance != 0,
            no_feature("drawIndirectFirstInstance"),
        ),
        ("geometry shader", features.geometry_shader != 0, no_feature("geometryShader")),
        (
            "tessellation shader",
            features.tessellation_shader != 0,
            no_feature("tessellationShader"),
        ),
        extension("fragment shader interlock", ext::fragment_shader_interlock::NAME),
        extension("conservative rasterisation", ext::conservative_rasterization::NAME),
        (
            "pipeline statistics",
            features.pipeline_statistics_query != 0,
            no_feature("pipelineStatisticsQuery"),
        ),
        extension("pipeline executable properties", khr::pipeline_executable_properties::NAME),
        ("64-bit atomics", int64_atomics, no_feature("shaderBufferInt64Atomics")),
        (
            "64-bit atomic minimum and maximum",
            int64_atomics,
            no_feature("shaderBufferInt64Atomics"),
        ),
        extension("mesh shaders", ext::mesh_shader::NAME),
    ]
    .into_iter()
    .filter(|(_, supported, _)| !supported)
    .map(|(feature, _, reason)| Unsupported { feature: feature.to_owned(), reason })
    .collect()
}
