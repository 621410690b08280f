//! The probe of Figure 3: a full-screen pass that declares an array and does next to nothing with it,
//! so that what is timed is the array.
//!
//! The paper reads one entry of an array that it never wrote. A compiler may know that such an entry
//! holds anything and drop the array, so there is a second form, which writes a few entries at places
//! that are known at run time only: the same few whatever the size.

use std::fmt;
use std::sync::Arc;

use oit_gpu::{
    Buffer, ColorAttachment, Dispatch, Draw, Format, Load, Pass, Plan, Raster, Shader, Target,
};

/// One size of one array in one place.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct ArrayProbe {
    /// What is done with it.
    pub access: ProbeAccess,
    /// Where it is.
    pub place: ProbePlace,
    /// Its entries: four 32-bit floats each, as the paper's `vec4`. At least 1, and no more than
    /// [`ProbePlace::most_entries`].
    pub size: u32,
}

/// What a probe does with its array.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum ProbeAccess {
    /// Writes four entries (the first, the last, and two between) and reads one of them.
    Touched,
    /// Reads one entry and writes none, as the paper's shader. In the vulkan backend the entry may
    /// hold anything, and the array may not be there at all; in the wgpu backend the array of a
    /// function is filled with zeros first.
    Unset,
}

/// The store of a probe's array, and the stage of the program.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum ProbePlace {
    /// An array of the function, in a fragment shader.
    LocalFragment,
    /// An array of the function, in a compute shader.
    LocalCompute,
    /// An array in workgroup memory, which a fragment shader has none of.
    WorkgroupCompute,
}

/// Invocations of a workgroup, the same for every size and store, so that nothing but the array
/// changes along a line.
const INVOCATIONS: u32 = 64;

/// Workgroup memory that a program may take, in bytes: what desktop GPUs have at least.
const WORKGROUP_BYTES: u32 = 32 * 1024;

/// Bytes of an entry.
const ENTRY_BYTES: u32 = 16;

/// Where the picture is left: a target in the fragment stage, a buffer in compute.
const IMAGE: &str = "image";

impl ProbeAccess {
    /// Both, in the order they are listed.
    pub const ALL: [Self; 2] = [Self::Touched, Self::Unset];

    fn name(self) -> &'static str {
        match self {
            Self::Touched => "array-probe",
            Self::Unset => "array-probe-unset",
        }
    }
}

impl ProbePlace {
    /// Every place, in the order they are listed.
    pub const ALL: [Self; 3] = [Self::LocalFragment, Self::LocalCompute, Self::WorkgroupCompute];

    fn name(self) -> &'static str {
        match self {
            Self::LocalFragment => "local/fragment",
            Self::LocalCompute => "local/compute",
            Self::WorkgroupCompute => "workgroup/compute",
        }
    }

    /// The most entries that a probe of this place has: the last of the figure, or what workgroup
    /// memory has room for.
    #[must_use]
    pub fn most_entries(self) -> u32 {
        match self {
            Self::LocalFragment | Self::LocalCompute => 256,
            Self::WorkgroupCompute => WORKGROUP_BYTES / ENTRY_BYTES / INVOCATIONS,
        }
    }
}

/// Its name in records, `array-probe/STORE/STAGE/sizeN`, with `array-probe-unset` for the paper's
/// form.
impl fmt::Display for ArrayProbe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/size{}", self.access.name(), self.place.name(), self.size)
    }
}

impl ArrayProbe {
    /// The places that are written, in this order.
    fn written(&self) -> [u32; 4] {
        let last = self.size - 1;
        [0, last / 3, last - last / 3, last]
    }

    /// The place that is read: one of those written, which are all the same where the size is 1. The
    /// paper's form reads the first.
    fn read(&self) -> u32 {
        match self.access {
            ProbeAccess::Touched => self.written()[2],
            ProbeAccess::Unset => 0,
        }
    }

    /// What a pixel of the picture must hold, as a processor computes it; `None` where the array is
    /// not written, and its entries may hold anything.
    #[must_use]
    pub fn expected(&self, pixel: u32) -> Option<[f32; 4]> {
        let read = self.read();
        let last = self.written().iter().rposition(|&place| place == read)? as u32;
        (self.access == ProbeAccess::Touched).then(|| {
            // Whole numbers below 2^24, which single precision holds exactly.
            [pixel, pixel + last, pixel + 2 * last, pixel + 3 * last].map(|value| value as f32)
        })
    }

