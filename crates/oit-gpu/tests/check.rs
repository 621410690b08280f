//! What `Plan::check` refuses, and how a plan is printed; no GPU is needed.

use oit_gpu::{
    Buffer, ColorAttachment, Compare, Depth, DepthStencil, Dispatch, Draw, Format, Glsl, GpuError,
    Load, Mesh, Pass, Plan, PreRaster, Raster, Shader, Stencil, StencilOp, Target, Tessellation,
    Topology, VertexAttribute, VertexFormat, VertexLayout, Work,
};

const COUNT: &str = "
@group(0) @binding(0) var<storage, read> nodes: array<u32>;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
@compute @workgroup_size(64) fn main() { counts[0] = nodes[0]; }
";

const MASKED: &str = "
@group(0) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.5, 1.0);
}
@fragment @early_depth_test(force) fn fs() -> @location(0) vec4<f32> {
    atomicAdd(&counts[0], 1u);
    return vec4<f32>(1.0);
}
";

fn target(name: &str, format: Format) -> Target {
    Target { name: name.to_owned(), format, width: 8, height: 4 }
}

fn color(target: &str) -> ColorAttachment {
    let load = Load::Clear([0.0; 4]);
    ColorAttachment { target: target.to_owned(), load, blend: None, write: true }
}

fn stencil(target: &str, compare: Compare) -> Option<DepthStencil> {
    let (pass, fail) = (StencilOp::Keep, StencilOp::Keep);
    let stencil = Some(Stencil { clear: Some(1), compare, reference: 1, pass, fail });
    Some(DepthStencil { target: target.to_owned(), depth: None, stencil })
}

fn compute_plan() -> Plan {
    Plan {
        name: "compute".to_owned(),
        buffers: vec![
            Buffer::data("nodes", vec![0; 64].into()),
            Buffer::new("counts", 64),
            Buffer::new("groups", 16),
        ],
        targets: vec![],
        passes: vec![
            Pass::clear("clear", "counts"),
            Pass::compute("count", Shader::new("count", COUNT), Dispatch::Workgroups([2, 1, 1])),
        ],
    }
}

fn raster_plan() -> Plan {
    let draw = Draw::Vertices { count: 3, instances: 1 };
    let raster = Raster {
        color: vec![color("image")],
        depth_stencil: stencil("mask", Compare::Equal),
        ..Raster::new(Shader::new("masked", MASKED), draw)
    };
    Plan {
        name: "raster".to_owned(),
        buffers: vec![Buffer::new("counts", 16)],
        targets: vec![target("image", Format::Rgba16Float), target("mask", Format::Stencil8)],
        passes: vec![Pass::raster("resolve", raster)],
    }
}

fn raster_of(plan: &mut Plan) -> &mut Raster {
    match &mut plan.passes[0].work {
        Work::Raster(raster) => raster,
        _ => unreachable!("the pass is a raster pass"),
    }
}

/// The fault of a plan that should have one.
fn fault(plan: &Plan) -> String {
    match plan.check() {
        Err(GpuError::Plan { plan: name, what }) => {
            assert_eq!(name, plan.name);
            what
        }
        other => panic!("a fault was expected: {other:?}"),
    }
}

/// Asserts that a change to a sound plan is refused with these words.
fn refused(sound: fn() -> Plan, change: impl FnOnce(&mut Plan), words: &[&str]) {
    let mut plan = sound();
    plan.check().expect("sound before the change");
    change(&mut plan);
    let what = fault(&plan);
    for word in words {
        assert!(what.contains(word), "{word:?} is not in: {what}");
    }
}

#[test]
fn names_must_have_resources() {
    refused(
        compute_plan,
        |p| p.buffers[0].name = "nodse".to_owned(),
        &["pass \"count\"", "shader \"count\"", "`nodes`", "the nearest is \"nodse\""],
    );
    refused(
        compute_plan,
        |p| p.buffers[1].name = "count".to_owned(),
        &["pass \"clear counts\"", "\"counts\"", "the nearest is \"count\""],
    );
    refused(
        raster_plan,
        |p| p.targets[0].name = "imago".to_owned(),
        &["no target is named \"image\"", "\"imago\""],
    );
    refused(compute_plan, |p| p.buffers.push(Buffer::new("counts", 4)), &["two resources"]);
    refused(raster_plan, |p| p.buffers.push(Buffer::new("mask", 4)), &["two resources"]);
}

