//! What the SPIR-V of a stage binds, reads and writes, where no WGSL says it.

use crate::glsl::{self, Stage};
use crate::reflect::Access;
use crate::vulkan::words::instructions;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

const OP_NAME: u32 = 5;
const OP_EXECUTION_MODE: u32 = 16;
const OP_CAPABILITY: u32 = 17;
const OP_TYPE_INT: u32 = 21;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_TYPE_MATRIX: u32 = 24;
const OP_TYPE_ARRAY: u32 = 28;
const OP_TYPE_RUNTIME_ARRAY: u32 = 29;
const OP_TYPE_STRUCT: u32 = 30;
const OP_TYPE_POINTER: u32 = 32;
const OP_CONSTANT: u32 = 43;
const OP_VARIABLE: u32 = 59;
const OP_DECORATE: u32 = 71;
const OP_MEMBER_DECORATE: u32 = 72;

const ARRAY_STRIDE: u32 = 6;
const MATRIX_STRIDE: u32 = 7;
const NON_WRITABLE: u32 = 24;
const LOCATION: u32 = 30;
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const OFFSET: u32 = 35;

const UNIFORM_CONSTANT: u32 = 0;
const INPUT: u32 = 1;
const UNIFORM: u32 = 2;
const OUTPUT: u32 = 3;
const PUSH_CONSTANT: u32 = 9;
const STORAGE_BUFFER: u32 = 12;

/// What a stage may need beyond what every device has: Shader, its matrices, and its own kind.
const CAPABILITIES: [(u32, &str); 5] =
    [(0, "Matrix"), (1, "Shader"), (2, "Geometry"), (3, "Tessellation"), (5283, "MeshShadingEXT")];
/// `gl_PointSize` in the stages of tessellation and geometry.
pub(crate) const POINT_SIZES: [u32; 2] = [23, 24];

/// A compiled stage.
#[derive(Debug)]
pub(crate) struct Compiled {
    pub(crate) stage: Stage,
    pub(crate) words: Vec<u32>,
    pub(crate) bindings: Vec<Found>,
    /// Each location it reads, and whether the type there is made of floats.
    pub(crate) inputs: Vec<(u32, bool)>,
    /// Each location it writes.
    pub(crate) outputs: Vec<u32>,
    /// Its execution modes, in SPIR-V's numbers.
    pub(crate) modes: Vec<u32>,
    /// Whether it sets the size of points.
    pub(crate) sizes_points: bool,
}

/// A buffer that a stage declares.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Found {
    pub(crate) group: u32,
    pub(crate) binding: u32,
    pub(crate) name: String,
    pub(crate) access: Access,
    pub(crate) min_bytes: u64,
}

impl Compiled {
    /// Compiles a stage and finds what it declares.
    ///
    /// # Errors
    /// The compiler's message, or what a plan cannot give such a stage.
    pub(crate) fn new(stage: Stage, source: &Arc<str>) -> Result<Self, String> {
        let in_stage = |what: String| format!("{} stage in GLSL: {what}", stage.name());
        let words = glsl::spirv(stage, source).map_err(in_stage)?;
        let module = Module::new(&words);
        let mut compiled = Self {
            stage,
            bindings: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            modes: module.modes.clone(),
            sizes_points: module.capabilities.iter().any(|c| POINT_SIZES.contains(c)),
            words: Vec::new(),
        };
        let known = |number: &u32| {
            POINT_SIZES.contains(number) || CAPABILITIES.iter().any(|(known, _)| known == number)
        };
        if let Some(number) = module.capabilities.iter().find(|number| !known(number)) {
            let all = CAPABILITIES.map(|(_, name)| name).join(", ");
            return Err(in_stage(format!("it needs SPIR-V's capability {number}, not just {all}")));
        }
        for &(id, pointer, class) in &module.variables {
            module.variable(&mut compiled, id, pointer, class).map_err(in_stage)?;
        }
        compiled.bindings.sort_by_key(|found| (found.group, found.binding));
        compiled.outputs.sort_unstable();
        compiled.words = words;
        Ok(compiled)
    }
}

