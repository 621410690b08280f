//! Takes from SPIR-V the zeros that WGSL puts into every array of a function.
//!
//! WGSL defines a variable without a value as zero, and naga writes that as an initializer, which no
//! form of WGSL avoids. For a sorting array of 256 fragments it is 2 KiB of stores before the first
//! fragment is read; the papers' GLSL has none. So arrays of this backend hold anything before they
//! are written, and a shader may not read what it has not written.

use super::words::{HEADER_WORDS, instruction, instructions};
use std::collections::HashSet;

const OP_TYPE_ARRAY: u32 = 28;
const OP_CONSTANT_NULL: u32 = 46;
const OP_VARIABLE: u32 = 59;

/// The module with no variable of an array type initialized to zero; all else stays.
pub(super) fn leave_arrays_unset(words: &[u32]) -> Vec<u32> {
    let mut arrays = HashSet::new();
    let mut nulls = HashSet::new();
    let mut out = words[..words.len().min(HEADER_WORDS)].to_vec();
    for (opcode, words) in instructions(words) {
        match (opcode, words) {
            (OP_TYPE_ARRAY, [_, id, ..]) => {
                arrays.insert(*id);
            }
            (OP_CONSTANT_NULL, [_, of, id]) if arrays.contains(of) => {
                nulls.insert(*id);
            }
            (OP_VARIABLE, [_, pointer, id, class, initializer]) if nulls.contains(initializer) => {
                out.extend(instruction(OP_VARIABLE, &[*pointer, *id, *class]));
                continue;
            }
            _ => {}
        }
        out.extend_from_slice(words);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::words::tests::spirv;
    use super::*;

    /// Variables with an initializer.
    fn initialized(words: &[u32]) -> usize {
        instructions(words).filter(|&(op, words)| op == OP_VARIABLE && words.len() == 5).count()
    }

    #[test]
    fn arrays_lose_their_zeros_and_scalars_keep_them() {
        let words = spirv(
            "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
             @compute @workgroup_size(1) fn main() {
                 var list: array<vec2<u32>, 64>;
                 var n: u32;
                 for (var i = 0u; i < out[0]; i += 1u) { list[i] = vec2<u32>(i, n); n += 2u; }
                 out[1] = list[out[2]].y + n;
             }",
        );
        let before = initialized(&words);
        assert!(before >= 2, "naga initializes both: {before}");
        let unset = leave_arrays_unset(&words);
        assert_eq!(initialized(&unset), before - 1);
        assert_eq!(unset.len(), words.len() - 1);
        assert_eq!(leave_arrays_unset(&unset), unset);
    }
}
