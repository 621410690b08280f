//! A plan as text: what it allocates and what it does, in order.

use crate::reflect::{Access, Kind, Reflection, Shaders};
use crate::{
    ColorAttachment, Contents, DepthStencil, Dispatch, Draw, Load, Plan, PreRaster, Raster,
    Topology, Work, glsl,
};
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

/// Prints buffers, targets and passes, with what each pass reads and writes. The text is a function
/// of the plan alone; the shaders' sources are left out.
impl Display for Plan {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "plan {}", self.name)?;
        writeln!(f, "buffers")?;
        for buffer in &self.buffers {
            let given = if matches!(buffer.contents, Contents::Data(_)) { ", given" } else { "" };
            writeln!(f, "  {}: {} bytes{given}", buffer.name, buffer.bytes)?;
        }
        if !self.targets.is_empty() {
            writeln!(f, "targets")?;
        }
        for target in &self.targets {
            let (name, format) = (&target.name, target.format);
            writeln!(f, "  {name}: {format:?} {}x{}", target.width, target.height)?;
        }
        writeln!(f, "passes")?;
        let mut shaders = Shaders::default();
        for pass in &self.passes {
            writeln!(f, "  [{}] {}", pass.stage, pass.label)?;
            match &pass.work {
                Work::Clear { buffer } => writeln!(f, "    writes {buffer}")?,
                Work::Compute { shader, dispatch } => {
                    match dispatch {
                        Dispatch::Workgroups([x, y, z]) => {
                            writeln!(f, "    workgroups {x} x {y} x {z}")?;
                        }
                        Dispatch::Indirect { buffer, offset_bytes } => {
                            writeln!(f, "    workgroups from {buffer} at byte {offset_bytes}")?;
                        }
                    }
                    write_access(f, shaders.get(shader), shader, Kind::Compute)?;
                }
                Work::Raster(raster) => {
                    write_raster(f, raster)?;
                    let reflection = shaders.of_raster(raster);
                    write_access(f, reflection, &raster.shader, Kind::Raster)?;
                }
            }
        }
        Ok(())
    }
}

fn write_access(
    f: &mut Formatter<'_>,
    reflection: Result<Arc<Reflection>, String>,
    shader: &crate::Shader,
    kind: Kind,
) -> fmt::Result {
    let Ok(reflection) = reflection else {
        return writeln!(f, "    shader {:?} does not compile", shader.label);
    };
    if let (Kind::Raster, Some(fs)) = (kind, reflection.fs.as_ref().filter(|fs| fs.writes_depth)) {
        let bound = fs.depth_bound.map_or_else(String::new, |bound| format!(", {}", bound.wgsl()));
        writeln!(f, "    depth of the shader{bound}")?;
    }
    if let (Kind::Compute, Some(main)) = (kind, &reflection.main) {
        let [x, y, z] = main.workgroup_size;
        writeln!(f, "    workgroup size {x} x {y} x {z}")?;
    }
    for (verb, writes) in [("reads", false), ("writes", true)] {
        let names: Vec<&str> = reflection
            .bindings_of(kind)
            .filter(|binding| (binding.access == Access::ReadWrite) == writes)
            .map(|binding| binding.name.as_str())
            .collect();
        if !names.is_empty() {
            writeln!(f, "    {verb} {}", names.join(", "))?;
        }
    }
    Ok(())
}

fn write_raster(f: &mut Formatter<'_>, raster: &Raster) -> fmt::Result {
    match &raster.draw {
        Draw::Vertices { count, instances } => {
            writeln!(f, "    draws {count} vertices, {instances} instances")?;
        }
        Draw::Indexed { vertices, indices, count, .. } => {
            writeln!(f, "    draws {count} indices of {indices} into {vertices}")?;
        }
        Draw::VerticesIndirect { arguments, offset_bytes, draws: 1 } => {
            writeln!(f, "    draws vertices from {arguments} at byte {offset_bytes}")?;
        }
        Draw::VerticesIndirect { arguments, offset_bytes, draws } => {
            writeln!(
                f,
                "    draws vertices {draws} times, from {arguments} at byte {offset_bytes} on"
            )?;
        }
        Draw::MeshIndirect { arguments, offset_bytes, at_most: [x, y, z] } => {
            writeln!(
                f,
                "    mesh workgroups from {arguments} at byte {offset_bytes}, at most {x} x {y} x {z}"
            )?;
        }
        Draw::IndexedIndirect { vertices, indices, arguments, offset_bytes, .. } => {
            writeln!(
                f,
                "    draws indices of {indices} into {vertices} from {arguments} at byte {offset_bytes}"
            )?;
        }
    }
    let stages = glsl::stages(&raster.pre_raster);
    if !stages.is_empty() {
        let names: Vec<&str> = stages.iter().map(|(stage, _)| stage.name()).collect();
        write!(f, "    stages in GLSL: {}", names.join(", "))?;
        match &raster.pre_raster {
            PreRaster::Glsl(glsl) => match glsl.topology {
                Topology::Points => writeln!(f, "; of points")?,
                Topology::Triangles => writeln!(f, "; of triangles")?,
                Topology::Patches(vertices) => writeln!(f, "; of patches of {vertices} vertices")?,
            },
            PreRaster::Wgsl | PreRaster::Mesh(_) => writeln!(f)?,
        }
    }
    if raster.unclipped {
        writeln!(f, "    unclipped: depth is clamped at the near and far planes")?;
    }
    if raster.late_writes {
        writeln!(f, "    late writes: rejected fragments may write buffers too")?;
    }
    for ColorAttachment { target, load, blend, write } in &raster.color {
        write!(f, "    color {target}")?;
        match load {
            Load::Clear(value) => write!(f, ", cleared to {value:?}")?,
            Load::Keep => write!(f, ", kept")?,
        }
        match (write, blend) {
            (false, _) => writeln!(f, ", not written")?,
            (true, None) => writeln!(f, ", replaced")?,
            (true, Some(blend)) => writeln!(f, ", blend {blend:?}")?,
        }
    }
    let Some(DepthStencil { target, depth, stencil }) = &raster.depth_stencil else {
        return Ok(());
    };
    if let Some(depth) = depth {
        write!(f, "    depth {target}")?;
        match depth.load {
            Load::Clear(value) => write!(f, ", cleared to {value:?}")?,
            Load::Keep => write!(f, ", kept")?,
        }
        writeln!(f, ", {:?}, {}", depth.compare, if depth.write { "written" } else { "read" })?;
    }
    if let Some(stencil) = stencil {
        write!(f, "    stencil {target}")?;
        match stencil.clear {
            Some(value) => write!(f, ", cleared to {value}")?,
            None => write!(f, ", kept")?,
        }
        writeln!(
            f,
            ", {:?} {}, pass {:?}, fail {:?}",
            stencil.compare, stencil.reference, stencil.pass, stencil.fail
        )?;
    }
    Ok(())
}
