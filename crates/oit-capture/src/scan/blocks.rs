//! Sums of blocks, sums of blocks of these, and down again block by block.
//!
//! Each level is read twice and written once: 12 bytes a value, and 16 more for each 1024.

use oit_gpu::{Buffer, Pass, Shader};

use super::{BLOCK, workgroups};

const SUM: &str = include_str!("blocks_sum.wgsl");
const BLOCK_SCAN: &str = include_str!("blocks_scan.wgsl");
const INNER: &str = include_str!("blocks_inner.wgsl");
const TOP: &str = include_str!("blocks_top.wgsl");

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
        let (row, dispatch) = workgroups(blocks);
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
        Pass::compute(stage, Shader::new(label, wgsl), dispatch)
    }
}

/// See [`super::Scan::exclusive`]; in place.
pub(super) fn exclusive(
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
