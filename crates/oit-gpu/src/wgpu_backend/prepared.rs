//! A plan made ready: its resources and bind groups, encoded anew at every run.

use super::formats;
use super::pipeline::{Pipeline, Raw};
use crate::reflect::{Access, Kind, Reflection};
use crate::timing::Stages;
use crate::{Contents, Dispatch, Draw, Load, Pass, Plan, Raster, Target, Work};
use std::rc::Rc;
use std::sync::Arc;

/// A plan made ready.
pub(super) struct Prepared {
    pub(super) plan: Plan,
    pub(super) buffers: Vec<wgpu::Buffer>,
    pub(super) targets: Vec<wgpu::Texture>,
    views: Vec<wgpu::TextureView>,
    passes: Vec<Option<Bound>>,
    pub(super) stages: Stages,
    pub(super) stamps: Option<Stamps>,
}

/// What is counted of a raster pass, in this order.
pub(super) const COUNTED: wgpu::PipelineStatisticsTypes =
    wgpu::PipelineStatisticsTypes::VERTEX_SHADER_INVOCATIONS
        .union(wgpu::PipelineStatisticsTypes::CLIPPER_INVOCATIONS)
        .union(wgpu::PipelineStatisticsTypes::CLIPPER_PRIMITIVES_OUT)
        .union(wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS);

/// A pass's pipeline, and its bind groups with their indices.
struct Bound {
    pipeline: Rc<Pipeline>,
    groups: Vec<(u32, wgpu::BindGroup)>,
}

/// Timestamps and the buffers in which they come back.
pub(super) struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) readable: wgpu::Buffer,
}

impl Stamps {
    fn new(device: &wgpu::Device, count: u32) -> Self {
        let size = u64::from(count) * u64::from(wgpu::QUERY_SIZE);
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
        }
    }
}

/// All of a buffer, and no more: without a size wgpu binds the spare bytes that it puts behind
/// buffers of vertices, and shaders take an array's length from the binding.
fn exactly(buffer: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    let size = std::num::NonZeroU64::new(buffer.size());
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
}

impl Prepared {
    /// Makes bind groups and timestamps. Errors go to the device's error handler.
    pub(super) fn new(
        device: &wgpu::Device,
        plan: &Plan,
        reflections: &[Option<Arc<Reflection>>],
        pipelines: Vec<Option<Rc<Pipeline>>>,
        buffers: Vec<wgpu::Buffer>,
        targets: Vec<wgpu::Texture>,
        has_timestamps: bool,
    ) -> Self {
        // The host has no further use for the data, and the device holds it.
        let mut kept = plan.clone();
        for buffer in &mut kept.buffers {
            if let Contents::Data(data) = &mut buffer.contents {
                *data = Arc::new([]);
            }
        }
        let stages = Stages::new(plan);
        let stamps = has_timestamps.then(|| Stamps::new(device, stages.stamps()));
        let views = targets.iter().map(|texture| texture.create_view(&Default::default()));
        let mut prepared = Self {
            views: views.collect(),
            plan: kept,
            buffers,
            targets,
            passes: Vec::new(),
            stages,
            stamps,
        };
        prepared.passes = pipelines
            .into_iter()
            .zip(reflections)
            .zip(&plan.passes)
            .map(|((pipeline, reflection), pass)| {
                let (pipeline, reflection) = (pipeline?, reflection.as_ref()?);
                let groups = prepared.groups(device, &pipeline, reflection, pass);
                Some(Bound { pipeline, groups })
            })
            .collect();
        prepared
    }

