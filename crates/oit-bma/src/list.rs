//! Grouping by pixel lists: a compacting compute pass, and one indirect dispatch an interval.
//!
//! The BMA paper (section 3) names it as the alternative to its stencil. Pixels without fragments
//! are set to nothing here, since no resolve program will visit them.

use oit_gpu::{Buffer, Dispatch, Pass, Shader};

use crate::{GroupRequest, Intervals};

/// Invocations of a workgroup of the compacting pass.
const GROUP_SIZE: u32 = 256;

/// Workgroups in x before a dispatch goes on in y; the resolve programs use the same.
const MAX_WORKGROUPS_X: u32 = 32768;

/// Buffers and passes of the stage `group`, and where each interval's list starts.
#[derive(Clone, Debug)]
pub struct ListGrouping {
    /// `group_pixels`, `group_counts`, `group_args`.
    pub buffers: Vec<Buffer>,
    /// Passes of the stage `group`.
    pub passes: Vec<Pass>,
    /// Where in `group_pixels` each interval's pixels start.
    pub firsts: Vec<u32>,
}

impl ListGrouping {
    /// How the resolve of an interval is dispatched.
    #[must_use]
    pub fn dispatch(&self, interval: usize) -> Dispatch {
        Dispatch::Indirect { buffer: "group_args".into(), offset_bytes: 12 * interval as u64 }
    }
}

/// Groups pixels into one list an interval. Each list has room for every pixel, so that no counting
/// pass is needed first. A workgroup of an interval's resolve takes as many of its pixels as
/// `per_workgroup` says for it.
///
/// # Panics
/// Where `per_workgroup` is not as long as there are intervals.
#[must_use]
pub fn list_grouping(
    request: &GroupRequest,
    intervals: &Intervals,
    per_workgroup: &[u32],
) -> ListGrouping {
    assert_eq!(per_workgroup.len(), intervals.len(), "one number an interval");
    let pixels = request.width_px * request.height_px;
    let n = intervals.len() as u32;
    let inner = intervals.iter().take(intervals.len() - 1);
    let interval = inner.map(|i| format!(" + u32(count > {}u)", i.high)).collect::<String>();
    let compact = format!(
        r"{count_wgsl}
@group(0) @binding(16) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> group_pixels: array<u32>;
@group(0) @binding(18) var<storage, read_write> group_counts: array<atomic<u32>>;

var<workgroup> here: array<atomic<u32>, {n}>;
var<workgroup> base: array<u32, {n}>;

// One global atomic a workgroup and interval: pixels of a workgroup stay neighbours in their list.
@compute @workgroup_size({GROUP_SIZE})
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {{
    if (lane < {n}u) {{
        atomicStore(&here[lane], 0u);
    }}
    workgroupBarrier();
    let pixel = (group.y * groups.x + group.x) * {GROUP_SIZE}u + lane;
    var list = {n}u;
    var slot = 0u;
    if (pixel < {pixels}u) {{
        let count = pixel_count(pixel);
        if (count == 0u) {{
            image[pixel] = vec4<f32>();
        }} else {{
            list = 0u{interval};
            slot = atomicAdd(&here[list], 1u);
        }}
    }}
    workgroupBarrier();
    if (lane < {n}u) {{
        base[lane] = atomicAdd(&group_counts[lane], atomicLoad(&here[lane]));
    }}
    workgroupBarrier();
    if (list < {n}u) {{
        group_pixels[list * {pixels}u + base[list] + slot] = pixel;
    }}
}}
",
        count_wgsl = request.count_wgsl,
    );
    let per_workgroup: Vec<String> = per_workgroup.iter().map(|n| format!("{n}u")).collect();
    let per_workgroup = per_workgroup.join(", ");
    let args = format!(
        r"@group(0) @binding(0) var<storage, read> group_counts: array<u32>;
@group(0) @binding(1) var<storage, read_write> group_args: array<u32>;

@compute @workgroup_size({n})
fn main(@builtin(local_invocation_index) list: u32) {{
    // Pixels that a workgroup of each list's resolve takes.
    var pixels = array<u32, {n}>({per_workgroup});
    let groups = (group_counts[list] + pixels[list] - 1u) / pixels[list];
    let x = clamp(groups, 1u, {MAX_WORKGROUPS_X}u);
    group_args[3u * list] = min(groups, x);
    group_args[3u * list + 1u] = (groups + x - 1u) / x;
    group_args[3u * list + 2u] = 1u;
}}
"
    );
    let groups = pixels.div_ceil(GROUP_SIZE);
    let x = groups.clamp(1, MAX_WORKGROUPS_X);
    let all = Dispatch::Workgroups([x, groups.div_ceil(x), 1]);
    let one = Dispatch::Workgroups([1, 1, 1]);
    ListGrouping {
        buffers: vec![
            Buffer::new("group_pixels", 4 * u64::from(n) * u64::from(pixels)),
            Buffer::new("group_counts", 4 * u64::from(n)),
            Buffer::new("group_args", 12 * u64::from(n)),
        ],
        passes: vec![
            Pass::clear("group", "group_counts"),
            Pass::compute("group", Shader::new("group: compact pixels by interval", compact), all),
            Pass::compute("group", Shader::new("group: dispatch arguments", args), one),
        ],
        firsts: (0..n).map(|list| list * pixels).collect(),
    }
}
