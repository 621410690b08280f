//! What can be wrong with a plan, found without a GPU.

use crate::glsl::Stage;
use crate::reflect::{Access, Fs, Kind, Reflection, Shaders, Vs, is_float};
use crate::{
    Blend, ColorAttachment, Compare, Contents, DepthStencil, Dispatch, Draw, Format, Glsl,
    GpuError, Load, Plan, PreRaster, Raster, Shader, Topology, Work,
};
use std::collections::HashSet;
use std::sync::Arc;

impl Plan {
    /// Finds what is wrong with a plan, without a GPU: a name that no resource has, a shader that
    /// does not compile, a pass that writes given data or reads what is attached to it, attachments
    /// of different sizes, a fragment shader that would write although the depth or stencil test
    /// rejects the fragment, a depth written that no test would see.
    ///
    /// # Errors
    /// [`GpuError::Plan`] with the first fault.
    pub fn check(&self) -> Result<(), GpuError> {
        check(self, &mut Shaders::default()).map(drop)
    }
}

/// Checks a plan, and gives back the reflection of each pass's shader.
pub(crate) fn check(
    plan: &Plan,
    shaders: &mut Shaders,
) -> Result<Vec<Option<Arc<Reflection>>>, GpuError> {
    let fault = |what| GpuError::Plan { plan: plan.name.clone(), what };
    resources(plan).map_err(fault)?;
    let mut reflections = Vec::with_capacity(plan.passes.len());
    for pass in &plan.passes {
        let in_pass = |what| fault(format!("pass {:?}: {what}", pass.label));
        let reflection = match &pass.work {
            Work::Clear { buffer } => {
                writable(plan, buffer).map_err(in_pass)?;
                None
            }
            Work::Compute { shader, dispatch } => {
                let reflection = shaders.get(shader).map_err(in_pass)?;
                compute(plan, shader, &reflection, dispatch).map_err(in_pass)?;
                Some(reflection)
            }
            Work::Raster(work) => {
                let reflection = shaders.of_raster(work).map_err(in_pass)?;
                raster(plan, work, &reflection).map_err(in_pass)?;
                Some(reflection)
            }
        };
        reflections.push(reflection);
    }
    Ok(reflections)
}

fn resources(plan: &Plan) -> Result<(), String> {
    let mut names = HashSet::new();
    let buffers = plan.buffers.iter().map(|buffer| &buffer.name);
    for name in buffers.chain(plan.targets.iter().map(|target| &target.name)) {
        if !names.insert(name) {
            return Err(format!("two resources are named {name:?}"));
        }
    }
    for buffer in &plan.buffers {
        if let Contents::Data(data) = &buffer.contents
            && data.len() as u64 != buffer.bytes
        {
            let (name, bytes, len) = (&buffer.name, buffer.bytes, data.len());
            return Err(format!("buffer {name:?} is of {bytes} bytes and has {len} bytes of data"));
        }
    }
    for target in &plan.targets {
        if target.width == 0 || target.height == 0 {
            let (name, width, height) = (&target.name, target.width, target.height);
            return Err(format!("target {name:?} is {width}x{height}"));
        }
    }
    Ok(())
}

fn buffer<'a>(plan: &'a Plan, name: &str) -> Result<&'a crate::Buffer, String> {
    plan.buffer(name).ok_or_else(|| {
        let names = plan.buffers.iter().map(|buffer| buffer.name.as_str());
        format!("no buffer is named {name:?}{}", nearest(name, names))
    })
}

/// The buffer, if a pass may write it.
fn writable<'a>(plan: &'a Plan, name: &str) -> Result<&'a crate::Buffer, String> {
    let buffer = buffer(plan, name)?;
    match buffer.contents {
        Contents::Undefined => Ok(buffer),
        Contents::Data(_) => Err(format!("buffer {name:?} has given data and may not be written")),
    }
}

