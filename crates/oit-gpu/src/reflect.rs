//! What a WGSL shader binds, reads and writes: the shader is where a pass's resources are declared.

use crate::directives::hoisted;
use crate::features::Features;
use crate::spirv;
use crate::{PreRaster, Raster, Shader, VertexFormat, Work, glsl};
use naga::proc::GlobalCtx;
use naga::valid::{GlobalUse, ModuleInfo};
use naga::{
    AddressSpace, Handle, ImageClass, ImageDimension, Module, ScalarKind, ShaderStage,
    StorageAccess, Type, TypeInner,
};
use std::collections::HashMap;
use std::sync::Arc;

/// A parsed and validated shader.
#[derive(Debug)]
pub struct Reflection {
    /// Every buffer and target its entry points use, by group and binding.
    pub bindings: Vec<Binding>,
    /// The compute entry point `main`.
    pub main: Option<Main>,
    /// The vertex entry point `vs`.
    pub vs: Option<Vs>,
    /// The fragment entry point `fs`.
    pub fs: Option<Fs>,
    /// The stages in GLSL that take the place of `vs`, in order.
    pub(crate) stages: Vec<spirv::Compiled>,
    /// Whether no product and sum may become one operation: whether the module has a constant
    /// `EXACT_ARITHMETIC` that is true.
    pub exact_arithmetic: bool,
    pub(crate) module: Module,
    pub(crate) info: ModuleInfo,
}

/// A buffer or target that a shader uses.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Binding {
    /// `@group`.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// The variable, which is the name of the plan's buffer or target.
    pub name: String,
    /// How it is declared.
    pub access: Access,
    /// Whether `main` uses it.
    pub compute: bool,
    /// Whether `vs` uses it, or a stage in GLSL in its place declares it.
    pub vertex: bool,
    /// Whether `fs` uses it.
    pub fragment: bool,
    /// Bytes the buffer must have at least: the type's size, with one element of a runtime array.
    /// Of a target 0.
    pub min_bytes: u64,
}

