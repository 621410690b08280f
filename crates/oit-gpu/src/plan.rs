//! A technique as data: named buffers and targets, and a list of labelled passes over them.
//!
//! A plan holds no API call. A pass names no binding either: every `var<storage>` or
//! `var<uniform>` of its shader is bound to the plan's buffer of the same name, and every
//! `texture_2d<f32>` to its colour target, so the shader is the one place where a resource is
//! declared to be read or written. Passes run one after the other, each seeing all that earlier
//! ones wrote.

use std::sync::Arc;

/// Named resources and the passes over them, in order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// What the plan is, for messages.
    pub name: String,
    /// Every buffer a pass or a shader names.
    pub buffers: Vec<Buffer>,
    /// Every texture that a raster pass draws to or a shader reads.
    pub targets: Vec<Target>,
    /// What is done, in order.
    pub passes: Vec<Pass>,
}

/// A buffer of bytes. Plans on one device that name a buffer of the same name and size share it
/// (they run one at a time), so a plan may rely on nothing that it did not write itself.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// The name, as the shaders spell it.
    pub name: String,
    /// Its size. Every buffer has at least 16 bytes; the backends round up to a multiple of 4.
    pub bytes: u64,
    /// What it holds before the first pass.
    pub contents: Contents,
}

/// What a buffer holds before the first pass of a run.
#[derive(Clone, Debug)]
pub enum Contents {
    /// Anything. A plan reads it only after writing it.
    Undefined,
    /// These bytes, uploaded once when the plan is prepared. No pass may write the buffer.
    Data(Arc<[u8]>),
}

/// A two-dimensional texture that raster passes draw to. Passes to which it is not attached can read
/// one of colour: their shader's `var NAME: texture_2d<f32>` (of integers, `texture_2d<u32>`) is the
/// target of that name, pixel (0, 0) at the top left. Depth and stencil cannot be read by a shader.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// Its format.
    pub format: Format,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// A target's format.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Format {
    /// Four 32-bit floats.
    Rgba32Float,
    /// Four 16-bit floats.
    Rgba16Float,
    /// Two 32-bit floats.
    Rg32Float,
    /// Two 16-bit floats.
    Rg16Float,
    /// One 32-bit float.
    R32Float,
    /// One 16-bit float.
    R16Float,
    /// Three floats without a sign: eleven bits, eleven, ten.
    Rg11b10Float,
    /// Four bytes, each 0 to 1.
    Rgba8Unorm,
    /// One byte, 0 to 1.
    R8Unorm,
    /// One unsigned 32-bit integer; it cannot be blended into, and shaders write a `u32` there.
    R32Uint,
    /// Four unsigned 32-bit integers; they cannot be blended into, and shaders write a `vec4<u32>`.
    Rgba32Uint,
    /// 32-bit float depth.
    Depth32Float,
    /// 8-bit stencil; a backend may add depth bits where the device has no format of stencil alone.
    Stencil8,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 13] = [
        Self::Rgba32Float,
        Self::Rgba16Float,
        Self::Rg32Float,
        Self::Rg16Float,
        Self::R32Float,
        Self::R16Float,
        Self::Rg11b10Float,
        Self::Rgba8Unorm,
        Self::R8Unorm,
        Self::R32Uint,
        Self::Rgba32Uint,
        Self::Depth32Float,
        Self::Stencil8,
    ];

    /// Bytes of one pixel as a plan reckons them, and as [`crate::Device::read`] returns them.
    #[must_use]
    pub fn bytes(self) -> u64 {
        match self {
            Self::Rgba32Float | Self::Rgba32Uint => 16,
            Self::Rgba16Float | Self::Rg32Float => 8,
            Self::Rg16Float
            | Self::R32Float
            | Self::R32Uint
            | Self::Rg11b10Float
            | Self::Rgba8Unorm
            | Self::Depth32Float => 4,
            Self::R16Float => 2,
            Self::R8Unorm | Self::Stencil8 => 1,
        }
    }

    /// Whether its channels are unsigned integers, which shaders write and read as `u32`.
    #[must_use]
    pub fn is_uint(self) -> bool {
        matches!(self, Self::R32Uint | Self::Rgba32Uint)
    }

    /// Whether it is a format of colour, not of depth or stencil.
    #[must_use]
    pub fn is_color(self) -> bool {
        !matches!(self, Self::Depth32Float | Self::Stencil8)
    }
}