#[test]
fn given_data_is_not_written() {
    let given = || Buffer::data("counts", vec![0; 64].into());
    refused(compute_plan, |p| p.buffers[1] = given(), &["\"counts\" has given data"]);
    let only_shader = |p: &mut Plan| {
        p.passes.remove(0);
        p.buffers[1] = given();
    };
    refused(compute_plan, only_shader, &["shader \"count\"", "\"counts\" has given data"]);
    refused(compute_plan, |p| p.buffers[0].bytes = 60, &["of 60 bytes and has 64"]);
}

#[test]
fn shaders_must_compile_and_have_their_entry_points() {
    let with = |wgsl: &'static str| {
        move |p: &mut Plan| {
            let shader = Shader::new("broken.wgsl", wgsl);
            p.passes[1] = Pass::compute("count", shader, Dispatch::Workgroups([1, 1, 1]));
        }
    };
    refused(compute_plan, with("fn main( {}"), &["broken.wgsl:1:", "fn main( {}"]);
    refused(compute_plan, with(MASKED), &["no compute entry point `main`"]);
    refused(compute_plan, with("override n: u32 = 3;"), &["override n"]);
    refused(raster_plan, |p| raster_of(p).shader = Shader::new("c", COUNT), &["`vs` and `fs`"]);
    let large = "@group(0) @binding(0) var<uniform> nodes: array<vec4<u32>, 5>;
        @compute @workgroup_size(1) fn main() { _ = nodes[0]; }";
    refused(compute_plan, with(large), &["needs 80 bytes and the buffer has 64"]);
}

#[test]
fn indirect_counts_are_inside_their_buffer() {
    let indirect = |offset_bytes| {
        move |p: &mut Plan| {
            let buffer = "groups".to_owned();
            let dispatch = Dispatch::Indirect { buffer, offset_bytes };
            p.passes[1] = Pass::compute("count", Shader::new("count", COUNT), dispatch);
        }
    };
    let mut plan = compute_plan();
    indirect(4)(&mut plan);
    plan.check().expect("sound");
    for offset in [2, 8, u64::MAX - 3] {
        refused(compute_plan, indirect(offset), &["\"groups\", which has 16"]);
    }
    let own = |p: &mut Plan| {
        let dispatch = Dispatch::Indirect { buffer: "counts".to_owned(), offset_bytes: 0 };
        p.passes[1] = Pass::compute("count", Shader::new("count", COUNT), dispatch);
    };
    refused(compute_plan, own, &["`counts`", "written by the pass"]);
}

#[test]
fn a_tested_fragment_shader_that_writes_must_test_early() {
    let late = || Shader::new("late", MASKED.replace("@early_depth_test(force)", ""));
    refused(raster_plan, |p| raster_of(p).shader = late(), &["@early_depth_test(force)", "late"]);
    let depth_tested = |p: &mut Plan| {
        p.targets[1].format = Format::Depth32Float;
        let load = Load::Clear(1.0);
        let depth = Some(Depth { load, compare: Compare::Less, write: false });
        let raster = raster_of(p);
        raster.shader = late();
        raster.depth_stencil =
            Some(DepthStencil { target: "mask".to_owned(), depth, stencil: None });
    };
    refused(raster_plan, depth_tested, &["@early_depth_test(force)"]);
    // It is permitted on purpose.
    let mut plan = raster_plan();
    raster_of(&mut plan).shader = late();
    raster_of(&mut plan).late_writes = true;
    plan.check().expect("sound");
    // Nothing is rejected, or nothing is written.
    let mut plan = raster_plan();
    raster_of(&mut plan).shader = late();
    raster_of(&mut plan).depth_stencil = stencil("mask", Compare::Always);
    plan.check().expect("sound");
    raster_of(&mut plan).depth_stencil = None;
    plan.check().expect("sound");
    let reads = MASKED
        .replace("@early_depth_test(force)", "")
        .replace("atomicAdd(&counts[0], 1u)", "_ = atomicLoad(&counts[0])");
    let mut plan = raster_plan();
    raster_of(&mut plan).shader = Shader::new("reads", reads);
    plan.check().expect("sound");
}

