//! From a technique's coordinate to a plan: capture passes, grouping passes, resolve passes.

use oit_bma::{
    GroupRequest, Interval, Intervals, ListGrouping, MOST_COUNTED, count_drawn, counted,
    list_grouping, mark, mask_pass, masked, stencil_target,
};
use oit_capture::{CapturePasses, CaptureRequest, Demand, Geometry, Lists};
use oit_fragments::DepthHistogram;
use oit_gpu::{
    Buffer, ColorAttachment, Compiled, DepthStencil, Dispatch, Draw, Format, Load, Pass, Plan,
    Raster, Shader, Target,
};
use oit_sort::{Entry, Layout, Output, Program, SortSpec, Store, store_name, workgroups};

use crate::technique::{DEEPEST, IntervalChoice, MaxFrags, PoolPolicy, Schedule, Sorted, Stage};
use crate::{CellError, FrameSize};

/// Where every plan leaves its picture: premultiplied RGBA, 16 bytes a pixel, a target in the
/// fragment stage and a buffer in the compute stage.
pub const IMAGE: &str = "image";

/// The intervals a technique's programs are compiled for, given the peak depth complexity. The
/// base schedule has one, which also takes empty pixels. What is left to measurements must have been
/// chosen before ([`crate::Tuner::choose`]).
pub(crate) fn intervals(technique: &Sorted, peak: u32) -> Result<Intervals, CellError> {
    let max = technique.max_frags.for_peak(peak);
    if max > DEEPEST {
        return Err(CellError::Unsupported(format!(
            "{peak} fragments on one pixel; techniques hold up to {DEEPEST}"
        )));
    }
    let bounds = match (&technique.intervals, technique.max_frags) {
        _ if !technique.schedule.has_intervals() => Intervals::from_uppers(vec![max]),
        (IntervalChoice::PowersOfTwo, MaxFrags::Peak) => Ok(Intervals::powers_of_two(peak)),
        (IntervalChoice::PowersOfTwo, MaxFrags::Exactly(_)) => {
            let doubling = std::iter::successors(Some(8u32), |&upper| Some(upper * 2));
            let mut uppers: Vec<u32> = doubling.take_while(|&upper| upper < max).collect();
            uppers.push(max);
            Intervals::from_uppers(uppers)
        }
        (IntervalChoice::Uppers(uppers), MaxFrags::Peak) => Intervals::within(uppers, peak, max),
        (IntervalChoice::Uppers(uppers), MaxFrags::Exactly(_)) => {
            Intervals::within(uppers, max, max)
        }
        (IntervalChoice::Optimal, _) => {
            let reason = "the optimal intervals were not chosen for this view";
            return Err(CellError::Unsupported(reason.into()));
        }
    };
    bounds.map_err(|error| CellError::Failed(format!("{technique}: {error}")))
}

/// What the program that runs on an interval's pixels is compiled for: the interval, or under
/// `base-intervals` all of them, as the one program of the base schedule is.
pub(crate) fn array(technique: &Sorted, intervals: &Intervals, interval: Interval) -> Interval {
    match technique.schedule {
        Schedule::BaseIntervals => Interval { low: 0, high: intervals.deepest() },
        _ => interval,
    }
}

/// What a program for one interval is compiled for, and with which strategy.
pub(crate) fn sort_spec(
    technique: &Sorted,
    interval: Interval,
) -> Result<(&'static dyn oit_sort::SortStrategy, SortSpec), CellError> {
    let (strategy, store) = technique
        .sort
        .for_max_frags(interval.high)
        .map_err(|error| CellError::Unsupported(error.to_string()))?;
    // The base schedule runs its one program on empty pixels too. And where fragments are left out, a
    // pixel may have fewer than were counted for it.
    let is_counted = technique.pool.policy == PoolPolicy::Grow;
    let min_frags =
        if is_counted && technique.schedule != Schedule::Base { interval.low } else { 0 };
    let spec = SortSpec { min_frags, max_frags: interval.high, ties: technique.ties, store };
    Ok((strategy, spec))
}

