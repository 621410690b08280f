//! What a sort strategy is.

use minijinja::Value;
use oit_fragments::{Fragment, Ties};
use std::fmt;

/// One way to put a pixel's fragments in order and composite them: a kernel, as a WGSL template,
/// and its CPU twin, in one file beside each other.
///
/// The template defines `fn sort_and_blend(pixel: u32)`. See `docs/adding-a-sort.md` for what it
/// may call.
pub trait SortStrategy: Sync {
    /// The name in technique coordinates: lower case, words joined by `_`.
    fn name(&self) -> &'static str;

    /// One sentence: what it does.
    fn summary(&self) -> &'static str;

    /// Where it comes from.
    fn citation(&self) -> &'static str;

    /// Where its sorting array may live; the first is the default.
    fn stores(&self) -> &'static [Store];

    /// The largest `max_frags` it can be compiled for; `None` if it has no limit of its own.
    fn limit(&self) -> Option<u32> {
        None
    }

    /// Whether its output is in order at all. `false` only for what sorting is measured against.
    fn sorts(&self) -> bool {
        true
    }

    /// Which end it composites from.
    fn blends_from(&self) -> End;

    /// The body of its kernel, a minijinja template.
    fn template(&self) -> &'static str;

    /// The same in CUDA C++, where there is one: a template of
    /// `INLINE void sort_and_blend(Lfb &lfb, Out &out)`, which finds the pixel begun
    /// (see [`crate::CudaProgram`]).
    fn cuda_template(&self) -> Option<&'static str> {
        None
    }

    /// Values its template needs beside the common ones (a network's comparators, say).
    fn values(&self, spec: &SortSpec) -> Value {
        let _ = spec;
        Value::UNDEFINED
    }

    /// The CPU twin: sorts `fragments` (at most `spec.max_frags`) nearest first, by the steps of
    /// the kernel. `scratch` is reused between pixels; its contents mean nothing.
    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], scratch: &mut Vec<Fragment>);
}

/// Its name.
impl fmt::Debug for dyn SortStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a kernel is compiled for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct SortSpec {
    /// The fewest fragments of a pixel that it is run on, 1 unless the schedule knows better. A
    /// kernel for 1 (or 0) is right on empty pixels too; one for more reads that many unasked.
    pub min_frags: u32,
    /// The most fragments it holds: of a deeper pixel it takes the first that many, in the order
    /// the layout gives them, and leaves the rest.
    pub max_frags: u32,
    /// What it compares.
    pub ties: Ties,
    /// Where its array lives.
    pub store: Store,
}

/// Where a sorting array lives.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Store {
    /// An array of the function, indexed at run time.
    Local,
    /// Workgroup (shared) memory.
    Workgroup,
    /// Variables, never indexed at run time.
    Registers,
    /// Device memory, in place.
    Global,
    /// None: nothing is stored.
    None,
}

impl Store {
    /// Every store, in the order they are listed.
    pub const ALL: [Self; 5] =
        [Self::Local, Self::Workgroup, Self::Registers, Self::Global, Self::None];

    /// The word for it in names.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Workgroup => "workgroup",
            Self::Registers => "registers",
            Self::Global => "global",
            Self::None => "none",
        }
    }
}

/// The end of the order a kernel composites from.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum End {
    /// Nearest first: `blend_front`.
    Front,
    /// Farthest first: `blend_back`.
    Back,
}