#[test]
fn attachments_fit_each_other_and_the_shader() {
    refused(raster_plan, |p| p.targets[1].width = 9, &["\"mask\" is 9x4", "\"image\" is 8x4"]);
    refused(raster_plan, |p| p.targets[0].height = 0, &["\"image\" is 8x0"]);
    refused(raster_plan, |p| raster_of(p).color.push(color("image")), &["attached twice"]);
    refused(raster_plan, |p| p.targets[0].format = Format::Depth32Float, &["does not go there"]);
    refused(raster_plan, |p| p.targets[1].format = Format::R8Unorm, &["does not go there"]);
    refused(raster_plan, |p| p.targets[1].format = Format::Depth32Float, &["test of its format"]);
    let bare = |p: &mut Plan| {
        let raster = raster_of(p);
        raster.color.clear();
        raster.depth_stencil = None;
    };
    refused(raster_plan, bare, &["no attachment"]);
    let second = |p: &mut Plan| {
        p.targets.push(target("other", Format::R8Unorm));
        raster_of(p).color.push(color("other"));
    };
    refused(raster_plan, second, &["no @location(1)", "\"other\""]);
}

#[test]
fn shaders_read_colour_targets_of_other_passes() {
    fn reading() -> Plan {
        let mut plan = raster_plan();
        plan.targets.push(target("earlier", Format::R32Float));
        let texture = "@group(0) @binding(1) var earlier: texture_2d<f32>;\n";
        let load = "textureLoad(earlier, vec2<u32>(0u, 0u), 0)";
        let wgsl = [texture, &MASKED.replace("vec4<f32>(1.0)", load)].concat();
        raster_of(&mut plan).shader = Shader::new("reading", wgsl);
        plan
    }
    let rename = |p: &mut Plan| p.targets[2].name = "earlie".to_owned();
    refused(reading, rename, &["`earlier`", "no target is named", "nearest is \"earlie\""]);
    let attached = |p: &mut Plan| raster_of(p).color[0].target = "earlier".to_owned();
    refused(reading, attached, &["`earlier`", "attached to the pass that reads it"]);
    for format in [Format::Depth32Float, Format::Stencil8] {
        refused(
            reading,
            |p| p.targets[2].format = format,
            &["`earlier`", "not of depth or stencil"],
        );
    }
    let buffer = |p: &mut Plan| {
        p.targets.pop();
        p.buffers.push(Buffer::new("earlier", 64));
    };
    refused(reading, buffer, &["`earlier`", "no target is named"]);
    assert!(reading().to_string().contains("    reads earlier\n"), "{}", reading());
}

