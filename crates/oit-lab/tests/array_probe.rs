//! The array probe on every GPU there is: its picture is what a processor computes.

mod support;

use oit_bma::{ArrayProbe, ProbeAccess, ProbePlace};

#[test]
fn every_place_and_size_gives_what_a_processor_computes() {
    for id in support::gpus() {
        let cache = support::cache();
        let mut device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        for place in ProbePlace::ALL {
            for size in [1, 2, 3, 17, 32] {
                let probe = ArrayProbe { access: ProbeAccess::Touched, place, size };
                // No multiple of a workgroup, and more repeats than one.
                let plan = probe.plan(61, 37, 3);
                let run = device.prepare(&plan).expect("it is prepared");
                device.poison(run).expect("it is poisoned");
                device.run(run).expect("it runs");
                let bytes = device.read(run, "image").expect("it is read");
                let picture: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
                let expected: Vec<[f32; 4]> =
                    (0..61 * 37).filter_map(|pixel| probe.expected(pixel)).collect();
                assert!(picture == expected, "{id} {probe}");
            }
        }
    }
}