impl VertexFormat {
    /// Bytes of one attribute.
    #[must_use]
    pub fn bytes(self) -> u32 {
        match self {
            Self::Float32x3 => 12,
            Self::Unorm8x4 | Self::Uint32 => 4,
        }
    }
}

/// How many bytes the arguments of one of several indirect draws of vertices take.
pub(crate) const DRAW_STRIDE_BYTES: u32 = 16;

/// WGSL source. Compute passes run the entry point `main`; raster passes run `vs` and `fs`. An array
/// of a function may hold anything before it is written (see the vulkan backend's `arrays`). A line
/// `enable NAME;` may stand anywhere, not only at the top, so that a source can be put together from
/// several texts. What a shader needs of a device is found from its code, whatever it enables.
///
/// A shader with `const EXACT_ARITHMETIC = true;` is to round after every single operation, so that
/// what several programs compute by the same expressions is the same: on `vulkan` no sum and product
/// become one operation. `wgpu` has no means to ask for it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Shader {
    /// What it is, for messages and listings.
    pub label: String,
    /// The source.
    pub wgsl: Arc<str>,
}

/// One labelled pass.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The step its time is charged to: `clear`, `count`, `scan`, `capture`, `group`, `resolve`.
    pub stage: &'static str,
    /// The part of the stage that it is, where the parts of a stage are to be told apart: neighbours
    /// with the same stage and part are timed together ([`crate::Timing::parts`]).
    pub part: Option<u32>,
    /// What it does, for messages and listings.
    pub label: String,
    /// What it does, for the backends.
    pub work: Work,
}

/// The kinds of pass.
#[derive(Clone, Debug)]
pub enum Work {
    /// Fills a whole buffer with zero bytes.
    Clear {
        /// The buffer.
        buffer: String,
    },
    /// Runs a compute shader.
    Compute {
        /// The shader.
        shader: Shader,
        /// How many workgroups.
        dispatch: Dispatch,
    },
    /// Draws.
    Raster(Raster),
}

/// How many workgroups a compute pass runs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Dispatch {
    /// This many in x, y and z.
    Workgroups([u32; 3]),
    /// As many as three `u32` in a buffer say.
    Indirect {
        /// The buffer.
        buffer: String,
        /// Where in it, in bytes; a multiple of 4.
        offset_bytes: u64,
    },
}

/// What makes the primitives of a raster pass.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub enum PreRaster {
    /// The entry point `vs` of the pass's shader, and triangles.
    #[default]
    Wgsl,
    /// Stages in GLSL: `vulkan` only. The pass's shader has `fs` alone (a `vs` is not used).
    Glsl(Box<Glsl>),
    /// A mesh shader in GLSL: `vulkan` with `VK_EXT_mesh_shader` only. The pass's shader has `fs`
    /// alone, and the draw is [`Draw::MeshIndirect`].
    Mesh(Box<Mesh>),
}

impl PreRaster {
    /// The stages in GLSL with their names, in the order in which they run.
    #[must_use]
    pub fn glsl_stages(&self) -> Vec<(&'static str, &str)> {
        let stages = crate::glsl::stages(self).into_iter();
        stages.map(|(stage, source)| (stage.name(), &**source)).collect()
    }
}

impl From<Glsl> for PreRaster {
    fn from(stages: Glsl) -> Self {
        Self::Glsl(Box::new(stages))
    }
}

impl From<Mesh> for PreRaster {
    fn from(stages: Mesh) -> Self {
        Self::Mesh(Box::new(stages))
    }
}