#[test]
fn vertices_fit_the_shader() {
    fn indexed() -> Plan {
        let mut plan = raster_plan();
        plan.buffers.push(Buffer::data("vertices", vec![0; 48].into()));
        plan.buffers.push(Buffer::data("indices", vec![0; 12].into()));
        let at = VertexAttribute { location: 0, format: VertexFormat::Float32x3, offset_bytes: 0 };
        let raster = raster_of(&mut plan);
        raster.shader = Shader::new(
            "indexed",
            MASKED.replace("@builtin(vertex_index) i: u32", "@location(0) at: vec3<f32>").replace(
                "vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i & 2u) * 2.0 - 1.0, 0.5, 1.0)",
                "vec4<f32>(at, 1.0)",
            ),
        );
        raster.draw = Draw::Indexed {
            vertices: "vertices".to_owned(),
            layout: VertexLayout { stride_bytes: 16, attributes: vec![at] },
            indices: "indices".to_owned(),
            count: 3,
        };
        plan
    }
    fn draw(plan: &mut Plan) -> (&mut VertexLayout, &mut u32) {
        match &mut raster_of(plan).draw {
            Draw::Indexed { layout, count, .. } => (layout, count),
            _ => unreachable!("the draw is indexed"),
        }
    }
    refused(indexed, |p| *draw(p).1 = 5, &["5 indices", "which has 16 bytes"]);
    refused(indexed, |p| draw(p).0.stride_bytes = 8, &["not inside the vertex"]);
    refused(indexed, |p| draw(p).0.stride_bytes = 14, &["no multiple of 4"]);
    refused(indexed, |p| draw(p).0.attributes[0].offset_bytes = 8, &["not inside the vertex"]);
    refused(indexed, |p| draw(p).0.attributes[0].location = 1, &["f32 at @location(0)"]);
    refused(indexed, |p| draw(p).0.attributes[0].format = VertexFormat::Uint32, &["f32 at"]);
    let none = |p: &mut Plan| raster_of(p).draw = Draw::Vertices { count: 3, instances: 1 };
    refused(indexed, none, &["@location(0)", "nothing is bound"]);
    let said = |p: &mut Plan, arguments: &str, offset_bytes, indexed: bool| {
        let arguments = arguments.to_owned();
        raster_of(p).draw = match (indexed, raster_of(p).draw.clone()) {
            (true, Draw::Indexed { vertices, layout, indices, .. }) => {
                Draw::IndexedIndirect { vertices, layout, indices, arguments, offset_bytes }
            }
            _ => Draw::VerticesIndirect { arguments, offset_bytes, draws: 1 },
        };
    };
    refused(indexed, |p| said(p, "indices", 0, true), &["5 u32", "which has 16"]);
    refused(indexed, |p| said(p, "vertices", 30, true), &["byte 30"]);
    refused(indexed, |p| said(p, "vertex", 0, true), &["no buffer", "\"vertices\""]);
    refused(indexed, |p| said(p, "vertices", 0, false), &["nothing is bound"]);
    let written = |p: &mut Plan| {
        p.buffers.truncate(1);
        p.buffers[0].bytes = 64;
        p.buffers.push(Buffer::data("indices", vec![0; 12].into()));
        if let Draw::Indexed { vertices, .. } = &mut raster_of(p).draw {
            *vertices = "counts".to_owned();
        }
    };
    refused(indexed, written, &["`counts`", "written by the pass"]);
}

#[test]
fn draws_from_a_buffer_are_inside_it() {
    let many = |draws| {
        move |p: &mut Plan| {
            p.buffers.push(Buffer::new("said", 80));
            raster_of(p).draw =
                Draw::VerticesIndirect { arguments: "said".to_owned(), offset_bytes: 16, draws };
        }
    };
    let mut plan = raster_plan();
    many(4)(&mut plan);
    plan.check().expect("sound");
    assert!(plan.to_string().contains("draws vertices 4 times, from said at byte 16 on\n"));
    refused(raster_plan, many(5), &["20 u32 at byte 16", "which has 80"]);
    refused(raster_plan, many(0), &["\"said\"", "1 is the least"]);
    refused(raster_plan, many(u32::MAX), &["which has 80"]);
}

