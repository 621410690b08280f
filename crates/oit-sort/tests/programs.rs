//! Every program parses and validates, small ones are as kept, and bad specs are refused.

use naga::valid::{Capabilities, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator};
use oit_fragments::{Element, Ties};
use oit_sort::{
    Entry, Layout, Output, Program, ProgramError, STRATEGIES, SortSpec, SortStrategy, Store,
    WORKGROUP_BYTES, store_name, strategy, workgroups,
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
        layout: Layout {
            name: "linear",
            wgsl: LINEAR,
            random_access: true,
            element: Element::Narrow,
        },
        strategy,
        spec: SortSpec { min_frags, max_frags, ties: Ties::Total, store: strategy.stores()[0] },
        entry: Entry::Pixels,
        output: Output::Composite,
        width_px: 33,
        height_px: 7,
    }
}

fn validate(wgsl: &str) {
    // naga 30 has subgroups without the directive, and refuses it.
    let wgsl = &wgsl.replace("enable subgroups;", "");
    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{}\n{wgsl}", error.emit_to_string(wgsl)));
    let capabilities = Capabilities::EARLY_DEPTH_TEST
        | Capabilities::SUBGROUP
        | Capabilities::SHADER_INT64
        | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let mut validator = Validator::new(ValidationFlags::all(), capabilities);
    validator
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}\n{wgsl}", error.emit_to_string(wgsl)));
}

/// Whether several invocations share a pixel.
fn in_compute_only(strategy: &dyn SortStrategy) -> bool {
    let spec = program(strategy, 1, 8).spec;
    strategy.lanes(&spec) > 1
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
            for ties in Ties::ALL {
                for (i, (entry, output)) in entries.into_iter().enumerate() {
                    if entry == Entry::Fragment && in_compute_only(*strategy) {
                        continue;
                    }
                    let min_frags = [0, 1, max_frags / 2 + 1, max_frags][i % 4];
                    let mut program = program(*strategy, min_frags, max_frags);
                    program.layout.random_access = i % 2 == 0;
                    (program.spec.ties, program.entry, program.output) = (ties, entry, output);
                    for &store in strategy.stores() {
                        let wgsl = layout(store);
                        let layout = Layout { wgsl: &wgsl, ..program.layout };
                        program.spec.store = store;
                        let too_deep = strategy.limit_in(store).is_some_and(|l| max_frags > l);
                        let misplaced = store == Store::Workgroup && entry == Entry::Fragment;
                        if too_deep || misplaced {
                            assert!(program.wgsl().is_err());
                            continue;
                        }
                        validate(&Program { layout, ..program }.wgsl().unwrap());
                    }
                }
            }
        }
    }
}

/// What a program declares in workgroup memory is what its strategy reckons with, and no more than
/// every device has; and its workgroup has the invocations that it is dispatched by.
#[test]
fn arrays_in_workgroup_memory_fit() {
    let mut declared_any = 0;
    for strategy in STRATEGIES.iter().filter(|s| s.stores().contains(&Store::Workgroup)) {
        let limit = strategy.limit_in(Store::Workgroup).unwrap();
        for max_frags in [1, 8, 32, 33, 64, 65, 100, 128, 256, 341, 512] {
            let mut program = program(*strategy, 1, max_frags.min(limit));
            program.spec.store = Store::Workgroup;
            let module = naga::front::wgsl::parse_str(&program.wgsl().unwrap()).unwrap();
            let arrays = module.global_variables.iter();
            let arrays = arrays.filter(|(_, var)| var.space == naga::AddressSpace::WorkGroup);
            let bytes: u32 =
                arrays.map(|(_, var)| module.types[var.ty].inner.size(module.to_ctx())).sum();
            let invocations = strategy.invocations(&program.spec);
            let frags = strategy.array_frags(program.spec.max_frags);
            assert_eq!(bytes, 8 * frags * invocations, "{strategy:?} {:?}", program.spec);
            assert!(bytes <= WORKGROUP_BYTES && invocations >= 8);
            // Twice as many would not fit, or are more than there are in any workgroup.
            assert!(invocations == 64 || 2 * bytes > WORKGROUP_BYTES);
            assert_eq!(module.entry_points[0].workgroup_size, [invocations, 1, 1]);
            assert_eq!(strategy.pixels_per_workgroup(&program.spec), invocations);
            declared_any += bytes;
        }
    }
    assert!(declared_any > 0);
}

