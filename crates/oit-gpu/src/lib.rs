//! Plans (passes over named resources) and the backends that run one.

mod cache_file;
mod check;
mod device;
mod devices;
mod directives;
mod features;
mod glsl;
mod limits;
mod listing;
mod pipeline_key;
mod plan;
mod reflect;
mod shared;
mod spirv;
mod timing;
mod vulkan;
mod wgpu_backend;

pub use device::{Compiled, Device, GpuError, Part, PassStatistics, PlanId, Timing};
pub use devices::{Listed, enumerate, open};
pub use oit_record::DeviceInfo;
pub use plan::{
    Blend, Buffer, ColorAttachment, Compare, Contents, Depth, DepthStencil, Dispatch, Draw, Format,
    Glsl, Load, Mesh, Pass, Plan, PreRaster, Raster, Shader, Stencil, StencilOp, Target,
    Tessellation, Topology, VertexAttribute, VertexFormat, VertexLayout, Work,
};
pub use reflect::{Access, Binding, DepthBound, Fs, Main, Reflection, Vs};
pub use shared::{Handle, SharedBuffer};
pub use vulkan::Vulkan;
pub use wgpu_backend::Wgpu;