#[test]
fn a_depth_that_is_written_is_tested_after() {
    const OUT: &str = "struct Out { @location(0) color: vec4<f32>, @builtin(frag_depth) z: f32 }\n";
    fn written(attribute: &str, body: &str) -> String {
        let wgsl = MASKED.replace("@early_depth_test(force)", attribute);
        let wgsl = wgsl.replace("-> @location(0) vec4<f32>", "-> Out");
        let wgsl = wgsl.replace("atomicAdd(&counts[0], 1u);", body);
        [OUT, &wgsl.replace("return vec4<f32>(1.0)", "return Out(vec4<f32>(1.0), 0.5)")].concat()
    }
    fn writing() -> Plan {
        let mut plan = raster_plan();
        plan.targets[1].format = Format::Depth32Float;
        let load = Load::Clear(1.0);
        let depth = Some(Depth { load, compare: Compare::Less, write: true });
        let raster = raster_of(&mut plan);
        raster.depth_stencil =
            Some(DepthStencil { target: "mask".to_owned(), depth, stencil: None });
        raster.shader = Shader::new("writing", written("", ""));
        plan
    }
    let with = |attribute: &'static str, body: &'static str| {
        move |p: &mut Plan| {
            raster_of(p).shader = Shader::new("changed", written(attribute, body));
        }
    };
    for bound in ["less_equal", "greater_equal", "unchanged"] {
        let mut plan = writing();
        let attribute = format!("@early_depth_test({bound})");
        raster_of(&mut plan).shader = Shader::new("bounded", written(&attribute, ""));
        plan.check().expect("sound");
        assert!(plan.to_string().contains(&format!("    depth of the shader, {bound}")), "{plan}");
    }
    assert!(writing().to_string().contains("    depth of the shader\n"));
    refused(writing, with("@early_depth_test(force)", ""), &["`fs` writes `frag_depth`", "force"]);
    let counting = "atomicAdd(&counts[0], 1u);";
    refused(writing, with("", counting), &["writes a buffer and its depth", "a pass of its own"]);
    let bare = |p: &mut Plan| raster_of(p).depth_stencil = None;
    refused(writing, bare, &["`frag_depth`", "no depth target"]);
    let idle = |p: &mut Plan| {
        let wgsl = MASKED.replace("(force)", "(less_equal)").replace(counting, "");
        raster_of(p).shader = Shader::new("idle", wgsl);
    };
    refused(writing, idle, &["@early_depth_test(less_equal)", "writes no `frag_depth`"]);
}

const VERTEX: &str = "#version 460
void main() { gl_Position = vec4(0.0, 0.0, 0.5, 1.0); }";

const GEOMETRY: &str = "#version 460
layout(points) in;
layout(points, max_vertices = 1) out;
layout(set = 0, binding = 1, std430) readonly buffer Atoms { vec4 list[]; } atoms;
layout(location = 0) out vec4 color;
void main() {
    color = atoms.list[gl_PrimitiveIDIn];
    gl_Position = gl_in[0].gl_Position;
    EmitVertex();
}";

const CONTROL: &str = "#version 460
layout(vertices = 3) out;
void main() { gl_TessLevelOuter[0] = gl_TessLevelInner[0] = 2.0; }";

const EVALUATION: &str = "#version 460
layout(triangles) in;
layout(location = 0) out vec4 color;
void main() { color = vec4(1.0); gl_Position = vec4(gl_TessCoord, 1.0); }";

fn with_geometry() -> Plan {
    let mut plan = raster_plan();
    plan.buffers.push(Buffer::data("atoms", vec![0; 64].into()));
    let raster = raster_of(&mut plan);
    let wgsl = MASKED.replace("fn fs()", "fn fs(@location(0) color: vec4<f32>)");
    raster.shader = Shader::new("impostor", wgsl.replace("vec4<f32>(1.0);", "color;"));
    raster.pre_raster = PreRaster::from(Glsl {
        topology: Topology::Points,
        vertex: VERTEX.into(),
        tessellation: None,
        geometry: Some(GEOMETRY.into()),
    });
    plan
}

fn with_tessellation() -> Plan {
    let mut plan = with_geometry();
    let glsl = glsl_of(&mut plan);
    glsl.topology = Topology::Patches(3);
    glsl.geometry = None;
    glsl.tessellation =
        Some(Tessellation { control: CONTROL.into(), evaluation: EVALUATION.into() });
    plan
}

fn glsl_of(plan: &mut Plan) -> &mut Glsl {
    match &mut raster_of(plan).pre_raster {
        PreRaster::Glsl(glsl) => glsl,
        _ => unreachable!("the pass has stages in GLSL"),
    }
}

