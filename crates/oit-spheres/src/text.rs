//! Shaders put together from constants and texts.

use oit_gpu::{Dispatch, Shader};

/// Workgroups in x before a dispatch goes on in y.
pub(crate) const ROW: u32 = 32768;

/// At least this many workgroups in x, y and z: the one at `(x, y)` has the number `y * ROW + x`.
pub(crate) fn rows(count: u64) -> [u32; 3] {
    let row = u64::from(ROW);
    let rows = count.div_ceil(row).max(1);
    [count.clamp(1, row) as u32, u32::try_from(rows).unwrap_or(u32::MAX), 1]
}

/// A dispatch of [`rows`].
pub(crate) fn workgroups(count: u64) -> Dispatch {
    Dispatch::Workgroups(rows(count))
}

/// A dispatch of an invocation for each, 256 to a workgroup.
pub(crate) fn invocations(count: u64) -> Dispatch {
    workgroups(count.div_ceil(256))
}

/// A constant of a shader.
pub(crate) fn word(name: &str, value: u32) -> String {
    format!("const {name} = {value}u;\n")
}

/// A constant of a shader.
pub(crate) fn flag(name: &str, value: bool) -> String {
    format!("const {name} = {value};\n")
}

/// A shader of constants and texts.
pub(crate) fn shader(label: &str, constants: &[String], texts: &[&str]) -> Shader {
    Shader::new(label, [constants.concat(), texts.concat()].concat())
}
