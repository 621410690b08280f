//! Assembles a resolve program: layout, strategy and entry point, to WGSL.

use crate::{STRATEGIES, SortSpec, SortStrategy, Store, store_name};
use minijinja::{Environment, UndefinedBehavior, context};
use oit_fragments::{Element, Ties};
use std::fmt::Write as _;

/// Everything that makes a resolve program.
#[derive(Clone, Copy)]
pub struct Program<'a> {
    /// How fragments are read.
    pub layout: Layout<'a>,
    /// How they are sorted.
    pub strategy: &'a dyn SortStrategy,
    /// What the kernel is compiled for.
    pub spec: SortSpec,
    /// How it is started.
    pub entry: Entry,
    /// What it makes.
    pub output: Output,
    /// Pixels a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

/// How a capture's fragments are read: WGSL that declares the capture's buffers (group 0, bindings
/// 0 to 15, read only) and defines `fn lfb_begin(pixel: u32)`, `fn lfb_more() -> bool`,
/// `fn lfb_next() -> vec2<u32>`; with random access also `fn lfb_len() -> u32` and
/// `fn lfb_at(i: u32) -> vec2<u32>`, both for the pixel last begun.
///
/// For [`Store::Global`](crate::Store) the fragments may be written, and it also defines
/// `fn lfb_cursor() -> u32`, where the next fragment is, `fn lfb_seek(cursor: u32)`, after which that
/// one is the next again, and `fn lfb_put(f: vec2<u32>)`, which writes it and goes on to the one after.
///
/// Fragments of 128 bits are `vec4<u32>`: in x, y and z halves, whole 255ths, from the low one on red,
/// green, blue, and the opacity for red, for green and for blue; in w the depth key. As
/// [`Element::Wide`] that is what is read. As [`Element::Index`] it is x where a fragment lies and y its
/// depth key, and `fn lfb_payload(index: u32) -> vec3<u32>` gives the rest.
#[derive(Clone, Copy, Debug)]
pub struct Layout<'a> {
    /// The capture's name.
    pub name: &'a str,
    /// The WGSL.
    pub wgsl: &'a str,
    /// Whether the i-th fragment can be read without reading those before it.
    pub random_access: bool,
    /// What is read of a fragment, and sorted.
    pub element: Element,
}

/// How a resolve program is started.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Entry {
    /// As a full-screen triangle's fragment shader (`vs`, `fs`), early tests forced so that a
    /// stencil can mask it; writes `@location(0)`.
    Fragment,
    /// As a compute shader over all pixels in rows (`main`, as many invocations a workgroup as the
    /// strategy says, workgroups in x and y); writes the buffer `image`.
    Pixels,
    /// As a compute shader over a list of pixels: `group_pixels[first + i]` for `i` below
    /// `group_counts[list]`; writes the buffer `image`.
    List {
        /// Which list.
        list: u32,
        /// Where its pixels start in `group_pixels`.
        first: u32,
    },
}

/// What a resolve program makes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Output {
    /// The composited pixel.
    Composite,
    /// For tests, compute only: the fragments in the order it would blend them, as `vec2<u32>`, to
    /// the buffer `emitted` from `emit_offsets[pixel]` on.
    Emit,
}

/// Invocations of a workgroup of a compute program, in one dimension, unless the strategy says
/// otherwise.
pub const INVOCATIONS: u32 = 64;

/// The most workgroups in x; further ones go into y. Below every device's limit of 65,535.
pub const MAX_WORKGROUPS_X: u32 = 32_768;

/// The workgroups (x, y, z) of a compute program for `items` pixels, of which each takes
/// `pixels_per_workgroup` ([`SortStrategy::pixels_per_workgroup`]). Surplus invocations end at once.
/// An indirect dispatch must be made by the same rule.
#[must_use]
pub fn workgroups(items: u64, pixels_per_workgroup: u32) -> [u32; 3] {
    let groups = items.div_ceil(u64::from(pixels_per_workgroup.max(1)));
    let x = groups.min(u64::from(MAX_WORKGROUPS_X));
    let y = groups.div_ceil(u64::from(MAX_WORKGROUPS_X)).max(1);
    [x as u32, u32::try_from(y).unwrap_or(u32::MAX), 1]
}