#[test]
fn stages_in_glsl_fit_each_other_and_the_plan() {
    let geometry = |from: &'static str, to: &'static str| {
        move |p: &mut Plan| {
            glsl_of(p).geometry = Some(GEOMETRY.replace(from, to).into());
        }
    };
    refused(with_geometry, geometry("max_vertices", "most"), &["geometry stage in GLSL", "ERROR"]);
    let renamed = |p: &mut Plan| p.buffers[1].name = "atom".to_owned();
    refused(with_geometry, renamed, &["`atoms`", "nearest is \"atom\""]);
    refused(with_geometry, geometry("readonly ", ""), &["`atoms`", "has given data"]);
    refused(
        with_geometry,
        geometry("set = 0, binding = 1", "binding = 0"),
        &["`counts`", "both at"],
    );
    refused(with_geometry, geometry("location = 0", "location = 2"), &["@location(0)", "[2]"]);
    refused(with_geometry, geometry("(points) in", "(triangles) in"), &["takes triangles"]);
    refused(
        with_geometry,
        |p| glsl_of(p).topology = Topology::Triangles,
        &["triangles come to it"],
    );
    let patches = |p: &mut Plan| glsl_of(p).topology = Topology::Patches(3);
    refused(with_geometry, patches, &["patches are drawn by tessellation"]);
    refused(with_tessellation, |p| glsl_of(p).topology = Topology::Points, &["Topology::Patches"]);
    let none = |p: &mut Plan| glsl_of(p).topology = Topology::Patches(0);
    refused(with_tessellation, none, &["no vertices"]);
    let both = |p: &mut Plan| glsl_of(p).geometry = Some(GEOMETRY.into());
    refused(with_tessellation, both, &["takes points, and triangles come to it"]);
    let no_fs = |p: &mut Plan| {
        let vs = "@vertex fn vs() -> @builtin(position) vec4<f32> { return vec4<f32>(); }";
        raster_of(p).shader = Shader::new("vs", vs);
    };
    refused(with_geometry, no_fs, &["needs the entry point `fs`"]);
    let mesh = |p: &mut Plan| raster_of(p).draw = mesh_draw("counts", 0);
    refused(with_geometry, mesh, &["mesh stages and a mesh draw"]);
    let listed = with_tessellation().to_string();
    let stages =
        "stages in GLSL: vertex, tessellation control, tessellation evaluation; of patches";
    assert!(listed.contains(stages), "{listed}");
    assert!(with_geometry().to_string().contains("    reads atoms\n    writes counts\n"));
}

fn mesh_draw(arguments: &str, offset_bytes: u64) -> Draw {
    Draw::MeshIndirect { arguments: arguments.to_owned(), offset_bytes, at_most: [4, 2, 1] }
}

fn with_mesh() -> Plan {
    let source = "#version 460
        #extension GL_EXT_mesh_shader : require
        layout(set = 0, binding = 1, std430) readonly buffer Atoms { vec4 list[]; } atoms;
        layout(local_size_x = 3) in;
        layout(triangles, max_vertices = 3, max_primitives = 1) out;
        layout(location = 0) out vec4 color[];
        void main() {
            SetMeshOutputsEXT(3, 1);
            color[gl_LocalInvocationIndex] = atoms.list[gl_WorkGroupID.x];
            gl_MeshVerticesEXT[gl_LocalInvocationIndex].gl_Position = vec4(0.0);
            gl_PrimitiveTriangleIndicesEXT[0] = uvec3(0, 1, 2);
        }";
    let mut plan = with_geometry();
    plan.buffers.push(Buffer::new("said", 16));
    let raster = raster_of(&mut plan);
    raster.pre_raster = PreRaster::from(Mesh { task: None, mesh: source.into() });
    raster.draw = mesh_draw("said", 4);
    plan
}

