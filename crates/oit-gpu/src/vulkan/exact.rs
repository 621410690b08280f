//! Forbids a driver to make one operation of several in SPIR-V, which rounds once instead of twice.
//!
//! A driver may turn a product and a sum into one multiply-add in one program and not in another. Where
//! programs must agree to the last bit, as those that count fragments and those that capture them, the
//! decoration `NoContraction` says that it may not. WGSL has no such word, and naga writes none.

use super::words::{HEADER_WORDS, instruction, instructions};

const OP_TYPE_VOID: u32 = 19;
const OP_TYPE_FORWARD_POINTER: u32 = 39;
const OP_DECORATE: u32 = 71;
/// `OpFNegate`, `OpFAdd`, `OpFSub`, `OpFMul`, `OpFDiv`, `OpFRem` and `OpFMod`, and those of vectors and
/// matrices from `OpVectorTimesScalar` to `OpDot`.
const OF_FLOATS: [u32; 14] = [127, 129, 131, 133, 136, 140, 141, 142, 143, 144, 145, 146, 147, 148];
const DECORATION_NO_CONTRACTION: u32 = 42;

/// The module with `NoContraction` on every operation of floats; all else stays.
pub(super) fn without_contraction(words: &[u32]) -> Vec<u32> {
    let decorations = instructions(words).filter_map(|(opcode, words)| match words {
        &[_, _, result, ..] if OF_FLOATS.contains(&opcode) => {
            Some(instruction(OP_DECORATE, &[result, DECORATION_NO_CONTRACTION]))
        }
        _ => None,
    });
    let mut decorations = Some(decorations.flatten().collect::<Vec<u32>>());
    let mut out = words[..words.len().min(HEADER_WORDS)].to_vec();
    for (opcode, words) in instructions(words) {
        // Annotations end where types begin.
        if (OP_TYPE_VOID..=OP_TYPE_FORWARD_POINTER).contains(&opcode) {
            out.extend(decorations.take().unwrap_or_default());
        }
        out.extend_from_slice(words);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::words::tests::spirv;
    use super::*;

    fn decorated(words: &[u32]) -> Vec<u32> {
        instructions(words)
            .filter_map(|(opcode, words)| match (opcode, words) {
                (OP_DECORATE, &[_, id, DECORATION_NO_CONTRACTION]) => Some(id),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn every_operation_of_floats_is_decorated_and_no_other() {
        let words = spirv(
            "@group(0) @binding(0) var<storage, read_write> out: array<vec4<f32>>;
             @compute @workgroup_size(1) fn main(@builtin(local_invocation_index) i: u32) {
                 let v = out[i * 3u + 1u];
                 out[i % 5u] = v * v.x + v / v.wzyx - v;
                 out[i - 2u].x = dot(v, v) * -v.y;
             }",
        );
        assert!(decorated(&words).is_empty());
        let new = without_contraction(&words);
        // Times a scalar, plus, by, minus; dot, minus, times.
        assert_eq!(decorated(&new).len(), 7);
        assert_eq!(new.len(), words.len() + 7 * 3);
        let (types, last) = (
            instructions(&new).position(|(opcode, _)| opcode == OP_TYPE_VOID),
            instructions(&new).collect::<Vec<_>>(),
        );
        let last = last.iter().rposition(|&(opcode, _)| opcode == OP_DECORATE);
        assert!(last < types, "annotations come before types");
    }

    #[test]
    fn modules_without_floats_stay() {
        let words = spirv("@compute @workgroup_size(1) fn main() {}");
        assert_eq!(without_contraction(&words), words);
    }
}
