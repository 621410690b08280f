//! One pass over the values: decoupled look-back (Merrill and Garland, "Single-pass Parallel Prefix
//! Scan with Decoupled Look-back", NVIDIA technical report NVR-2016-002), with the fallback of
//! Smith, Levien and Owens ("Decoupled Fallback: A Portable Single-Pass GPU Scan", SPAA 2025).
//!
//! A workgroup scans a block and publishes its sum; the sum before it is gathered from the
//! workgroups before it, each of which has published either the sum of its block or that of all up
//! to it. A device need not let a waiting workgroup's predecessors go on, so none waits for long:
//! after a few polls it adds up the missing block itself and publishes the sum in its owner's stead.
//! To that end the values stay as they are, and the sums go to another buffer.
//!
//! Each value is read once (twice in blocks that are added up for another) and each sum written
//! once: 8 bytes a value, and for each 1024 of them a word that is cleared, written twice and read
//! by some of the workgroups behind it.

use oit_gpu::{Buffer, Pass, Shader};

use super::{BLOCK, workgroups};

/// Two of a word's 32 bits say what it holds, so that both change in one atomic operation and no
/// order of two is asked of the memory.
pub(super) const LIMIT: u64 = 1 << 30;

/// See [`super::Scan::exclusive`]; from one buffer to another.
pub(super) fn exclusive(
    stage: &'static str,
    values: &str,
    sums: &str,
    length: u32,
    total: &str,
) -> (Vec<Buffer>, Vec<Pass>) {
    let blocks = length.div_ceil(BLOCK).max(1);
    let (_, dispatch) = workgroups(blocks);
    let status = format!("{sums}_status");
    let constants = format!("const LENGTH = {length}u;\nconst BLOCKS = {blocks}u;\n\n");
    let wgsl = constants
        + &include_str!("look_back.wgsl")
            .replace("VALUES", values)
            .replace("SUMS", sums)
            .replace("STATUS", &status)
            .replace("TOTAL", total);
    let shader = Shader::new(format!("{stage}: look back over {values}"), wgsl);
    (
        vec![Buffer::new(&status, 4 * (u64::from(blocks) + 1))],
        vec![Pass::clear(stage, &status), Pass::compute(stage, shader, dispatch)],
    )
}
