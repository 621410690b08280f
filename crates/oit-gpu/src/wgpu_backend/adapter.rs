//! A wgpu adapter: what it is, what it can do, and what of that the backend enables.

use super::{block_on, formats};
use crate::features::Features as ShaderFeatures;
use crate::limits::{Limits, StageLimits};
use crate::{Format, GpuError};
use naga::valid::{Capabilities, ShaderStages, SubgroupOperationSet};
use oit_record::{DeviceInfo, Unsupported};
use wgpu::{DownlevelFlags, Features};

/// NVIDIA's number as a PCI vendor.
const NVIDIA: u32 = 0x10DE;

/// What is enabled where it is offered.
const WANTED: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::SUBGROUP)
    .union(Features::SUBGROUP_BARRIER)
    .union(Features::SHADER_EARLY_DEPTH_TEST)
    .union(Features::SHADER_INT64)
    .union(Features::SHADER_INT64_ATOMIC_MIN_MAX)
    .union(Features::SHADER_INT64_ATOMIC_ALL_OPS)
    .union(Features::FLOAT32_BLENDABLE)
    .union(Features::RG11B10UFLOAT_RENDERABLE)
    .union(Features::DEPTH_CLIP_CONTROL)
    .union(Features::VERTEX_WRITABLE_STORAGE)
    .union(Features::INDIRECT_FIRST_INSTANCE)
    .union(Features::PIPELINE_STATISTICS_QUERY)
    .union(Features::PIPELINE_CACHE);

/// What a timestamp in the midst of an encoder needs.
const TIMESTAMPS: Features =
    Features::TIMESTAMP_QUERY.union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// An opened adapter.
pub(super) struct Opened {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) info: DeviceInfo,
    pub(super) limits: Limits,
    /// The file of its pipeline cache, if it can have one.
    pub(super) cache_name: Option<String>,
}

/// All adapters of the first-class APIs, in wgpu's order.
pub(super) fn list() -> Result<Vec<wgpu::Adapter>, GpuError> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    // No debug names, no validation layer, and above all no passes that check indirect arguments,
    // which would be timed.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let adapters = block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    if adapters.is_empty() {
        let what = "wgpu finds no Vulkan, Metal or DX12 device".to_owned();
        return Err(GpuError::Unsupported(what));
    }
    Ok(adapters)
}

/// Opens an adapter with all its limits and the features that plans use.
pub(super) fn open(adapter: &wgpu::Adapter, index: usize) -> Result<Opened, GpuError> {
    let features = adapter.features() & WANTED;
    let descriptor = wgpu::DeviceDescriptor {
        label: None,
        required_features: features,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = block_on(adapter.request_device(&descriptor))
        .map_err(|error| GpuError::Device(format!("opening the device: {error}")))?;
    let downlevel = adapter.get_downlevel_capabilities().flags;
    let limits = limits(adapter, &device.limits(), features, downlevel);
    let told = adapter.get_info();
    let has_timestamps = features.contains(TIMESTAMPS);
    let has_subgroups = features.contains(Features::SUBGROUP);
    let info = DeviceInfo {
        id: format!("wgpu:{index}"),
        backend: "wgpu".to_owned(),
        name: told.name.clone(),
        driver: format!("{} {}", told.driver, told.driver_info).trim().to_owned(),
        api: match told.backend {
            wgpu::Backend::Vulkan => "Vulkan".to_owned(),
            wgpu::Backend::Metal => "Metal".to_owned(),
            wgpu::Backend::Dx12 => "DirectX 12".to_owned(),
            other => format!("{other:?}"),
        },
        kind: match told.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete-gpu",
            wgpu::DeviceType::IntegratedGpu => "integrated-gpu",
            wgpu::DeviceType::VirtualGpu => "virtual-gpu",
            wgpu::DeviceType::Cpu => "cpu",
            wgpu::DeviceType::Other => "other",
        }
        .to_owned(),
        subgroup_size: has_subgroups.then_some((told.subgroup_min_size, told.subgroup_max_size)),
        max_storage_buffer_bytes: limits.storage_binding_bytes.min(limits.buffer_bytes),
        max_workgroup_bytes: limits.workgroup_bytes,
        max_workgroup_invocations: limits.workgroup_invocations,
        timestamp_period_ns: has_timestamps.then(|| f64::from(queue.get_timestamp_period())),
        // wgpu does not tell.
        memory_bytes: None,
        cuda: None,
        unsupported: unsupported(adapter.features(), downlevel, limits.first_instance),
    };
    let cache_name = features
        .contains(Features::PIPELINE_CACHE)
        .then(|| wgpu::util::pipeline_cache_key(&told))
        .flatten()
        .map(|key| format!("{key}.bin"));
    Ok(Opened { device, queue, info, limits, cache_name })
}

