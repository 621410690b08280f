//! The bandwidth probe: what a device's memory moves, as this project's own passes see it. Two buffers
//! larger than any cache are filled and copied by compute shaders, and colour attachments as large are
//! written by a raster pass. What was written is checked, and is no pattern that a device could
//! compress.

use std::time::Instant;

use oit_gpu::{
    Buffer, ColorAttachment, Device, Dispatch, Draw, Format, GpuError, Load, Pass, Plan, PlanId,
    Raster, Shader, Target,
};
use oit_record::{AttachmentBandwidth, Bandwidth, Event, RunWriter};

use crate::runner::{RunError, Setup, run_of};

/// Bytes of each buffer, and of all attachments together: the first that the device allows. An NVIDIA
/// H200 has 50 MiB of L2 cache.
pub const BANDWIDTH_BYTES: [u64; 4] = [256 << 20, 128 << 20, 64 << 20, 32 << 20];

/// Attachments of 16 bytes a pixel: the first number that the device allows.
const ATTACHMENTS: [u32; 3] = [4, 2, 1];
const ATTACHMENT_BYTES: u64 = 16;

/// Invocations of a workgroup.
const INVOCATIONS: u32 = 256;
/// Vectors of 16 bytes that an invocation writes, a workgroup's width apart.
const VECTORS: u32 = 4;

/// The best of so many repeats counts; of fewer on a device that is slow.
const MOST_REPEATS: u32 = 20;
const LEAST_REPEATS: u32 = 3;
/// What is a slow device: after so many seconds it is not repeated any more.
const PATIENCE_S: f64 = 1.0;

/// What every vector holds: words without a pattern.
const CONTENTS: &str = r"
fn contents(i: u32) -> vec4<u32> {
    let h = (vec4<u32>(4u * i) + vec4<u32>(0u, 1u, 2u, 3u)) * 2654435761u;
    return (h ^ (h >> vec4<u32>(15u))) * 2246822519u;
}
";

/// The same on a processor.
fn contents(i: u32) -> [u32; 4] {
    [0, 1, 2, 3].map(|k| {
        let h = i.wrapping_mul(4).wrapping_add(k).wrapping_mul(2_654_435_761);
        (h ^ (h >> 15)).wrapping_mul(2_246_822_519)
    })
}

/// Measures what a device's memory moves, with buffers of the first of some sizes that the device
/// allows; they are multiples of 16, and [`BANDWIDTH_BYTES`] for what is recorded. Plans that were
/// prepared before are forgotten.
///
/// # Errors
/// Where the device has no timestamps, lacks memory for the smallest buffers, fails, or does not write
/// what it was told to.
pub fn measure_bandwidth(
    device: &mut dyn Device,
    sizes_bytes: &[u64],
) -> Result<Bandwidth, GpuError> {
    device.reset();
    let measured = measure_all(device, sizes_bytes);
    device.reset();
    measured
}

fn measure_all(device: &mut dyn Device, sizes_bytes: &[u64]) -> Result<Bandwidth, GpuError> {
    let plans = sizes_bytes.iter().map(|&bytes| (bytes, copy_plan(bytes)));
    let (buffer_bytes, copy) = first_that_fits(device, plans)?;
    device.poison(copy)?;
    device.run(copy)?;
    let differing: Vec<u32> = bytemuck::pod_collect_to_vec(&device.read(copy, "differing")?);
    if differing != [0; 4] {
        let what =
            format!("{} of {buffer_bytes} bytes copied differ", 16 * u64::from(differing[0]));
        return Err(GpuError::Device(what));
    }
    let ([fill_ns, copy_ns], repeats) = best(device, copy, ["fill", "copy"])?;
    Ok(Bandwidth {
        buffer_bytes,
        copy_bytes_per_s: per_second(2 * buffer_bytes, copy_ns),
        fill_bytes_per_s: per_second(buffer_bytes, fill_ns),
        attachment: measure_attachments(device, buffer_bytes)?,
        repeats,
    })
}

