//! Gives SPIR-V the sample mask as Vulkan has it: an array of 32 bits each.
//!
//! WGSL's `@builtin(sample_mask)` is one `u32`, and naga 30 writes a variable of that type. Vulkan
//! wants an array of them (VUID-SampleMask-SampleMask-04359), of which this is the first element.

use super::words::{HEADER_WORDS, instruction, instructions};
use std::collections::HashMap;

const OP_TYPE_ARRAY: u32 = 28;
const OP_TYPE_POINTER: u32 = 32;
const OP_CONSTANT: u32 = 43;
const OP_VARIABLE: u32 = 59;
const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_ACCESS_CHAIN: u32 = 65;
const OP_DECORATE: u32 = 71;
const DECORATION_BUILT_IN: u32 = 11;
const BUILT_IN_SAMPLE_MASK: u32 = 20;
/// The word of the header that is one more than the largest id.
const BOUND: usize = 3;

/// A sample mask that became an array.
struct Mask {
    /// The type of a pointer to its element.
    pointer: u32,
    /// The constant 0.
    zero: u32,
}

/// The module with every scalar sample mask an array of one; all else stays.
pub(super) fn as_array(words: &[u32]) -> Vec<u32> {
    let decorated: Vec<u32> = instructions(words)
        .filter_map(|(opcode, words)| match (opcode, words) {
            (OP_DECORATE, &[_, id, DECORATION_BUILT_IN, BUILT_IN_SAMPLE_MASK]) => Some(id),
            _ => None,
        })
        .collect();
    if decorated.is_empty() {
        return words.to_vec();
    }
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut bound = words[BOUND];
    let mut new_id = || {
        bound += 1;
        bound - 1
    };
    let mut arrays = Vec::new();
    let mut pointees = HashMap::new();
    let mut masks: HashMap<u32, Mask> = HashMap::new();
    for (opcode, words) in instructions(words) {
        match (opcode, words) {
            (OP_TYPE_ARRAY, &[_, id, ..]) => arrays.push(id),
            (OP_TYPE_POINTER, &[_, id, _, to]) => drop(pointees.insert(id, to)),
            (OP_VARIABLE, &[_, pointer, id, class]) if decorated.contains(&id) => {
                let scalar = pointees.get(&pointer).filter(|to| !arrays.contains(to));
                if let Some(&scalar) = scalar {
                    let [zero, one, array, to_array] = [(); 4].map(|()| new_id());
                    out.extend(instruction(OP_CONSTANT, &[scalar, zero, 0]));
                    out.extend(instruction(OP_CONSTANT, &[scalar, one, 1]));
                    out.extend(instruction(OP_TYPE_ARRAY, &[array, scalar, one]));
                    out.extend(instruction(OP_TYPE_POINTER, &[to_array, class, array]));
                    out.extend(instruction(OP_VARIABLE, &[to_array, id, class]));
                    masks.insert(id, Mask { pointer, zero });
                    continue;
                }
            }
            (OP_LOAD, &[_, ty, id, from, ..]) => {
                if let Some(Mask { pointer, zero }) = masks.get(&from) {
                    let element = new_id();
                    out.extend(instruction(OP_ACCESS_CHAIN, &[*pointer, element, from, *zero]));
                    out.extend(instruction(OP_LOAD, &[ty, id, element]));
                    continue;
                }
            }
            (OP_STORE, &[_, to, value, ..]) => {
                if let Some(Mask { pointer, zero }) = masks.get(&to) {
                    let element = new_id();
                    out.extend(instruction(OP_ACCESS_CHAIN, &[*pointer, element, to, *zero]));
                    out.extend(instruction(OP_STORE, &[element, value]));
                    continue;
                }
            }
            _ => {}
        }
        out.extend_from_slice(words);
    }
    out[BOUND] = bound;
    out
}

#[cfg(test)]
mod tests {
    use super::super::words::tests::spirv;
    use super::*;

    fn count(words: &[u32], wanted: u32) -> usize {
        instructions(words).filter(|&(opcode, _)| opcode == wanted).count()
    }

    #[test]
    fn masks_become_arrays_and_their_uses_the_first_element() {
        let words = spirv(
            "struct Out { @builtin(sample_mask) mask: u32, @location(0) color: vec4<f32> }
             @fragment fn fs(@builtin(sample_mask) mask: u32) -> Out {
                 return Out(mask & 5u, vec4<f32>(f32(mask)));
             }",
        );
        let new = as_array(&words);
        assert_eq!(count(&new, OP_TYPE_ARRAY), count(&words, OP_TYPE_ARRAY) + 2);
        assert_eq!(count(&new, OP_ACCESS_CHAIN), count(&words, OP_ACCESS_CHAIN) + 2);
        for opcode in [OP_VARIABLE, OP_LOAD, OP_STORE] {
            assert_eq!(count(&new, opcode), count(&words, opcode), "{opcode}");
        }
        // Four ids of each mask, and one of each use.
        assert_eq!(new[BOUND], words[BOUND] + 2 * 4 + 2);
        assert_eq!(as_array(&new), new, "an array stays");
    }

    #[test]
    fn modules_without_a_mask_stay() {
        let words = spirv("@fragment fn fs() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }");
        assert_eq!(as_array(&words), words);
    }
}
