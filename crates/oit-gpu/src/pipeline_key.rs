//! All that makes a pipeline, and so the key under which it is kept.

use crate::{
    Blend, Compare, Depth, Format, Plan, PreRaster, Raster, Shader, Stencil, StencilOp,
    VertexLayout, Work,
};
use std::sync::Arc;

/// All that makes a pipeline. What is set while recording is left out: the values cleared to, the
/// stencil reference, the size of the targets.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum PipelineKey {
    Compute { wgsl: Arc<str> },
    Raster(RasterKey),
}

/// All that makes a raster pipeline.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct RasterKey {
    wgsl: Arc<str>,
    pub(crate) pre_raster: PreRaster,
    pub(crate) layout: Option<VertexLayout>,
    pub(crate) color: Vec<ColorKey>,
    pub(crate) depth: Option<DepthKey>,
    pub(crate) stencil: Option<StencilKey>,
    pub(crate) unclipped: bool,
}

/// What a pipeline knows of a colour target.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct ColorKey {
    pub(crate) format: Format,
    pub(crate) blend: Option<Blend>,
    pub(crate) write: bool,
}

/// What a pipeline knows of a depth test.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct DepthKey {
    pub(crate) compare: Compare,
    pub(crate) write: bool,
}

/// What a pipeline knows of a stencil test.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct StencilKey {
    pub(crate) compare: Compare,
    pub(crate) pass: StencilOp,
    pub(crate) fail: StencilOp,
}

impl PipelineKey {
    /// The key of a pass; a pass without a shader has none.
    pub(crate) fn of<'a>(plan: &Plan, work: &'a Work) -> Option<(Self, &'a Shader)> {
        match work {
            Work::Clear { .. } => None,
            Work::Compute { shader, .. } => {
                Some((Self::Compute { wgsl: shader.wgsl.clone() }, shader))
            }
            Work::Raster(raster) => {
                Some((Self::Raster(RasterKey::of(plan, raster)), &raster.shader))
            }
        }
    }
}

impl RasterKey {
    fn of(plan: &Plan, raster: &Raster) -> Self {
        let color = raster.color.iter().filter_map(|color| {
            let format = plan.target(&color.target)?.format;
            Some(ColorKey { format, blend: color.blend, write: color.write })
        });
        let layout = match &raster.draw {
            crate::Draw::Vertices { .. }
            | crate::Draw::VerticesIndirect { .. }
            | crate::Draw::MeshIndirect { .. } => None,
            crate::Draw::Indexed { layout, .. } | crate::Draw::IndexedIndirect { layout, .. } => {
                Some(layout.clone())
            }
        };
        let attachment = raster.depth_stencil.as_ref();
        let depth = attachment
            .and_then(|attachment| attachment.depth)
            .map(|Depth { compare, write, .. }| DepthKey { compare, write });
        let stencil = attachment
            .and_then(|attachment| attachment.stencil)
            .map(|Stencil { compare, pass, fail, .. }| StencilKey { compare, pass, fail });
        Self {
            wgsl: raster.shader.wgsl.clone(),
            pre_raster: raster.pre_raster.clone(),
            layout,
            color: color.collect(),
            depth,
            stencil,
            unclipped: raster.unclipped,
        }
    }
}
