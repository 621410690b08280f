//! A plan's words in Vulkan's.

use crate::glsl::Stage;
use crate::{Blend, Compare, Format, StencilOp, VertexFormat};
use ash::vk;

/// What a device may have for [`Format::Stencil8`], best first; one of the last two is always there.
pub(super) const STENCIL: [vk::Format; 3] =
    [vk::Format::S8_UINT, vk::Format::D24_UNORM_S8_UINT, vk::Format::D32_SFLOAT_S8_UINT];

/// A target's format, where stencil is this format.
pub(super) fn format(format: Format, stencil: vk::Format) -> vk::Format {
    match format {
        Format::Rgba32Float => vk::Format::R32G32B32A32_SFLOAT,
        Format::Rgba16Float => vk::Format::R16G16B16A16_SFLOAT,
        Format::Rg32Float => vk::Format::R32G32_SFLOAT,
        Format::Rg16Float => vk::Format::R16G16_SFLOAT,
        Format::R32Float => vk::Format::R32_SFLOAT,
        Format::R16Float => vk::Format::R16_SFLOAT,
        Format::Rg11b10Float => vk::Format::B10G11R11_UFLOAT_PACK32,
        Format::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
        Format::R8Unorm => vk::Format::R8_UNORM,
        Format::R32Uint => vk::Format::R32_UINT,
        Format::Rgba32Uint => vk::Format::R32G32B32A32_UINT,
        Format::Depth32Float => vk::Format::D32_SFLOAT,
        Format::Stencil8 => stencil,
    }
}

/// The flag of a stage in GLSL.
pub(super) fn stage(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::TessellationControl => vk::ShaderStageFlags::TESSELLATION_CONTROL,
        Stage::TessellationEvaluation => vk::ShaderStageFlags::TESSELLATION_EVALUATION,
        Stage::Geometry => vk::ShaderStageFlags::GEOMETRY,
        Stage::Task => vk::ShaderStageFlags::TASK_EXT,
        Stage::Mesh => vk::ShaderStageFlags::MESH_EXT,
    }
}

/// All aspects of an image of this format.
pub(super) fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
        vk::Format::S8_UINT => vk::ImageAspectFlags::STENCIL,
        vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT => {
            vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
        }
        _ => vk::ImageAspectFlags::COLOR,
    }
}

/// The aspect that a plan means by this format.
pub(super) fn aspect(format: Format) -> vk::ImageAspectFlags {
    match format {
        Format::Depth32Float => vk::ImageAspectFlags::DEPTH,
        Format::Stencil8 => vk::ImageAspectFlags::STENCIL,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

/// The layout in which a target stays between passes. Passes that read it have it in
/// [`READ_LAYOUT`].
pub(super) fn layout(format: Format) -> vk::ImageLayout {
    match format.is_color() {
        true => vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        false => vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    }
}

/// The layout in which shaders read a target.
pub(super) const READ_LAYOUT: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

pub(super) fn compare(compare: Compare) -> vk::CompareOp {
    match compare {
        Compare::Always => vk::CompareOp::ALWAYS,
        Compare::Equal => vk::CompareOp::EQUAL,
        Compare::Less => vk::CompareOp::LESS,
        Compare::LessEqual => vk::CompareOp::LESS_OR_EQUAL,
        Compare::Greater => vk::CompareOp::GREATER,
        Compare::GreaterEqual => vk::CompareOp::GREATER_OR_EQUAL,
    }
}

pub(super) fn stencil_op(op: StencilOp) -> vk::StencilOp {
    match op {
        StencilOp::Keep => vk::StencilOp::KEEP,
        StencilOp::Zero => vk::StencilOp::ZERO,
        StencilOp::Replace => vk::StencilOp::REPLACE,
        StencilOp::IncrementClamp => vk::StencilOp::INCREMENT_AND_CLAMP,
    }
}

pub(super) fn vertex(format: VertexFormat) -> vk::Format {
    match format {
        VertexFormat::Float32x3 => vk::Format::R32G32B32_SFLOAT,
        VertexFormat::Unorm8x4 => vk::Format::R8G8B8A8_UNORM,
        VertexFormat::Uint32 => vk::Format::R32_UINT,
    }
}

pub(super) fn blend(blend: Option<Blend>, write: bool) -> vk::PipelineColorBlendAttachmentState {
    use vk::{BlendFactor, BlendOp};
    let mask = if write { vk::ColorComponentFlags::RGBA } else { vk::ColorComponentFlags::empty() };
    let state = vk::PipelineColorBlendAttachmentState::default().color_write_mask(mask);
    let (op, source, target) = match blend {
        None => return state,
        Some(Blend::Add) => (BlendOp::ADD, BlendFactor::ONE, BlendFactor::ONE),
        Some(Blend::Max) => (BlendOp::MAX, BlendFactor::ONE, BlendFactor::ONE),
        Some(Blend::Min) => (BlendOp::MIN, BlendFactor::ONE, BlendFactor::ONE),
        Some(Blend::Over) => (BlendOp::ADD, BlendFactor::ONE, BlendFactor::ONE_MINUS_SRC_ALPHA),
        Some(Blend::Under) => (BlendOp::ADD, BlendFactor::ONE_MINUS_DST_ALPHA, BlendFactor::ONE),
        Some(Blend::Attenuate) => {
            (BlendOp::ADD, BlendFactor::ZERO, BlendFactor::ONE_MINUS_SRC_COLOR)
        }
    };
    state
        .blend_enable(true)
        .color_blend_op(op)
        .alpha_blend_op(op)
        .src_color_blend_factor(source)
        .src_alpha_blend_factor(source)
        .dst_color_blend_factor(target)
        .dst_alpha_blend_factor(target)
}