fn limits(
    adapter: &wgpu::Adapter,
    limits: &wgpu::Limits,
    features: Features,
    downlevel: DownlevelFlags,
) -> Limits {
    let offered = |format: Format| adapter.get_texture_format_features(formats::format(format));
    let drawable = |format: &Format| {
        offered(*format).allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
    };
    let blendable = |format: &Format| {
        // 32-bit floats are blendable only by a feature, whatever the adapter says of the format.
        let float32 = matches!(format, Format::Rgba32Float | Format::Rg32Float | Format::R32Float);
        offered(*format).flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE)
            && (!float32 || features.contains(Features::FLOAT32_BLENDABLE))
    };
    let mut capabilities = ShaderFeatures::ALL.capabilities;
    for (capability, feature) in [
        (Capabilities::SUBGROUP, Features::SUBGROUP),
        (Capabilities::SUBGROUP_BARRIER, Features::SUBGROUP_BARRIER),
        (Capabilities::EARLY_DEPTH_TEST, Features::SHADER_EARLY_DEPTH_TEST),
        (Capabilities::SHADER_INT64, Features::SHADER_INT64),
        (Capabilities::SHADER_INT64_ATOMIC_MIN_MAX, Features::SHADER_INT64_ATOMIC_MIN_MAX),
        (Capabilities::SHADER_INT64_ATOMIC_ALL_OPS, Features::SHADER_INT64_ATOMIC_ALL_OPS),
    ] {
        capabilities.set(capability, features.contains(feature));
    }
    capabilities.set(
        Capabilities::SHADER_FLOAT16_IN_FLOAT32,
        downlevel.contains(DownlevelFlags::SHADER_F16_IN_F32),
    );
    let has_subgroups = features.contains(Features::SUBGROUP);
    let told = adapter.get_info();
    Limits {
        device: told.name,
        buffer_bytes: limits.max_buffer_size,
        storage_binding_bytes: limits.max_storage_buffer_binding_size,
        uniform_binding_bytes: limits.max_uniform_buffer_binding_size,
        storage_bindings_per_stage: limits.max_storage_buffers_per_shader_stage,
        uniform_bindings_per_stage: limits.max_uniform_buffers_per_shader_stage,
        textures_per_stage: limits.max_sampled_textures_per_shader_stage,
        groups: limits.max_bind_groups,
        workgroups: [limits.max_compute_workgroups_per_dimension; 3],
        workgroup_size: [
            limits.max_compute_workgroup_size_x,
            limits.max_compute_workgroup_size_y,
            limits.max_compute_workgroup_size_z,
        ],
        workgroup_invocations: limits.max_compute_invocations_per_workgroup,
        workgroup_bytes: u64::from(limits.max_compute_workgroup_storage_size),
        // NVIDIA's compiler (580) refuses 16 KiB, and wgpu loses the device by it.
        function_array_bytes: if told.vendor == NVIDIA { (16 << 10) - 1 } else { u64::MAX },
        target_px: limits.max_texture_dimension_2d,
        color_attachments: limits.max_color_attachments,
        color_bytes: limits.max_color_attachment_bytes_per_sample,
        // Where the API has no such command, wgpu makes one draw after the other.
        indirect_draws: u32::MAX,
        stages: StageLimits::default(),
        // Shaders do not see it on DX12 without the passes that check indirect arguments.
        first_instance: features.contains(Features::INDIRECT_FIRST_INSTANCE)
            && told.backend != wgpu::Backend::Dx12,
        drawable: Format::ALL.into_iter().filter(drawable).collect(),
        blendable: Format::ALL.into_iter().filter(blendable).collect(),
        fragment_writes: downlevel.contains(DownlevelFlags::FRAGMENT_WRITABLE_STORAGE),
        vertex_writes: features.contains(Features::VERTEX_WRITABLE_STORAGE),
        unclipped: features.contains(Features::DEPTH_CLIP_CONTROL),
        independent_blend: downlevel.contains(DownlevelFlags::INDEPENDENT_BLEND),
        // wgpu offers subgroups in both stages and all operations, or none.
        features: match has_subgroups {
            true => ShaderFeatures { capabilities, ..ShaderFeatures::ALL },
            false => ShaderFeatures {
                capabilities,
                subgroup_stages: ShaderStages::empty(),
                subgroup_operations: SubgroupOperationSet::empty(),
            },
        },
        subgroup_size: (told.subgroup_min_size, told.subgroup_max_size),
        chooses_subgroup_size: false,
    }
}

/// What techniques may need and wgpu or the adapter lacks.
fn unsupported(
    features: Features,
    downlevel: DownlevelFlags,
    first_instance: bool,
) -> Vec<Unsupported> {
    let feature = |name, feature: Features| {
        let missing: Vec<_> = (feature - features).iter_names().map(|(name, _)| name).collect();
        let reason = format!("the adapter lacks {}", missing.join(" and "));
        (name, missing.is_empty(), reason)
    };
    let never = |name| (name, false, "wgpu does not offer it".to_owned());
    [
        feature("timestamps", TIMESTAMPS),
        (
            "fragment stores and atomics",
            downlevel.contains(DownlevelFlags::FRAGMENT_WRITABLE_STORAGE),
            "the adapter lacks FRAGMENT_WRITABLE_STORAGE".to_owned(),
        ),
        feature("subgroups in compute", Features::SUBGROUP),
        feature("subgroups in fragment", Features::SUBGROUP),
        feature("32-bit float blending", Features::FLOAT32_BLENDABLE),
        feature("unclipped depth", Features::DEPTH_CLIP_CONTROL),
        (
            "first instance of indirect draws",
            first_instance,
            "the adapter lacks INDIRECT_FIRST_INSTANCE, or shaders do not see it".to_owned(),
        ),
        never("geometry shader"),
        never("tessellation shader"),
        never("fragment shader interlock"),
        feature("conservative rasterisation", Features::CONSERVATIVE_RASTERIZATION),
        feature("pipeline statistics", Features::PIPELINE_STATISTICS_QUERY),
        never("pipeline executable properties"),
        feature("64-bit atomics", Features::SHADER_INT64_ATOMIC_ALL_OPS),
        feature("64-bit atomic minimum and maximum", Features::SHADER_INT64_ATOMIC_MIN_MAX),
        ("mesh shaders", false, "they are in GLSL, which wgpu does not take".to_owned()),
        never("memory shared with CUDA"),
    ]
    .into_iter()
    .filter(|(_, supported, _)| !supported)
    .map(|(feature, _, reason)| Unsupported { feature: feature.to_owned(), reason })
    .collect()
}
