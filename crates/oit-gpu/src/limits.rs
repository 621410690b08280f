//! What a device can do, and whether that is enough for a plan.

use crate::features::Features;
use crate::glsl::Stage;
use crate::reflect::{Access, Binding, Kind, Reflection};
use crate::{
    ColorAttachment, Dispatch, Draw, Format, GpuError, Plan, PreRaster, Raster, Topology, Work,
};
use std::sync::Arc;

/// What a device can do, in the terms of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// The device's name, for messages.
    pub(crate) device: String,
    pub(crate) buffer_bytes: u64,
    pub(crate) storage_binding_bytes: u64,
    pub(crate) uniform_binding_bytes: u64,
    pub(crate) storage_bindings_per_stage: u32,
    pub(crate) uniform_bindings_per_stage: u32,
    pub(crate) textures_per_stage: u32,
    pub(crate) groups: u32,
    pub(crate) workgroups: [u32; 3],
    pub(crate) workgroup_size: [u32; 3],
    pub(crate) workgroup_invocations: u32,
    pub(crate) workgroup_bytes: u64,
    /// Bytes of the arrays that a function keeps, where that is known beforehand.
    pub(crate) function_array_bytes: u64,
    pub(crate) target_px: u32,
    pub(crate) color_attachments: u32,
    /// Bytes of a pixel in all colour targets of a pass, as [`render_bytes`] adds them up.
    pub(crate) color_bytes: u32,
    /// Draws of one indirect command.
    pub(crate) indirect_draws: u32,
    /// The kinds of stages in GLSL.
    pub(crate) stages: StageLimits,
    /// Whether an indirect draw can have a first instance.
    pub(crate) first_instance: bool,
    /// Formats that can be drawn to.
    pub(crate) drawable: Vec<Format>,
    /// Formats that can be blended into.
    pub(crate) blendable: Vec<Format>,
    pub(crate) fragment_writes: bool,
    pub(crate) vertex_writes: bool,
    /// Whether primitives can be drawn without clipping at the near and far planes.
    pub(crate) unclipped: bool,
    /// Whether the targets of a pass can be blended in unlike ways.
    pub(crate) independent_blend: bool,
    /// What its shaders may use beyond WGSL's core.
    pub(crate) features: Features,
    /// The fewest and the most invocations of a subgroup.
    pub(crate) subgroup_size: (u32, u32),
    /// Whether a compute pipeline can have any size of subgroup between these.
    pub(crate) chooses_subgroup_size: bool,
}

/// What of the stages in GLSL a device has.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct StageLimits {
    /// Whether the backend takes GLSL at all.
    pub(crate) glsl: bool,
    pub(crate) geometry: bool,
    pub(crate) tessellation: bool,
    /// Vertices of a patch.
    pub(crate) patch_vertices: u32,
    /// Whether tessellation and geometry stages can set the size of points.
    pub(crate) point_size: bool,
    pub(crate) mesh: bool,
    pub(crate) task: bool,
    /// Workgroups of a mesh draw: of a side, and in all.
    pub(crate) mesh_workgroups: [u32; 3],
    pub(crate) mesh_workgroups_total: u32,
}

impl Limits {
    /// Whether the device can run a plan that [`crate::check`] found sound.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] with the numbers.
    pub(crate) fn check(
        &self,
        plan: &Plan,
        reflections: &[Option<Arc<Reflection>>],
    ) -> Result<(), GpuError> {
        let unsupported = GpuError::Unsupported;
        for buffer in &plan.buffers {
            let what = || format!("buffer {:?}", buffer.name);
            within(what, buffer.allocated_bytes(), self.buffer_bytes, "bytes of a buffer")
                .map_err(unsupported)?;
        }
        for target in &plan.targets {
            let what = || format!("target {:?}", target.name);
            for side in [target.width, target.height] {
                within(what, side, self.target_px, "pixels of a side").map_err(unsupported)?;
            }
            if !self.drawable.contains(&target.format) {
                let format = target.format;
                return Err(unsupported(format!("{}: {format:?} cannot be drawn to", what())));
            }
        }
        for (pass, reflection) in plan.passes.iter().zip(reflections) {
            let Some(reflection) = reflection else { continue };
            self.shader(plan, reflection, Kind::of(&pass.work))
                .and_then(|()| self.work(&pass.work, reflection, plan))
                .map_err(|what| unsupported(format!("pass {:?}: {what}", pass.label)))?;
        }
        Ok(())
    }

