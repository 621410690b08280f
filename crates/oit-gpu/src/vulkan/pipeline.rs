//! Pipelines: SPIR-V from naga, layouts from the reflection, and the driver's cache.

use super::arrays::leave_arrays_unset;
use super::gpu::Gpu;
use super::{exact, executables, failure, formats, sample_mask};
use crate::cache_file::CacheFile;
use crate::pipeline_key::{PipelineKey, RasterKey};
use crate::reflect::{Access, Kind, Reflection};
use crate::{GpuError, PreRaster, Topology};
use ash::vk;
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use oit_record::Executable;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

/// A pipeline and its layouts.
pub(super) struct Pipeline {
    gpu: Rc<Gpu>,
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    /// One for each bind group, gaps included.
    pub(super) sets: Vec<vk::DescriptorSetLayout>,
    /// Nanoseconds that the driver took to make it.
    pub(super) compile_ns: u64,
    /// Whether it was in the cache, if the driver says so.
    pub(super) from_cache: Option<bool>,
    /// What it became, if the driver says so.
    pub(super) executables: Option<Vec<Executable>>,
}

/// The pipelines made so far, and the cache that outlives the process.
pub(super) struct Pipelines {
    gpu: Rc<Gpu>,
    by_key: HashMap<PipelineKey, Rc<Pipeline>>,
    cache: vk::PipelineCache,
    file: CacheFile,
    /// Whether a pipeline was compiled since the cache was last stored.
    unstored: bool,
}

impl Pipelines {
    pub(super) fn new(gpu: &Rc<Gpu>, cache_dir: &Path) -> Result<Self, GpuError> {
        let mut file = CacheFile::new(cache_dir, &gpu.physical.cache_name);
        let stored = file.load().unwrap_or_default();
        let create = vk::PipelineCacheCreateInfo::default().initial_data(&stored);
        // SAFETY: the data is what the same driver gave (its UUID is in the file's name, a checksum
        // before it), and the driver checks its header.
        let cache = unsafe { gpu.device.create_pipeline_cache(&create, None) }
            .map_err(|error| failure("creating a pipeline cache", error))?;
        Ok(Self { gpu: gpu.clone(), by_key: HashMap::new(), cache, file, unstored: false })
    }