fn nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    names.min_by_key(|candidate| strsim::damerau_levenshtein(name, candidate)).map_or_else(
        || "; the plan has none".to_owned(),
        |name| format!("; the nearest is {name:?}"),
    )
}

/// The target, if a shader may read it as integers or not.
fn readable(plan: &Plan, name: &str, uint: bool) -> Result<(), String> {
    let format = target(plan, name)?.format;
    if !format.is_color() {
        return Err(format!(
            "target {name:?} is {format:?}, and shaders read targets of colour only, not of depth \
             or stencil"
        ));
    }
    if format.is_uint() != uint {
        let kind = if format.is_uint() { "u32" } else { "f32" };
        return Err(format!("target {name:?} is {format:?}, a `texture_2d<{kind}>`"));
    }
    Ok(())
}

fn target<'a>(plan: &'a Plan, name: &str) -> Result<&'a crate::Target, String> {
    plan.target(name).ok_or_else(|| {
        let names = plan.targets.iter().map(|target| target.name.as_str());
        format!("no target is named {name:?}{}", nearest(name, names))
    })
}

/// The checks of a shader of either kind. `held` are buffers that the pass itself also reads as
/// indices, vertices or workgroup counts, which its shader may not write, and targets that are
/// attached to it, which its shader may not read: either would be a race.
fn bindings(
    plan: &Plan,
    shader: &Shader,
    reflection: &Reflection,
    kind: Kind,
    held: &[&str],
) -> Result<(), String> {
    for binding in reflection.bindings_of(kind) {
        let in_shader = |what| format!("shader {:?}: `{}`: {what}", shader.label, binding.name);
        let is_held = held.contains(&binding.name.as_str());
        let buffer = match binding.access {
            Access::Uniform | Access::Read => buffer(plan, &binding.name),
            Access::ReadWrite => writable(plan, &binding.name),
            Access::Texture | Access::UintTexture => {
                let uint = binding.access == Access::UintTexture;
                readable(plan, &binding.name, uint).map_err(in_shader)?;
                if is_held {
                    return Err(in_shader("is attached to the pass that reads it".to_owned()));
                }
                continue;
            }
        }
        .map_err(in_shader)?;
        if buffer.allocated_bytes() < binding.min_bytes {
            let (has, needs) = (buffer.allocated_bytes(), binding.min_bytes);
            return Err(in_shader(format!("needs {needs} bytes and the buffer has {has}")));
        }
        if binding.access == Access::ReadWrite && is_held {
            let what = "is written by the pass that takes its vertices, indices or counts from it";
            return Err(in_shader(what.to_owned()));
        }
    }
    Ok(())
}

fn compute(
    plan: &Plan,
    shader: &Shader,
    reflection: &Reflection,
    dispatch: &Dispatch,
) -> Result<(), String> {
    if reflection.main.is_none() {
        return Err(format!("shader {:?} has no compute entry point `main`", shader.label));
    }
    match dispatch {
        Dispatch::Workgroups(_) => bindings(plan, shader, reflection, Kind::Compute, &[]),
        Dispatch::Indirect { buffer: name, offset_bytes } => {
            arguments_in(plan, name, *offset_bytes, 3)?;
            bindings(plan, shader, reflection, Kind::Compute, &[name])
        }
    }
}

/// Whether a buffer has this many `u32` there.
fn arguments_in(plan: &Plan, name: &str, offset_bytes: u64, words: u64) -> Result<(), String> {
    let bytes = buffer(plan, name)?.allocated_bytes();
    let end = offset_bytes.checked_add(4 * words);
    if !offset_bytes.is_multiple_of(4) || end.is_none_or(|end| end > bytes) {
        return Err(format!(
            "{words} u32 at byte {offset_bytes} of buffer {name:?}, which has {bytes}"
        ));
    }
    Ok(())
}