/// Why a program cannot be assembled.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// The strategy holds fewer fragments.
    #[error("sort {strategy:?} holds at most {limit} fragments, not {max_frags}")]
    TooManyFrags {
        /// The strategy and its store.
        strategy: String,
        /// Fragments asked for.
        max_frags: u32,
        /// Fragments it holds at most.
        limit: u32,
    },
    /// A kernel that holds no fragment, or that is to run only on more than it holds.
    #[error("sort {strategy:?} for {min_frags} to {max_frags} fragments: there is no such count")]
    Range {
        /// The strategy.
        strategy: &'static str,
        /// The fewest fragments.
        min_frags: u32,
        /// The most fragments.
        max_frags: u32,
    },
    /// The strategy has no such store.
    #[error("sort {strategy:?} has no store {store:?}; it has {}", stores.join(", "))]
    Store {
        /// The strategy.
        strategy: &'static str,
        /// The store asked for.
        store: &'static str,
        /// Its stores.
        stores: Vec<&'static str>,
    },
    /// More pixels than 32 bits count.
    #[error("{width_px}x{height_px} pixels are more than a kernel can count")]
    TooManyPixels {
        /// Pixels a row.
        width_px: u32,
        /// Rows.
        height_px: u32,
    },
    /// Fragment shaders have no workgroup.
    #[error("sort {strategy:?} runs in the compute stage only: a fragment shader has no workgroup")]
    WorkgroupInFragment {
        /// The strategy and its store.
        strategy: String,
    },
    /// The strategy is written in WGSL alone.
    #[error("sort {strategy:?} has no kernel in CUDA, or not in this store")]
    NoCuda {
        /// The strategy.
        strategy: &'static str,
    },
    /// The strategy takes fragments apart into two words, or its store is laid out for two.
    #[error("sort {strategy:?} holds fragments of 64 bits, not of 128")]
    Wide {
        /// The strategy and its store.
        strategy: String,
    },
    /// An index is no colour.
    #[error(
        "indirect sorting holds depth and an index, and ties-total needs the colour: use ties-depth"
    )]
    TiesOfIndices,
    /// Emitting is for compute entries.
    #[error("a fragment shader cannot emit fragments: use a compute entry")]
    EmitFromFragment,
    /// A subgroup sorts a pixel, and a fragment shader has an invocation for each.
    #[error("sort {strategy:?} has {lanes} invocations to a pixel, and the fragment stage has one")]
    FragmentStage {
        /// The strategy.
        strategy: &'static str,
        /// Invocations that share a pixel.
        lanes: u32,
    },
    /// A template is at fault.
    #[error("the template of sort {strategy:?}, layout {layout:?}")]
    Template {
        /// The strategy.
        strategy: &'static str,
        /// The layout.
        layout: String,
        /// What minijinja says.
        #[source]
        source: minijinja::Error,
    },
}

/// An environment for kernels' templates, without any.
pub(crate) fn environment<'a>() -> Environment<'a> {
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_keep_trailing_newline(true);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment
}

impl SortSpec {
    /// Whether the strategy can be compiled for it.
    pub(crate) fn check(&self, strategy: &dyn SortStrategy) -> Result<(), ProgramError> {
        let (name, stores) = (strategy.name(), strategy.stores());
        let Self { min_frags, max_frags, store, .. } = *self;
        if max_frags == 0 || min_frags > max_frags {
            return Err(ProgramError::Range { strategy: name, min_frags, max_frags });
        }
        if !stores.contains(&store) {
            let stores = stores.iter().map(|store| store.name()).collect();
            return Err(ProgramError::Store { strategy: name, store: store.name(), stores });
        }
        if let Some(limit) = strategy.limit_in(store).filter(|&limit| max_frags > limit) {
            let strategy = store_name(strategy, store);
            return Err(ProgramError::TooManyFrags { strategy, max_frags, limit });
        }
        Ok(())
    }
}