    /// The pipeline of this key, compiled at its first use.
    pub(super) fn get(
        &mut self,
        key: PipelineKey,
        label: &str,
        reflection: &Reflection,
    ) -> Result<Rc<Pipeline>, GpuError> {
        if let Some(known) = self.by_key.get(&key) {
            return Ok(known.clone());
        }
        let kind = match key {
            PipelineKey::Compute { .. } => Kind::Compute,
            PipelineKey::Raster(_) => Kind::Raster,
        };
        let mut pipeline = Pipeline::with_layout(&self.gpu, reflection, kind)?;
        let mut feedback = vk::PipelineCreationFeedback::default();
        let (raw, compile_ns) = match &key {
            PipelineKey::Compute { .. } => {
                self.compute(label, reflection, pipeline.layout, &mut feedback)?
            }
            PipelineKey::Raster(state) => {
                self.raster(label, reflection, pipeline.layout, state, &mut feedback)?
            }
        };
        pipeline.raw = raw;
        pipeline.compile_ns = compile_ns;
        type Flags = vk::PipelineCreationFeedbackFlags;
        pipeline.from_cache = feedback
            .flags
            .contains(Flags::VALID)
            .then(|| feedback.flags.contains(Flags::APPLICATION_PIPELINE_CACHE_HIT));
        pipeline.executables = executables::of(&self.gpu, raw);
        let pipeline = Rc::new(pipeline);
        self.unstored = true;
        self.by_key.insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// Stores the driver's cache if it has grown.
    pub(super) fn store(&mut self) {
        // To ask a driver for its cache is to copy it.
        if !std::mem::take(&mut self.unstored) {
            return;
        }
        // SAFETY: the cache is alive.
        if let Ok(data) = unsafe { self.gpu.device.get_pipeline_cache_data(self.cache) }
            && self.file.is_new(data.len())
        {
            self.file.store(&data);
        }
    }

    /// A compute pipeline, and the nanoseconds that it took.
    fn compute(
        &self,
        label: &str,
        reflection: &Reflection,
        layout: vk::PipelineLayout,
        feedback: &mut vk::PipelineCreationFeedback,
    ) -> Result<(vk::Pipeline, u64), GpuError> {
        let module = Module::new(&self.gpu, label, reflection, naga::ShaderStage::Compute, "main")?;
        let mut stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(c"main");
        let mut size = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default();
        let main = reflection.main.as_ref();
        if let Some((main, at_least)) = main.and_then(|main| Some((main, main.subgroup_at_least?)))
        {
            // The limits were checked: where the smallest is too small, a size can be asked for.
            let (min, mut max) = self.gpu.physical.limits.subgroup_size;
            if min < at_least {
                max = at_least;
                size = size.required_subgroup_size(at_least);
                stage = stage.push_next(&mut size);
            }
            if main.workgroup_size[0].is_multiple_of(max) {
                stage = stage.flags(vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS);
            }
        }
        let mut feedback =
            vk::PipelineCreationFeedbackCreateInfo::default().pipeline_creation_feedback(feedback);
        let create = [vk::ComputePipelineCreateInfo::default()
            .flags(executables::flags(&self.gpu))
            .stage(stage)
            .layout(layout)
            .push_next(&mut feedback)];
        let started = Instant::now();
        // SAFETY: the module and the layout are alive, and both come from the same reflection.
        let made = unsafe { self.gpu.device.create_compute_pipelines(self.cache, &create, None) };
        let compile_ns = started.elapsed().as_nanos() as u64;
        made.map(|pipelines| (pipelines[0], compile_ns))
            .map_err(|(_, error)| not_compiled(label, reflection, error))
    }

    /// A raster pipeline, and the nanoseconds that it took.
    fn raster(
        &self,
        label: &str,
        reflection: &Reflection,
        layout: vk::PipelineLayout,
        key: &RasterKey,
        feedback: &mut vk::PipelineCreationFeedback,
    ) -> Result<(vk::Pipeline, u64), GpuError> {
        let gpu = &self.gpu;
        let fs = Module::new(gpu, label, reflection, naga::ShaderStage::Fragment, "fs")?;
        let mut modules = Vec::new();
        if key.pre_raster == PreRaster::Wgsl {
            let vs = Module::new(gpu, label, reflection, naga::ShaderStage::Vertex, "vs")?;
            modules.push((vk::ShaderStageFlags::VERTEX, vs, c"vs"));
        }
        for compiled in &reflection.stages {
            let module = Module::of_words(gpu, label, &compiled.words)?;
            modules.push((formats::stage(compiled.stage), module, c"main"));
        }
        let stage = vk::PipelineShaderStageCreateInfo::default();
        let mut stages: Vec<_> = modules
            .iter()
            .map(|(flag, module, name)| stage.stage(*flag).module(module.raw).name(name))
            .collect();
        stages.push(stage.stage(vk::ShaderStageFlags::FRAGMENT).module(fs.raw).name(c"fs"));
        let mut bindings = Vec::new();
        let mut attributes = Vec::new();
        if let Some(layout) = &key.layout {
            bindings.push(vk::VertexInputBindingDescription {
                binding: 0,
                stride: layout.stride_bytes,
                input_rate: vk::VertexInputRate::VERTEX,
            });
            // What the shader does not read is left out, as the validation layer asks.
            let read = reflection.vs.iter().flat_map(|vs| &vs.inputs).map(|input| input.0);
            let read: Vec<u32> = read.collect();
            let used = layout.attributes.iter().filter(|a| read.contains(&a.location));
            attributes.extend(used.map(|a| vk::VertexInputAttributeDescription {
                location: a.location,
                binding: 0,
                format: formats::vertex(a.format),
                offset: a.offset_bytes,
            }));
        }
        let vertex = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let (mut topology, mut patch) = (vk::PrimitiveTopology::TRIANGLE_LIST, None);
        if let PreRaster::Glsl(glsl) = &key.pre_raster {
            match glsl.topology {
                Topology::Points => topology = vk::PrimitiveTopology::POINT_LIST,
                Topology::Triangles => {}
                Topology::Patches(vertices) => {
                    topology = vk::PrimitiveTopology::PATCH_LIST;
                    patch = Some(vertices);
                }
            }
        }
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        let tessellation = vk::PipelineTessellationStateCreateInfo::default()
            .patch_control_points(patch.unwrap_or(1));
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .depth_clamp_enable(key.unclipped)
            .line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let mut depth_stencil = vk::PipelineDepthStencilStateCreateInfo::default();
        if let Some(depth) = &key.depth {
            depth_stencil = depth_stencil
                .depth_test_enable(true)
                .depth_write_enable(depth.write)
                .depth_compare_op(formats::compare(depth.compare));
        }
        if let Some(stencil) = &key.stencil {
            // The depth of a combined format is neither tested nor written.
            let face = vk::StencilOpState::default()
                .compare_op(formats::compare(stencil.compare))
                .pass_op(formats::stencil_op(stencil.pass))
                .fail_op(formats::stencil_op(stencil.fail))
                .compare_mask(0xFF)
                .write_mask(0xFF);
            depth_stencil = depth_stencil.stencil_test_enable(true).front(face).back(face);
        }
        let blends: Vec<_> =
            key.color.iter().map(|color| formats::blend(color.blend, color.write)).collect();
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = [
            vk::DynamicState::VIEWPORT,
            vk::DynamicState::SCISSOR,
            vk::DynamicState::STENCIL_REFERENCE,
        ];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let stencil_format = gpu.physical.stencil_format;
        let colors: Vec<_> =
            key.color.iter().map(|color| formats::format(color.format, stencil_format)).collect();
        let mut rendering =
            vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&colors);
        if key.depth.is_some() {
            rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
        }
        if key.stencil.is_some() {
            rendering = rendering.stencil_attachment_format(stencil_format);
        }
        let mut feedback =
            vk::PipelineCreationFeedbackCreateInfo::default().pipeline_creation_feedback(feedback);
        let mut create = vk::GraphicsPipelineCreateInfo::default();
        if patch.is_some() {
            create = create.tessellation_state(&tessellation);
        }
        let create = [create
            .flags(executables::flags(gpu))
            .stages(&stages)
            .vertex_input_state(&vertex)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&rasterization)
            .multisample_state(&samples)
            .depth_stencil_state(&depth_stencil)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout)
            .push_next(&mut rendering)
            .push_next(&mut feedback)];
        let started = Instant::now();
        // SAFETY: the modules and the layout are alive and come from the same reflection; the plan
        // was checked for what the state names.
        let made = unsafe { gpu.device.create_graphics_pipelines(self.cache, &create, None) };
        let compile_ns = started.elapsed().as_nanos() as u64;
        made.map(|pipelines| (pipelines[0], compile_ns))
            .map_err(|(_, error)| not_compiled(label, reflection, error))
    }
}

