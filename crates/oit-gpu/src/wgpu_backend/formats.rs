//! A plan's words in wgpu's.

use crate::{Blend, Compare, Format, StencilOp, VertexFormat};

pub(super) fn format(format: Format) -> wgpu::TextureFormat {
    match format {
        Format::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        Format::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
        Format::Rg32Float => wgpu::TextureFormat::Rg32Float,
        Format::Rg16Float => wgpu::TextureFormat::Rg16Float,
        Format::R32Float => wgpu::TextureFormat::R32Float,
        Format::R16Float => wgpu::TextureFormat::R16Float,
        Format::Rg11b10Float => wgpu::TextureFormat::Rg11b10Ufloat,
        Format::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        Format::R8Unorm => wgpu::TextureFormat::R8Unorm,
        Format::R32Uint => wgpu::TextureFormat::R32Uint,
        Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
        Format::Depth32Float => wgpu::TextureFormat::Depth32Float,
        Format::Stencil8 => wgpu::TextureFormat::Stencil8,
    }
}

/// The aspect that a plan means by this format.
pub(super) fn aspect(format: Format) -> wgpu::TextureAspect {
    match format {
        Format::Depth32Float => wgpu::TextureAspect::DepthOnly,
        Format::Stencil8 => wgpu::TextureAspect::StencilOnly,
        _ => wgpu::TextureAspect::All,
    }
}

pub(super) fn compare(compare: Compare) -> wgpu::CompareFunction {
    match compare {
        Compare::Always => wgpu::CompareFunction::Always,
        Compare::Equal => wgpu::CompareFunction::Equal,
        Compare::Less => wgpu::CompareFunction::Less,
        Compare::LessEqual => wgpu::CompareFunction::LessEqual,
        Compare::Greater => wgpu::CompareFunction::Greater,
        Compare::GreaterEqual => wgpu::CompareFunction::GreaterEqual,
    }
}

pub(super) fn stencil_op(op: StencilOp) -> wgpu::StencilOperation {
    match op {
        StencilOp::Keep => wgpu::StencilOperation::Keep,
        StencilOp::Zero => wgpu::StencilOperation::Zero,
        StencilOp::Replace => wgpu::StencilOperation::Replace,
        StencilOp::IncrementClamp => wgpu::StencilOperation::IncrementClamp,
    }
}

pub(super) fn vertex(format: VertexFormat) -> wgpu::VertexFormat {
    match format {
        VertexFormat::Float32x3 => wgpu::VertexFormat::Float32x3,
        VertexFormat::Unorm8x4 => wgpu::VertexFormat::Unorm8x4,
        VertexFormat::Uint32 => wgpu::VertexFormat::Uint32,
    }
}

pub(super) fn blend(blend: Blend) -> wgpu::BlendState {
    use wgpu::{BlendFactor, BlendOperation};
    let (operation, src_factor, dst_factor) = match blend {
        Blend::Add => (BlendOperation::Add, BlendFactor::One, BlendFactor::One),
        Blend::Max => (BlendOperation::Max, BlendFactor::One, BlendFactor::One),
        Blend::Min => (BlendOperation::Min, BlendFactor::One, BlendFactor::One),
        Blend::Over => (BlendOperation::Add, BlendFactor::One, BlendFactor::OneMinusSrcAlpha),
        Blend::Under => (BlendOperation::Add, BlendFactor::OneMinusDstAlpha, BlendFactor::One),
        Blend::Attenuate => (BlendOperation::Add, BlendFactor::Zero, BlendFactor::OneMinusSrc),
    };
    let component = wgpu::BlendComponent { src_factor, dst_factor, operation };
    wgpu::BlendState { color: component, alpha: component }
}
