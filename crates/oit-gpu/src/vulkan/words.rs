//! SPIR-V as words: what rewrites it shares.

/// Words before the first instruction.
pub(super) const HEADER_WORDS: usize = 5;

/// Every instruction of a module: its opcode and its words, the first included.
pub(crate) fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(HEADER_WORDS..).unwrap_or_default();
    std::iter::from_fn(move || {
        // Its length is in the upper half of the first word, its opcode in the lower.
        let first = *rest.first()?;
        let length = ((first >> 16) as usize).clamp(1, rest.len());
        let (instruction, after) = rest.split_at(length);
        rest = after;
        Some((first & 0xffff, instruction))
    })
}

/// The words of an instruction.
pub(super) fn instruction(opcode: u32, operands: &[u32]) -> Vec<u32> {
    let length = operands.len() as u32 + 1;
    [&[length << 16 | opcode], operands].concat()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use naga::back::spv;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    /// The SPIR-V of a shader, as naga writes it.
    pub(in super::super) fn spirv(wgsl: &str) -> Vec<u32> {
        let module = naga::front::wgsl::parse_str(wgsl).expect("it parses");
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator.validate(&module).expect("it is valid");
        spv::write_vec(&module, &info, &spv::Options::default(), None).expect("it is written")
    }

    #[test]
    fn instructions_end_where_the_module_does() {
        let words = spirv("@compute @workgroup_size(1) fn main() {}");
        let all: Vec<u32> =
            instructions(&words).flat_map(|(_, words)| words.iter().copied()).collect();
        assert_eq!(all, words[HEADER_WORDS..]);
        assert_eq!(instructions(&words[..3]).count(), 0);
        assert_eq!(instruction(59, &[1, 2, 3]), [4 << 16 | 59, 1, 2, 3]);
        // A length of zero is damage and ends nothing.
        assert_eq!(instructions(&[0; 7]).count(), 2);
    }
}