/// The same of colour attachments; `None` where the device draws to none that large.
fn measure_attachments(
    device: &mut dyn Device,
    bytes: u64,
) -> Result<Option<AttachmentBandwidth>, GpuError> {
    device.reset();
    let plans = ATTACHMENTS.iter().map(|&count| {
        let side_px = (bytes / (u64::from(count) * ATTACHMENT_BYTES)).isqrt() as u32;
        ((count, side_px), attachment_plan(count, side_px))
    });
    let ((count, side_px), plan) = match first_that_fits(device, plans) {
        Ok(fits) => fits,
        Err(GpuError::Unsupported(_) | GpuError::OutOfMemory(_)) => return Ok(None),
        Err(error) => return Err(error),
    };
    device.run(plan)?;
    let last = device.read(plan, &attachment(count - 1))?;
    let told: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&last);
    let differ = (0..).zip(&told).any(|(pixel, &found)| found != colour(pixel, count - 1));
    if differ || told.len() as u64 != u64::from(side_px).pow(2) {
        return Err(GpuError::Device("an attachment holds other colours than were drawn".into()));
    }
    let ([ns], _) = best(device, plan, ["draw"])?;
    let (pixels, bytes_per_px) = (u64::from(side_px).pow(2), u64::from(count) * ATTACHMENT_BYTES);
    let bytes_per_s = per_second(pixels * bytes_per_px, ns);
    Ok(Some(AttachmentBandwidth { bytes_per_px, pixels, bytes_per_s }))
}

