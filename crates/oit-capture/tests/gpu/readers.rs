//! Every layout's reader on every device: it meets what unpacking gives, in the same order.

use oit_gpu::{Buffer, Dispatch, Pass, Shader};

use super::*;

/// What the reader of a capture's layout meets: fragments as words, and how many on each pixel.
struct Met {
    words: Vec<u32>,
    counts: Vec<u32>,
}

/// Runs a capture and reads it on the device, in turn or by index; also what it unpacks to.
fn read(
    device: &mut dyn Device,
    capture: &dyn Capture,
    view: &View,
    pool_slots: u64,
    by_index: bool,
) -> (Met, Lfb) {
    let request = &CaptureRequest {
        pool_slots: pool_slots.max(1),
        ..request(view.geometry, view.size, &view.histogram)
    };
    let mut plan = capture_plan(capture, request);
    let pixels = view.counts.len();
    let body = if by_index {
        "let held = min(lfb_len(), room);
         for (var i = 0u; i < held; i++) { met[first + i] = lfb_at(i); }
         met_counts[pixel] = lfb_len();"
    } else {
        "var held = 0u;
         while (lfb_more() && held < room) { met[first + held] = lfb_next(); held += 1u; }
         met_counts[pixel] = held + u32(lfb_more());"
    };
    let wgsl = format!(
        "{}
        @group(0) @binding(16) var<storage, read> firsts: array<u32>;
        @group(0) @binding(17) var<storage, read_write> met: array<vec2<u32>>;
        @group(0) @binding(18) var<storage, read_write> met_counts: array<u32>;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let pixel = id.x;
            if (pixel >= {pixels}u) {{ return; }}
            let first = firsts[pixel];
            let room = firsts[pixel + 1u] - first;
            lfb_begin(pixel);
            {body}
        }}",
        capture.layout_wgsl()
    );
    let firsts = view.firsts();
    plan.buffers.extend([
        Buffer::data("firsts", bytemuck::cast_slice(&firsts).into()),
        Buffer::new("met", 8 * view.total().max(2)),
        Buffer::new("met_counts", 4 * pixels as u64),
    ]);
    let dispatch = Dispatch::Workgroups([(pixels as u32).div_ceil(64), 1, 1]);
    plan.passes.push(Pass::compute("resolve", Shader::new("read", wgsl), dispatch));

    let id = device.prepare(&plan).expect("the plan is sound");
    device.poison(id).expect("fills");
    device.run(id).expect("runs");
    let mut bytes = |name: &str| device.read(id, name);
    let met = Met {
        words: words(&bytes("met").expect("reads")),
        counts: words(&bytes("met_counts").expect("reads")),
    };
    let mut reader = LfbReader {
        width_px: request.width_px,
        height_px: request.height_px,
        pool_slots: request.pool_slots,
        read: &mut bytes,
    };
    (met, capture.unpack(&mut reader).expect("undamaged"))
}

impl View<'_> {
    /// Where each pixel's fragments start, and the end of the last.
    fn firsts(&self) -> Vec<u32> {
        let mut first = 0;
        let starts = self.counts.iter().map(|count| {
            first += count;
            first
        });
        [0].into_iter().chain(starts).collect()
    }
}

#[test]
fn readers_meet_what_is_unpacked() {
    on_every_device("readers", |device| {
        // A single pixel has buffers that are larger than they need be.
        for size in [(50, 30), (1, 1), (3, 1)] {
            let mesh = random_mesh(7, 100);
            let geometry = Geometry::new(&mesh, &shading(), &perspective_camera(), size.0, size.1);
            let view = View::new(device, &geometry, size);
            assert!(view.total() > 0, "{size:?}");
            for capture in supported(device) {
                let slots = view.slots(capture);
                let readings =
                    [false, true].into_iter().take(1 + usize::from(capture.random_access()));
                for (by_index, pool) in
                    readings.flat_map(|by| [slots, slots / 3, 1].map(|pool| (by, pool)))
                {
                    let what = format!("{}, {size:?}, {pool} slots", capture.name());
                    let (met, lfb) = read(device, capture, &view, pool, by_index);
                    assert!(lfb.counts().eq(met.counts), "{what}");
                    for (pixel, &first) in view.firsts()[..lfb.pixels()].iter().enumerate() {
                        let own = lfb.pixel(pixel);
                        let words = &met.words[2 * first as usize..][..2 * own.len()];
                        assert_eq!(words, bytemuck::cast_slice::<_, u32>(own), "{what}, {pixel}");
                    }
                }
            }
        }
    });
}