/// A type, as far as its size and place matter.
enum Type {
    Scalar {
        bytes: u64,
        float: bool,
    },
    /// A vector or a matrix: what it is of, and how often.
    Several {
        of: u32,
        count: u64,
    },
    /// An array, of a length unless it is a buffer's last.
    Array {
        of: u32,
        length: Option<u32>,
    },
    Struct {
        members: Vec<u32>,
    },
}

#[derive(Default)]
struct Module {
    names: HashMap<u32, String>,
    decorations: HashMap<(u32, u32), u32>,
    member_decorations: HashMap<(u32, u32, u32), u32>,
    types: HashMap<u32, Type>,
    matrices: HashSet<u32>,
    pointees: HashMap<u32, u32>,
    constants: HashMap<u32, u32>,
    variables: Vec<(u32, u32, u32)>,
    capabilities: Vec<u32>,
    modes: Vec<u32>,
}

impl Module {
    fn new(words: &[u32]) -> Self {
        let mut module = Self::default();
        for (opcode, words) in instructions(words) {
            match (opcode, words) {
                (OP_NAME, [_, id, text @ ..]) => drop(module.names.insert(*id, string(text))),
                (OP_EXECUTION_MODE, [_, _, mode, ..]) => module.modes.push(*mode),
                (OP_CAPABILITY, [_, capability]) => module.capabilities.push(*capability),
                (OP_TYPE_INT | OP_TYPE_FLOAT, [_, id, bits, ..]) => {
                    let (bytes, float) = (u64::from(bits / 8), opcode == OP_TYPE_FLOAT);
                    module.types.insert(*id, Type::Scalar { bytes, float });
                }
                (OP_TYPE_VECTOR | OP_TYPE_MATRIX, [_, id, of, count]) => {
                    let (of, count) = (*of, u64::from(*count));
                    module.types.insert(*id, Type::Several { of, count });
                    if opcode == OP_TYPE_MATRIX {
                        module.matrices.insert(*id);
                    }
                }
                (OP_TYPE_ARRAY, [_, id, of, length]) => {
                    let length = Some(*length);
                    module.types.insert(*id, Type::Array { of: *of, length });
                }
                (OP_TYPE_RUNTIME_ARRAY, [_, id, of]) => {
                    module.types.insert(*id, Type::Array { of: *of, length: None });
                }
                (OP_TYPE_STRUCT, [_, id, members @ ..]) => {
                    module.types.insert(*id, Type::Struct { members: members.to_vec() });
                }
                (OP_TYPE_POINTER, [_, id, _, to]) => drop(module.pointees.insert(*id, *to)),
                (OP_CONSTANT, [_, _, id, value, ..]) => drop(module.constants.insert(*id, *value)),
                (OP_VARIABLE, [_, pointer, id, class, ..]) => {
                    module.variables.push((*id, *pointer, *class));
                }
                (OP_DECORATE, [_, id, what, rest @ ..]) => {
                    let value = rest.first().copied().unwrap_or_default();
                    module.decorations.insert((*id, *what), value);
                }
                (OP_MEMBER_DECORATE, [_, id, member, what, rest @ ..]) => {
                    let value = rest.first().copied().unwrap_or_default();
                    module.member_decorations.insert((*id, *member, *what), value);
                }
                _ => {}
            }
        }
        module
    }

    fn decoration(&self, id: u32, what: u32) -> Option<u32> {
        self.decorations.get(&(id, what)).copied()
    }

    /// The type, and if it is an array, what it is of.
    fn innermost(&self, mut id: u32) -> u32 {
        while let Some(Type::Array { of, .. }) = self.types.get(&id) {
            id = *of;
        }
        id
    }

