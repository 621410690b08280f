//! Pipelines: shader modules without checks, layouts from the reflection, and the cache.

use super::formats;
use crate::Shader;
use crate::cache_file::CacheFile;
use crate::directives::hoisted;
use crate::pipeline_key::{PipelineKey, RasterKey};
use crate::reflect::{Access, Kind, Reflection};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use wgpu::ShaderStages;

/// A pipeline and its layouts.
pub(super) struct Pipeline {
    pub(super) raw: Raw,
    /// One for each bind group; `None` for a gap.
    pub(super) groups: Vec<Option<wgpu::BindGroupLayout>>,
}

/// The two kinds of pipeline.
pub(super) enum Raw {
    Compute(wgpu::ComputePipeline),
    Raster(wgpu::RenderPipeline),
}

/// The pipelines made so far, and the cache that outlives the process.
pub(super) struct Pipelines {
    by_key: HashMap<PipelineKey, Rc<Pipeline>>,
    cache: Option<(wgpu::PipelineCache, CacheFile)>,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, cache_dir: &Path, cache_name: Option<&str>) -> Self {
        let cache = cache_name.map(|name| {
            let mut file = CacheFile::new(cache_dir, name);
            let data = file.load();
            let descriptor = wgpu::PipelineCacheDescriptor {
                label: None,
                data: data.as_deref(),
                fallback: true,
            };
            // SAFETY: the data is what wgpu gave on the same kind of device, a checksum before it;
            // wgpu checks the driver's version, and begins anew if it does not fit.
            let cache = unsafe { device.create_pipeline_cache(&descriptor) };
            (cache, file)
        });
        Self { by_key: HashMap::new(), cache }
    }

    /// The pipeline of this key, if it was compiled before.
    pub(super) fn known(&self, key: &PipelineKey) -> Option<Rc<Pipeline>> {
        self.by_key.get(key).cloned()
    }

    /// Keeps a pipeline that was compiled without an error.
    pub(super) fn keep(&mut self, key: PipelineKey, pipeline: Rc<Pipeline>) {
        self.by_key.insert(key, pipeline);
    }

    /// Stores the cache if it has grown.
    pub(super) fn store(&mut self) {
        if let Some((cache, file)) = &mut self.cache
            && let Some(data) = cache.get_data()
            && file.is_new(data.len())
        {
            file.store(&data);
        }
    }

    /// Compiles a pipeline. Errors go to the device's error handler.
    pub(super) fn compile(
        &self,
        device: &wgpu::Device,
        key: &PipelineKey,
        shader: &Shader,
        reflection: &Reflection,
    ) -> Pipeline {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(&shader.label),
            source: wgpu::ShaderSource::Wgsl(hoisted(&shader.wgsl)),
        };
        // SAFETY: the shaders are the project's own and end; the vulkan backend runs them without
        // checks too, so that both time the same work.
        let module = unsafe {
            let checks = wgpu::ShaderRuntimeChecks::unchecked();
            device.create_shader_module_trusted(descriptor, checks)
        };
        let kind = match key {
            PipelineKey::Compute { .. } => Kind::Compute,
            PipelineKey::Raster(_) => Kind::Raster,
        };
        let groups = group_layouts(device, reflection, kind);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups.iter().map(Option::as_ref).collect::<Vec<_>>(),
            immediate_size: 0,
        });
        let cache = self.cache.as_ref().map(|(cache, _)| cache);
        let raw = match key {
            PipelineKey::Compute { .. } => {
                Raw::Compute(device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(&shader.label),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some("main"),
                    compilation_options: options(),
                    cache,
                }))
            }
            PipelineKey::Raster(state) => {
                Raw::Raster(raster(device, shader, state, &module, &layout, cache))
            }
        };
        Pipeline { raw, groups }
    }
}

/// Workgroup memory is not zeroed, which would be timed.
fn options() -> wgpu::PipelineCompilationOptions<'static> {
    wgpu::PipelineCompilationOptions { zero_initialize_workgroup_memory: false, constants: &[] }
}

