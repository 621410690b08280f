//! How much work the passes of a plan are: what the plan says, and what the device counts.

use oit_gpu::{
    Device, Dispatch, GpuError, Load, Pass, PassStatistics, Plan, PlanId, Raster, Reflection,
    StencilOp, Work,
};
use oit_record::{PassKind, PassWork, RasterCounts};

/// The work of each pass of a plan, in order. The plan is run once, to be counted.
///
/// # Errors
/// Where the plan is not prepared or the device fails. A device that does not count is no error.
pub fn pass_work(device: &mut dyn Device, plan: PlanId) -> Result<Vec<PassWork>, GpuError> {
    let mut passes = declared(device.planned(plan)?);
    match device.statistics(plan) {
        Ok(statistics) => {
            for told in statistics {
                if let Some(pass) = passes.get_mut(told.pass) {
                    pass.counted = Some(counts(&told));
                }
            }
        }
        Err(GpuError::Unsupported(_)) => {}
        Err(error) => return Err(error),
    }
    Ok(passes)
}

/// What a plan says of its passes without being run.
fn declared(plan: &Plan) -> Vec<PassWork> {
    plan.passes.iter().map(|pass| declared_of(plan, pass)).collect()
}

fn declared_of(plan: &Plan, pass: &Pass) -> PassWork {
    let mut work = PassWork {
        stage: pass.stage.to_owned(),
        label: pass.label.clone(),
        kind: PassKind::Clear,
        cleared_bytes: 0,
        color_bytes_per_fragment: 0,
        depth_stencil_bytes_per_fragment: 0,
        compute_invocations: None,
        counted: None,
    };
    match &pass.work {
        Work::Clear { buffer } => {
            work.cleared_bytes = plan.buffer(buffer).map_or(0, |buffer| buffer.bytes);
        }
        Work::Compute { shader, dispatch } => {
            work.kind = PassKind::Compute;
            let main = Reflection::new(shader).ok().and_then(|reflection| reflection.main);
            if let (Some(main), Dispatch::Workgroups(groups)) = (main, dispatch) {
                let sides = groups.iter().chain(&main.workgroup_size);
                work.compute_invocations =
                    Some(sides.fold(1_u64, |all, &side| all.saturating_mul(u64::from(side))));
            }
        }
        Work::Raster(raster) => {
            work.kind = PassKind::Raster;
            attachments(plan, raster, &mut work);
        }
    }
    work
}

/// Bytes that a raster pass clears, and that a fragment of it writes.
fn attachments(plan: &Plan, raster: &Raster, work: &mut PassWork) {
    for color in &raster.color {
        let Some(target) = plan.target(&color.target) else { continue };
        if matches!(color.load, Load::Clear(_)) {
            work.cleared_bytes += target.bytes();
        }
        if color.write {
            work.color_bytes_per_fragment += target.format.bytes();
        }
    }
    let Some(attached) = &raster.depth_stencil else { return };
    let Some(target) = plan.target(&attached.target) else { return };
    let depth_cleared =
        attached.depth.as_ref().is_some_and(|depth| matches!(depth.load, Load::Clear(_)));
    let stencil_cleared = attached.stencil.as_ref().is_some_and(|stencil| stencil.clear.is_some());
    if depth_cleared || stencil_cleared {
        work.cleared_bytes += target.bytes();
    }
    let depth_written = attached.depth.as_ref().is_some_and(|depth| depth.write);
    // Fragments that a test rejects may change a stencil without being run; none is counted for that.
    let stencil_written =
        attached.stencil.as_ref().is_some_and(|stencil| stencil.pass != StencilOp::Keep);
    if depth_written || stencil_written {
        work.depth_stencil_bytes_per_fragment = target.format.bytes();
    }
}