    /// A plan that runs the probe `repeats` times on every pixel of a frame, in one pass of the
    /// stage `probe`. The picture is left in the target or buffer `image`.
    ///
    /// # Panics
    /// Where the size is not one of those allowed, or the frame has more than 2^22 pixels.
    #[must_use]
    pub fn plan(&self, width_px: u32, height_px: u32, repeats: u32) -> Plan {
        let most = self.place.most_entries();
        assert!((1..=most).contains(&self.size), "{} is not 1 to {most}", self.size);
        let pixels = u64::from(width_px) * u64::from(height_px);
        assert!(pixels <= 1 << 22, "{width_px}x{height_px}: the probe counts pixels in floats");
        let mut plan = Plan { name: self.to_string(), ..Plan::default() };
        let mut words = self.written().to_vec();
        words.extend([self.read(), 0, 0, 0]);
        let bytes: Arc<[u8]> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        plan.buffers.push(Buffer::data("probe", bytes));
        let shader = Shader::new(self.to_string(), self.wgsl(width_px, pixels));
        plan.passes.push(match self.place {
            ProbePlace::LocalFragment => {
                plan.targets.push(Target {
                    name: IMAGE.into(),
                    format: Format::Rgba32Float,
                    width: width_px,
                    height: height_px,
                });
                let target = IMAGE.to_owned();
                let load = Load::Clear([0.0; 4]);
                let color = vec![ColorAttachment { target, load, blend: None, write: true }];
                let draw = Draw::Vertices { count: 3, instances: repeats };
                Pass::raster("probe", Raster { color, ..Raster::new(shader, draw) })
            }
            ProbePlace::LocalCompute | ProbePlace::WorkgroupCompute => {
                plan.buffers.push(Buffer::new(IMAGE, 16 * pixels));
                // Below every device's limit of 65,535: see the greatest frame above.
                let groups = pixels.div_ceil(u64::from(INVOCATIONS)) as u32;
                let x = groups.min(1 << 15);
                let dispatch = Dispatch::Workgroups([x, groups.div_ceil(x), repeats]);
                Pass::compute("probe", shader, dispatch)
            }
        });
        plan
    }

    fn wgsl(&self, width_px: u32, pixels: u64) -> String {
        let size = self.size;
        let (global, local, lane) = match self.place {
            ProbePlace::WorkgroupCompute => {
                let all = size * INVOCATIONS;
                let array = format!("var<workgroup> entries: array<vec4<f32>, {all}>;\n");
                // Entries of neighbouring invocations lie beside one another.
                (array, String::new(), format!(" * {INVOCATIONS}u + lane"))
            }
            ProbePlace::LocalFragment | ProbePlace::LocalCompute => {
                let array = format!("    var entries: array<vec4<f32>, {size}>;\n");
                (String::new(), array, String::new())
            }
        };
        let writes = match self.access {
            ProbeAccess::Unset => String::new(),
            ProbeAccess::Touched => (0..4)
                .map(|k| format!("    entries[probe.written[{k}]{lane}] = value(pixel, {k}u);\n"))
                .collect(),
        };
        let program = format!(
            r"struct Probe {{
    written: vec4<u32>,
    read: u32,
}}
@group(0) @binding(0) var<uniform> probe: Probe;
{global}
fn value(pixel: u32, k: u32) -> vec4<f32> {{
    return vec4<f32>(vec4<u32>(pixel, pixel + k, pixel + 2u * k, pixel + 3u * k));
}}

fn probed(pixel: u32, lane: u32) -> vec4<f32> {{
{local}{writes}    return entries[probe.read{lane}];
}}
"
        );
        let entry = match self.place {
            ProbePlace::LocalFragment => format!(
                r"
@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}}

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {{
    return probed(u32(position.y) * {width_px}u + u32(position.x), 0u);
}}
"
            ),
            ProbePlace::LocalCompute | ProbePlace::WorkgroupCompute => format!(
                r"
@group(0) @binding(1) var<storage, read_write> image: array<vec4<f32>>;

// What the repeats store is the same, so that it does not matter which of them is the last.
@compute
@workgroup_size({INVOCATIONS})
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {{
    let pixel = (group.y * groups.x + group.x) * {INVOCATIONS}u + lane;
    if (pixel < {pixels}u) {{
        image[pixel] = probed(pixel, lane);
    }}
}}
"
            ),
        };
        program + &entry
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(size: u32) -> impl Iterator<Item = ArrayProbe> {
        ProbeAccess::ALL.into_iter().flat_map(move |access| {
            let probe = move |place: ProbePlace| ArrayProbe {
                access,
                place,
                size: size.min(place.most_entries()),
            };
            ProbePlace::ALL.into_iter().map(probe)
        })
    }

    #[test]
    fn every_plan_is_sound() {
        for size in [1, 2, 3, 32, 256] {
            for probe in all(size) {
                probe.plan(61, 37, 64).check().unwrap_or_else(|error| panic!("{probe}: {error}"));
            }
        }
    }

    #[test]
    fn what_is_read_was_written_and_nothing_else_is_touched() {
        for size in 1..=256 {
            for probe in all(size) {
                let mut entries = vec![None; probe.size as usize];
                for (k, place) in probe.written().into_iter().enumerate() {
                    entries[place as usize] = Some([7, 7 + k, 7 + 2 * k, 7 + 3 * k]);
                }
                let read = entries[probe.read() as usize].map(|v| v.map(|v| v as f32));
                let written = probe.access == ProbeAccess::Touched;
                assert_eq!(probe.expected(7), read.filter(|_| written), "{probe}");
            }
        }
    }

    #[test]
    fn names_say_access_store_stage_and_size() {
        let names: Vec<String> = all(64).map(|probe| probe.to_string()).collect();
        assert_eq!(names[0], "array-probe/local/fragment/size64");
        assert_eq!(names[5], "array-probe-unset/workgroup/compute/size32");
    }
}
