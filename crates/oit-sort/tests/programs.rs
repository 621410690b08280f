//! Every program parses and validates, small ones are as kept, and bad specs are refused.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use oit_fragments::Ties;
use oit_sort::{
    Entry, Layout, Output, Program, ProgramError, STRATEGIES, SortSpec, SortStrategy, Store,
    strategy, workgroups,
};

/// Pixel p's fragments are `pool[starts[p]]` to `pool[starts[p + 1] - 1]`.
const LINEAR: &str = "
@group(0) @binding(0) var<storage, read> starts: array<u32>;
@group(0) @binding(1) var<storage, read> pool: array<vec2<u32>>;
var<private> lfb_first: u32;
var<private> lfb_cursor: u32;
var<private> lfb_end: u32;

fn lfb_begin(pixel: u32) {
    lfb_first = starts[pixel];
    lfb_cursor = lfb_first;
    lfb_end = starts[pixel + 1u];
}

fn lfb_more() -> bool {
    return lfb_cursor < lfb_end;
}

fn lfb_next() -> vec2<u32> {
    let f = pool[lfb_cursor];
    lfb_cursor += 1u;
    return f;
}

fn lfb_len() -> u32 {
    return lfb_end - lfb_first;
}

fn lfb_at(i: u32) -> vec2<u32> {
    return pool[lfb_first + i];
}
";

/// What the store `global` needs beside it.
const REWRITE: &str = "
fn lfb_cursor() -> u32 {
    return lfb_cursor_;
}

fn lfb_seek(cursor: u32) {
    lfb_cursor_ = cursor;
}

fn lfb_put(f: vec2<u32>) {
    pool[lfb_cursor_] = f;
    lfb_cursor_ += 1u;
}
";

/// The layout of a program whose array is in this store.
fn layout(store: Store) -> String {
    if store != Store::Global {
        return LINEAR.to_owned();
    }
    let linear = LINEAR.replace("read> pool", "read_write> pool");
    linear.replace("lfb_cursor", "lfb_cursor_") + REWRITE
}

fn program(strategy: &dyn SortStrategy, min_frags: u32, max_frags: u32) -> Program<'_> {
    Program {
        layout: Layout { name: "linear", wgsl: LINEAR, random_access: true },
        strategy,
        spec: SortSpec { min_frags, max_frags, ties: Ties::Total, store: strategy.stores()[0] },
        entry: Entry::Pixels,
        output: Output::Composite,
        width_px: 33,
        height_px: 7,
    }
}

fn validate(wgsl: &str) {
    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{}\n{wgsl}", error.emit_to_string(wgsl)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::EARLY_DEPTH_TEST);
    validator
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}\n{wgsl}", error.emit_to_string(wgsl)));
}

#[test]
fn every_program_is_valid() {
    let entries = [
        (Entry::Fragment, Output::Composite),
        (Entry::Pixels, Output::Composite),
        (Entry::List { list: 2, first: 100 }, Output::Composite),
        (Entry::List { list: 0, first: 0 }, Output::Emit),
        (Entry::Pixels, Output::Emit),
    ];
    for strategy in STRATEGIES {
        let counts = [1, 2, 3, 8, 16, 20, 31, 32, 33, 64, 65, 100, 128, 256, 1024, 4096];
        for max_frags in counts {
            if strategy.limit().is_some_and(|limit| max_frags > limit) {
                continue;
            }
            for ties in Ties::ALL {
                for (i, (entry, output)) in entries.into_iter().enumerate() {
                    let min_frags = [0, 1, max_frags / 2 + 1, max_frags][i % 4];
                    let mut program = program(*strategy, min_frags, max_frags);
                    program.layout.random_access = i % 2 == 0;
                    (program.spec.ties, program.entry, program.output) = (ties, entry, output);
                    for &store in strategy.stores() {
                        let wgsl = layout(store);
                        let layout = Layout { wgsl: &wgsl, ..program.layout };
                        program.spec.store = store;
                        validate(&Program { layout, ..program }.wgsl().unwrap());
                    }
                }
            }
        }
    }
}

/// One small instance of each strategy; `rbs` needs more than a block to be itself.
#[test]
fn small_programs_are_as_kept() {
    for strategy in STRATEGIES {
        insta::assert_snapshot!(strategy.name(), program(*strategy, 1, 4).wgsl().unwrap());
    }
    insta::assert_snapshot!("rbs_two_blocks", {
        program(strategy("rbs").unwrap(), 33, 40).wgsl().unwrap()
    });
    let rewritten = layout(Store::Global);
    let mut global = program(strategy("rbs8").unwrap(), 9, 20);
    (global.spec.store, global.layout.wgsl) = (Store::Global, &rewritten);
    insta::assert_snapshot!("rbs8_global_three_blocks", global.wgsl().unwrap());
    insta::assert_snapshot!("insertion_merge_branch", {
        program(strategy("insertion_merge").unwrap(), 1, 40).wgsl().unwrap()
    });
    let mut fragment = program(strategy("network").unwrap(), 2, 3);
    fragment.layout.random_access = false;
    fragment.spec.ties = Ties::Depth;
    fragment.entry = Entry::Fragment;
    insta::assert_snapshot!("network_list_depth_fragment", fragment.wgsl().unwrap());
    let mut emit = program(strategy("passthrough").unwrap(), 1, 8);
    (emit.entry, emit.output) = (Entry::List { list: 3, first: 64 }, Output::Emit);
    insta::assert_snapshot!("passthrough_list_emit", emit.wgsl().unwrap());
}

#[test]
fn specs_that_make_no_kernel_are_refused() {
    let message = |program: &Program| program.wgsl().unwrap_err().to_string();
    let rs = strategy("rs").unwrap();
    assert_eq!(message(&program(rs, 1, 33)), "sort \"rs\" holds at most 32 fragments, not 33");
    for (min, max) in [(9, 8), (0, 0)] {
        let error = program(rs, min, max).wgsl().unwrap_err();
        assert!(matches!(error, ProgramError::Range { .. }), "{error}");
    }
    let mut bad = program(rs, 1, 8);
    bad.spec.store = Store::Workgroup;
    assert_eq!(message(&bad), "sort \"rs\" has no store \"workgroup\"; it has registers");
    let mut bad = program(rs, 1, 8);
    (bad.width_px, bad.height_px) = (1 << 16, 1 << 16);
    assert_eq!(message(&bad), "65536x65536 pixels are more than a kernel can count");
    let mut bad = program(rs, 1, 8);
    (bad.entry, bad.output) = (Entry::Fragment, Output::Emit);
    assert!(matches!(bad.wgsl(), Err(ProgramError::EmitFromFragment)));
}

#[test]
fn workgroups_cover_all_items() {
    assert_eq!(workgroups(0), [0, 1, 1]);
    assert_eq!(workgroups(1), [1, 1, 1]);
    assert_eq!(workgroups(65), [2, 1, 1]);
    assert_eq!(workgroups(64 * 32_768), [32_768, 1, 1]);
    assert_eq!(workgroups(64 * 32_768 + 1), [32_768, 2, 1]);
    for items in [1u64, 63, 64, 2_073_600, 3840 * 2160, u64::from(u32::MAX)] {
        let [x, y, z] = workgroups(items);
        assert!(u64::from(x) * u64::from(y) * u64::from(z) * 64 >= items);
        assert!(x <= 32_768 && y <= 65_535);
    }
}