/// Arrays of a function that every driver so far has compiled. NVIDIA's (580) gives an unknown error for
/// 16 KiB and says of no limit beforehand.
const COMPILED_ARRAY_BYTES: u64 = 12 << 10;

/// Why a pipeline could not be made: where a shader keeps large arrays, that this is more than the
/// driver has room for.
fn not_compiled(label: &str, reflection: &Reflection, error: vk::Result) -> GpuError {
    let bytes = reflection.function_array_bytes();
    match error {
        vk::Result::ERROR_UNKNOWN | vk::Result::ERROR_INITIALIZATION_FAILED
            if bytes > COMPILED_ARRAY_BYTES =>
        {
            GpuError::Unsupported(format!(
                "the driver does not compile {label:?}, whose function keeps {bytes} bytes of arrays"
            ))
        }
        _ => failure(&format!("compiling {label:?}"), error),
    }
}

impl Drop for Pipelines {
    fn drop(&mut self) {
        self.store();
        // SAFETY: nothing is being compiled.
        unsafe { self.gpu.device.destroy_pipeline_cache(self.cache, None) };
    }
}

impl Pipeline {
    /// The layouts of a shader, without the pipeline.
    fn with_layout(gpu: &Rc<Gpu>, reflection: &Reflection, kind: Kind) -> Result<Self, GpuError> {
        let (raw, layout) = (vk::Pipeline::null(), vk::PipelineLayout::null());
        let mut pipeline = Self {
            gpu: gpu.clone(),
            raw,
            layout,
            sets: Vec::new(),
            compile_ns: 0,
            from_cache: None,
            executables: None,
        };
        // Stages in GLSL take the place of the vertex stage.
        let before_raster = match reflection.stages.is_empty() {
            true => vk::ShaderStageFlags::VERTEX,
            false => {
                let flags = reflection.stages.iter().map(|stage| formats::stage(stage.stage));
                flags.fold(vk::ShaderStageFlags::empty(), |all, flag| all | flag)
            }
        };
        for group in 0..reflection.groups(kind) {
            let bindings: Vec<_> = reflection
                .bindings_of(kind)
                .filter(|binding| binding.group == group)
                .map(|binding| {
                    let used = |used, stage| {
                        if used { stage } else { vk::ShaderStageFlags::empty() }
                    };
                    let stages = match kind {
                        Kind::Compute => vk::ShaderStageFlags::COMPUTE,
                        Kind::Raster => {
                            used(binding.vertex, before_raster)
                                | used(binding.fragment, vk::ShaderStageFlags::FRAGMENT)
                        }
                    };
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.binding)
                        .descriptor_type(descriptor_type(binding.access))
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: the device is alive; no two bindings are the same.
            let set = unsafe { gpu.device.create_descriptor_set_layout(&create, None) }
                .map_err(|error| failure("creating a descriptor set layout", error))?;
            pipeline.sets.push(set);
        }
        let create = vk::PipelineLayoutCreateInfo::default().set_layouts(&pipeline.sets);
        // SAFETY: the set layouts are alive.
        pipeline.layout = unsafe { gpu.device.create_pipeline_layout(&create, None) }
            .map_err(|error| failure("creating a pipeline layout", error))?;
        Ok(pipeline)
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for, so nothing uses the pipeline.
        unsafe {
            self.gpu.device.destroy_pipeline(self.raw, None);
            self.gpu.device.destroy_pipeline_layout(self.layout, None);
            for &set in &self.sets {
                self.gpu.device.destroy_descriptor_set_layout(set, None);
            }
        }
    }
}

/// The kind of descriptor that a buffer or target so declared has.
pub(super) fn descriptor_type(access: Access) -> vk::DescriptorType {
    match access {
        Access::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        Access::Read | Access::ReadWrite => vk::DescriptorType::STORAGE_BUFFER,
        Access::Texture | Access::UintTexture => vk::DescriptorType::SAMPLED_IMAGE,
    }
}

/// A shader module, needed only while its pipeline is made.
struct Module<'a> {
    gpu: &'a Gpu,
    raw: vk::ShaderModule,
}

