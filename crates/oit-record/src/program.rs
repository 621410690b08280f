//! What a driver tells of the programs that it made of shaders.

use serde::{Deserialize, Serialize};

/// One resolve program of a cell: what it is compiled for, and what the driver tells of it.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// The sort strategy.
    pub sort: String,
    /// Where its sorting array lives: `local`, `workgroup`, `registers`, `global`.
    pub store: String,
    /// The fewest fragments of the pixels that it resolves; 1 where it resolves all.
    pub low: u32,
    /// The most fragments, which is the size of its array.
    pub high: u32,
    /// Invocations of a workgroup; `None` in the fragment stage, and where it is not known.
    pub invocations: Option<u32>,
    /// Workgroup memory that its source declares, in bytes; `None` as before.
    pub declared_workgroup_bytes: Option<u64>,
    /// Nanoseconds that the driver took to make it, by the host's clock. Where cells of one process
    /// share a program, all have the time of the first. `None` where the backend does not tell.
    pub compile_ns: Option<u64>,
    /// Whether the driver found it in the pipeline cache that this project keeps. Caches of the
    /// driver's own do not show. `None` where it does not say.
    pub from_cache: Option<bool>,
    /// What it was compiled to; `None` where the driver tells nothing, or was not asked.
    pub executables: Option<Vec<Executable>>,
}

/// A piece of code for the device (`VkPipelineExecutablePropertiesKHR`) in the driver's own words.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Executable {
    /// Its name.
    pub name: String,
    /// The shader stages it was made of: `vertex`, `fragment`, `compute`. A hint, says Vulkan, and
    /// possibly none.
    pub stages: Vec<String>,
    /// Invocations that run together.
    pub subgroup_size: u32,
    /// What is told of it, in the driver's order.
    pub statistics: Vec<Statistic>,
}

/// One figure (`VkPipelineExecutableStatisticKHR`).
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistic {
    /// Its name.
    pub name: String,
    /// What it is, with its unit if the driver gives one.
    pub description: String,
    /// Its value.
    pub value: StatisticValue,
}

/// A value of one of the formats that Vulkan has for them. Written as plain JSON, so that a signed
/// one that is not negative is read back as unsigned.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StatisticValue {
    /// Yes or no.
    Bool(bool),
    /// A number that is not negative.
    Unsigned(u64),
    /// A number.
    Signed(i64),
    /// A number with a fraction, not infinite: JSON has no other.
    Float(f64),
}

impl StatisticValue {
    /// The value as a number: 1 for yes.
    #[must_use]
    pub fn number(self) -> f64 {
        match self {
            Self::Bool(value) => f64::from(u8::from(value)),
            Self::Unsigned(value) => value as f64,
            Self::Signed(value) => value as f64,
            Self::Float(value) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_back_as_they_were() {
        for (value, json) in [
            (StatisticValue::Bool(true), "true"),
            (StatisticValue::Unsigned(u64::MAX), "18446744073709551615"),
            (StatisticValue::Signed(-3), "-3"),
            (StatisticValue::Float(2.0), "2.0"),
        ] {
            assert_eq!(serde_json::to_string(&value).unwrap(), json);
            assert_eq!(serde_json::from_str::<StatisticValue>(json).unwrap(), value);
        }
        assert_eq!(StatisticValue::Bool(true).number(), 1.0);
        assert_eq!(StatisticValue::Signed(-3).number(), -3.0);
    }
}