    /// The buffer of this name; the plan was checked, so every name it uses has one.
    pub(super) fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        let index = self.plan.buffers.iter().position(|buffer| buffer.name == name)?;
        self.buffers.get(index)
    }

    fn view(&self, name: &str) -> Option<&wgpu::TextureView> {
        let index = self.plan.targets.iter().position(|target: &Target| target.name == name)?;
        self.views.get(index)
    }

    /// Whether the target of this name is of integers.
    fn is_uint(&self, name: &str) -> bool {
        self.plan.target(name).is_some_and(|target| target.format.is_uint())
    }

    fn groups(
        &self,
        device: &wgpu::Device,
        pipeline: &Pipeline,
        reflection: &Reflection,
        pass: &Pass,
    ) -> Vec<(u32, wgpu::BindGroup)> {
        let kind = Kind::of(&pass.work);
        let group = |(index, layout): (u32, &Option<wgpu::BindGroupLayout>)| {
            let bindings = reflection.bindings_of(kind).filter(|binding| binding.group == index);
            let entries: Vec<_> = bindings
                .filter_map(|binding| {
                    let resource = match binding.access {
                        Access::Texture | Access::UintTexture => {
                            wgpu::BindingResource::TextureView(self.view(&binding.name)?)
                        }
                        _ => exactly(self.buffer(&binding.name)?),
                    };
                    Some(wgpu::BindGroupEntry { binding: binding.binding, resource })
                })
                .collect();
            let layout = layout.as_ref()?;
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
            Some((index, device.create_bind_group(&descriptor)))
        };
        (0..).zip(&pipeline.groups).filter_map(group).collect()
    }

    /// Encodes the plan, its timestamps and their way back.
    pub(super) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let stamp = |encoder: &mut wgpu::CommandEncoder, index| {
            if let Some(stamps) = &self.stamps {
                encoder.write_timestamp(&stamps.queries, index);
            }
        };
        stamp(encoder, 0);
        for (run, passes) in (1..).zip(&self.stages.runs) {
            for index in passes.clone() {
                self.encode_pass(encoder, index, None);
            }
            stamp(encoder, run);
        }
        if let Some(Stamps { queries, resolved, readable }) = &self.stamps {
            encoder.resolve_query_set(queries, 0..self.stages.stamps(), resolved, 0);
            encoder.copy_buffer_to_buffer(resolved, 0, readable, 0, readable.size());
        }
    }

    /// The raster passes, as indices into the plan's.
    pub(super) fn raster_passes(&self) -> impl Iterator<Item = usize> {
        let raster = |work: &Work| matches!(work, Work::Raster(_));
        let passes = self.plan.passes.iter().enumerate();
        passes.filter(move |(_, pass)| raster(&pass.work)).map(|(index, _)| index)
    }

    /// Encodes the plan without timestamps, and what each raster pass counts: [`COUNTED`], raster
    /// pass by raster pass, in the buffer given back.
    pub(super) fn encode_counting(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
    ) -> wgpu::Buffer {
        let count = self.raster_passes().count() as u32;
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::PipelineStatistics(COUNTED),
            count: count.max(1),
        });
        let size = u64::from(count.max(1))
            * u64::from(COUNTED.bits().count_ones())
            * u64::from(wgpu::QUERY_SIZE);
        let buffer = |usage| {
            let mapped_at_creation = false;
            let label = None;
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        let mut query = 0;
        for index in 0..self.plan.passes.len() {
            self.encode_pass(encoder, index, Some((&queries, query)));
            query += u32::from(matches!(self.plan.passes[index].work, Work::Raster(_)));
        }
        if count > 0 {
            encoder.resolve_query_set(&queries, 0..count, &resolved, 0);
            encoder.copy_buffer_to_buffer(&resolved, 0, &readable, 0, size);
        }
        readable
    }

    fn encode_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        index: usize,
        counts: Option<(&wgpu::QuerySet, u32)>,
    ) {
        match (&self.plan.passes[index].work, &self.passes[index]) {
            (Work::Clear { buffer }, _) => {
                if let Some(buffer) = self.buffer(buffer) {
                    encoder.clear_buffer(buffer, 0, None);
                }
            }
            (Work::Compute { dispatch, .. }, Some(Bound { pipeline, groups })) => {
                let Raw::Compute(pipeline) = &pipeline.raw else { return };
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(pipeline);
                for (index, group) in groups {
                    pass.set_bind_group(*index, group, &[]);
                }
                match dispatch {
                    Dispatch::Workgroups([x, y, z]) => pass.dispatch_workgroups(*x, *y, *z),
                    Dispatch::Indirect { buffer, offset_bytes } => {
                        if let Some(buffer) = self.buffer(buffer) {
                            pass.dispatch_workgroups_indirect(buffer, *offset_bytes);
                        }
                    }
                }
            }
            (Work::Raster(raster), Some(bound)) => {
                self.encode_raster(encoder, raster, bound, counts);
            }
            _ => {}
        }
    }

    fn encode_raster(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        raster: &Raster,
        bound: &Bound,
        counts: Option<(&wgpu::QuerySet, u32)>,
    ) {
        let Raw::Raster(pipeline) = &bound.pipeline.raw else { return };
        let store = wgpu::StoreOp::Store;
        let colors: Vec<_> = raster
            .color
            .iter()
            .map(|color| {
                let load = match color.load {
                    Load::Clear([r, g, b, a]) => {
                        // In a target of integers infinity stands for the largest.
                        let largest = f64::from(u32::MAX);
                        let finite = |value: f32| match self.is_uint(&color.target) {
                            true => f64::from(value).min(largest),
                            false => f64::from(value),
                        };
                        let [r, g, b, a] = [r, g, b, a].map(finite);
                        wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a })
                    }
                    Load::Keep => wgpu::LoadOp::Load,
                };
                Some(wgpu::RenderPassColorAttachment {
                    view: self.view(&color.target)?,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store },
                })
            })
            .collect();
        let attachment = raster.depth_stencil.as_ref();
        let depth_stencil_attachment = attachment.and_then(|attachment| {
            Some(wgpu::RenderPassDepthStencilAttachment {
                view: self.view(&attachment.target)?,
                depth_ops: attachment.depth.map(|depth| {
                    let load = match depth.load {
                        Load::Clear(value) => wgpu::LoadOp::Clear(value),
                        Load::Keep => wgpu::LoadOp::Load,
                    };
                    wgpu::Operations { load, store }
                }),
                stencil_ops: attachment.stencil.map(|stencil| {
                    let load = match stencil.clear {
                        Some(value) => wgpu::LoadOp::Clear(u32::from(value)),
                        None => wgpu::LoadOp::Load,
                    };
                    wgpu::Operations { load, store }
                }),
            })
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &colors,
            depth_stencil_attachment,
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        for (index, group) in &bound.groups {
            pass.set_bind_group(*index, group, &[]);
        }
        if let Some(stencil) = attachment.and_then(|attachment| attachment.stencil) {
            pass.set_stencil_reference(u32::from(stencil.reference));
        }
        if let Some((queries, query)) = counts {
            pass.begin_pipeline_statistics_query(queries, query);
        }
        match &raster.draw {
            Draw::Vertices { count, instances } => pass.draw(0..*count, 0..*instances),
            Draw::Indexed { vertices, indices, count, .. } => {
                if let (Some(vertices), Some(indices)) =
                    (self.buffer(vertices), self.buffer(indices))
                {
                    pass.set_vertex_buffer(0, vertices.slice(..));
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..*count, 0, 0..1);
                }
            }
            Draw::VerticesIndirect { arguments, offset_bytes, draws } => {
                if let Some(arguments) = self.buffer(arguments) {
                    pass.multi_draw_indirect(arguments, *offset_bytes, *draws);
                }
            }
            // Refused before: the backend has no stages in GLSL.
            Draw::MeshIndirect { .. } => {}
            Draw::IndexedIndirect { vertices, indices, arguments, offset_bytes, .. } => {
                if let (Some(vertices), Some(indices), Some(arguments)) =
                    (self.buffer(vertices), self.buffer(indices), self.buffer(arguments))
                {
                    pass.set_vertex_buffer(0, vertices.slice(..));
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed_indirect(arguments, *offset_bytes);
                }
            }
        }
        if counts.is_some() {
            pass.end_pipeline_statistics_query();
        }
    }

    /// Encodes the copy of a target to a buffer; the buffer and the bytes of a row in it.
    pub(super) fn encode_read(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        index: usize,
    ) -> (wgpu::Buffer, u32) {
        let target = &self.plan.targets[index];
        let row_bytes = target.width * target.format.bytes() as u32;
        let padded_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let readable = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(padded_bytes) * u64::from(target.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let from = wgpu::TexelCopyTextureInfo {
            texture: &self.targets[index],
            mip_level: 0,
            origin: wgpu::Origin3d::ZERO,
            aspect: formats::aspect(target.format),
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(padded_bytes),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &readable, layout };
        encoder.copy_texture_to_buffer(from, to, self.targets[index].size());
        (readable, padded_bytes)
    }
}