/// Stages in GLSL 4.60 for Vulkan, each with the entry point `main`, for what WGSL cannot say:
/// tessellation and geometry. Their buffers are named as those of WGSL are: the plan's buffer of the
/// name of a block's instance, or of the block if its instance has none, is bound at its
/// `layout(set = ..., binding = ...)`; a `buffer` block that is not `readonly` is written. What the
/// last stage writes at a `location`, `fs` reads there. Depth is 0 to 1 and y is up, as in WGSL.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Glsl {
    /// What vertices are put together to.
    pub topology: Topology,
    /// The vertex stage.
    pub vertex: Arc<str>,
    /// Both stages of tessellation; needs [`Topology::Patches`].
    pub tessellation: Option<Tessellation>,
    /// The geometry stage. Its input must be what comes to it: points or triangles.
    pub geometry: Option<Arc<str>>,
}

/// The stages of tessellation, in GLSL.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Tessellation {
    /// The control stage.
    pub control: Arc<str>,
    /// The evaluation stage.
    pub evaluation: Arc<str>,
}

/// A mesh shader in GLSL (`GL_EXT_mesh_shader`), bound as [`Glsl`] is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Mesh {
    /// The task stage that says how many workgroups of the mesh stage run.
    pub task: Option<Arc<str>>,
    /// The mesh stage.
    pub mesh: Arc<str>,
}

/// What vertices are put together to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Topology {
    /// A point a vertex. Where points reach rasterisation, the last stage says how large they are in
    /// `gl_PointSize`, in pixels.
    Points,
    /// A triangle of each three.
    Triangles,
    /// A patch of each so many, for tessellation.
    Patches(u32),
}

/// One draw into targets of one size: triangles, unless [`Self::pre_raster`] makes others; no
/// culling. [`Raster::new`] gives the usual state.
#[derive(Clone, Debug)]
pub struct Raster {
    /// The shader.
    pub shader: Shader,
    /// What makes the primitives.
    pub pre_raster: PreRaster,
    /// What is drawn.
    pub draw: Draw,
    /// Colour targets, in the order of the shader's `@location`s. A pass has at least one
    /// attachment, of colour or of depth and stencil.
    pub color: Vec<ColorAttachment>,
    /// The depth or stencil target.
    pub depth_stencil: Option<DepthStencil>,
    /// Whether primitives reach beyond the near and the far plane, where a fragment's depth is
    /// clamped to 0 or 1 for the test and the target. Otherwise they are clipped at both planes.
    pub unclipped: bool,
    /// The permission to write buffers under a rejecting depth or stencil test without
    /// `@early_depth_test(force)`, so that rejected fragments write too: a fault, which
    /// [`Plan::check`] refuses unless it is to be shown.
    pub late_writes: bool,
}

/// What a raster pass draws.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Draw {
    /// This many vertices without any buffer, in this many instances.
    Vertices {
        /// Vertices.
        count: u32,
        /// Instances.
        instances: u32,
    },
    /// Indexed triangles of one vertex buffer; indices are `u32`.
    Indexed {
        /// The buffer of vertices.
        vertices: String,
        /// How a vertex lies in it.
        layout: VertexLayout,
        /// The buffer of indices.
        indices: String,
        /// How many indices.
        count: u32,
    },
    /// As [`Draw::Vertices`], as many as four `u32` in a buffer say: vertices, instances, the first
    /// vertex, the first instance. No instances draw nothing: a pass that a shader has called off.
    ///
    /// There may be many draws, each with its four, one behind the other; they run in that order.
    /// `@builtin(vertex_index)` counts from the draw's first vertex, and
    /// `@builtin(instance_index)` from its first instance: both contain the first on `vulkan` and on
    /// wgpu's Vulkan and Metal. So draws tell themselves apart by their first instance. One that is
    /// not 0 needs the feature that [`oit_record::DeviceInfo::unsupported`] calls "first instance of
    /// indirect draws"; a pass of more than one draw is refused without it. wgpu's DX12 never has it
    /// here: shaders count from 0 there, and what wgpu adds to that it knows of an indirect draw only
    /// from passes that check the arguments, which are off because they would be timed.
    VerticesIndirect {
        /// The buffer of the four.
        arguments: String,
        /// Where in it the first draw's are, in bytes; a multiple of 4.
        offset_bytes: u64,
        /// How many draws: 1 or more. The four of each begin 16 bytes after those of the last.
        draws: u32,
    },
    /// Workgroups of the first stage of a [`Mesh`], as many as three `u32` in a buffer say: in x, y
    /// and z. Where one is 0, nothing is drawn.
    ///
    /// A side has at least 65,535 on every device with mesh shaders and all sides together 2^22
    /// (`maxMeshWorkGroupCount`, `maxMeshWorkGroupTotalCount`), so that many are spread over x and y.
    /// No one looks at what the buffer says, so the most that it can say is said here: a device with
    /// less refuses the plan.
    MeshIndirect {
        /// The buffer of the three.
        arguments: String,
        /// Where in it, in bytes; a multiple of 4.
        offset_bytes: u64,
        /// No side is larger in the buffer than this, nor their product than that of these.
        at_most: [u32; 3],
    },
    /// As [`Draw::Indexed`], as many as five `u32` in a buffer say: indices, instances, the first
    /// index, what is added to each index, the first instance (0).
    IndexedIndirect {
        /// The buffer of vertices.
        vertices: String,
        /// How a vertex lies in it.
        layout: VertexLayout,
        /// The buffer of indices.
        indices: String,
        /// The buffer of the five.
        arguments: String,
        /// Where in it, in bytes; a multiple of 4.
        offset_bytes: u64,
    },
}

