//! What drivers tell of resolve programs, in common columns.

use oit_record::{Executable, Program, StatisticValue};

/// The figures of a program, where its driver gives them. What it does not give is `None`, never 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ProgramFigures {
    /// Registers of an invocation; on Intel's GPUs those of a subgroup, of 32 bytes or more each.
    pub registers: Option<u64>,
    /// Local memory of an invocation, in bytes: arrays that are not in registers, and spills.
    pub local_bytes: Option<u64>,
    /// Memory of a workgroup, in bytes.
    pub workgroup_bytes: Option<u64>,
    /// Code, in bytes.
    pub binary_bytes: Option<u64>,
    /// Subgroups that a processor can hold at once.
    pub occupancy: Option<u64>,
}

/// A column of [`ProgramFigures`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Column {
    Registers,
    LocalBytes,
    WorkgroupBytes,
    BinaryBytes,
    Occupancy,
}

/// What a driver's figure is for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Per {
    /// As the column has it.
    Same,
    /// For a subgroup, where the column is for an invocation.
    Subgroup,
    /// In the low 32 bits: NVIDIA's driver 580 has 16 in the high ones, whatever the program.
    LowWord,
}

/// The drivers' names of what the columns hold. Case does not matter: drivers have changed it. Of two
/// names of one column the first that is told counts. AMD's and Intel's are those of Mesa (RADV and ANV).
/// NVIDIA documents none: they are what its driver 580 tells.
const NAMES: &[(Column, &str, Per)] = &[
    (Column::Registers, "Register Count", Per::Same), // NVIDIA
    (Column::Registers, "VGPRs", Per::Same),          // AMD
    (Column::Registers, "Max live registers", Per::Same), // Intel
    (Column::LocalBytes, "Local Memory Size", Per::LowWord), // NVIDIA
    (Column::LocalBytes, "Stack Size", Per::Same),    // NVIDIA
    (Column::LocalBytes, "Scratch size", Per::Subgroup), // AMD
    (Column::LocalBytes, "Scratch Memory Size", Per::Same), // Intel
    (Column::WorkgroupBytes, "Shared Memory Size", Per::Same), // NVIDIA
    (Column::WorkgroupBytes, "LDS size", Per::Same),  // AMD
    (Column::WorkgroupBytes, "Workgroup Memory Size", Per::Same), // Intel
    (Column::BinaryBytes, "Binary Size", Per::Same),  // NVIDIA
    (Column::BinaryBytes, "Code size", Per::Same),    // AMD, Intel
    (Column::Occupancy, "Subgroups per SIMD", Per::Same), // AMD
    (Column::Occupancy, "Max Waves", Per::Same),      // AMD, in older releases of Mesa
];

/// The executable that does a program's work, in this shader stage: the one that was made of it,
/// the only one, or of several the one with the largest subgroups.
#[must_use]
pub fn executable<'a>(program: &'a Program, shader_stage: &str) -> Option<&'a Executable> {
    let all = program.executables.as_deref()?;
    if let [only] = all {
        return Some(only);
    }
    let of_stage = all.iter().filter(|one| one.stages.iter().any(|stage| stage == shader_stage));
    of_stage.max_by_key(|executable| executable.subgroup_size)
}

impl ProgramFigures {
    /// The figures of a program in this shader stage.
    #[must_use]
    pub fn of(program: &Program, shader_stage: &str) -> Self {
        let Some(executable) = executable(program, shader_stage) else { return Self::default() };
        let told = |column| told(executable, column);
        Self {
            registers: told(Column::Registers),
            local_bytes: told(Column::LocalBytes),
            workgroup_bytes: told(Column::WorkgroupBytes),
            binary_bytes: told(Column::BinaryBytes),
            occupancy: told(Column::Occupancy),
        }
    }
}

