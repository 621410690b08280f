//! Assembles a resolve program in CUDA C++: layout, strategy and entry point, as NVRTC compiles it.

use crate::{Output, ProgramError, STRATEGIES, SortSpec, SortStrategy};
use minijinja::{Environment, context};
use std::fmt::Write as _;

/// Everything that makes a resolve program in CUDA: the counterpart of [`crate::Program`] for the
/// schedule `base`, the one that CUDA has.
#[derive(Clone, Copy)]
pub struct CudaProgram<'a> {
    /// How fragments are read.
    pub layout: CudaLayout<'a>,
    /// How they are sorted.
    pub strategy: &'a dyn SortStrategy,
    /// What the kernel is compiled for; `min_frags` means nothing here, since the program is run on
    /// every pixel.
    pub spec: SortSpec,
    /// What it makes.
    pub output: Output,
    /// Pixels of the picture.
    pub pixels: u32,
}

/// How a capture's fragments are read in CUDA. The source defines `struct Lfb` with a pointer for each
/// of the capture's buffers, by the buffer's name and a line each (`const u32 *heads;`), with
/// `u32 room` (the slots of `fragments`) and what else it needs, and
/// `INLINE void lfb_begin(Lfb &lfb, u32 pixel)`, `INLINE bool lfb_more(const Lfb &lfb)`,
/// `INLINE Frag lfb_next(Lfb &lfb)`; with random access also `INLINE u32 lfb_len(const Lfb &lfb)` and
/// `INLINE Frag lfb_at(const Lfb &lfb, u32 i)`, both for the pixel last begun.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CudaLayout<'a> {
    /// The capture's name.
    pub name: &'a str,
    /// The CUDA C++.
    pub source: &'a str,
    /// Whether the i-th fragment can be read without reading those before it.
    pub random_access: bool,
}

impl<'a> CudaLayout<'a> {
    /// The buffers that it reads, in the order of the kernel's parameters.
    #[must_use]
    pub fn buffers(&self) -> Vec<&'a str> {
        self.members().into_iter().map(|(_, name)| name).collect()
    }

    /// The pointers of `struct Lfb`: what they point to, and their names.
    fn members(&self) -> Vec<(&'a str, &'a str)> {
        let body = self.source.split_once("struct Lfb {").map_or("", |(_, rest)| rest);
        let body = body.split_once("};").map_or("", |(body, _)| body);
        let member = |line: &'a str| {
            let line = line.trim().strip_prefix("const ")?.strip_suffix(';')?;
            line.split_once(" *")
        };
        body.lines().filter_map(member).collect()
    }
}

/// Threads of a block, in one dimension: as many as invocations of a compute program's workgroup.
pub const CUDA_THREADS: u32 = crate::INVOCATIONS;

/// The name of the program's kernel. Its parameters are the layout's buffers in their order, the
/// slots of `fragments` (`u32`), and the picture (a `float4` a pixel), or with [`Output::Emit`] where
/// each pixel's fragments go (`u32` a pixel) and where they all go.
pub const CUDA_KERNEL: &str = "resolve";

impl CudaProgram<'_> {
    /// The program's CUDA C++: the prelude, the layout, the strategy's kernel, the entry point.
    ///
    /// # Errors
    /// Where the strategy has no kernel in CUDA for that store, or cannot be compiled for the spec, or a template
    /// fails.
    pub fn source(&self) -> Result<String, ProgramError> {
        let strategy = self.strategy.name();
        self.spec.check(self.strategy)?;
        let default = self.strategy.stores().first() == Some(&self.spec.store);
        let template = self.strategy.cuda_template().filter(|_| default);
        let template = template.ok_or(ProgramError::NoCuda { strategy })?;
        self.assemble(template).map_err(|source| ProgramError::Template {
            strategy,
            layout: self.layout.name.to_owned(),
            source,
        })
    }

    fn assemble(&self, template: &'static str) -> Result<String, minijinja::Error> {
        let mut environment = crate::program::environment();
        for strategy in STRATEGIES {
            if let Some(template) = strategy.cuda_template() {
                environment.add_template(strategy.name(), template)?;
            }
        }
        environment.add_template(self.strategy.name(), template)?;
        environment.add_template("prelude.cuh", include_str!("prelude.cuh.j2"))?;
        environment.add_template("entry.cu", include_str!("entry.cu.j2"))?;
        self.render(&environment)
    }

    fn render(&self, environment: &Environment) -> Result<String, minijinja::Error> {
        let spec = &self.spec;
        let context = context! {
            max_frags => spec.max_frags,
            ties => spec.ties.name(),
            store => spec.store.name(),
            random_access => self.layout.random_access,
            values => self.strategy.values(spec),
            emit => self.output == Output::Emit,
            buffers => self.layout.members(),
            threads => CUDA_THREADS,
            pixels => self.pixels,
        };
        let render = |name: &str| environment.get_template(name)?.render(&context);
        let mut source = render("prelude.cuh")?;
        let parts = [
            ("Layout", self.layout.name, self.layout.source.to_owned()),
            ("Sort", self.strategy.name(), render(self.strategy.name())?),
            ("Entry", "pixels", render("entry.cu")?),
        ];
        for (part, name, text) in parts {
            let _ = write!(source, "\n// {part}: {name}.\n\n{}\n", text.trim());
        }
        Ok(source)
    }
}