/// One small instance of each strategy in each store; `rbs` needs more than a block to be itself.
#[test]
fn small_programs_are_as_kept() {
    for strategy in STRATEGIES {
        for &store in strategy.stores() {
            let mut program = program(*strategy, 1, 4);
            program.spec.store = store;
            insta::assert_snapshot!(store_name(*strategy, store), program.wgsl().unwrap());
        }
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
    let mut workgroup = program(strategy("insertion_merge").unwrap(), 1, 40);
    workgroup.spec.store = Store::Workgroup;
    insta::assert_snapshot!("insertion_merge_branch_workgroup", workgroup.wgsl().unwrap());
    let mut fragment = program(strategy("network").unwrap(), 2, 3);
    fragment.layout.random_access = false;
    fragment.spec.ties = Ties::Depth;
    fragment.entry = Entry::Fragment;
    insta::assert_snapshot!("network_list_depth_fragment", fragment.wgsl().unwrap());
    let mut list = program(strategy("cooperative8").unwrap(), 9, 12);
    list.layout.random_access = false;
    (list.entry, list.spec.ties) = (Entry::List { list: 1, first: 64 }, Ties::Depth);
    insta::assert_snapshot!("cooperative8_list_depth", list.wgsl().unwrap());
    let mut emit = program(strategy("passthrough").unwrap(), 1, 8);
    (emit.entry, emit.output) = (Entry::List { list: 3, first: 64 }, Output::Emit);
    insta::assert_snapshot!("passthrough_list_emit", emit.wgsl().unwrap());
}

/// The layout of [`LINEAR`] with fragments of 128 bits, sorted as they are or by index.
fn wide(element: Element) -> String {
    if element == Element::Wide {
        return LINEAR.replace("vec2<u32>", "vec4<u32>");
    }
    let by_index = |place: &str| format!("vec2<u32>({place}, pool[{place}].w)");
    let linear = LINEAR.replace("array<vec2<u32>>", "array<vec4<u32>>");
    linear
        .replace("let f = pool[lfb_cursor]", &format!("let f = {}", by_index("lfb_cursor")))
        .replace("return pool[lfb_first + i]", &format!("return {}", by_index("(lfb_first + i)")))
        + "\nfn lfb_payload(index: u32) -> vec3<u32> {\n    return pool[index].xyz;\n}\n"
}

/// Every strategy sorts indices, by depth; those that say so sort fragments of 128 bits.
#[test]
fn fragments_of_128_bits_are_sorted_or_refused() {
    let mut direct = 0;
    for strategy in STRATEGIES {
        for element in [Element::Wide, Element::Index] {
            let text = wide(element);
            for (max_frags, ties, output, store) in [
                (8, Ties::Depth, Output::Composite),
                (8, Ties::Total, Output::Composite),
                (40, Ties::Depth, Output::Emit),
                (300, Ties::Depth, Output::Composite),
            ]
            .into_iter()
            .flat_map(|(n, ties, output)| {
                strategy.stores().iter().map(move |s| (n, ties, output, *s))
            }) {
                let mut program = program(*strategy, 1, max_frags);
                (program.layout.wgsl, program.layout.element) = (&text, element);
                (program.spec.ties, program.spec.store, program.output) = (ties, store, output);
                if strategy.limit_in(store).is_some_and(|limit| max_frags > limit) {
                    continue;
                }
                let laid_out = matches!(store, Store::Workgroup | Store::Global);
                if element == Element::Wide && (laid_out || !strategy.sorts_wide()) {
                    let error = program.wgsl().unwrap_err();
                    assert!(matches!(error, ProgramError::Wide { .. }), "{error}");
                } else if element == Element::Index && ties == Ties::Total {
                    let error = program.wgsl().unwrap_err();
                    assert!(matches!(error, ProgramError::TiesOfIndices), "{error}");
                } else if store != Store::Global {
                    validate(&program.wgsl().unwrap());
                    direct += u32::from(element == Element::Wide);
                }
            }
        }
    }
    assert!(direct >= 20, "{direct} programs of whole fragments");
    for (element, name) in [(Element::Wide, "insertion_wide"), (Element::Index, "insertion_index")]
    {
        let text = wide(element);
        let mut program = program(strategy("insertion").unwrap(), 1, 4);
        (program.layout.wgsl, program.layout.element) = (&text, element);
        program.spec.ties = if element == Element::Wide { Ties::Total } else { Ties::Depth };
        insta::assert_snapshot!(name, program.wgsl().unwrap());
    }
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
    let merge = strategy("merge").unwrap();
    let mut bad = program(merge, 1, 257);
    bad.spec.store = Store::Workgroup;
    assert_eq!(message(&bad), "sort \"merge-workgroup\" holds at most 256 fragments, not 257");
    bad.spec.max_frags = 256;
    bad.entry = Entry::Fragment;
    let text = message(&bad);
    assert!(text.starts_with("sort \"merge-workgroup\" runs in the compute stage only"), "{text}");
    let mut bad = program(rs, 1, 8);
    (bad.width_px, bad.height_px) = (1 << 16, 1 << 16);
    assert_eq!(message(&bad), "65536x65536 pixels are more than a kernel can count");
    let mut bad = program(rs, 1, 8);
    (bad.entry, bad.output) = (Entry::Fragment, Output::Emit);
    assert!(matches!(bad.wgsl(), Err(ProgramError::EmitFromFragment)));
    let mut bad = program(strategy("cooperative8").unwrap(), 1, 8);
    bad.entry = Entry::Fragment;
    assert_eq!(
        message(&bad),
        "sort \"cooperative8\" has 8 invocations to a pixel, and the fragment stage has one"
    );
}

#[test]
fn workgroups_cover_all_items() {
    assert_eq!(workgroups(0, 64), [0, 1, 1]);
    assert_eq!(workgroups(1, 64), [1, 1, 1]);
    assert_eq!(workgroups(65, 64), [2, 1, 1]);
    assert_eq!(workgroups(64 * 32_768, 64), [32_768, 1, 1]);
    assert_eq!(workgroups(64 * 32_768 + 1, 64), [32_768, 2, 1]);
    assert_eq!(workgroups(65, 8), [9, 1, 1]);
    for items in [1u64, 63, 64, 2_073_600, 3840 * 2160, u64::from(u32::MAX)] {
        for pixels in [8, 16, 32, 64] {
            let [x, y, z] = workgroups(items, pixels);
            assert!(u64::from(x) * u64::from(y) * u64::from(z) * u64::from(pixels) >= items);
            assert!(x <= 32_768 && y <= 65_535);
        }
    }
}