impl<'a> Module<'a> {
    fn new(
        gpu: &'a Gpu,
        label: &str,
        reflection: &Reflection,
        stage: naga::ShaderStage,
        entry_point: &str,
    ) -> Result<Self, GpuError> {
        let code = spirv(reflection, stage, entry_point).map_err(|error| {
            GpuError::Unsupported(format!("shader {label:?} has no SPIR-V: {error}"))
        })?;
        Self::of_words(gpu, label, &code)
    }

    /// The module of SPIR-V that naga or glslang wrote.
    fn of_words(gpu: &'a Gpu, label: &str, code: &[u32]) -> Result<Self, GpuError> {
        let create = vk::ShaderModuleCreateInfo::default().code(code);
        // SAFETY: naga writes valid SPIR-V from a validated module, and glslang from a program that
        // it has checked.
        let raw = unsafe { gpu.device.create_shader_module(&create, None) }
            .map_err(|error| failure(&format!("loading {label:?}"), error))?;
        Ok(Self { gpu, raw })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: the pipeline is made, or has failed.
        unsafe { self.gpu.device.destroy_shader_module(self.raw, None) };
    }
}

/// The SPIR-V of an entry point, with none of the checks that would be timed along with it. The
/// options are those of the wgpu backend's unchecked shaders.
fn spirv(
    reflection: &Reflection,
    shader_stage: naga::ShaderStage,
    entry_point: &str,
) -> Result<Vec<u32>, spv::Error> {
    let options = spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Unchecked,
            buffer: BoundsCheckPolicy::Unchecked,
            image_load: BoundsCheckPolicy::Unchecked,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        emit_int_div_checks: false,
        ..spv::Options::default()
    };
    let pipeline = spv::PipelineOptions { shader_stage, entry_point: entry_point.to_owned() };
    let words = spv::write_vec(&reflection.module, &reflection.info, &options, Some(&pipeline))?;
    let words = sample_mask::as_array(&leave_arrays_unset(&words));
    Ok(if reflection.exact_arithmetic { exact::without_contraction(&words) } else { words })
}

