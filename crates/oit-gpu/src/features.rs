//! What shaders may use beyond WGSL's core, and what of it a device has.

use crate::limits::chain;
use naga::Module;
use naga::valid::{
    Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationError, ValidationFlags,
    Validator,
};

/// What a shader may use, or a device has, beyond WGSL's core.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Features {
    pub(crate) capabilities: Capabilities,
    /// The stages in which subgroup operations can be used.
    pub(crate) subgroup_stages: ShaderStages,
    pub(crate) subgroup_operations: SubgroupOperationSet,
}

/// What each capability is in words.
const CAPABILITIES: [(Capabilities, &str); 7] = [
    (Capabilities::SUBGROUP, "subgroup operations"),
    (Capabilities::SUBGROUP_BARRIER, "subgroup barriers"),
    (Capabilities::EARLY_DEPTH_TEST, "forced early depth test"),
    (Capabilities::SHADER_FLOAT16_IN_FLOAT32, "16-bit floats packed in 32 bits"),
    (Capabilities::SHADER_INT64, "64-bit integers"),
    // Minimum and maximum without a result are in the second of these, all else is in the first.
    (Capabilities::SHADER_INT64_ATOMIC_ALL_OPS, "64-bit integer atomics with a result"),
    (Capabilities::SHADER_INT64_ATOMIC_MIN_MAX, "64-bit integer atomics"),
];

/// What each stage with subgroup operations is in words.
const STAGES: [(ShaderStages, &str); 2] = [
    (ShaderStages::COMPUTE, "subgroup operations in compute shaders"),
    (ShaderStages::FRAGMENT, "subgroup operations in fragment shaders"),
];

/// What each kind of subgroup operation is in words.
const OPERATIONS: [(SubgroupOperationSet, &str); 7] = [
    (SubgroupOperationSet::BASIC, "basic subgroup operations"),
    (SubgroupOperationSet::VOTE, "subgroup votes"),
    (SubgroupOperationSet::ARITHMETIC, "subgroup arithmetic"),
    (SubgroupOperationSet::BALLOT, "subgroup ballots and broadcasts"),
    (SubgroupOperationSet::SHUFFLE, "subgroup shuffles"),
    (SubgroupOperationSet::SHUFFLE_RELATIVE, "relative subgroup shuffles"),
    (SubgroupOperationSet::QUAD_FRAGMENT_COMPUTE, "quad operations"),
];

impl Features {
    /// All that a shader may use: what both backends can offer. A device that lacks some of it
    /// refuses the shaders that need it.
    pub(crate) const ALL: Self = Self {
        capabilities: Capabilities::SUBGROUP
            .union(Capabilities::SUBGROUP_BARRIER)
            .union(Capabilities::EARLY_DEPTH_TEST)
            .union(Capabilities::SHADER_FLOAT16_IN_FLOAT32)
            .union(Capabilities::SHADER_INT64)
            .union(Capabilities::SHADER_INT64_ATOMIC_MIN_MAX)
            .union(Capabilities::SHADER_INT64_ATOMIC_ALL_OPS),
        subgroup_stages: ShaderStages::COMPUTE.union(ShaderStages::FRAGMENT),
        subgroup_operations: SubgroupOperationSet::all(),
    };

    /// Validates a module that may use so much and no more.
    ///
    /// # Errors
    /// As naga has them.
    pub(crate) fn validate(
        &self,
        module: &Module,
    ) -> Result<ModuleInfo, Box<naga::WithSpan<ValidationError>>> {
        let mut validator = Validator::new(ValidationFlags::all(), self.capabilities);
        validator
            .subgroup_stages(self.subgroup_stages)
            .subgroup_operations(self.subgroup_operations)
            .validate(module)
            .map_err(Box::new)
    }

