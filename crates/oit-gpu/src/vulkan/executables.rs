//! What the driver tells of a pipeline once it is made: its registers, spills and code size, by
//! `VK_KHR_pipeline_executable_properties`.
//!
//! The flag that asks for it must not change the code that is made, but it may keep the pipeline out
//! of caches (Vulkan, `VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR`). A pipeline made with the flag
//! has its statistics also where it comes out of a cache.

use super::gpu::Gpu;
use super::physical::text;
use ash::{khr, vk};
use oit_record::{Executable, Statistic, StatisticValue};

/// The extension's functions, on a device that has them enabled.
pub(super) type Functions = khr::pipeline_executable_properties::Device;

/// Whether the environment forbids asking: `OIT_STATISTICS=0`.
pub(super) fn are_refused() -> bool {
    std::env::var_os("OIT_STATISTICS").is_some_and(|value| value == "0")
}

/// The flags with which pipelines are made so that they can be asked for.
pub(super) fn flags(gpu: &Gpu) -> vk::PipelineCreateFlags {
    match gpu.executables {
        Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
        None => vk::PipelineCreateFlags::empty(),
    }
}

/// The executables of a pipeline that was made with [`flags`]; `None` where the driver has not the
/// extension, or fails to tell. What is told is no part of what is measured, so failing is no error.
pub(super) fn of(gpu: &Gpu, pipeline: vk::Pipeline) -> Option<Vec<Executable>> {
    let functions = gpu.executables.as_ref()?;
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
    // SAFETY: the feature is enabled, and the pipeline alive and of this device.
    let executables = unsafe { functions.get_pipeline_executable_properties(&info) }.ok()?;
    (0..)
        .zip(&executables)
        .map(|(index, found)| executable(functions, pipeline, index, found))
        .collect()
}

fn executable(
    functions: &Functions,
    pipeline: vk::Pipeline,
    index: u32,
    found: &vk::PipelineExecutablePropertiesKHR,
) -> Option<Executable> {
    let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
    // SAFETY: the feature is enabled, the pipeline alive and made with the flag for statistics, and
    // the index below the number of its executables.
    let statistics = unsafe { functions.get_pipeline_executable_statistics(&info) }.ok()?;
    let stages = [
        (vk::ShaderStageFlags::VERTEX, "vertex"),
        (vk::ShaderStageFlags::TESSELLATION_CONTROL, "tessellation control"),
        (vk::ShaderStageFlags::TESSELLATION_EVALUATION, "tessellation evaluation"),
        (vk::ShaderStageFlags::GEOMETRY, "geometry"),
        (vk::ShaderStageFlags::TASK_EXT, "task"),
        (vk::ShaderStageFlags::MESH_EXT, "mesh"),
        (vk::ShaderStageFlags::FRAGMENT, "fragment"),
        (vk::ShaderStageFlags::COMPUTE, "compute"),
    ];
    let stages = stages.into_iter().filter(|(stage, _)| found.stages.contains(*stage));
    Some(Executable {
        name: text(found.name_as_c_str()),
        stages: stages.map(|(_, name)| name.to_owned()).collect(),
        subgroup_size: found.subgroup_size,
        statistics: statistics.iter().filter_map(statistic).collect(),
    })
}

/// A statistic, if its format is known and its value can be written down.
fn statistic(told: &vk::PipelineExecutableStatisticKHR) -> Option<Statistic> {
    type Format = vk::PipelineExecutableStatisticFormatKHR;
    // SAFETY: the driver fills the member of the union that the format names.
    let value = unsafe {
        match told.format {
            Format::BOOL32 => StatisticValue::Bool(told.value.b32 != 0),
            Format::UINT64 => StatisticValue::Unsigned(told.value.u64),
            Format::INT64 => match u64::try_from(told.value.i64) {
                Ok(value) => StatisticValue::Unsigned(value),
                Err(_) => StatisticValue::Signed(told.value.i64),
            },
            // JSON has neither infinities nor what is no number.
            Format::FLOAT64 if told.value.f64.is_finite() => StatisticValue::Float(told.value.f64),
            _ => return None,
        }
    };
    let (name, description) = (text(told.name_as_c_str()), text(told.description_as_c_str()));
    Some(Statistic { name, description, value })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Format = vk::PipelineExecutableStatisticFormatKHR;
    type Value = vk::PipelineExecutableStatisticValueKHR;

    fn told(format: Format, value: Value) -> Option<Statistic> {
        let named = vk::PipelineExecutableStatisticKHR::default()
            .name(c"Register Count")
            .and_then(|told| told.description(c"of a thread"))
            .expect("short");
        statistic(&named.format(format).value(value))
    }

    #[test]
    fn a_statistic_has_the_type_of_its_format() {
        let register_count = told(Format::UINT64, Value { u64: 40 }).expect("a number");
        assert_eq!(register_count.name, "Register Count");
        assert_eq!(register_count.description, "of a thread");
        assert_eq!(register_count.value, StatisticValue::Unsigned(40));
        let value = |format, value| told(format, value).map(|statistic| statistic.value);
        assert_eq!(value(Format::INT64, Value { i64: 7 }), Some(StatisticValue::Unsigned(7)));
        assert_eq!(value(Format::INT64, Value { i64: -7 }), Some(StatisticValue::Signed(-7)));
        assert_eq!(value(Format::BOOL32, Value { b32: 1 }), Some(StatisticValue::Bool(true)));
        assert_eq!(value(Format::FLOAT64, Value { f64: 0.5 }), Some(StatisticValue::Float(0.5)));
        assert_eq!(value(Format::FLOAT64, Value { f64: f64::NAN }), None);
        assert_eq!(value(Format::from_raw(99), Value { u64: 1 }), None);
    }
}
