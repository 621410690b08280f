//! What a sort strategy is.

use crate::INVOCATIONS;
use crate::composite;
use crate::workgroup_memory::{LEAST_INVOCATIONS, invocations_with_room, most_frags};
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

    /// Fragments that its arrays hold in all where it is compiled for up to `max_frags`.
    fn array_frags(&self, max_frags: u32) -> u32 {
        max_frags
    }

    /// The largest `max_frags` it can be compiled for with its arrays in this store; `None` if there
    /// is no limit. Workgroup memory has room for so many.
    fn limit_in(&self, store: Store) -> Option<u32> {
        let room = (store == Store::Workgroup).then(|| most_frags(|n| self.array_frags(n)));
        self.limit().into_iter().chain(room).min()
    }

    /// Invocations of a workgroup of its compute programs, in one dimension. They are fewer where
    /// workgroup memory would have no room for the arrays of more.
    fn invocations(&self, spec: &SortSpec) -> u32 {
        let room = || invocations_with_room(self.array_frags(spec.max_frags));
        match spec.store {
            Store::Workgroup => room().unwrap_or(LEAST_INVOCATIONS),
            _ => INVOCATIONS,
        }
    }

    /// Pixels that a workgroup of its compute programs resolves: one an invocation, or fewer where
    /// several share a pixel.
    fn pixels_per_workgroup(&self, spec: &SortSpec) -> u32 {
        self.invocations(spec) / self.lanes(spec)
    }

    /// How many invocations of a subgroup sort one pixel together: 1, or a power of two that divides
    /// [`INVOCATIONS`](crate::INVOCATIONS). A device whose subgroups are smaller cannot run it, and
    /// the fragment stage, where an invocation is a pixel, cannot either.
    fn lanes(&self, spec: &SortSpec) -> u32 {
        let _ = spec;
        1
    }

    /// Whether its kernel looks into fragments by `behind` alone, so that they may be of 128 bits
    /// ([`Element::Wide`](oit_fragments::Element)) where its arrays are the function's own.
    fn sorts_wide(&self) -> bool {
        false
    }

    /// Whether its output is in order at all. `false` only for what sorting is measured against.
    fn sorts(&self) -> bool {
        true
    }

    /// How far any channel of a pixel may be off by the strategy's own definition, where that is
    /// known: it stops early, say. It must sort nevertheless. `None` for what is exact.
    fn error_bound(&self) -> Option<f32> {
        None
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

    /// The CPU twin of its blending: premultiplied red, green, blue, alpha of what [`Self::sort`]
    /// left. From the end it composites from, all of them, unless it says otherwise.
    fn composite(&self, sorted: &[Fragment]) -> [f32; 4] {
        let sorted = sorted.iter().copied();
        match self.blends_from() {
            End::Front => composite(sorted, End::Front),
            End::Back => composite(sorted.rev(), End::Back),
        }
    }
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
    /// Workgroup (shared) memory, in compute programs only.
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

/// A strategy with its store as names have it: the store is written only where it is not the
/// strategy's first.
#[must_use]
pub fn store_name(strategy: &dyn SortStrategy, store: Store) -> String {
    let name = strategy.name();
    if strategy.stores().first() == Some(&store) {
        name.to_owned()
    } else {
        format!("{name}-{}", store.name())
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
