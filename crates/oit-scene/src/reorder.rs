//! The order in which objects are submitted.

use glam::Vec3;

use crate::{Camera, Spheres, SplitMix64};

/// A static order of objects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObjectOrder {
    /// The nearest along this camera's line of sight first.
    FrontToBack(Camera),
    /// The farthest along it first.
    BackToFront(Camera),
    /// At random, from this seed.
    Random(u64),
    /// The farthest from the middle of the box about all positions first: near to front-to-back for any
    /// camera outside (Kugler 2018, section 5.3).
    OutsideIn,
}

impl Spheres {
    /// The objects' numbers in that order. Objects whose positions tie stay in the order they have.
    #[must_use]
    pub fn object_order(&self, order: ObjectOrder) -> Vec<u32> {
        let mut numbers: Vec<u32> = (0..self.objects.len() as u32).collect();
        let position = |number: u32| Vec3::from(self.objects[number as usize].position);
        let mut sort = |key: &dyn Fn(Vec3) -> f32| {
            numbers.sort_by(|a, b| key(position(*a)).total_cmp(&key(position(*b))));
        };
        let along = |camera: Camera| {
            let eye = Vec3::from(camera.eye);
            let forward = (Vec3::from(camera.target) - eye).normalize_or_zero();
            move |position: Vec3| (position - eye).dot(forward)
        };
        match order {
            ObjectOrder::FrontToBack(camera) => sort(&along(camera)),
            ObjectOrder::BackToFront(camera) => {
                let depth = along(camera);
                sort(&|position| -depth(position));
            }
            ObjectOrder::OutsideIn => {
                let positions = || self.objects.iter().map(|object| Vec3::from(object.position));
                let low = positions().reduce(Vec3::min).unwrap_or_default();
                let high = positions().reduce(Vec3::max).unwrap_or_default();
                let middle = (low + high) / 2.0;
                sort(&|position| -position.distance_squared(middle));
            }
            ObjectOrder::Random(seed) => {
                let mut random = SplitMix64::new(seed);
                for last in (1..numbers.len()).rev() {
                    numbers.swap(last, random.below(last + 1));
                }
            }
        }
        numbers
    }

    /// The same spheres, objects in that order.
    #[must_use]
    pub fn reordered(&self, order: ObjectOrder) -> Self {
        let numbers = self.object_order(order);
        let objects = numbers.iter().map(|number| self.objects[*number as usize]).collect();
        Self { objects, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Object, Projection};

    #[test]
    fn orders_are_permutations_by_depth_seed_and_distance() {
        let object = |z: f32| Object {
            position: [0.0, 0.0, z],
            rotation: [0.0, 0.0, 0.0, 1.0],
            kind: 0,
            rgba: [255; 4],
        };
        let objects = [3.0, 0.0, -3.0, 1.0, -2.0, 1.0].map(object).to_vec();
        let spheres = Spheres { objects, ..Spheres::default() };
        let projection = Projection::Perspective { fov_y_degrees: 40.0, near: 1.0, far: 50.0 };
        let eye = [0.0, 0.0, 9.0];
        let camera = Camera { eye, target: [0.0; 3], up: [0.0, 1.0, 0.0], projection };
        let order = |order| spheres.object_order(order);
        assert_eq!(order(ObjectOrder::FrontToBack(camera)), [0, 3, 5, 1, 4, 2]);
        assert_eq!(order(ObjectOrder::BackToFront(camera)), [2, 4, 1, 3, 5, 0]);
        assert_eq!(order(ObjectOrder::OutsideIn), [0, 2, 4, 3, 5, 1]);
        let random = order(ObjectOrder::Random(1));
        assert_eq!(random, order(ObjectOrder::Random(1)));
        assert_ne!(random, order(ObjectOrder::Random(2)));
        let mut sorted = random;
        sorted.sort_unstable();
        assert_eq!(sorted, [0, 1, 2, 3, 4, 5]);

        let reordered = spheres.reordered(ObjectOrder::FrontToBack(camera));
        let depths: Vec<f32> = reordered.objects.iter().map(|o| o.position[2]).collect();
        assert_eq!(depths, [3.0, 1.0, 1.0, 0.0, -2.0, -3.0]);
        assert!(Spheres::default().object_order(ObjectOrder::OutsideIn).is_empty());
    }
}