fn group_layouts(
    device: &wgpu::Device,
    reflection: &Reflection,
    kind: Kind,
) -> Vec<Option<wgpu::BindGroupLayout>> {
    let layout = |group| {
        let entries: Vec<_> = reflection
            .bindings_of(kind)
            .filter(|binding| binding.group == group)
            .map(|binding| {
                let mut visibility = ShaderStages::empty();
                if kind == Kind::Compute {
                    visibility = ShaderStages::COMPUTE;
                } else {
                    visibility.set(ShaderStages::VERTEX, binding.vertex);
                    visibility.set(ShaderStages::FRAGMENT, binding.fragment);
                }
                let buffer = |ty| wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                };
                let ty = match binding.access {
                    Access::Uniform => buffer(wgpu::BufferBindingType::Uniform),
                    Access::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                    Access::ReadWrite => {
                        buffer(wgpu::BufferBindingType::Storage { read_only: false })
                    }
                    // Without a sampler nothing is filtered, and 32-bit floats could not be.
                    access @ (Access::Texture | Access::UintTexture) => {
                        wgpu::BindingType::Texture {
                            sample_type: match access {
                                Access::UintTexture => wgpu::TextureSampleType::Uint,
                                _ => wgpu::TextureSampleType::Float { filterable: false },
                            },
                            view_dimension: wgpu::TextureViewDimension::D2,
                            multisampled: false,
                        }
                    }
                };
                wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None }
            })
            .collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
        (!entries.is_empty()).then(|| device.create_bind_group_layout(&descriptor))
    };
    (0..reflection.groups(kind)).map(layout).collect()
}

fn raster(
    device: &wgpu::Device,
    shader: &Shader,
    key: &RasterKey,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    cache: Option<&wgpu::PipelineCache>,
) -> wgpu::RenderPipeline {
    let attributes: Vec<_> = key
        .layout
        .iter()
        .flat_map(|layout| &layout.attributes)
        .map(|attribute| wgpu::VertexAttribute {
            format: formats::vertex(attribute.format),
            offset: u64::from(attribute.offset_bytes),
            shader_location: attribute.location,
        })
        .collect();
    let buffers: Vec<_> = key
        .layout
        .iter()
        .map(|layout| {
            Some(wgpu::VertexBufferLayout {
                array_stride: u64::from(layout.stride_bytes),
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })
        })
        .collect();
    let targets: Vec<_> = key
        .color
        .iter()
        .map(|color| {
            let all = wgpu::ColorWrites::ALL;
            Some(wgpu::ColorTargetState {
                format: formats::format(color.format),
                blend: color.blend.map(formats::blend),
                write_mask: if color.write { all } else { wgpu::ColorWrites::empty() },
            })
        })
        .collect();
    let depth = key.depth.as_ref().map(|depth| wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(depth.write),
        depth_compare: Some(formats::compare(depth.compare)),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    });
    let stencil = key.stencil.as_ref().map(|stencil| {
        let face = wgpu::StencilFaceState {
            compare: formats::compare(stencil.compare),
            fail_op: formats::stencil_op(stencil.fail),
            depth_fail_op: wgpu::StencilOperation::Keep,
            pass_op: formats::stencil_op(stencil.pass),
        };
        wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Stencil8,
            depth_write_enabled: None,
            depth_compare: None,
            stencil: wgpu::StencilState {
                front: face,
                back: face,
                read_mask: 0xFF,
                write_mask: 0xFF,
            },
            bias: wgpu::DepthBiasState::default(),
        }
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(&shader.label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vs"),
            compilation_options: options(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            unclipped_depth: key.unclipped,
            ..wgpu::PrimitiveState::default()
        },
        // A plan's format has either depth or stencil.
        depth_stencil: depth.or(stencil),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("fs"),
            compilation_options: options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache,
    })
}