    fn variable(
        &self,
        compiled: &mut Compiled,
        id: u32,
        pointer: u32,
        class: u32,
    ) -> Result<(), String> {
        let Some(&ty) = self.pointees.get(&pointer) else { return Ok(()) };
        let named = |id: u32| self.names.get(&id).filter(|name| !name.is_empty()).cloned();
        // Of a block without an instance's name, the block's.
        let name = named(id).or_else(|| named(ty)).unwrap_or_default();
        let access = match class {
            INPUT => {
                let first = self.decoration(id, LOCATION);
                for (location, float) in self.locations(ty, first) {
                    compiled.inputs.push((location, float));
                }
                return Ok(());
            }
            OUTPUT => {
                let first = self.decoration(id, LOCATION);
                let locations = self.locations(ty, first);
                compiled.outputs.extend(locations.into_iter().map(|(location, _)| location));
                return Ok(());
            }
            UNIFORM => Access::Uniform,
            STORAGE_BUFFER => match self.is_read_only(id, ty) {
                true => Access::Read,
                false => Access::ReadWrite,
            },
            UNIFORM_CONSTANT | PUSH_CONSTANT => {
                return Err(format!("`{name}` is no buffer, and a plan binds nothing else there"));
            }
            _ => return Ok(()),
        };
        let place = self.decoration(id, DESCRIPTOR_SET).zip(self.decoration(id, BINDING));
        let Some((group, binding)) = place else {
            return Err(format!("`{name}` has no layout(set = ..., binding = ...)"));
        };
        if matches!(self.types.get(&ty), Some(Type::Array { .. })) {
            return Err(format!("`{name}` is an array of buffers, and a plan binds single ones"));
        }
        let min_bytes = self.bytes(ty);
        compiled.bindings.push(Found { group, binding, name, access, min_bytes });
        Ok(())
    }

    /// Whether a variable, or every member of its block, is `readonly`.
    fn is_read_only(&self, id: u32, block: u32) -> bool {
        let Some(Type::Struct { members }) = self.types.get(&block) else { return false };
        let member = |(at, _)| self.member_decorations.contains_key(&(block, at, NON_WRITABLE));
        self.decoration(id, NON_WRITABLE).is_some() || (0..).zip(members).all(member)
    }

    /// The locations of an input or output from its first on, and whether each is of floats. Those
    /// of a stage's arrays of vertices are those of one.
    fn locations(&self, ty: u32, first: Option<u32>) -> Vec<(u32, bool)> {
        let inner = self.innermost(ty);
        let mut found = Vec::new();
        let mut next = first;
        let members = match self.types.get(&inner) {
            Some(Type::Struct { members }) => members.clone(),
            _ => {
                let Some(first) = first else { return found };
                return (0..self.slots(inner)).map(|i| (first + i, self.is_float(inner))).collect();
            }
        };
        for (at, &member) in (0..).zip(&members) {
            let own = self.member_decorations.get(&(inner, at, LOCATION)).copied();
            let Some(start) = own.or(next) else { continue };
            let slots = self.slots(member);
            found.extend((0..slots).map(|i| (start + i, self.is_float(member))));
            next = Some(start + slots);
        }
        found
    }

    /// How many locations a type takes.
    fn slots(&self, ty: u32) -> u32 {
        match self.types.get(&ty) {
            Some(Type::Several { count, .. }) if self.matrices.contains(&ty) => *count as u32,
            Some(Type::Array { of, length: Some(length) }) => {
                let length = self.constants.get(length).copied().unwrap_or(1);
                self.slots(*of).saturating_mul(length).min(64)
            }
            _ => 1,
        }
    }

    fn is_float(&self, mut ty: u32) -> bool {
        loop {
            match self.types.get(&ty) {
                Some(Type::Scalar { float, .. }) => return *float,
                Some(Type::Several { of, .. } | Type::Array { of, .. }) => ty = *of,
                _ => return false,
            }
        }
    }

    /// The size of a type in a block, with one element of an array without a length.
    fn bytes(&self, ty: u32) -> u64 {
        match self.types.get(&ty) {
            Some(Type::Scalar { bytes, .. }) => *bytes,
            Some(Type::Several { of, count }) => self.bytes(*of) * count,
            Some(Type::Array { of, length }) => {
                let stride =
                    self.decoration(ty, ARRAY_STRIDE).map_or_else(|| self.bytes(*of), u64::from);
                let length = length.and_then(|id| self.constants.get(&id)).copied().unwrap_or(1);
                stride.saturating_mul(u64::from(length))
            }
            Some(Type::Struct { members }) => (0..)
                .zip(members)
                .map(|(at, &member)| {
                    let told = |what| self.member_decorations.get(&(ty, at, what)).copied();
                    let offset = u64::from(told(OFFSET).unwrap_or_default());
                    let bytes = match (self.types.get(&member), told(MATRIX_STRIDE)) {
                        (Some(Type::Several { count, .. }), Some(stride)) => {
                            u64::from(stride) * count
                        }
                        _ => self.bytes(member),
                    };
                    offset.saturating_add(bytes)
                })
                .max()
                .unwrap_or_default(),
            None => 0,
        }
    }
}