#[cfg(test)]
mod tests {
    use super::super::words::instructions;
    use super::*;
    use crate::Shader;

    const OP_VARIABLE: u32 = 59;
    const OP_CONTROL_BARRIER: u32 = 224;

    /// Zeros in workgroup memory are an initializer, or stores of all invocations and a barrier.
    fn zeros(words: &[u32]) -> usize {
        let is_zeroing = |&(opcode, words): &(u32, &[u32])| {
            opcode == OP_CONTROL_BARRIER || (opcode == OP_VARIABLE && words.len() == 5)
        };
        instructions(words).filter(is_zeroing).count()
    }

    /// The execution modes of a fragment stage, in SPIR-V's numbers.
    fn execution_modes(attribute: &str) -> Vec<u32> {
        const OP_EXECUTION_MODE: u32 = 16;
        const ORIGIN_UPPER_LEFT: u32 = 7;
        let shader = format!(
            "@fragment {attribute} fn fs(@builtin(position) at: vec4<f32>)
                 -> @builtin(frag_depth) f32 {{ return at.z; }}"
        );
        let reflection = Reflection::new(&Shader::new("depth", shader)).expect("valid");
        let words = spirv(&reflection, naga::ShaderStage::Fragment, "fs").expect("SPIR-V");
        let modes = instructions(&words).filter(|&(opcode, _)| opcode == OP_EXECUTION_MODE);
        modes.map(|(_, words)| words[2]).filter(|&mode| mode != ORIGIN_UPPER_LEFT).collect()
    }

    #[test]
    fn depth_that_is_bounded_is_also_replaced() {
        const DEPTH_REPLACING: u32 = 12;
        const DEPTH_GREATER: u32 = 14;
        const DEPTH_LESS: u32 = 15;
        const DEPTH_UNCHANGED: u32 = 16;
        assert_eq!(execution_modes(""), [DEPTH_REPLACING]);
        for (word, mode) in [
            ("greater_equal", DEPTH_GREATER),
            ("less_equal", DEPTH_LESS),
            ("unchanged", DEPTH_UNCHANGED),
        ] {
            let modes = execution_modes(&format!("@early_depth_test({word})"));
            assert_eq!(modes, [mode, DEPTH_REPLACING], "{word}");
        }
    }

    #[test]
    fn workgroup_memory_is_not_zeroed() {
        let shader = Shader::new(
            "workgroup.wgsl",
            "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
             var<workgroup> list: array<u32, 4096>;
             @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) lane: u32) {
                 list[lane] = out[lane];
                 out[lane] = list[lane];
             }",
        );
        let reflection = Reflection::new(&shader).expect("valid");
        let words = spirv(&reflection, naga::ShaderStage::Compute, "main").expect("SPIR-V");
        assert_eq!(zeros(&words), 0);
        // naga would.
        let zeroed = spv::Options::default();
        let zeroed = spv::write_vec(&reflection.module, &reflection.info, &zeroed, None);
        assert!(zeros(&zeroed.expect("SPIR-V")) > 0);
    }
}