fn counts(told: &PassStatistics) -> RasterCounts {
    RasterCounts {
        input_vertices: told.input_vertices,
        input_primitives: told.input_primitives,
        vertex_invocations: told.vertex_invocations,
        tessellation_patches: told.tessellation_patches,
        tessellation_invocations: told.tessellation_invocations,
        geometry_invocations: told.geometry_invocations,
        geometry_primitives: told.geometry_primitives,
        clipping_invocations: told.clipping_invocations,
        clipping_primitives: told.clipping_primitives,
        fragment_invocations: told.fragment_invocations,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use oit_gpu::{
        Buffer, ColorAttachment, Compare, Depth, DepthStencil, Draw, Format, Shader, Stencil,
        Target,
    };

    fn target(name: &str, format: Format) -> Target {
        Target { name: name.into(), format, width: 8, height: 4 }
    }

    fn color(target: &str, load: Load<[f32; 4]>, write: bool) -> ColorAttachment {
        ColorAttachment { target: target.into(), load, blend: None, write }
    }

    fn raster(color: Vec<ColorAttachment>, depth_stencil: Option<DepthStencil>) -> Pass {
        let draw = Draw::Vertices { count: 3, instances: 1 };
        let new = Raster::new(Shader::new("draw", ""), draw);
        Pass::raster("draw", Raster { color, depth_stencil, ..new })
    }

    #[test]
    fn attachments_that_are_not_written_count_for_nothing() {
        let depth = |load, write| Depth { load, compare: Compare::Less, write };
        let stencil = Stencil {
            clear: Some(0),
            compare: Compare::Equal,
            reference: 1,
            pass: StencilOp::Keep,
            fail: StencilOp::Keep,
        };
        let both = |target: &str, depth, stencil| {
            Some(DepthStencil { target: target.into(), depth, stencil })
        };
        let plan = Plan {
            targets: vec![
                target("colour", Format::Rgba16Float),
                target("other", Format::R32Float),
                target("depth", Format::Depth32Float),
                target("mask", Format::Stencil8),
            ],
            passes: vec![
                raster(
                    vec![
                        color("colour", Load::Clear([0.0; 4]), true),
                        color("other", Load::Keep, true),
                    ],
                    both("depth", Some(depth(Load::Clear(1.0), true)), None),
                ),
                raster(
                    vec![color("colour", Load::Keep, false)],
                    both("depth", Some(depth(Load::Keep, false)), None),
                ),
                raster(vec![], both("mask", None, Some(stencil))),
                raster(
                    vec![],
                    both(
                        "mask",
                        None,
                        Some(Stencil { clear: None, pass: StencilOp::Replace, ..stencil }),
                    ),
                ),
            ],
            ..Plan::default()
        };
        let found: Vec<[u64; 3]> = declared(&plan)
            .iter()
            .map(|pass| {
                [
                    pass.cleared_bytes,
                    pass.color_bytes_per_fragment,
                    pass.depth_stencil_bytes_per_fragment,
                ]
            })
            .collect();
        assert_eq!(found, [[32 * 12, 12, 4], [0, 0, 0], [32, 0, 0], [0, 0, 1]]);
    }

    #[test]
    fn invocations_of_a_direct_dispatch_are_known() {
        let shader = Shader::new("work", "@compute @workgroup_size(8, 4) fn main() {}");
        let direct = Dispatch::Workgroups([3, 2, 1]);
        let indirect = Dispatch::Indirect { buffer: "heads".into(), offset_bytes: 0 };
        let plan = Plan {
            buffers: vec![Buffer::new("heads", 48)],
            passes: vec![
                Pass::clear("clear", "heads"),
                Pass::compute("group", shader.clone(), direct),
                Pass::compute("resolve", shader, indirect),
            ],
            ..Plan::default()
        };
        let passes = declared(&plan);
        assert_eq!(passes[0].cleared_bytes, 48);
        let invocations: Vec<_> = passes.iter().map(|pass| pass.compute_invocations).collect();
        assert_eq!(invocations, [None, Some(192), None]);
    }
}
