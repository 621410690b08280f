//! Up-sweep and down-sweep, a pass a level in device memory, as the LFB chapter has it (section
//! 20.4, figure 20.4b; the algorithm is Blelloch's of 1990, which Harris et al. describe in GPU
//! Gems 3, chapter 39).
//!
//! A pair of a level reads two words and writes one on the way up, and reads two and writes two on
//! the way down. There are as many pairs as (padded) values: 16 bytes read a value and 12 written.
//! Memory moves by sectors of 32 bytes at least, and from the fourth level on each word of a level
//! has one of its own: 76 bytes a value pass through the caches (20 read and 16 written on the way up,
//! 20 and 20 on the way down).

use oit_gpu::{Buffer, Pass, Shader};

use super::workgroups;

const UP: &str = include_str!("sweep_up.wgsl");
const DOWN: &str = include_str!("sweep_down.wgsl");
const INNER: &str = include_str!("sweep_inner.wgsl");
const TOP: &str = include_str!("sweep_top.wgsl");

/// Values with those that fill them up to a power of two, of which there is a level at least.
pub(super) fn padded(length: u32) -> u64 {
    u64::from(length.max(2)).next_power_of_two()
}

/// See [`super::Scan::exclusive`]; in place, and the padding must be zero.
pub(super) fn exclusive(
    stage: &'static str,
    values: &str,
    length: u32,
    total: &str,
) -> (Vec<Buffer>, Vec<Pass>) {
    let n = padded(length);
    let levels = n.ilog2();
    let level = |level: u32, what: &str, parts: &[&str]| {
        let pairs = (n >> (level + 1)) as u32;
        let (row, dispatch) = workgroups(pairs.div_ceil(256));
        let half = 1u32 << level;
        let wgsl =
            format!("const PAIRS = {pairs}u;\nconst HALF = {half}u;\nconst ROW = {row}u;\n\n")
                + &parts.concat().replace("VALUES", values).replace("TOTAL", total);
        let label = format!("{stage}: {what}-sweep {values}, halves of {half}");
        Pass::compute(stage, Shader::new(label, wgsl), dispatch)
    };
    let up = (0..levels).map(|i| level(i, "up", &[UP]));
    let down = (0..levels).rev().map(|i| {
        let before = if i + 1 == levels { TOP } else { INNER };
        level(i, "down", &[before, DOWN])
    });
    (Vec::new(), up.chain(down).collect())
}