/// A text of SPIR-V: UTF-8 in words, the lowest byte first, ended by a zero.
fn string(words: &[u32]) -> String {
    let bytes: Vec<u8> =
        words.iter().flat_map(|word| word.to_le_bytes()).take_while(|&byte| byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compiled(stage: Stage, source: &str) -> Result<Compiled, String> {
        Compiled::new(stage, &Arc::from(source))
    }

    #[test]
    fn blocks_are_found_by_their_instance_or_their_own_name() {
        let seen = compiled(
            Stage::Vertex,
            "#version 450
            layout(set = 0, binding = 1, std430) readonly buffer Atoms { vec4 list[]; } atoms;
            layout(set = 0, binding = 0, std140) uniform scene { mat4 project; vec3 eye; };
            layout(set = 1, binding = 2, std430) buffer Counts { uint first; uint all[4]; } counts;
            layout(location = 3) in uint id;
            layout(location = 0) in vec3 at;
            layout(location = 1) out vec4 color;
            layout(location = 2) flat out uint number;
            void main() {
                gl_Position = project * vec4(atoms.list[id].xyz + at, 1.0);
                color = vec4(eye, 1.0);
                number = counts.all[id] + counts.first;
            }",
        )
        .expect("it compiles");
        let listed: Vec<_> = seen
            .bindings
            .iter()
            .map(|b| (b.group, b.binding, b.name.as_str(), b.access, b.min_bytes))
            .collect();
        assert_eq!(
            listed,
            [
                (0, 0, "scene", Access::Uniform, 76),
                (0, 1, "atoms", Access::Read, 16),
                (1, 2, "counts", Access::ReadWrite, 20),
            ]
        );
        let mut inputs = seen.inputs;
        inputs.sort_unstable();
        assert_eq!(inputs, [(0, true), (3, false)]);
        assert_eq!(seen.outputs, [1, 2]);
        assert!(!seen.sizes_points);
    }

    #[test]
    fn arrays_of_vertices_have_the_locations_of_one() {
        let seen = compiled(
            Stage::Geometry,
            "#version 450
            layout(points) in;
            layout(triangle_strip, max_vertices = 4) out;
            layout(location = 1) in Atom { vec4 at; mat2 turn; flat uint id; } atom[];
            layout(location = 0) out vec2 corner;
            layout(location = 4) out Two { vec4 a; vec4 b; } two;
            void main() {
                for (int i = 0; i < 4; ++i) {
                    corner = atom[0].turn * vec2(i & 1, i >> 1);
                    two.a = vec4(atom[0].id);
                    two.b = two.a;
                    gl_Position = atom[0].at + vec4(corner, 0.0, 0.0);
                    EmitVertex();
                }
            }",
        )
        .expect("it compiles");
        assert_eq!(seen.inputs, [(1, true), (2, true), (3, true), (4, false)]);
        assert_eq!(seen.outputs, [0, 4, 5]);
    }

    #[test]
    fn what_a_plan_cannot_bind_is_refused() {
        let refused = |declaration: &str, used: &str, words: &str| {
            let source = format!(
                "#version 460\n{declaration}\nvoid main() {{ gl_Position = vec4({used}); }}"
            );
            let message = compiled(Stage::Vertex, &source).expect_err("not bound");
            assert!(message.contains(words), "{message}");
            assert!(message.starts_with("vertex stage in GLSL: "), "{message}");
        };
        let image = "layout(set = 0, binding = 0) uniform sampler2D image;";
        refused(image, "texelFetch(image, ivec2(0), 0)", "`image` is no buffer");
        refused("layout(push_constant) uniform P { vec4 a; } p;", "p.a", "`p` is no buffer");
        let many = "layout(set = 0, binding = 0) uniform U { vec4 a; } many[2];";
        refused(many, "many[1].a", "`many` is an array of buffers");
        refused("", "float(double(gl_VertexIndex) / 3.0lf)", "capability 10");
    }
}