fn raster(plan: &Plan, raster: &Raster, reflection: &Reflection) -> Result<(), String> {
    let label = &raster.shader.label;
    let (vs, fs) = match (&raster.pre_raster, &reflection.vs, &reflection.fs) {
        (PreRaster::Wgsl, Some(vs), Some(fs)) => (vs, fs),
        (PreRaster::Glsl(_), Some(vs), Some(fs)) => (vs, fs),
        (PreRaster::Mesh(_), _, Some(fs)) => (&Vs { inputs: Vec::new() }, fs),
        (PreRaster::Wgsl, ..) => {
            return Err(format!("shader {label:?} needs the entry points `vs` and `fs`"));
        }
        (PreRaster::Glsl(_) | PreRaster::Mesh(_), ..) => {
            return Err(format!("shader {label:?} needs the entry point `fs`"));
        }
    };
    stages(raster, reflection, fs).map_err(|what| format!("shader {label:?}: {what}"))?;
    attachments(plan, raster)?;
    for (location, color) in raster.color.iter().enumerate() {
        let ColorAttachment { target, write, load, blend } = color;
        let written = fs.outputs.iter().any(|&output| output as usize == location);
        if *write && !written {
            return Err(format!(
                "shader {label:?}: `fs` has no @location({location}), the target {target:?}"
            ));
        }
        let Some(format) = plan.target(target).map(|target| target.format) else { continue };
        let written_uint = fs.uint_outputs.iter().any(|&output| output as usize == location);
        if written && written_uint != format.is_uint() {
            let kind = if format.is_uint() { "u32" } else { "f32" };
            return Err(format!(
                "shader {label:?}: @location({location}) of `fs` is not of {kind}, as the target \
                 {target:?} of {format:?} is"
            ));
        }
        if format.is_uint() {
            integers(target, format, *load, *blend)?;
        }
    }
    depth_writes(raster, fs).map_err(|what| format!("shader {label:?}: `fs` {what}"))?;
    let late = fs.writes && !fs.early_depth_test && !raster.late_writes;
    if late && raster.depth_stencil.as_ref().is_some_and(rejects) {
        return Err(match fs.writes_depth {
            true => format!(
                "shader {label:?}: `fs` writes a buffer and its depth under a depth or stencil \
                 test: it cannot be tested before it runs, so a rejected fragment still writes the \
                 buffer. Write the buffer in a pass of its own"
            ),
            false => format!(
                "shader {label:?}: `fs` writes a buffer under a depth or stencil test, so it must \
                 say `@early_depth_test(force)`: without it a rejected fragment still writes"
            ),
        });
    }
    let without_vertices = || match vs.inputs.first() {
        None => Ok(()),
        Some((location, _)) => Err(format!(
            "shader {label:?}: `vs` reads @location({location}), and nothing is bound there"
        )),
    };
    let mut held = match &raster.draw {
        Draw::Vertices { .. } => {
            without_vertices()?;
            vec![]
        }
        Draw::VerticesIndirect { arguments, offset_bytes, draws } => {
            without_vertices()?;
            if *draws == 0 {
                return Err(format!("no draws are made from buffer {arguments:?}: 1 is the least"));
            }
            arguments_in(plan, arguments, *offset_bytes, 4 * u64::from(*draws))?;
            vec![arguments.as_str()]
        }
        Draw::MeshIndirect { arguments, offset_bytes, .. } => {
            arguments_in(plan, arguments, *offset_bytes, 3)?;
            vec![arguments.as_str()]
        }
        Draw::IndexedIndirect { vertices, layout, indices, arguments, offset_bytes } => {
            vertex_layout(label, vs, layout)?;
            buffer(plan, vertices)?;
            buffer(plan, indices)?;
            arguments_in(plan, arguments, *offset_bytes, 5)?;
            vec![vertices.as_str(), indices.as_str(), arguments.as_str()]
        }
        Draw::Indexed { vertices, layout, indices, count } => {
            vertex_layout(label, vs, layout)?;
            buffer(plan, vertices)?;
            let bytes = buffer(plan, indices)?.allocated_bytes();
            if u64::from(*count) * 4 > bytes {
                return Err(format!(
                    "{count} indices of buffer {indices:?}, which has {bytes} bytes"
                ));
            }
            vec![vertices.as_str(), indices.as_str()]
        }
    };
    held.extend(raster.color.iter().map(|color| color.target.as_str()));
    held.extend(raster.depth_stencil.as_ref().map(|attachment| attachment.target.as_str()));
    bindings(plan, &raster.shader, reflection, Kind::Raster, &held)
}