#[test]
fn mesh_stages_are_checked_without_a_gpu() {
    let plan = with_mesh();
    plan.check().expect("sound");
    let listed = plan.to_string();
    let draw =
        "    mesh workgroups from said at byte 4, at most 4 x 2 x 1\n    stages in GLSL: mesh\n";
    assert!(listed.contains(draw), "{listed}");
    let vertices = |p: &mut Plan| raster_of(p).draw = Draw::Vertices { count: 3, instances: 1 };
    refused(with_mesh, vertices, &["mesh stages and a mesh draw"]);
    let from = |arguments, at| move |p: &mut Plan| raster_of(p).draw = mesh_draw(arguments, at);
    refused(with_mesh, from("sad", 0), &["no buffer", "\"said\""]);
    refused(with_mesh, from("said", 8), &["3 u32 at byte 8", "which has 16"]);
    refused(with_mesh, from("said", 2), &["3 u32 at byte 2"]);
    let written = |p: &mut Plan| {
        p.buffers.iter_mut().find(|buffer| buffer.name == "counts").expect("counts").bytes = 64;
        raster_of(p).draw = mesh_draw("counts", 0);
    };
    refused(with_mesh, written, &["`counts`", "written by the pass"]);
}

#[test]
fn integers_are_written_as_such() {
    fn ids() -> Plan {
        let mut plan = raster_plan();
        plan.targets[0].format = Format::R32Uint;
        let wgsl = MASKED.replace("@location(0) vec4<f32>", "@location(0) u32");
        let wgsl = wgsl.replace("return vec4<f32>(1.0)", "return 7u");
        raster_of(&mut plan).shader = Shader::new("ids", wgsl);
        plan
    }
    let float = |p: &mut Plan| p.targets[0].format = Format::R32Float;
    refused(ids, float, &["@location(0)", "not of f32", "R32Float"]);
    let shader = |p: &mut Plan| raster_of(p).shader = Shader::new("masked", MASKED);
    refused(ids, shader, &["@location(0)", "not of u32", "R32Uint"]);
    let blended = |p: &mut Plan| raster_of(p).color[0].blend = Some(oit_gpu::Blend::Add);
    refused(ids, blended, &["\"image\" is R32Uint", "not blended"]);
    let cleared = |value| move |p: &mut Plan| raster_of(p).color[0].load = Load::Clear([value; 4]);
    for value in [0.5, -1.0, 16_777_218.0, f32::NAN, f32::NEG_INFINITY] {
        refused(ids, cleared(value), &["whole numbers"]);
    }
    for value in [0.0, 16_777_216.0, f32::INFINITY] {
        let mut plan = ids();
        cleared(value)(&mut plan);
        plan.check().expect("sound");
    }
    fn reading() -> Plan {
        let mut plan = ids();
        plan.targets.push(target("earlier", Format::R32Uint));
        let texture = "@group(0) @binding(1) var earlier: texture_2d<u32>;\n";
        let wgsl = [texture, &raster_of(&mut plan).shader.wgsl].concat();
        let load = "textureLoad(earlier, vec2<u32>(0u, 0u), 0).x";
        raster_of(&mut plan).shader = Shader::new("reading", wgsl.replace("7u", load));
        plan
    }
    let float = |p: &mut Plan| p.targets[2].format = Format::R32Float;
    refused(reading, float, &["`earlier`", "R32Float, a `texture_2d<f32>`"]);
}

#[test]
fn a_plan_prints_what_it_does() {
    let mut plan = raster_plan();
    raster_of(&mut plan).unclipped = true;
    raster_of(&mut plan).late_writes = true;
    plan.passes.splice(0..0, compute_plan().passes);
    plan.buffers = compute_plan().buffers;
    assert_eq!(
        plan.to_string(),
        "\
plan raster
buffers
  nodes: 64 bytes, given
  counts: 64 bytes
  groups: 16 bytes
targets
  image: Rgba16Float 8x4
  mask: Stencil8 8x4
passes
  [clear] clear counts
    writes counts
  [count] count
    workgroups 2 x 1 x 1
    workgroup size 64 x 1 x 1
    reads nodes
    writes counts
  [resolve] masked
    draws 3 vertices, 1 instances
    unclipped: depth is clamped at the near and far planes
    late writes: rejected fragments may write buffers too
    color image, cleared to [0.0, 0.0, 0.0, 0.0], replaced
    stencil mask, cleared to 1, Equal 1, pass Keep, fail Keep
    writes counts
"
    );
}