    /// Whether a device with these features runs a module that is valid with [`Self::ALL`].
    ///
    /// # Errors
    /// What the module needs and these features lack, in words.
    pub(crate) fn suffice(&self, module: &Module) -> Result<(), String> {
        if *self == Self::ALL {
            return Ok(());
        }
        let Err(error) = self.validate(module) else { return Ok(()) };
        // The module needs what it is not valid without.
        let needs = |all_but: Self| all_but.validate(module).is_err();
        let all = Self::ALL;
        let mut lacking = Vec::new();
        for (capability, words) in CAPABILITIES {
            let capabilities = all.capabilities - capability;
            if !self.capabilities.contains(capability) && needs(Self { capabilities, ..all }) {
                lacking.push(words);
            }
        }
        for (stage, words) in STAGES {
            let subgroup_stages = all.subgroup_stages - stage;
            if !self.subgroup_stages.contains(stage) && needs(Self { subgroup_stages, ..all }) {
                lacking.push(words);
            }
        }
        for (operation, words) in OPERATIONS {
            let subgroup_operations = all.subgroup_operations - operation;
            let lacks = !self.subgroup_operations.contains(operation);
            if lacks && needs(Self { subgroup_operations, ..all }) {
                lacking.push(words);
            }
        }
        match lacking.is_empty() {
            true => Err(chain(error.as_inner())),
            false => Err(lacking.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lacking(wgsl: &str, has: Features) -> Result<(), String> {
        let module = naga::front::wgsl::parse_str(wgsl).expect("it parses");
        Features::ALL.validate(&module).expect("it is valid");
        has.suffice(&module)
    }

    #[test]
    fn what_a_module_needs_follows_from_its_code() {
        let all = Features::ALL;
        let without =
            |capabilities| Features { capabilities: all.capabilities - capabilities, ..all };
        let chain = "
            @group(0) @binding(0) var<storage, read_write> slots: array<atomic<u64>>;
            @compute @workgroup_size(1) fn main() {
                let old = atomicMax(&slots[0], 3lu);
                atomicMax(&slots[1], old);
            }";
        let last = "
            @group(0) @binding(0) var<storage, read_write> slots: array<atomic<u64>>;
            @compute @workgroup_size(1) fn main() { atomicMax(&slots[0], 3lu); }";
        let plain = "@compute @workgroup_size(1) fn main() {}";
        let all_ops = without(Capabilities::SHADER_INT64_ATOMIC_ALL_OPS);
        let atomics = without(
            Capabilities::SHADER_INT64_ATOMIC_ALL_OPS | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX,
        );
        assert_eq!(lacking(chain, all), Ok(()));
        let words = "64-bit integer atomics with a result";
        assert_eq!(lacking(chain, all_ops), Err(words.to_owned()));
        assert_eq!(lacking(chain, atomics), Err(words.to_owned()));
        assert_eq!(lacking(last, all_ops), Ok(()));
        assert!(lacking(last, atomics).is_err());
        assert_eq!(lacking(plain, atomics), Ok(()));
        let words = Err("64-bit integers".to_owned());
        assert_eq!(lacking(chain, without(Capabilities::SHADER_INT64)), words);
    }

    #[test]
    fn subgroups_are_lacking_by_stage_and_by_operation() {
        let all = Features::ALL;
        let fragment = "
            @group(0) @binding(0) var<storage, read_write> sums: array<u32>;
            @fragment fn fs(@builtin(subgroup_invocation_id) lane: u32) {
                sums[lane] = subgroupAdd(1u);
            }";
        let compute = "
            @group(0) @binding(0) var<storage, read_write> sums: array<u32>;
            @compute @workgroup_size(8) fn main(@builtin(local_invocation_index) i: u32) {
                sums[i] = subgroupShuffle(i, 0u);
            }";
        let no_fragment = Features { subgroup_stages: ShaderStages::COMPUTE, ..all };
        let words = Err("subgroup operations in fragment shaders".to_owned());
        assert_eq!(lacking(fragment, no_fragment), words);
        assert_eq!(lacking(compute, no_fragment), Ok(()));
        let no_shuffle = SubgroupOperationSet::all() - SubgroupOperationSet::SHUFFLE;
        let no_shuffle = Features { subgroup_operations: no_shuffle, ..all };
        assert_eq!(lacking(compute, no_shuffle), Err("subgroup shuffles".to_owned()));
        assert_eq!(lacking(fragment, no_shuffle), Ok(()));
    }
}
