//! Parallel prefix sums (Ladner and Fischer 1980, as the LFB chapter uses them, section 20.4), for
//! any length: sums of blocks, sums of blocks of these, down again block by block.
//!
//! Each level is read twice and written once, and needs workgroup memory only: no subgroups, no
//! power of two.

use oit_gpu::{Buffer, Dispatch, Pass, Shader};

/// Values of a block: 256 invocations with four each.
const BLOCK: u32 = 1024;

/// Workgroups in x before a dispatch goes on in y.
const MAX_WORKGROUPS_X: u32 = 32768;

const SUM: &str = include_str!("scan/sum.wgsl");
const BLOCK_SCAN: &str = include_str!("scan/block.wgsl");
const INNER: &str = include_str!("scan/inner.wgsl");
const TOP: &str = include_str!("scan/top.wgsl");

/// One level: a buffer and how many of its values count.
struct Level {
    name: String,
    length: u32,
}

impl Level {
    fn blocks(&self) -> u32 {
        self.length.div_ceil(BLOCK).max(1)
    }

    /// A pass over the blocks of this level. `sums` is the level above, or where the total goes.
    fn pass(&self, stage: &'static str, what: &str, parts: &[&str], sums: &str) -> Pass {
        let blocks = self.blocks();
        let row = blocks.min(MAX_WORKGROUPS_X);
        let constants = format!(
            "const LENGTH = {}u;\nconst BLOCKS = {blocks}u;\nconst ROW = {row}u;\n\n",
            self.length
        );
        let wgsl = constants
            + &parts
                .concat()
                .replace("VALUES", &self.name)
                .replace("SUMS", sums)
                .replace("TOTAL", sums);
        let label = format!("{stage}: {what} {}", self.name);
        let dispatch = Dispatch::Workgroups([row, blocks.div_ceil(row), 1]);
        Pass::compute(stage, Shader::new(label, wgsl), dispatch)
    }
}

/// Passes that replace each of the first `length` values (`u32`) of a buffer by the sum of those
/// before it, and put the sum of all into the first word of the buffer `total`. Sums are taken
/// modulo 2^32. Returned with the buffers of the levels in between; those of `values` and `total`
/// are the caller's.
pub(crate) fn exclusive_scan(
    stage: &'static str,
    values: &str,
    length: u32,
    total: &str,
) -> (Vec<Buffer>, Vec<Pass>) {
    let mut levels = vec![Level { name: values.into(), length }];
    while let Some(below) = levels.last()
        && below.blocks() > 1
    {
        let level =
            Level { name: format!("{values}_sums{}", levels.len()), length: below.blocks() };
        levels.push(level);
    }
    let top = levels.len() - 1;
    let up = (0..top).map(|i| levels[i].pass(stage, "sum blocks of", &[SUM], &levels[i + 1].name));
    let turn = levels[top].pass(stage, "scan", &[TOP, BLOCK_SCAN], total);
    let down = (0..top).rev().map(|i| {
        levels[i].pass(stage, "scan blocks of", &[INNER, BLOCK_SCAN], &levels[i + 1].name)
    });
    let passes = up.chain([turn]).chain(down).collect();
    let buffers = levels[1..].iter().map(|l| Buffer::new(&l.name, 4 * u64::from(l.length)));
    (buffers.collect(), passes)
}