/// Prepares the first of some plans that the device has the memory and the limits for.
fn first_that_fits<T>(
    device: &mut dyn Device,
    plans: impl Iterator<Item = (T, Plan)>,
) -> Result<(T, PlanId), GpuError> {
    let mut last = GpuError::Unsupported("nothing to measure".into());
    for (what, plan) in plans {
        match device.prepare(&plan) {
            Ok(id) => return Ok((what, id)),
            Err(error @ (GpuError::Unsupported(_) | GpuError::OutOfMemory(_))) => {
                device.reset();
                last = error;
            }
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

/// The least nanoseconds of some stages of a plan, each the least of all repeats, and how many these
/// were.
fn best<const N: usize>(
    device: &mut dyn Device,
    plan: PlanId,
    stages: [&str; N],
) -> Result<([u64; N], u32), GpuError> {
    let started = Instant::now();
    let (mut least, mut repeats) = ([u64::MAX; N], 0);
    while repeats < LEAST_REPEATS
        || (repeats < MOST_REPEATS && started.elapsed().as_secs_f64() < PATIENCE_S)
    {
        let timing = device.run(plan)?;
        for (least, stage) in least.iter_mut().zip(stages) {
            let found = timing.stages.iter().find(|(name, ns)| *name == stage && *ns > 0);
            let Some((_, ns)) = found else {
                let name = &device.info().name;
                return Err(GpuError::Unsupported(format!("{name} does not time {stage}")));
            };
            *least = (*least).min(*ns);
        }
        repeats += 1;
    }
    Ok((least, repeats))
}

fn per_second(bytes: u64, ns: u64) -> f64 {
    bytes as f64 / (ns as f64 / 1e9)
}

/// Fills one buffer, copies it to another and checks that.
fn copy_plan(bytes: u64) -> Plan {
    let vectors = (bytes / 16) as u32;
    let groups = Dispatch::Workgroups([vectors.div_ceil(INVOCATIONS * VECTORS), 1, 1]);
    let shader = |label: &str, buffers: &str, what: &str| {
        let wgsl = format!(
            "{CONTENTS}{buffers}
@compute @workgroup_size({INVOCATIONS})
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
    for (var k = 0u; k < {VECTORS}u; k++) {{
        let i = (group.x * {VECTORS}u + k) * {INVOCATIONS}u + lane;
        if i < {vectors}u {{
            {what}
        }}
    }}
}}
"
        );
        Shader::new(label, wgsl)
    };
    let fill = shader(
        "fill",
        "@group(0) @binding(0) var<storage, read_write> origin: array<vec4<u32>>;",
        "origin[i] = contents(i);",
    );
    let copy = shader(
        "copy",
        "@group(0) @binding(0) var<storage, read> origin: array<vec4<u32>>;\n\
         @group(0) @binding(1) var<storage, read_write> copied: array<vec4<u32>>;",
        "copied[i] = origin[i];",
    );
    let check = shader(
        "check",
        "@group(0) @binding(0) var<storage, read> copied: array<vec4<u32>>;\n\
         @group(0) @binding(1) var<storage, read_write> differing: array<atomic<u32>>;",
        "if any(copied[i] != contents(i)) { atomicAdd(&differing[0], 1u); }",
    );
    Plan {
        name: format!("bandwidth of {bytes} bytes"),
        buffers: vec![
            Buffer::new("origin", bytes),
            Buffer::new("copied", bytes),
            Buffer::new("differing", 16),
        ],
        targets: Vec::new(),
        passes: vec![
            Pass::clear("clear", "differing"),
            Pass::compute("fill", fill, groups.clone()),
            Pass::compute("copy", copy, groups.clone()),
            Pass::compute("check", check, groups),
        ],
    }
}

fn attachment(place: u32) -> String {
    format!("colour{place}")
}

/// What a pixel of an attachment holds: floats that are whole numbers, which they hold exactly.
fn colour(pixel: u32, place: u32) -> [f32; 4] {
    contents(pixel.wrapping_add(place)).map(|word| (word & 0x00ff_ffff) as f32)
}

/// Writes every pixel of some attachments once, without clearing or blending.
fn attachment_plan(count: u32, side_px: u32) -> Plan {
    let places = 0..count;
    let fields: String = places
        .clone()
        .map(|place| format!("    @location({place}) c{place}: vec4<f32>,\n"))
        .collect();
    let values: Vec<String> =
        places.clone().map(|place| format!("colour(pixel, {place}u)")).collect();
    let values = values.join(", ");
    let wgsl = format!(
        "{CONTENTS}
struct Colours {{
{fields}}}

fn colour(pixel: u32, place: u32) -> vec4<f32> {{
    return vec4<f32>(contents(pixel + place) & vec4<u32>(0x00ffffffu));
}}

@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {{
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}}

@fragment
fn fs(@builtin(position) position: vec4<f32>) -> Colours {{
    let pixel = u32(position.y) * {side_px}u + u32(position.x);
    return Colours({values});
}}
"
    );
    let target = |place| Target {
        name: attachment(place),
        format: Format::Rgba32Float,
        width: side_px,
        height: side_px,
    };
    let color = |place| ColorAttachment {
        target: attachment(place),
        load: Load::Keep,
        blend: None,
        write: true,
    };
    let shader = Shader::new("draw", wgsl);
    let draw = Draw::Vertices { count: 3, instances: 1 };
    let raster = Raster { color: places.clone().map(color).collect(), ..Raster::new(shader, draw) };
    Plan {
        name: format!("bandwidth of {count} attachments"),
        buffers: Vec::new(),
        targets: places.map(target).collect(),
        passes: vec![Pass::raster("draw", raster)],
    }
}

/// Measures what a device's memory moves. The run folder of `setup` is written if `keep`: it has no
/// cells. Scenes and worker of `setup` are not used.
///
/// # Errors
/// Where the device does not start or cannot do it, or the record cannot be written.
pub fn probe_bandwidth(setup: &Setup, keep: bool) -> Result<Bandwidth, RunError> {
    let started = Instant::now();
    let failed = |what: String| RunError::Device { device: setup.device.clone(), what };
    if setup.device == "cpu" {
        return Err(failed("the bandwidth probe is of a GPU's memory, and this is none".into()));
    }
    let mut device =
        oit_gpu::open(&setup.device, &setup.cache).map_err(|error| failed(error.to_string()))?;
    let measured = measure_bandwidth(&mut *device, &BANDWIDTH_BYTES)
        .map_err(|error| failed(error.to_string()))?;
    if keep {
        let run = run_of(setup, device.info(), "bandwidth-probe", "", 0, Vec::new());
        let mut writer = RunWriter::create(&setup.out, &run)?;
        writer.append(&Event::Bandwidth { measured })?;
        writer.append(&Event::Finished { wall_s: started.elapsed().as_secs_f64() })?;
    }
    Ok(measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plans_are_sound_and_every_byte_has_its_invocation() {
        for bytes in BANDWIDTH_BYTES {
            let plan = copy_plan(bytes);
            plan.check().unwrap();
            let oit_gpu::Work::Compute { dispatch: Dispatch::Workgroups(groups), .. } =
                &plan.passes[1].work
            else {
                panic!("no direct dispatch");
            };
            let written = u64::from(groups[0] * INVOCATIONS * VECTORS) * 16;
            assert!(written >= bytes && groups[0] <= 65_535, "{bytes}: {groups:?}");
        }
        for count in ATTACHMENTS {
            attachment_plan(count, 64).check().unwrap();
        }
    }

    #[test]
    fn nanoseconds_come_to_bytes_a_second() {
        assert_eq!(per_second(1 << 30, 500_000_000), 2.0 * f64::from(1 << 30));
    }
}
