//! Parallel prefix sums (Ladner and Fischer 1980, as the LFB chapter uses them, section 20.4), for
//! any length, in three ways. All need workgroup memory only: no subgroups.

mod blocks;
mod look_back;
mod sweep;
#[cfg(test)]
mod tests;

use oit_gpu::{Buffer, Dispatch, Pass};

/// Values of a block: 256 invocations with four each.
const BLOCK: u32 = 1024;

/// Workgroups in x before a dispatch goes on in y.
const MAX_WORKGROUPS_X: u32 = 32768;

/// How prefix sums are computed. Of the same values all give the same sums.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Scan {
    /// Reduce, then scan, by blocks: three passes up to 2^20 values, five up to 2^30. Reads 8 bytes
    /// a value and writes 4.
    Blocks,
    /// The chapter's: values padded to a power of two, then up-sweep and down-sweep with one pass a
    /// level in device memory, `2 * log2(n)` in all. Reads 16 bytes a value and writes 12, most of
    /// them far apart.
    Sweep,
    /// One pass by decoupled look-back. Reads 4 bytes a value and writes 4, to another buffer.
    LookBack,
}

impl Scan {
    /// Whether the sums take the place of the values.
    pub(crate) fn in_place(self) -> bool {
        self != Self::LookBack
    }

    /// Words that a buffer of this many values must have. Those behind the values must be zero.
    pub(crate) fn words(self, length: u32) -> u64 {
        match self {
            Self::Sweep => sweep::padded(length),
            Self::Blocks | Self::LookBack => u64::from(length),
        }
    }

    /// The first total that is too large. Below it the sums are exact.
    pub(crate) fn limit(self) -> u64 {
        match self {
            Self::Blocks | Self::Sweep => 1 << 32,
            Self::LookBack => look_back::LIMIT,
        }
    }

    /// Passes that put into `sums`, for each of the first `length` values (`u32`) of a buffer, the
    /// sum of those before it, and into the first word of the buffer `total` the sum of all.
    /// Returned with buffers of their own; `values`, `sums` and `total` are the caller's. Where the
    /// scan is in place, `sums` is `values`.
    pub(crate) fn exclusive(
        self,
        stage: &'static str,
        values: &str,
        sums: &str,
        length: u32,
        total: &str,
    ) -> (Vec<Buffer>, Vec<Pass>) {
        debug_assert_eq!(self.in_place(), values == sums, "{self:?}: {values} to {sums}");
        match self {
            Self::Blocks => blocks::exclusive(stage, values, length, total),
            Self::Sweep => sweep::exclusive(stage, values, length, total),
            Self::LookBack => look_back::exclusive(stage, values, sums, length, total),
        }
    }
}

/// A dispatch of at least this many workgroups, and how many of them are in a row: the one at
/// `(x, y)` has the number `y * row + x`.
pub(crate) fn workgroups(count: u32) -> (u32, Dispatch) {
    let row = count.clamp(1, MAX_WORKGROUPS_X);
    (row, Dispatch::Workgroups([row, count.div_ceil(row).max(1), 1]))
}