/// Whether the stages before rasterisation fit each other, the draw and the fragment stage.
fn stages(raster: &Raster, reflection: &Reflection, fs: &Fs) -> Result<(), String> {
    let is_mesh = matches!(raster.pre_raster, PreRaster::Mesh(_));
    if is_mesh != matches!(raster.draw, Draw::MeshIndirect { .. }) {
        return Err("mesh stages and a mesh draw go together".to_owned());
    }
    let Some(last) = reflection.stages.last() else { return Ok(()) };
    if let Some(location) = fs.inputs.iter().find(|&input| !last.outputs.contains(input)) {
        return Err(format!(
            "`fs` reads @location({location}), which the {} stage does not write; it writes {:?}",
            last.stage.name(),
            last.outputs
        ));
    }
    let PreRaster::Glsl(glsl) = &raster.pre_raster else { return Ok(()) };
    let Glsl { topology, tessellation, geometry, .. } = &**glsl;
    match (topology, tessellation) {
        (Topology::Patches(0), _) => return Err("a patch of no vertices".to_owned()),
        (Topology::Patches(_), Some(_)) | (_, None) => {}
        (other, Some(_)) => {
            return Err(format!("tessellation takes Topology::Patches, not {other:?}"));
        }
    }
    if let (Topology::Patches(_), None) = (topology, tessellation) {
        return Err("patches are drawn by tessellation, and there is none".to_owned());
    }
    if geometry.is_none() {
        return Ok(());
    }
    // In SPIR-V's numbers: InputPoints, InputLines, Triangles of a geometry stage; PointMode and
    // Isolines of what a tessellation evaluation stage gives it.
    const INPUTS: [(u32, &str); 5] = [
        (19, "points"),
        (20, "lines"),
        (21, "lines with adjacency"),
        (22, "triangles"),
        (23, "triangles with adjacency"),
    ];
    let has = |stage: Stage, mode: u32| {
        reflection.stages.iter().any(|s| s.stage == stage && s.modes.contains(&mode))
    };
    let evaluation = Stage::TessellationEvaluation;
    let given = match topology {
        Topology::Points => "points",
        Topology::Triangles => "triangles",
        Topology::Patches(_) if has(evaluation, 10) => "points",
        Topology::Patches(_) if has(evaluation, 25) => "lines",
        Topology::Patches(_) => "triangles",
    };
    let taken = INPUTS.into_iter().find(|&(mode, _)| has(Stage::Geometry, mode));
    let taken = taken.map_or("nothing", |(_, words)| words);
    match taken == given {
        true => Ok(()),
        false => Err(format!("the geometry stage takes {taken}, and {given} come to it")),
    }
}

/// Whether a target of integers is cleared and drawn to as one.
fn integers(
    target: &str,
    format: Format,
    load: Load<[f32; 4]>,
    blend: Option<Blend>,
) -> Result<(), String> {
    if let Some(blend) = blend {
        return Err(format!(
            "target {target:?} is {format:?}, and integers are not blended ({blend:?})"
        ));
    }
    // Above 2^24 not every whole number is an `f32`.
    let exact = |value: &f32| {
        *value == f32::INFINITY || (value.fract() == 0.0 && (0.0..=16_777_216.0).contains(value))
    };
    if let Load::Clear(values) = load
        && !values.iter().all(exact)
    {
        return Err(format!(
            "target {target:?} is {format:?} and cleared to {values:?}: integers are cleared to \
             whole numbers from 0 to 2^24, or to infinity, the largest there is"
        ));
    }
    Ok(())
}