/// How a vertex lies in its buffer.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct VertexLayout {
    /// Bytes from one vertex to the next.
    pub stride_bytes: u32,
    /// Its attributes.
    pub attributes: Vec<VertexAttribute>,
}

/// One attribute of a vertex.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct VertexAttribute {
    /// The shader's `@location`.
    pub location: u32,
    /// Its format.
    pub format: VertexFormat,
    /// Where in the vertex, in bytes.
    pub offset_bytes: u32,
}

/// The format of a vertex attribute.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum VertexFormat {
    /// Three 32-bit floats.
    Float32x3,
    /// Four bytes, each 0 to 1.
    Unorm8x4,
    /// One unsigned integer.
    Uint32,
}

/// A colour target of a raster pass.
#[derive(Clone, PartialEq, Debug)]
pub struct ColorAttachment {
    /// The target.
    pub target: String,
    /// What it holds when the pass starts. A format of integers is cleared to whole numbers: 0 to
    /// 2^24, or [`f32::INFINITY`], which stands for the largest `u32`.
    pub load: Load<[f32; 4]>,
    /// How a fragment's colour joins what is there; `None` replaces it.
    pub blend: Option<Blend>,
    /// Whether it is written at all. A pass that only writes buffers still needs an attachment.
    pub write: bool,
}

/// What an attachment holds when a pass starts.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Load<T> {
    /// This value everywhere.
    Clear(T),
    /// What earlier passes left.
    Keep,
}

/// How a fragment's colour joins what the target holds, the same for colour and alpha.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Blend {
    /// `source + target`.
    Add,
    /// `max(source, target)`.
    Max,
    /// `min(source, target)`.
    Min,
    /// `source + (1 - source alpha) * target`: what is in front, premultiplied, over what is behind.
    Over,
    /// `(1 - target alpha) * source + target`: what is behind, premultiplied, under what is in front.
    Under,
    /// `(1 - source) * target`, each channel by itself: what a coverage leaves of a transmittance.
    Attenuate,
}

/// The depth or stencil target of a raster pass.
#[derive(Clone, PartialEq, Debug)]
pub struct DepthStencil {
    /// The target.
    pub target: String,
    /// The depth test; needs a depth format.
    pub depth: Option<Depth>,
    /// The stencil test; needs a stencil format.
    pub stencil: Option<Stencil>,
}

/// A depth test.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Depth {
    /// What it holds when the pass starts.
    pub load: Load<f32>,
    /// A fragment passes if `fragment COMPARE target`.
    pub compare: Compare,
    /// Whether passing fragments write their depth.
    pub write: bool,
}

/// A stencil test, the same for both faces.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Stencil {
    /// The value cleared to, or `None` to keep what is there.
    pub clear: Option<u8>,
    /// A fragment passes if `reference COMPARE target`.
    pub compare: Compare,
    /// The reference.
    pub reference: u8,
    /// What happens to the target where the fragment passes.
    pub pass: StencilOp,
    /// What happens to the target where the fragment does not pass.
    pub fail: StencilOp,
}

