//! In which order objects are submitted.

use glam::Vec3;
use oit_gpu::{Buffer, Pass};
use oit_scene::{Camera, Spheres, SplitMix64};
use rayon::prelude::*;

use crate::Order;
use crate::context::Context;
use crate::text::{invocations, word, workgroups};
use crate::view::is_perspective;

/// Of [`Order::Random`].
const SEED: u64 = 1;

/// What a workgroup sorts.
const BLOCK: u32 = 2048;

impl Order {
    /// The objects in an order that is known before a frame; `None` where there is none to know.
    pub(crate) fn known(self, spheres: &Spheres, camera: &Camera) -> Option<Vec<u32>> {
        let position = |object: u32| Vec3::from(spheres.objects[object as usize].position);
        let eye = Vec3::from(camera.eye);
        let along = (Vec3::from(camera.target) - eye).normalize_or_zero();
        let distance = |object: u32| match is_perspective(camera) {
            true => position(object).distance(eye),
            false => along.dot(position(object) - eye),
        };
        let mut order: Vec<u32> = (0..spheres.objects.len() as u32).collect();
        // Stable: what is equally far stays as it is in the scene.
        let mut sort = |key: &(dyn Fn(u32) -> f32 + Sync)| {
            order.par_sort_by(|&a, &b| key(a).total_cmp(&key(b)));
        };
        match self {
            Self::AsIs | Self::Sorted => return None,
            Self::FrontToBack => sort(&distance),
            Self::BackToFront => sort(&|object| -distance(object)),
            Self::OutsideIn => {
                let sum = |sum: glam::DVec3, object: &oit_scene::Object| {
                    sum + Vec3::from(object.position).as_dvec3()
                };
                let count = spheres.objects.len().max(1) as f64;
                let middle = spheres.objects.iter().fold(glam::DVec3::ZERO, sum) / count;
                let middle = middle.as_vec3();
                sort(&|object| -position(object).distance_squared(middle));
            }
            Self::Random => {
                let mut random = SplitMix64::new(SEED);
                for i in (1..order.len()).rev() {
                    order.swap(i, random.below(i + 1));
                }
            }
        }
        Some(order)
    }
}

/// Elements of a bitonic sort of so many.
fn padded(objects: u32) -> u32 {
    objects.next_power_of_two().max(BLOCK)
}

/// The buffer of a sort on the device.
pub(crate) fn sort_buffer(context: &Context) -> Buffer {
    Buffer::new("sorted", 8 * u64::from(padded(context.objects())))
}

/// The passes that sort objects by their distance, nearest first.
pub(crate) fn sort_passes(context: &mut Context) -> Vec<Pass> {
    let length = padded(context.objects());
    let slot = include_str!("wgsl/slot.wgsl");
    let view = include_str!("wgsl/view.wgsl");
    let constants = [word("LENGTH", length), context.perspective_wgsl()];
    let keys = [view, slot, include_str!("wgsl/sort_keys.wgsl")];
    let mut passes =
        vec![context.listing("sort: keys", &constants, &keys, invocations(u64::from(length)))];
    let blocks = workgroups(u64::from(length / BLOCK));
    let local = |context: &mut Context, first: u32, last: u32| {
        let constants = [word("LENGTH", length), word("FIRST", first), word("LAST", last)];
        let text = include_str!("wgsl/sort_local.wgsl");
        context.listing("sort: blocks", &constants, &[text], blocks.clone())
    };
    passes.push(local(context, 2, BLOCK));
    // Rounds and steps are powers of two: those that fit into a block are done there.
    for round in (BLOCK.ilog2() + 1..=length.ilog2()).map(|log| 1u32 << log) {
        for step in (BLOCK.ilog2()..round.ilog2()).rev().map(|log| 1u32 << log) {
            let constants = [word("LENGTH", length), word("STEP", step), word("ROUND", round)];
            let texts = [slot, include_str!("wgsl/sort_step.wgsl")];
            let dispatch = invocations(u64::from(length / 2));
            passes.push(context.listing("sort: step", &constants, &texts, dispatch));
        }
        passes.push(local(context, round, round));
    }
    passes
}