/// Whether a fragment shader that says something of its depth says what can be.
fn depth_writes(raster: &Raster, fs: &Fs) -> Result<(), String> {
    let depth = raster.depth_stencil.as_ref().and_then(|attachment| attachment.depth);
    if fs.writes_depth && depth.is_none() {
        return Err("writes `frag_depth`, and no depth target is attached".to_owned());
    }
    if fs.writes_depth && fs.early_depth_test {
        return Err("writes `frag_depth` and says `@early_depth_test(force)`: what is tested \
                    before it runs has the primitive's depth, and what it writes is lost"
            .to_owned());
    }
    if let (Some(bound), false) = (fs.depth_bound, fs.writes_depth) {
        let word = bound.wgsl();
        return Err(format!("says `@early_depth_test({word})` and writes no `frag_depth`"));
    }
    Ok(())
}

/// Whether a test can reject a fragment.
fn rejects(attachment: &DepthStencil) -> bool {
    let depth = attachment.depth.map(|depth| depth.compare);
    let stencil = attachment.stencil.map(|stencil| stencil.compare);
    [depth, stencil].into_iter().flatten().any(|compare| compare != Compare::Always)
}

fn attachments(plan: &Plan, raster: &Raster) -> Result<(), String> {
    let depth_stencil = raster.depth_stencil.as_ref().map(|attachment| &attachment.target);
    let mut size = None;
    let mut seen = HashSet::new();
    for name in raster.color.iter().map(|color| &color.target).chain(depth_stencil) {
        let target = target(plan, name)?;
        let (first, width, height) = *size.get_or_insert((name, target.width, target.height));
        if (width, height) != (target.width, target.height) {
            return Err(format!(
                "target {name:?} is {}x{} and {first:?} is {width}x{height}",
                target.width, target.height
            ));
        }
        if !seen.insert(name) {
            return Err(format!("target {name:?} is attached twice"));
        }
        let is_color = Some(name) != depth_stencil;
        if is_color != target.format.is_color() {
            let format = target.format;
            return Err(format!("target {name:?} is {format:?}, which does not go there"));
        }
    }
    if size.is_none() {
        return Err("it has no attachment".to_owned());
    }
    if let Some(DepthStencil { target, depth, stencil }) = &raster.depth_stencil {
        let format = plan.target(target).map(|target| target.format);
        let fits = match format {
            Some(Format::Depth32Float) => depth.is_some() && stencil.is_none(),
            _ => depth.is_none() && stencil.is_some(),
        };
        if !fits {
            return Err(format!(
                "target {target:?} needs exactly the test of its format: depth or stencil"
            ));
        }
    }
    Ok(())
}

fn vertex_layout(
    label: &str,
    vs: &crate::reflect::Vs,
    layout: &crate::VertexLayout,
) -> Result<(), String> {
    for attribute in &layout.attributes {
        let end = attribute.offset_bytes.checked_add(attribute.format.bytes());
        if attribute.offset_bytes % 4 != 0 || end.is_none_or(|end| end > layout.stride_bytes) {
            return Err(format!("vertex attribute {attribute:?} is not inside the vertex"));
        }
    }
    if !layout.stride_bytes.is_multiple_of(4) {
        return Err(format!("a vertex of {} bytes is no multiple of 4", layout.stride_bytes));
    }
    for &(location, float) in &vs.inputs {
        let bound = layout.attributes.iter().find(|attribute| attribute.location == location);
        if bound.is_none_or(|attribute| is_float(attribute.format) != float) {
            let kind = if float { "f32" } else { "u32" };
            return Err(format!(
                "shader {label:?}: `vs` reads {kind} at @location({location}), which no attribute \
                 gives"
            ));
        }
    }
    Ok(())
}