/// A comparison.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Compare {
    /// Passes always.
    Always,
    /// Passes if equal.
    Equal,
    /// Passes if less.
    Less,
    /// Passes if less or equal.
    LessEqual,
    /// Passes if greater.
    Greater,
    /// Passes if greater or equal.
    GreaterEqual,
}

/// What becomes of a stencil value.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum StencilOp {
    /// It stays.
    Keep,
    /// It becomes zero.
    Zero,
    /// It becomes the reference.
    Replace,
    /// It grows by one, up to 255.
    IncrementClamp,
}

impl Plan {
    /// The buffer of this name.
    #[must_use]
    pub fn buffer(&self, name: &str) -> Option<&Buffer> {
        self.buffers.iter().find(|buffer| buffer.name == name)
    }

    /// The target of this name.
    #[must_use]
    pub fn target(&self, name: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.name == name)
    }

    /// The stages its passes are charged to, each once, in the order they first appear.
    #[must_use]
    pub fn stages(&self) -> Vec<&'static str> {
        let mut stages = Vec::new();
        for pass in &self.passes {
            if !stages.contains(&pass.stage) {
                stages.push(pass.stage);
            }
        }
        stages
    }

    /// Device memory of all buffers and targets, in bytes, as declared; what a device allocates for
    /// them is in [`crate::Device::memory_bytes`].
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum::<u64>()
            + self.targets.iter().map(Target::bytes).sum::<u64>()
    }
}

impl Target {
    /// Bytes of its pixels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.format.bytes() * u64::from(self.width) * u64::from(self.height)
    }
}

impl Buffer {
    /// A buffer whose contents the plan's own passes make.
    #[must_use]
    pub fn new(name: &str, bytes: u64) -> Self {
        Self { name: name.to_owned(), bytes, contents: Contents::Undefined }
    }

    /// A buffer of given bytes that no pass writes.
    #[must_use]
    pub fn data(name: &str, data: Arc<[u8]>) -> Self {
        Self { name: name.to_owned(), bytes: data.len() as u64, contents: Contents::Data(data) }
    }

    /// The bytes a backend allocates: at least 16, and a multiple of 4.
    pub(crate) fn allocated_bytes(&self) -> u64 {
        self.bytes.max(16).next_multiple_of(4)
    }
}

impl Shader {
    /// A shader of this label and source.
    #[must_use]
    pub fn new(label: impl Into<String>, wgsl: impl Into<Arc<str>>) -> Self {
        Self { label: label.into(), wgsl: wgsl.into() }
    }
}

impl Raster {
    /// A draw without attachments, of which it needs at least one; clipped at both planes, and
    /// without late writes.
    #[must_use]
    pub fn new(shader: Shader, draw: Draw) -> Self {
        Self {
            shader,
            pre_raster: PreRaster::Wgsl,
            draw,
            color: Vec::new(),
            depth_stencil: None,
            unclipped: false,
            late_writes: false,
        }
    }
}

impl Pass {
    /// Fills a buffer with zero bytes.
    #[must_use]
    pub fn clear(stage: &'static str, buffer: &str) -> Self {
        Self {
            stage,
            part: None,
            label: format!("clear {buffer}"),
            work: Work::Clear { buffer: buffer.to_owned() },
        }
    }

    /// Runs a compute shader.
    #[must_use]
    pub fn compute(stage: &'static str, shader: Shader, dispatch: Dispatch) -> Self {
        let label = shader.label.clone();
        Self { stage, part: None, label, work: Work::Compute { shader, dispatch } }
    }

    /// Draws.
    #[must_use]
    pub fn raster(stage: &'static str, raster: Raster) -> Self {
        let label = raster.shader.label.clone();
        Self { stage, part: None, label, work: Work::Raster(raster) }
    }

    /// The same pass as a part of its stage.
    #[must_use]
    pub fn part(self, part: u32) -> Self {
        Self { part: Some(part), ..self }
    }
}