    fn shader(&self, plan: &Plan, reflection: &Reflection, kind: Kind) -> Result<(), String> {
        self.features
            .suffice(&reflection.module)
            .map_err(|lacking| format!("{} has no {lacking}", self.device))?;
        for binding in reflection.bindings_of(kind) {
            if binding.access.is_target() {
                continue;
            }
            let bytes = plan.buffer(&binding.name).map_or(0, crate::Buffer::allocated_bytes);
            let (limit, unit) = match binding.access {
                Access::Uniform => (self.uniform_binding_bytes, "bytes of a uniform binding"),
                _ => (self.storage_binding_bytes, "bytes of a storage binding"),
            };
            within(|| format!("buffer {:?}", binding.name), bytes, limit, unit)?;
        }
        let in_stage: [fn(&Binding) -> bool; 3] = [|b| b.compute, |b| b.vertex, |b| b.fragment];
        for used in in_stage {
            let count = |is: fn(Access) -> bool| {
                let bindings = reflection.bindings_of(kind);
                bindings.filter(|binding| used(binding) && is(binding.access)).count() as u32
            };
            let uniform = count(|access| access == Access::Uniform);
            let storage = count(|access| matches!(access, Access::Read | Access::ReadWrite));
            let textures = count(Access::is_target);
            let what = || "the shader".to_owned();
            within(what, uniform, self.uniform_bindings_per_stage, "uniform buffers of a stage")?;
            within(what, storage, self.storage_bindings_per_stage, "storage buffers of a stage")?;
            within(what, textures, self.textures_per_stage, "textures of a stage")?;
        }
        let (arrays, limit) = (reflection.function_array_bytes(), self.function_array_bytes);
        within(|| "a function".to_owned(), arrays, limit, "bytes of arrays")?;
        within(|| "the shader".to_owned(), reflection.groups(kind), self.groups, "bind groups")
    }

    /// Whether the device has the stages of a raster pass.
    fn stages(&self, raster: &Raster, reflection: &Reflection) -> Result<(), String> {
        let device = &self.device;
        for compiled in &reflection.stages {
            let has = match compiled.stage {
                Stage::Vertex => true,
                Stage::TessellationControl | Stage::TessellationEvaluation => {
                    self.stages.tessellation
                }
                Stage::Geometry => self.stages.geometry,
                Stage::Task => self.stages.task,
                Stage::Mesh => self.stages.mesh,
            };
            if !self.stages.glsl {
                return Err("this backend takes no stages in GLSL".to_owned());
            }
            if !has {
                return Err(format!("{device} has no {} stage", compiled.stage.name()));
            }
            if compiled.sizes_points && !self.stages.point_size {
                let stage = compiled.stage.name();
                return Err(format!("{device} sets no size of points in the {stage} stage"));
            }
        }
        if let PreRaster::Glsl(glsl) = &raster.pre_raster
            && let Topology::Patches(vertices) = glsl.topology
        {
            let limit = self.stages.patch_vertices;
            within(|| "it".to_owned(), vertices, limit, "vertices of a patch")?;
        }
        if let Draw::MeshIndirect { at_most, .. } = raster.draw {
            let what = || "the mesh draw".to_owned();
            for (side, limit) in at_most.into_iter().zip(self.stages.mesh_workgroups) {
                within(what, side, limit, "workgroups of a side")?;
            }
            let all = at_most.into_iter().map(u64::from).fold(1, u64::saturating_mul);
            within(what, all, u64::from(self.stages.mesh_workgroups_total), "workgroups")?;
        }
        Ok(())
    }

    /// Whether subgroups of a compute shader can be sure to have so many invocations.
    fn subgroup(&self, at_least: u32) -> Result<(), String> {
        let (min, max) = self.subgroup_size;
        if at_least <= min || (at_least <= max && self.chooses_subgroup_size) {
            return Ok(());
        }
        let device = &self.device;
        Err(match min == max {
            true => format!("subgroups of {at_least} are needed, and {device} has them of {min}"),
            false => format!(
                "subgroups of {at_least} are needed, and {device} has them of {min} to {max}, as \
                 its driver chooses"
            ),
        })
    }