/// Whether a technique orders fragments where they were captured, on a view of this peak depth
/// complexity.
pub(crate) fn rewrites(technique: &Sorted, peak: u32) -> Result<bool, CellError> {
    for interval in intervals(technique, peak)?.iter() {
        if sort_spec(technique, interval)?.1.store == Store::Global {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Where a plan's fragments come from.
#[derive(Clone, Copy, Debug)]
pub enum Fragments<'a> {
    /// The capture draws them.
    Drawn(&'a Geometry),
    /// They were captured before and are uploaded: buffers as [`Capture::upload`] gives them.
    ///
    /// [`Capture::upload`]: oit_capture::Capture::upload
    Stored(&'a [Buffer]),
}

/// How the schedule groups the pixels of a frame, if it does.
fn group_request<'a>(count_wgsl: &'a str, size: FrameSize) -> GroupRequest<'a> {
    GroupRequest { count_wgsl, width_px: size.width_px, height_px: size.height_px }
}

/// Whether a technique's schedule makes lists of pixels.
fn makes_lists(technique: &Sorted) -> bool {
    technique.schedule.groups() && technique.stage == Stage::Compute
}

/// Refuses a capture whose layout goes by lists that the schedule does not make.
pub(crate) fn needs_lists(technique: &Sorted) -> Result<(), CellError> {
    if technique.capture.needs_lists() && !makes_lists(technique) {
        return Err(CellError::Unsupported(format!(
            "{} lies in the order of a schedule's lists, which only bma-list makes",
            technique.capture.name()
        )));
    }
    Ok(())
}

/// The lists of pixels that a technique's schedule makes.
fn list_passes(
    technique: &Sorted,
    size: FrameSize,
    peak: u32,
) -> Result<Option<(ListGrouping, Lists)>, CellError> {
    if !makes_lists(technique) {
        return Ok(None);
    }
    let intervals = intervals(technique, peak)?;
    let count_wgsl = technique.capture.count_wgsl();
    let mut pixels_per_workgroup = Vec::with_capacity(intervals.len());
    for interval in intervals.iter() {
        let (strategy, spec) = sort_spec(technique, interval)?;
        pixels_per_workgroup.push(strategy.pixels_per_workgroup(&spec));
    }
    let group = group_request(&count_wgsl, size);
    let grouping = list_grouping(&group, &intervals, &pixels_per_workgroup);
    let uppers = intervals.iter().map(|interval| interval.high).collect();
    let lists = Lists { firsts: grouping.firsts.clone(), uppers };
    Ok(Some((grouping, lists)))
}

/// The lists of pixels that a technique's schedule makes on a view of this peak depth complexity.
pub(crate) fn lists(
    technique: &Sorted,
    size: FrameSize,
    peak: u32,
) -> Result<Option<Lists>, CellError> {
    Ok(list_passes(technique, size, peak)?.map(|(_, lists)| lists))
}

/// Slots that a technique's pool needs on a view.
///
/// # Errors
/// [`CellError::Unsupported`] where the technique or its capture cannot hold the view.
pub(crate) fn slots(
    technique: &Sorted,
    size: FrameSize,
    counts: &[u32],
    histogram: &DepthHistogram,
) -> Result<u64, CellError> {
    let lists = lists(technique, size, histogram.peak())?;
    let demand = Demand { counts, histogram, lists: lists.as_ref() };
    match technique.capture.refuses(&demand) {
        Some(reason) => Err(CellError::Unsupported(reason)),
        None => Ok(technique.capture.slots(&demand)),
    }
}

/// The plan of a technique on one view with these counts and this many slots in the pool. In the
/// stage `cuda` it ends with the capture.
///
/// # Errors
/// [`CellError::Unsupported`] where no strategy of its sort choice holds that many fragments, or
/// the capture needs lists that the schedule does not make, or the stage lacks the schedule.
pub fn assemble(
    technique: &Sorted,
    fragments: Fragments,
    size: FrameSize,
    histogram: &DepthHistogram,
    pool_slots: u64,
) -> Result<Plan, CellError> {
    needs_lists(technique)?;
    if !technique.stage.has(technique.schedule) {
        let stage = technique.stage.name();
        return Err(CellError::Unsupported(format!("the {stage} stage has no such schedule")));
    }
    let capture = technique.capture;
    if matches!(fragments, Fragments::Stored(_)) && rewrites(technique, histogram.peak())? {
        let reason = "stored fragments are uploaded once, and it would leave them in another order";
        return Err(CellError::Unsupported(reason.into()));
    }
    if technique.schedule.masks_what_is_drawn() && !capture.marks() {
        return Err(CellError::Unsupported(format!(
            "{} has a depth target, and no stencil to mark pixels in",
            capture.name()
        )));
    }
    let grouping = list_passes(technique, size, histogram.peak())?;
    let CapturePasses { buffers, targets, passes, lists_at } = match fragments {
        Fragments::Drawn(geometry) => capture.build(&CaptureRequest {
            geometry,
            width_px: size.width_px,
            height_px: size.height_px,
            pool_slots,
            histogram,
            counts: technique.schedule.groups(),
            lists: grouping.as_ref().map(|(_, lists)| lists),
            mark: match technique.schedule {
                Schedule::BaseStencil => Some(mark()),
                Schedule::BmaStencilCount => Some(count_drawn()),
                Schedule::Base | Schedule::Bma | Schedule::BaseIntervals => None,
            }
            .as_ref(),
        }),
        Fragments::Stored(buffers) => {
            CapturePasses { buffers: buffers.to_vec(), ..CapturePasses::default() }
        }
    };
    let mut plan = Plan { name: technique.to_string(), buffers, targets, passes };
    let count_wgsl = capture.count_wgsl();
    let group = group_request(&count_wgsl, size);
    let intervals = intervals(technique, histogram.peak())?;
    match technique.stage {
        Stage::Fragment => {
            plan.targets.push(Target {
                name: IMAGE.into(),
                format: Format::Rgba32Float,
                width: size.width_px,
                height: size.height_px,
            });
            if technique.schedule != Schedule::Base {
                plan.targets.push(stencil_target(&group));
            }
            let stored = matches!(fragments, Fragments::Stored(_));
            let mut masks = Vec::new();
            match technique.schedule {
                Schedule::Base => masks.push((None, None)),
                // Nothing is drawn that could leave its mark.
                Schedule::BaseStencil if stored => {
                    let covered = Interval { low: 1, high: u32::MAX };
                    masks.push((Some(mask_pass(&group, covered, true)), Some(masked())));
                }
                Schedule::BaseStencil => masks.push((None, Some(masked()))),
                Schedule::Bma | Schedule::BaseIntervals => {
                    for (place, interval) in intervals.iter().enumerate() {
                        let last = place + 1 == intervals.len();
                        masks.push((Some(mask_pass(&group, interval, last)), Some(masked())));
                    }
                }
                Schedule::BmaStencilCount => {
                    masks
                        .extend(stencil_counts(&intervals, stored)?.map(|test| (None, Some(test))));
                }
            }
            let mut resolves: Vec<_> = intervals.iter().zip(masks).collect();
            if technique.schedule == Schedule::BmaStencilCount {
                resolves.reverse();
            }
            for (place, (interval, (pass, test))) in resolves.into_iter().enumerate() {
                let own = array(technique, &intervals, interval);
                let shader = program(technique, own, Entry::Fragment, size)?;
                let load = if place == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
                for pass in pass.into_iter().chain([full_screen(shader, load, test)]) {
                    plan.passes.push(part(technique, interval, pass));
                }
            }
        }
        // Not the plan's: see `cuda_stage`.
        Stage::Cuda => {}
        Stage::Compute => {
            plan.buffers.push(Buffer::new(IMAGE, 16 * size.pixels()));
            if let Some((grouping, _)) = grouping {
                // Grouping comes before the resolves that it dispatches, and before that part of
                // the capture that goes by its lists.
                let at = lists_at.unwrap_or(plan.passes.len());
                plan.passes.splice(at..at, grouping.passes.clone());
                for (place, interval) in intervals.iter().enumerate() {
                    let entry = Entry::List { list: place as u32, first: grouping.firsts[place] };
                    let own = array(technique, &intervals, interval);
                    let shader = program(technique, own, entry, size)?;
                    let pass = Pass::compute("resolve", shader, grouping.dispatch(place));
                    plan.passes.push(part(technique, interval, pass));
                }
                plan.buffers.extend(grouping.buffers);
            } else {
                for interval in intervals.iter() {
                    let shader = program(technique, interval, Entry::Pixels, size)?;
                    let (strategy, spec) = sort_spec(technique, interval)?;
                    let each = strategy.pixels_per_workgroup(&spec);
                    let all = Dispatch::Workgroups(workgroups(size.pixels(), each));
                    plan.passes.push(Pass::compute("resolve", shader, all));
                }
            }
        }
    }
    Ok(plan)
}

/// The tests by which each interval is resolved where the stencil has counted fragments.
fn stencil_counts(
    intervals: &Intervals,
    stored: bool,
) -> Result<impl Iterator<Item = DepthStencil>, CellError> {
    let deepest = intervals.iter().last().map_or(0, |interval| interval.low);
    if deepest > MOST_COUNTED {
        return Err(CellError::Unsupported(format!(
            "the stencil counts {MOST_COUNTED} fragments at most, and an interval begins at {deepest}"
        )));
    }
    if stored {
        let reason = "stored fragments are not drawn, so that no stencil counts them";
        return Err(CellError::Unsupported(reason.into()));
    }
    Ok(intervals.iter().map(|interval| counted(interval.low)))
}

/// A pass for an interval's pixels: timed by itself, by the interval's upper bound.
fn part(technique: &Sorted, interval: Interval, pass: Pass) -> Pass {
    if technique.schedule.has_intervals() { pass.part(interval.high) } else { pass }
}

fn program(
    technique: &Sorted,
    interval: Interval,
    entry: Entry,
    size: FrameSize,
) -> Result<Shader, CellError> {
    let (strategy, spec) = sort_spec(technique, interval)?;
    let capture = technique.capture;
    let layout = if spec.store == Store::Global {
        let reason = || format!("{} cannot be written back to", capture.name());
        capture.rewrite_wgsl().ok_or_else(|| CellError::Unsupported(reason()))?
    } else {
        capture.layout_wgsl()
    };
    let program = Program {
        layout: Layout {
            name: capture.name(),
            wgsl: &layout,
            random_access: capture.random_access(),
            element: capture.element(),
        },
        strategy,
        spec,
        entry,
        output: Output::Composite,
        width_px: size.width_px,
        height_px: size.height_px,
    };
    let wgsl = program.wgsl().map_err(|error| CellError::Unsupported(error.to_string()))?;
    Ok(Shader::new(program_label(strategy, spec.store, interval), wgsl))
}

/// The label of the resolve program of an interval, by which it is found among a plan's shaders.
fn program_label(
    strategy: &dyn oit_sort::SortStrategy,
    store: Store,
    interval: Interval,
) -> String {
    let sort = store_name(strategy, store);
    format!("resolve: {sort} for {} to {}", interval.low, interval.high)
}

/// A technique's resolve programs on a view of this peak depth complexity, one an interval from the
/// shallowest, with what the backend tells of each.
pub(crate) fn programs(
    technique: &Sorted,
    peak: u32,
    compiled: &[Compiled],
) -> Result<Vec<oit_record::Program>, CellError> {
    let intervals = intervals(technique, peak)?;
    let program = |interval: Interval| {
        let (strategy, spec) = sort_spec(technique, array(technique, &intervals, interval))?;
        let label = program_label(strategy, spec.store, array(technique, &intervals, interval));
        let told = compiled.iter().find(|compiled| compiled.shader == label);
        let main = told.and_then(|told| told.main.as_ref());
        Ok(oit_record::Program {
            sort: strategy.name().into(),
            store: spec.store.name().into(),
            low: interval.low,
            high: interval.high,
            invocations: main.map(|main| main.workgroup_size.iter().product()),
            declared_workgroup_bytes: main.map(|main| main.workgroup_bytes),
            compile_ns: told.and_then(|told| told.compile_ns),
            from_cache: told.and_then(|told| told.from_cache),
            executables: told.and_then(|told| told.executables.clone()),
        })
    };
    intervals.iter().map(program).collect()
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