fn told(executable: &Executable, column: Column) -> Option<u64> {
    let names = NAMES.iter().filter(|(of, ..)| *of == column);
    let mut found = names.filter_map(|(_, name, per)| {
        let mut statistics = executable.statistics.iter();
        let statistic = statistics.find(|told| told.name.eq_ignore_ascii_case(name))?;
        let value = match statistic.value {
            StatisticValue::Unsigned(value) => value,
            StatisticValue::Float(value) if value >= 0.0 => value.ceil() as u64,
            // No count and no size.
            _ => return None,
        };
        Some(match per {
            Per::Same => value,
            Per::LowWord => value & u64::from(u32::MAX),
            Per::Subgroup => value.div_ceil(u64::from(executable.subgroup_size.max(1))),
        })
    });
    found.next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use oit_record::Statistic;

    fn made_of(stage: &str, subgroup_size: u32, told: &[(&str, StatisticValue)]) -> Executable {
        let statistics = told.iter().map(|&(name, value)| {
            let (name, description) = (name.to_owned(), String::new());
            Statistic { name, description, value }
        });
        let (name, stages) = (stage.to_owned(), vec![stage.to_owned()]);
        Executable { name, stages, subgroup_size, statistics: statistics.collect() }
    }

    fn program(executables: Option<Vec<Executable>>) -> Program {
        Program {
            sort: "rbs".to_owned(),
            store: "local".to_owned(),
            low: 1,
            high: 8,
            invocations: None,
            declared_workgroup_bytes: None,
            compile_ns: None,
            from_cache: None,
            executables,
        }
    }

    const fn whole(value: u64) -> StatisticValue {
        StatisticValue::Unsigned(value)
    }

    #[test]
    fn names_of_several_drivers_come_to_the_same_columns() {
        let nvidia = [("Register Count", whole(40)), ("Stack Size", whole(0))];
        let vertex = made_of("vertex", 32, &[("Register Count", whole(99))]);
        let both = program(Some(vec![vertex, made_of("fragment", 32, &nvidia)]));
        let figures = ProgramFigures::of(&both, "fragment");
        assert_eq!((figures.registers, figures.local_bytes), (Some(40), Some(0)));
        let told = [("Local Memory Size", whole((16 << 32) + 2048)), ("Stack Size", whole(0))];
        let one = program(Some(vec![made_of("compute", 32, &told)]));
        assert_eq!(ProgramFigures::of(&one, "compute").local_bytes, Some(2048));
        // What is not told is not 0.
        assert_eq!((figures.workgroup_bytes, figures.occupancy), (None, None));

        let amd = [
            ("VGPRs", whole(24)),
            ("Scratch size", whole(4100)),
            ("LDS Size", whole(512)),
            ("Code size", whole(1000)),
            ("Subgroups per SIMD", whole(16)),
        ];
        let figures =
            ProgramFigures::of(&program(Some(vec![made_of("compute", 64, &amd)])), "compute");
        let expected = ProgramFigures {
            registers: Some(24),
            local_bytes: Some(65),
            workgroup_bytes: Some(512),
            binary_bytes: Some(1000),
            occupancy: Some(16),
        };
        assert_eq!(figures, expected);
    }

    #[test]
    fn of_several_variants_the_widest_counts() {
        let of =
            |width, spills| made_of("fragment", width, &[("Max live registers", whole(spills))]);
        let intel = program(Some(vec![of(8, 40), of(32, 120), of(16, 60)]));
        assert_eq!(ProgramFigures::of(&intel, "fragment").registers, Some(120));
        // Not of this stage.
        assert_eq!(ProgramFigures::of(&intel, "compute"), ProgramFigures::default());
    }

    #[test]
    fn a_driver_that_tells_nothing_gives_nothing() {
        assert_eq!(ProgramFigures::of(&program(None), "compute"), ProgramFigures::default());
        let odd = [("Register Count", StatisticValue::Signed(-1))];
        let odd = program(Some(vec![made_of("compute", 32, &odd)]));
        assert_eq!(ProgramFigures::of(&odd, "compute").registers, None);
    }
}