    fn work(&self, work: &Work, reflection: &Reflection, plan: &Plan) -> Result<(), String> {
        match work {
            Work::Clear { .. } => Ok(()),
            Work::Compute { dispatch, .. } => {
                if let Some(main) = &reflection.main {
                    let size = main.workgroup_size;
                    let what = || format!("a workgroup of {} x {} x {}", size[0], size[1], size[2]);
                    for (side, limit) in size.into_iter().zip(self.workgroup_size) {
                        within(what, side, limit, "invocations of a side")?;
                    }
                    let invocations = size.into_iter().map(u64::from).product::<u64>();
                    within(
                        what,
                        invocations,
                        u64::from(self.workgroup_invocations),
                        "invocations",
                    )?;
                    let unit = "bytes of workgroup memory";
                    within(what, main.workgroup_bytes, self.workgroup_bytes, unit)?;
                    if let Some(at_least) = main.subgroup_at_least {
                        self.subgroup(at_least)?;
                    }
                }
                if let Dispatch::Workgroups(count) = dispatch {
                    for (side, limit) in count.iter().zip(self.workgroups) {
                        within(|| "the dispatch".to_owned(), *side, limit, "workgroups of a side")?;
                    }
                }
                Ok(())
            }
            Work::Raster(raster) => {
                // A declaration is enough: a driver without the feature refuses it.
                let mut writable = reflection
                    .bindings_of(Kind::Raster)
                    .filter(|binding| binding.access == Access::ReadWrite);
                if writable.clone().any(|binding| binding.fragment) && !self.fragment_writes {
                    return Err("fragment shaders cannot write buffers".to_owned());
                }
                if writable.any(|binding| binding.vertex) && !self.vertex_writes {
                    return Err("vertex shaders cannot write buffers".to_owned());
                }
                self.stages(raster, reflection)?;
                if raster.unclipped && !self.unclipped {
                    return Err(format!("{} has no unclipped depth", self.device));
                }
                let count = raster.color.len() as u32;
                within(|| "it".to_owned(), count, self.color_attachments, "colour targets")?;
                let formats = raster.color.iter().filter_map(|color| plan.target(&color.target));
                let bytes = render_bytes(formats.map(|target| target.format));
                let unit = "bytes of a pixel in its colour targets";
                within(|| "it".to_owned(), bytes, self.color_bytes, unit)?;
                if let Draw::VerticesIndirect { draws: draws @ 2.., .. } = raster.draw {
                    let what = || "it".to_owned();
                    within(what, draws, self.indirect_draws, "draws of an indirect command")?;
                    if !self.first_instance {
                        let device = &self.device;
                        return Err(format!("{device} has no first instance of indirect draws"));
                    }
                }
                let state = |color: &ColorAttachment| (color.blend, color.write);
                let unlike = raster.color.windows(2).any(|two| state(&two[0]) != state(&two[1]));
                if unlike && !self.independent_blend {
                    let device = &self.device;
                    return Err(format!("{device} blends all targets of a pass alike"));
                }
                for color in raster.color.iter().filter(|color| color.blend.is_some()) {
                    let format = plan.target(&color.target).map(|target| target.format);
                    if let Some(format) = format.filter(|format| !self.blendable.contains(format)) {
                        let target = &color.target;
                        return Err(format!(
                            "target {target:?}: {} cannot blend into {format:?}",
                            self.device
                        ));
                    }
                }
                Ok(())
            }
        }
    }
}

/// Bytes of a pixel in targets of these formats as WebGPU adds them up (section "Render target
/// formats", `calculateColorAttachmentBytesPerSample`): in order, each aligned to its channels, and
/// some of 4 bytes counted as 8.
fn render_bytes(formats: impl Iterator<Item = Format>) -> u32 {
    formats.fold(0_u32, |sum, format| {
        let (bytes, align) = match format {
            Format::Rgba8Unorm => (8, 1),
            Format::R8Unorm | Format::Stencil8 => (1, 1),
            Format::Rgba16Float => (8, 2),
            Format::Rg16Float => (4, 2),
            Format::R16Float => (2, 2),
            Format::Rg11b10Float | Format::Rg32Float => (8, 4),
            Format::Rgba32Float | Format::Rgba32Uint => (16, 4),
            Format::R32Float | Format::R32Uint | Format::Depth32Float => (4, 4),
        };
        sum.next_multiple_of(align) + bytes
    })
}

/// Whether a number is within a limit, in words if not.
fn within<T: PartialOrd + std::fmt::Display>(
    what: impl Fn() -> String,
    number: T,
    limit: T,
    unit: &str,
) -> Result<(), String> {
    if number <= limit {
        return Ok(());
    }
    Err(format!("{} needs {number} {unit}, and this device has {limit}", what()))
}

/// An error and all that caused it, in one line.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text = format!("{text}: {error}");
        source = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_a_pixel_add_up_as_in_webgpu() {
        let sum = |formats: &[Format]| render_bytes(formats.iter().copied());

        assert_eq!(sum(&[Format::Rgba8Unorm; 4]), 32);
        assert_eq!(sum(&[Format::Rgba32Float; 4]), 64);
        let packed = [Format::R8Unorm, Format::R32Float, Format::R8Unorm, Format::Rg16Float];
        // 1, then 4 from byte 4, 1 at byte 8, 4 from byte 10.
        assert_eq!(sum(&packed), 14);
        let mixed = [
            Format::Rgba32Float,
            Format::Rgba16Float,
            Format::Rgba8Unorm,
            Format::R32Float,
            Format::Rg16Float,
            Format::R32Uint,
            Format::Rgba32Uint,
            Format::R32Float,
        ];
        assert_eq!(sum(&mixed), 64);
    }
}
