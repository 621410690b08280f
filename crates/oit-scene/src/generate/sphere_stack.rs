use super::shapes::part_colour;
use super::{GenerateError, SphereGenerator, spaced};
use crate::detail::Cloud;
use crate::{Object, ObjectOrder, Parameter, Params, Spheres};

/// Spheres behind one another on the z axis about the origin: the stack of Kugler 2018 (chapter 3,
/// Figure 3.1).
pub(super) struct SphereStack;

const ORDERS: &[&str] = &["front_to_back", "back_to_front", "random"];

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("count", "Spheres.", 10_000, 0, 1 << 20),
    Parameter::number("radius", "World units.", 0.5, 1e-3, 1e6),
    Parameter::number("gap", "Distance between centres, world units.", 0.001, 0.0, 1e6),
    Parameter::number("alpha", "Opacity of every sphere.", 1.0, 0.0, 1.0),
    Parameter::word("order", "As seen from +z.", "front_to_back", ORDERS),
    Parameter::word(
        "objects",
        "Whether each sphere is an object, or all are the atoms of one.",
        "each",
        &["each", "one"],
    ),
    Parameter::integer("seed", "Of the random order.", 1, 0, u32::MAX as u64),
];

const UNTURNED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

impl SphereGenerator for SphereStack {
    fn name(&self) -> &'static str {
        "sphere_stack"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Spheres, GenerateError> {
        let count = params.integer("count");
        let radius = params.number("radius");
        let extent = params.number("gap") * count.saturating_sub(1) as f32;
        // One object each, until all are in order.
        let mut stack = Spheres::default();
        let objects = (0..).zip(spaced(count, extent)).map(|(i, z)| Object {
            position: [0.0, 0.0, z],
            rotation: UNTURNED,
            kind: 0,
            rgba: part_colour(i, params.number("alpha")),
        });
        stack.objects = objects.collect();
        match params.word("order") {
            "back_to_front" => stack.objects.reverse(),
            "random" => stack = stack.reordered(ObjectOrder::Random(params.integer("seed"))),
            _ => {}
        }
        if stack.objects.is_empty() {
            return Ok(stack);
        }
        let mut cloud = Cloud::default();
        if params.word("objects") == "one" {
            for sphere in std::mem::take(&mut stack.objects) {
                cloud.push(sphere.position, radius, sphere.rgba);
            }
            let all = Object { position: [0.0; 3], rotation: UNTURNED, kind: 0, rgba: [255; 4] };
            stack.objects.push(all);
        } else {
            cloud.push([0.0; 3], radius, [255; 4]);
        }
        // One level: all spheres of a stack are drawn.
        stack.push_kind("sphere".into(), cloud, 1, 1.0);
        Ok(stack)
    }
}
