//! From a technique's coordinate to a plan: capture passes, grouping passes, resolve passes.

use oit_bma::{
    GroupRequest, Interval, Intervals, list_grouping, mask_pass, masked, stencil_target,
};
use oit_capture::{CapturePasses, CaptureRequest, Geometry};
use oit_gpu::{
    Buffer, ColorAttachment, DepthStencil, Dispatch, Draw, Format, Load, Pass, Plan, Raster,
    Shader, Target,
};
use oit_sort::{Entry, Layout, Output, Program, SortSpec, workgroups};

use crate::technique::{DEEPEST, MaxFrags, Schedule, Stage, Technique};
use crate::{CellError, FrameSize};

/// Where every plan leaves its picture: premultiplied RGBA, 16 bytes a pixel, a target in the
/// fragment stage and a buffer in the compute stage.
pub const IMAGE: &str = "image";

/// The intervals a technique's programs are compiled for, given the peak depth complexity. The
/// base schedule has one, which also takes empty pixels.
pub(crate) fn intervals(technique: &Technique, peak: u32) -> Result<Intervals, CellError> {
    let max = technique.max_frags.for_peak(peak);
    if max > DEEPEST {
        return Err(CellError::Unsupported(format!(
            "{peak} fragments on one pixel; techniques hold up to {DEEPEST}"
        )));
    }
    Ok(match (technique.schedule, technique.max_frags) {
        (Schedule::Base, _) => Intervals::from_uppers(vec![max]),
        (Schedule::Bma, MaxFrags::Peak) => Ok(Intervals::powers_of_two(peak)),
        (Schedule::Bma, MaxFrags::Exactly(_)) => {
            let doubling = std::iter::successors(Some(8u32), |&upper| Some(upper * 2));
            let mut uppers: Vec<u32> = doubling.take_while(|&upper| upper < max).collect();
            uppers.push(max);
            Intervals::from_uppers(uppers)
        }
    }
    .expect("bounds that rise from 8, or one bound of at least 1"))
}

/// What a program for one interval is compiled for, and with which strategy.
pub(crate) fn sort_spec(
    technique: &Technique,
    interval: Interval,
) -> Result<(&'static dyn oit_sort::SortStrategy, SortSpec), CellError> {
    let (strategy, store) = technique
        .sort
        .for_max_frags(interval.high)
        .map_err(|error| CellError::Unsupported(error.to_string()))?;
    // The base schedule runs its one program on empty pixels too.
    let min_frags = if technique.schedule == Schedule::Base { 0 } else { interval.low };
    let spec = SortSpec { min_frags, max_frags: interval.high, ties: technique.ties, store };
    Ok((strategy, spec))
}

/// The passes that capture as the technique asks.
fn capture_passes(
    technique: &Technique,
    geometry: &Geometry,
    size: FrameSize,
    pool_fragments: u64,
) -> CapturePasses {
    technique.capture.build(&CaptureRequest {
        geometry,
        width_px: size.width_px,
        height_px: size.height_px,
        pool_slots: pool_fragments,
        histogram: &oit_fragments::DepthHistogram::default(),
        lists: None,
        mark: None,
        counts: technique.schedule == Schedule::Bma,
    })
}

/// The plan of a technique on one view with this peak depth complexity and room in the pool.
///
/// # Errors
/// [`CellError::Unsupported`] where no strategy of its sort choice holds that many fragments.
pub fn assemble(
    technique: &Technique,
    geometry: &Geometry,
    size: FrameSize,
    peak: u32,
    pool_fragments: u64,
) -> Result<Plan, CellError> {
    let CapturePasses { buffers, targets, passes, lists_at: _ } =
        capture_passes(technique, geometry, size, pool_fragments);
    let mut plan = Plan { name: technique.to_string(), buffers, targets, passes };
    let intervals = intervals(technique, peak)?;
    let group = GroupRequest {
        count_wgsl: &technique.capture.count_wgsl(),
        width_px: size.width_px,
        height_px: size.height_px,
    };
    match technique.stage {
        Stage::Fragment => {
            plan.targets.push(Target {
                name: IMAGE.into(),
                format: Format::Rgba32Float,
                width: size.width_px,
                height: size.height_px,
            });
            let grouped = technique.schedule == Schedule::Bma;
            if grouped {
                plan.targets.push(stencil_target(&group));
            }
            for (place, interval) in intervals.iter().enumerate() {
                if grouped {
                    plan.passes.push(mask_pass(&group, interval, place + 1 == intervals.len()));
                }
                let shader = program(technique, interval, Entry::Fragment, size)?;
                let load = if place == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
                plan.passes.push(full_screen(shader, load, grouped.then(masked)));
            }
        }
        Stage::Compute => {
            plan.buffers.push(Buffer::new(IMAGE, 16 * size.pixels()));
            if technique.schedule == Schedule::Bma {
                let grouping = list_grouping(&group, &intervals);
                for (place, interval) in intervals.iter().enumerate() {
                    let entry = Entry::List { list: place as u32, first: grouping.firsts[place] };
                    let shader = program(technique, interval, entry, size)?;
                    let pass = Pass::compute("resolve", shader, grouping.dispatch(place));
                    plan.passes.push(pass);
                }
                // Grouping comes before the resolves that it dispatches.
                let resolves = plan.passes.len() - intervals.len();
                plan.passes.splice(resolves..resolves, grouping.passes);
                plan.buffers.extend(grouping.buffers);
            } else {
                for interval in intervals.iter() {
                    let shader = program(technique, interval, Entry::Pixels, size)?;
                    let all = Dispatch::Workgroups(workgroups(size.pixels()));
                    plan.passes.push(Pass::compute("resolve", shader, all));
                }
            }
        }
    }
    Ok(plan)
}

fn program(
    technique: &Technique,
    interval: Interval,
    entry: Entry,
    size: FrameSize,
) -> Result<Shader, CellError> {
    let (strategy, spec) = sort_spec(technique, interval)?;
    let program = Program {
        layout: Layout {
            name: technique.capture.name(),
            wgsl: &technique.capture.layout_wgsl(),
            random_access: technique.capture.random_access(),
        },
        strategy,
        spec,
        entry,
        output: Output::Composite,
        width_px: size.width_px,
        height_px: size.height_px,
    };
    let wgsl = program.wgsl().map_err(|error| CellError::Unsupported(error.to_string()))?;
    let label = format!("resolve: {} for {} to {}", strategy.name(), interval.low, interval.high);
    Ok(Shader::new(label, wgsl))
}

fn full_screen(shader: Shader, load: Load<[f32; 4]>, mask: Option<DepthStencil>) -> Pass {
    Pass::raster(
        "resolve",
        Raster {
            color: vec![ColorAttachment { target: IMAGE.into(), load, blend: None, write: true }],
            depth_stencil: mask,
            ..Raster::new(shader, Draw::Vertices { count: 3, instances: 1 })
        },
    )
}