impl Program<'_> {
    /// The program's WGSL: the prelude, the layout, the strategy's kernel, the entry point.
    ///
    /// # Errors
    /// Where the strategy cannot be compiled for the spec, or a template fails.
    pub fn wgsl(&self) -> Result<String, ProgramError> {
        self.check()?;
        self.assemble().map_err(|source| ProgramError::Template {
            strategy: self.strategy.name(),
            layout: self.layout.name.to_owned(),
            source,
        })
    }

    fn check(&self) -> Result<(), ProgramError> {
        self.spec.check(self.strategy)?;
        if self.spec.store == Store::Workgroup && self.entry == Entry::Fragment {
            let strategy = store_name(self.strategy, self.spec.store);
            return Err(ProgramError::WorkgroupInFragment { strategy });
        }
        let strategy = self.strategy.name();
        if self.width_px.checked_mul(self.height_px).is_none() {
            let (width_px, height_px) = (self.width_px, self.height_px);
            return Err(ProgramError::TooManyPixels { width_px, height_px });
        }
        if self.output == Output::Emit && self.entry == Entry::Fragment {
            return Err(ProgramError::EmitFromFragment);
        }
        let is_wide = self.layout.element == Element::Wide;
        let laid_out = matches!(self.spec.store, Store::Workgroup | Store::Global);
        if is_wide && (laid_out || !self.strategy.sorts_wide()) {
            let strategy = store_name(self.strategy, self.spec.store);
            return Err(ProgramError::Wide { strategy });
        }
        if self.layout.element == Element::Index && self.spec.ties == Ties::Total {
            return Err(ProgramError::TiesOfIndices);
        }
        let lanes = self.strategy.lanes(&self.spec);
        if lanes > 1 && self.entry == Entry::Fragment {
            return Err(ProgramError::FragmentStage { strategy, lanes });
        }
        Ok(())
    }

    fn assemble(&self) -> Result<String, minijinja::Error> {
        let mut environment = environment();
        // Every kernel's template under its name, so that one may import another's macros.
        for strategy in STRATEGIES {
            environment.add_template(strategy.name(), strategy.template())?;
        }
        environment.add_template(self.strategy.name(), self.strategy.template())?;
        environment.add_template("prelude.wgsl", include_str!("prelude.wgsl.j2"))?;
        environment.add_template("entry.wgsl", include_str!("entry.wgsl.j2"))?;

        let (entry, list, first) = match self.entry {
            Entry::Fragment => ("fragment", 0, 0),
            Entry::Pixels => ("pixels", 0, 0),
            Entry::List { list, first } => ("list", list, first),
        };
        let spec = &self.spec;
        let context = context! {
            // A kernel for at least 1 fragment is also run where there is none.
            min_frags => if spec.min_frags > 1 { spec.min_frags } else { 0 },
            max_frags => spec.max_frags,
            ties => spec.ties.name(),
            store => spec.store.name(),
            random_access => self.layout.random_access,
            element => match self.layout.element {
                Element::Narrow => "narrow",
                Element::Wide => "wide",
                Element::Index => "index",
            },
            values => self.strategy.values(spec),
            emit => self.output == Output::Emit,
            entry, list, first,
            invocations => self.strategy.invocations(spec),
            lanes => self.strategy.lanes(spec),
            pixels_per_workgroup => self.strategy.pixels_per_workgroup(spec),
            width => self.width_px,
            pixels => self.width_px * self.height_px,
        };
        let render = |name: &str| environment.get_template(name)?.render(&context);
        let mut wgsl = render("prelude.wgsl")?;
        let named = [
            ("Layout", self.layout.name, self.layout.wgsl.to_owned()),
            ("Sort", self.strategy.name(), render(self.strategy.name())?),
            ("Entry", entry, render("entry.wgsl")?),
        ];
        for (part, name, text) in named {
            let _ = write!(wgsl, "\n// {part}: {name}.\n\n{}\n", text.trim());
        }
        Ok(wgsl)
    }
}