/// How a shader declares a buffer or a target.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Access {
    /// `var<uniform>`.
    Uniform,
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`.
    ReadWrite,
    /// `texture_2d<f32>`.
    Texture,
    /// `texture_2d<u32>`.
    UintTexture,
}

impl Access {
    /// Whether it is a target, not a buffer.
    #[must_use]
    pub fn is_target(self) -> bool {
        matches!(self, Self::Texture | Self::UintTexture)
    }
}

/// The compute entry point.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Main {
    /// Invocations of a workgroup in x, y and z.
    pub workgroup_size: [u32; 3],
    /// Workgroup memory it uses, in bytes.
    pub workgroup_bytes: u64,
    /// The fewest invocations of a subgroup that it is right with: the module's constant
    /// `SUBGROUP_AT_LEAST`, a power of two. Where there is one, subgroups are full as well.
    pub subgroup_at_least: Option<u32>,
}

/// The vertex entry point.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Vs {
    /// Each `@location` it reads, and whether the type there is made of floats, else of `u32`.
    pub inputs: Vec<(u32, bool)>,
}

/// The fragment entry point.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fs {
    /// Each `@location` it reads.
    pub inputs: Vec<u32>,
    /// Each `@location` it writes.
    pub outputs: Vec<u32>,
    /// Whether it writes a buffer.
    pub writes: bool,
    /// Whether it says `@early_depth_test(force)`.
    pub early_depth_test: bool,
    /// Those of its outputs that are of `u32`, not of floats.
    pub uint_outputs: Vec<u32>,
    /// Whether it writes `@builtin(frag_depth)`.
    pub writes_depth: bool,
    /// What it promises of the depth that it writes.
    pub depth_bound: Option<DepthBound>,
}

/// What a fragment shader promises of the depth that it writes, so that the device may test the
/// primitive's own depth before it runs the shader (conservative depth). A depth that breaks the
/// promise gives anything.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DepthBound {
    /// `@early_depth_test(less_equal)`: no greater than the primitive's.
    LessEqual,
    /// `@early_depth_test(greater_equal)`: no less than the primitive's.
    GreaterEqual,
    /// `@early_depth_test(unchanged)`: the primitive's.
    Unchanged,
}

impl DepthBound {
    /// The word of `@early_depth_test`.
    #[must_use]
    pub fn wgsl(self) -> &'static str {
        match self {
            Self::LessEqual => "less_equal",
            Self::GreaterEqual => "greater_equal",
            Self::Unchanged => "unchanged",
        }
    }
}

/// The two ways a shader is run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    Compute,
    Raster,
}

impl Kind {
    /// How a pass with this work runs its shader.
    pub(crate) fn of(work: &Work) -> Self {
        match work {
            Work::Raster(_) => Self::Raster,
            Work::Compute { .. } | Work::Clear { .. } => Self::Compute,
        }
    }
}

impl Reflection {
    /// Parses and validates a shader.
    ///
    /// # Errors
    /// The compiler's message with the lines concerned, or what a plan cannot give such a shader.
    pub fn new(shader: &Shader) -> Result<Self, String> {
        let label = &shader.label;
        let wgsl = hoisted(&shader.wgsl);
        let module = naga::front::wgsl::parse_str(&wgsl)
            .map_err(|error| error.emit_to_string_with_path(&wgsl, label))?;
        let info = Features::ALL
            .validate(&module)
            .map_err(|error| error.emit_to_string_with_path(&wgsl, label))?;
        if let Some((_, constant)) = module.overrides.iter().next() {
            let name = constant.name.as_deref().unwrap_or("without a name");
            return Err(format!("shader {label:?}: `override {name}`: use a `const` instead"));
        }
        let mut reflection = Self {
            bindings: Vec::new(),
            main: None,
            vs: None,
            fs: None,
            stages: Vec::new(),
            exact_arithmetic: is_exact(&module),
            module,
            info,
        };
        reflection.find_entry_points();
        reflection.find_subgroup().map_err(|what| format!("shader {label:?}: {what}"))?;
        reflection.find_bindings().map_err(|what| format!("shader {label:?}: {what}"))?;
        Ok(reflection)
    }

    /// Puts stages in GLSL in the place of `vs`.
    ///
    /// # Errors
    /// The compiler's message, or what a plan cannot give such a stage.
    fn with_stages(mut self, pre_raster: &PreRaster) -> Result<Self, String> {
        self.vs = None;
        for binding in &mut self.bindings {
            binding.vertex = false;
        }
        self.bindings.retain(|binding| binding.compute || binding.fragment);
        for (stage, source) in glsl::stages(pre_raster) {
            let compiled = spirv::Compiled::new(stage, source)?;
            for found in &compiled.bindings {
                self.join(found).map_err(|what| format!("{} stage: {what}", stage.name()))?;
            }
            if stage == glsl::Stage::Vertex {
                self.vs = Some(Vs { inputs: compiled.inputs.clone() });
            }
            self.stages.push(compiled);
        }
        self.bindings.sort_by_key(|binding| (binding.group, binding.binding));
        Ok(self)
    }

    /// Adds a stage's buffer, which another stage may declare too.
    fn join(&mut self, found: &spirv::Found) -> Result<(), String> {
        let spirv::Found { group, binding, name, access, min_bytes } = found.clone();
        let twin = self.bindings.iter_mut().find(|b| (b.group, b.binding) == (group, binding));
        let Some(twin) = twin else {
            let (compute, vertex, fragment) = (false, true, false);
            let new =
                Binding { group, binding, name, access, compute, vertex, fragment, min_bytes };
            self.bindings.push(new);
            return Ok(());
        };
        let of_storage = |access| matches!(access, Access::Read | Access::ReadWrite);
        let alike = twin.access == access || (of_storage(twin.access) && of_storage(access));
        if twin.name != name || !alike {
            return Err(format!(
                "`{name}` ({access:?}) and `{}` ({:?}) are both at set {group} and binding {binding}",
                twin.name, twin.access
            ));
        }
        if access == Access::ReadWrite {
            twin.access = access;
        }
        twin.vertex = true;
        twin.min_bytes = twin.min_bytes.max(min_bytes);
        Ok(())
    }

    /// What a pass of this kind binds.
    pub(crate) fn bindings_of(&self, kind: Kind) -> impl Iterator<Item = &Binding> + Clone {
        self.bindings.iter().filter(move |binding| match kind {
            Kind::Compute => binding.compute,
            Kind::Raster => binding.vertex || binding.fragment,
        })
    }

    /// How many bind groups a pass of this kind has, gaps included.
    pub(crate) fn groups(&self, kind: Kind) -> u32 {
        self.bindings_of(kind).map(|binding| binding.group + 1).max().unwrap_or(0)
    }

    fn find_entry_points(&mut self) {
        let context = self.module.to_ctx();
        for (index, entry) in self.module.entry_points.iter().enumerate() {
            let used = |space: fn(AddressSpace) -> bool, how: GlobalUse| {
                let info = self.info.get_entry_point(index);
                self.module
                    .global_variables
                    .iter()
                    .filter(move |&(handle, global)| {
                        space(global.space) && info[handle].intersects(how)
                    })
                    .map(|(_, global)| global)
            };
            let is_storage = |space| matches!(space, AddressSpace::Storage { .. });
            let writes = used(is_storage, GlobalUse::WRITE | GlobalUse::ATOMIC).next().is_some();
            match (entry.stage, entry.name.as_str()) {
                (ShaderStage::Compute, "main") => {
                    let bytes = |global: &naga::GlobalVariable| type_bytes(global.ty, context);
                    let workgroup_bytes =
                        used(|space| space == AddressSpace::WorkGroup, GlobalUse::all())
                            .map(bytes)
                            .sum();
                    let workgroup_size = entry.workgroup_size;
                    self.main =
                        Some(Main { workgroup_size, workgroup_bytes, subgroup_at_least: None });
                }
                (ShaderStage::Vertex, "vs") => {
                    let mut inputs = Vec::new();
                    for argument in &entry.function.arguments {
                        locations(
                            &self.module,
                            argument.ty,
                            argument.binding.as_ref(),
                            &mut inputs,
                        );
                    }
                    let is_float = |ty: Handle<Type>| {
                        let scalar = self.module.types[ty].inner.scalar();
                        scalar.is_some_and(|scalar| scalar.kind == ScalarKind::Float)
                    };
                    let inputs = inputs.into_iter().map(|(at, ty)| (at, is_float(ty))).collect();
                    self.vs = Some(Vs { inputs });
                }
                (ShaderStage::Fragment, "fs") => {
                    let mut outputs = Vec::new();
                    let mut writes_depth = false;
                    if let Some(result) = &entry.function.result {
                        let binding = result.binding.as_ref();
                        locations(&self.module, result.ty, binding, &mut outputs);
                        writes_depth = has_depth(&self.module, result.ty, binding);
                    }
                    let is_uint = |ty: Handle<Type>| {
                        let scalar = self.module.types[ty].inner.scalar();
                        scalar.is_some_and(|scalar| scalar.kind == ScalarKind::Uint)
                    };
                    let early_depth_test =
                        entry.early_depth_test == Some(naga::EarlyDepthTest::Force);
                    let depth_bound = match entry.early_depth_test {
                        Some(naga::EarlyDepthTest::Allow { conservative }) => {
                            Some(match conservative {
                                naga::ConservativeDepth::LessEqual => DepthBound::LessEqual,
                                naga::ConservativeDepth::GreaterEqual => DepthBound::GreaterEqual,
                                naga::ConservativeDepth::Unchanged => DepthBound::Unchanged,
                            })
                        }
                        _ => None,
                    };
                    let mut inputs = Vec::new();
                    for argument in &entry.function.arguments {
                        let binding = argument.binding.as_ref();
                        locations(&self.module, argument.ty, binding, &mut inputs);
                    }
                    let uint = outputs.iter().filter(|(_, ty)| is_uint(*ty));
                    self.fs = Some(Fs {
                        inputs: inputs.into_iter().map(|(at, _)| at).collect(),
                        uint_outputs: uint.map(|&(at, _)| at).collect(),
                        outputs: outputs.into_iter().map(|(at, _)| at).collect(),
                        writes,
                        early_depth_test,
                        writes_depth,
                        depth_bound,
                    });
                }
                _ => {}
            }
        }
    }

    /// What the constant `SUBGROUP_AT_LEAST` says, if there is one.
    fn find_subgroup(&mut self) -> Result<(), String> {
        const NAME: &str = "SUBGROUP_AT_LEAST";
        let named = |constant: &&naga::Constant| constant.name.as_deref() == Some(NAME);
        let mut constants = self.module.constants.iter().map(|(_, constant)| constant);
        let Some(constant) = constants.find(named) else { return Ok(()) };
        let value = match self.module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value,
            _ => 0,
        };
        if !value.is_power_of_two() {
            return Err(format!("`{NAME}` must be a power of two, as `u32`"));
        }
        if let Some(main) = &mut self.main {
            main.subgroup_at_least = Some(value);
        }
        Ok(())
    }

    fn find_bindings(&mut self) -> Result<(), String> {
        for (handle, global) in self.module.global_variables.iter() {
            let uses = |stage: ShaderStage, name: &str| {
                self.module.entry_points.iter().enumerate().any(|(index, entry)| {
                    let info = self.info.get_entry_point(index);
                    entry.stage == stage && entry.name == name && !info[handle].is_empty()
                })
            };
            let compute = uses(ShaderStage::Compute, "main");
            let vertex = uses(ShaderStage::Vertex, "vs");
            let fragment = uses(ShaderStage::Fragment, "fs");
            if !(compute || vertex || fragment) {
                continue;
            }
            let name = global.name.clone().unwrap_or_default();
            let access = match global.space {
                AddressSpace::Function | AddressSpace::Private | AddressSpace::WorkGroup => {
                    continue;
                }
                AddressSpace::Uniform => Access::Uniform,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                    Access::ReadWrite
                }
                AddressSpace::Storage { .. } => Access::Read,
                AddressSpace::Handle => {
                    texture(&self.module.types[global.ty].inner).ok_or_else(|| {
                        format!(
                            "`{name}` is neither a buffer nor a `texture_2d<f32>` or \
                             `texture_2d<u32>`, and a plan binds nothing else"
                        )
                    })?
                }
                _ => return Err(format!("`{name}` is in no address space that a plan binds")),
            };
            let Some(naga::ResourceBinding { group, binding }) = global.binding else {
                return Err(format!("`{name}` has no @group and @binding"));
            };
            let min_bytes = match access {
                _ if access.is_target() => 0,
                _ => type_bytes(global.ty, self.module.to_ctx()),
            };
            let new =
                Binding { group, binding, name, access, compute, vertex, fragment, min_bytes };
            let twin = self.bindings.iter().find(|b| (b.group, b.binding) == (group, binding));
            if let Some(twin) = twin {
                return Err(format!(
                    "`{}` and `{}` are both @group({group}) @binding({binding})",
                    twin.name, new.name
                ));
            }
            self.bindings.push(new);
        }
        self.bindings.sort_by_key(|binding| (binding.group, binding.binding));
        Ok(())
    }
}

/// Whether a module asks for exact arithmetic.
fn is_exact(module: &Module) -> bool {
    module.constants.iter().any(|(_, constant)| {
        constant.name.as_deref() == Some("EXACT_ARITHMETIC")
            && matches!(
                module.global_expressions[constant.init],
                naga::Expression::Literal(naga::Literal::Bool(true))
            )
    })
}

/// Whether a vertex attribute of this format is read as floats, else as `u32`.
pub(crate) fn is_float(format: VertexFormat) -> bool {
    match format {
        VertexFormat::Float32x3 | VertexFormat::Unorm8x4 => true,
        VertexFormat::Uint32 => false,
    }
}

/// How a type is bound that is `texture_2d<f32>` or `texture_2d<u32>`.
fn texture(ty: &TypeInner) -> Option<Access> {
    let TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } = *ty else {
        return None;
    };
    match class {
        ImageClass::Sampled { kind: ScalarKind::Float, multi: false } => Some(Access::Texture),
        ImageClass::Sampled { kind: ScalarKind::Uint, multi: false } => Some(Access::UintTexture),
        _ => None,
    }
}

/// Whether an entry point's result, or a member of it, is `frag_depth`.
fn has_depth(module: &Module, ty: Handle<Type>, binding: Option<&naga::Binding>) -> bool {
    match (binding, &module.types[ty].inner) {
        (Some(binding), _) => *binding == naga::Binding::BuiltIn(naga::BuiltIn::FragDepth),
        (None, TypeInner::Struct { members, .. }) => {
            members.iter().any(|member| has_depth(module, member.ty, member.binding.as_ref()))
        }
        _ => false,
    }
}

/// The size of a type; of a type too large to have one, the largest number there is, which no
/// buffer has.
impl Reflection {
    /// Bytes of the arrays that one invocation's functions keep: those of the function that keeps most.
    pub(crate) fn function_array_bytes(&self) -> u64 {
        let module = &self.module;
        let arrays = |function: &naga::Function| -> u64 {
            let types = function.local_variables.iter().map(|(_, variable)| variable.ty);
            let arrays =
                types.filter(|&ty| matches!(module.types[ty].inner, TypeInner::Array { .. }));
            arrays.map(|ty| type_bytes(ty, module.to_ctx())).sum()
        };
        let functions = module.functions.iter().map(|(_, function)| function);
        let entries = module.entry_points.iter().map(|entry| &entry.function);
        functions.chain(entries).map(arrays).max().unwrap_or(0)
    }
}

fn type_bytes(ty: Handle<Type>, context: GlobalCtx<'_>) -> u64 {
    context.types[ty].inner.try_size(context).map_or(u64::MAX, u64::from)
}

/// The `@location`s of an entry point's argument or result, also inside a structure.
fn locations(
    module: &Module,
    ty: Handle<Type>,
    binding: Option<&naga::Binding>,
    found: &mut Vec<(u32, Handle<Type>)>,
) {
    match binding {
        Some(&naga::Binding::Location { location, .. }) => found.push((location, ty)),
        Some(naga::Binding::BuiltIn(_)) => {}
        None => {
            if let TypeInner::Struct { members, .. } = &module.types[ty].inner {
                for member in members {
                    locations(module, member.ty, member.binding.as_ref(), found);
                }
            }
        }
    }
}

/// The shaders seen so far, so that each is parsed once.
#[derive(Default)]
pub(crate) struct Shaders {
    by_source: HashMap<Arc<str>, Arc<Reflection>>,
    with_stages: HashMap<(Arc<str>, PreRaster), Arc<Reflection>>,
}

impl Shaders {
    /// The reflection of a shader.
    pub(crate) fn get(&mut self, shader: &Shader) -> Result<Arc<Reflection>, String> {
        if let Some(known) = self.by_source.get(&shader.wgsl) {
            return Ok(known.clone());
        }
        let reflection = Arc::new(Reflection::new(shader)?);
        self.by_source.insert(shader.wgsl.clone(), reflection.clone());
        Ok(reflection)
    }

    /// The reflection of all stages of a raster pass.
    pub(crate) fn of_raster(&mut self, raster: &Raster) -> Result<Arc<Reflection>, String> {
        if raster.pre_raster == PreRaster::Wgsl {
            return self.get(&raster.shader);
        }
        let key = (raster.shader.wgsl.clone(), raster.pre_raster.clone());
        if let Some(known) = self.with_stages.get(&key) {
            return Ok(known.clone());
        }
        let label = &raster.shader.label;
        let reflection = Reflection::new(&raster.shader)?
            .with_stages(&raster.pre_raster)
            .map_err(|what| format!("shader {label:?}: {what}"))?;
        let reflection = Arc::new(reflection);
        self.with_stages.insert(key, reflection.clone());
        Ok(reflection)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_a_function_are_counted() {
        let shader = Shader::new(
            "arrays.wgsl",
            "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
            var<workgroup> elsewhere: array<u32, 64>;
            fn deep() -> u32 {
                var frags: array<vec2<u32>, 2048>;
                var scratch: array<u32, 3>;
                return frags[out[1]].x + scratch[out[2]];
            }
            @compute @workgroup_size(1) fn main() {
                var few: array<u32, 5>;
                out[0] = deep() + few[out[3]] + elsewhere[0];
            }",
        );
        let reflection = Reflection::new(&shader).expect("valid");
        assert_eq!(reflection.function_array_bytes(), 8 * 2048 + 12);
    }

    #[test]
    fn lists_what_each_entry_point_binds() {
        let shader = Shader::new(
            "all.wgsl",
            "struct Scene { width: u32, height: u32 }
            @group(1) @binding(2) var<storage, read_write> counts: array<atomic<u32>>;
            @group(0) @binding(0) var<uniform> scene: Scene;
            @group(0) @binding(1) var<storage, read> nodes: array<vec2<u32>>;
            @group(0) @binding(7) var<storage, read> unused: array<u32>;
            var<workgroup> shared_nodes: array<u32, 32>;
            fn helper() -> u32 { return nodes[0].x; }
            @compute @workgroup_size(8, 4) fn main() {
                shared_nodes[0] = helper();
                atomicAdd(&counts[0], shared_nodes[0]);
            }
            struct In { @location(0) at: vec3<f32>, @location(3) id: u32 }
            @vertex fn vs(in: In, @builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
                return vec4<f32>(in.at, f32(scene.width + in.id + i));
            }
            @fragment @early_depth_test(force) fn fs() -> @location(1) vec4<f32> {
                return vec4<f32>(f32(atomicLoad(&counts[0])));
            }",
        );
        let seen = Reflection::new(&shader).expect("valid");
        let listed: Vec<_> = seen
            .bindings
            .iter()
            .map(|b| (b.group, b.binding, b.name.as_str(), b.access, b.min_bytes))
            .collect();
        assert_eq!(
            listed,
            [
                (0, 0, "scene", Access::Uniform, 8),
                (0, 1, "nodes", Access::Read, 8),
                (1, 2, "counts", Access::ReadWrite, 4),
            ]
        );
        let stages = |b: &Binding| (b.compute, b.vertex, b.fragment);
        assert_eq!(stages(&seen.bindings[0]), (false, true, false));
        assert_eq!(stages(&seen.bindings[1]), (true, false, false));
        assert_eq!(stages(&seen.bindings[2]), (true, false, true));
        let main =
            Main { workgroup_size: [8, 4, 1], workgroup_bytes: 128, subgroup_at_least: None };
        assert_eq!(seen.main, Some(main));
        assert_eq!(seen.vs, Some(Vs { inputs: vec![(0, true), (3, false)] }));
        let fs = Fs {
            inputs: vec![],
            outputs: vec![1],
            writes: false,
            early_depth_test: true,
            uint_outputs: vec![],
            writes_depth: false,
            depth_bound: None,
        };
        assert_eq!(seen.fs, Some(fs));
        assert_eq!(seen.groups(Kind::Compute), 2);
        assert_eq!(seen.bindings_of(Kind::Raster).count(), 2);
    }

    #[test]
    fn fragment_outputs_are_floats_integers_and_a_depth() {
        let seen = |attribute: &str| {
            let shader = format!(
                "struct Out {{
                    @location(1) color: vec4<f32>,
                    @location(0) id: u32,
                    @builtin(frag_depth) depth: f32,
                }}
                @fragment {attribute} fn fs() -> Out {{ return Out(vec4<f32>(), 7u, 0.5); }}"
            );
            let seen = Reflection::new(&Shader::new("outputs", shader)).expect("valid");
            seen.fs.expect("a fragment stage")
        };
        let fs = seen("");
        assert_eq!((fs.outputs, fs.uint_outputs), (vec![1, 0], vec![0]));
        assert!(fs.writes_depth && !fs.early_depth_test && fs.depth_bound.is_none());
        for bound in [DepthBound::LessEqual, DepthBound::GreaterEqual, DepthBound::Unchanged] {
            let fs = seen(&format!("@early_depth_test({})", bound.wgsl()));
            assert!(fs.writes_depth && !fs.early_depth_test);
            assert_eq!(fs.depth_bound, Some(bound));
        }
    }

    #[test]
    fn a_constant_says_how_large_a_subgroup_must_be() {
        let main = "@compute @workgroup_size(64) fn main() {}";
        let seen = |constant: &str| {
            let reflection = Reflection::new(&Shader::new("s", format!("{constant}\n{main}")))?;
            Ok::<_, String>(reflection.main.and_then(|main| main.subgroup_at_least))
        };
        assert_eq!(seen(""), Ok(None));
        assert_eq!(seen("const SUBGROUP_AT_LEAST = 16u;"), Ok(Some(16)));
        assert_eq!(seen("const SUBGROUP_AT_LEAST: u32 = 4u << 3u;"), Ok(Some(32)));
        for bad in ["0u", "12u", "8i", "8.0f"] {
            let message = seen(&format!("const SUBGROUP_AT_LEAST = {bad};")).expect_err(bad);
            assert!(message.contains("`SUBGROUP_AT_LEAST` must be a power of two"), "{message}");
        }
    }

    #[test]
    fn a_constant_asks_for_exact_arithmetic() {
        let main = "@compute @workgroup_size(64) fn main() {}";
        for (constant, exact) in [
            ("", false),
            ("const EXACT_ARITHMETIC = true;", true),
            ("const EXACT_ARITHMETIC = false;", false),
        ] {
            let shader = Shader::new("s", format!("{constant}\n{main}"));
            assert_eq!(Reflection::new(&shader).expect("valid").exact_arithmetic, exact);
        }
    }

    #[test]
    fn errors_show_the_line_and_the_label() {
        let parse = Reflection::new(&Shader::new("broken.wgsl", "fn main() { let x = ; }"));
        let message = parse.expect_err("does not parse");
        assert!(message.contains("broken.wgsl:1:"), "{message}");
        assert!(message.contains("let x = ;"), "{message}");

        let types = "@compute @workgroup_size(1) fn main() { var x: u32 = 1.5f; }";
        let message = Reflection::new(&Shader::new("types.wgsl", types)).expect_err("ill typed");
        assert!(message.contains("types.wgsl:1:"), "{message}");

        for ty in ["texture_2d<i32>", "texture_depth_2d", "texture_2d_array<f32>"] {
            let texture = format!(
                "@group(0) @binding(0) var image: {ty};
                @compute @workgroup_size(1) fn main() {{ _ = textureDimensions(image); }}"
            );
            let message = Reflection::new(&Shader::new("t", texture)).expect_err("not bound");
            assert!(message.contains("`image` is neither a buffer nor"), "{message}");
        }
    }

    #[test]
    fn textures_are_bound_by_name_as_buffers_are() {
        let shader = "@group(0) @binding(1) var unused: texture_2d<f32>;
            @group(1) @binding(0) var image: texture_2d<f32>;
            @group(0) @binding(0) var<storage, read_write> first: array<f32>;
            @compute @workgroup_size(1) fn main() {
                first[0] = textureLoad(image, vec2<u32>(0u, 0u), 0).x;
            }";
        let seen = Reflection::new(&Shader::new("t", shader)).expect("valid");
        let listed: Vec<_> =
            seen.bindings.iter().map(|b| (b.name.as_str(), b.access, b.min_bytes)).collect();
        assert_eq!(listed, [("first", Access::ReadWrite, 4), ("image", Access::Texture, 0)]);
    }
}
