use super::shapes::{part_colour, push_rectangle};
use super::{GenerateError, Generator, check_triangles, spaced};
use crate::{Mesh, Parameter, Params};

/// Layers of tessellated rectangles about the origin, facing +z, for an orthographic view of height
/// 2 and aspect 16:9 (LFB chapter, Figures 20.10 to 20.12).
pub(super) struct Grid;

/// Width by height of the view that `size` is a fraction of.
const ASPECT: f32 = 16.0 / 9.0;

const ORDERS: &[&str] = &["front_to_back", "back_to_front", "alternating"];

const PARAMETERS: &[Parameter] = &[
    Parameter::number("size", "Side of a layer as a fraction of the view's.", 1.0, 0.0, 16.0),
    Parameter::integer("layers", "Layers behind one another.", 10, 0, 4096),
    Parameter::integer(
        "tessellation",
        "Triangles per layer, rounded down to a lattice of cells.",
        20_000,
        2,
        1 << 24,
    ),
    Parameter::number("gap", "Distance between layers, world units.", 0.01, 0.0, 100.0),
    Parameter::number("alpha", "Opacity of every layer.", 0.1, 0.0, 1.0),
    Parameter::word(
        "order",
        "As seen from +z; alternating goes outward from the middle, near and far in turn.",
        "alternating",
        ORDERS,
    ),
];

impl Generator for Grid {
    fn name(&self) -> &'static str {
        "grid"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError> {
        let layers = params.integer("layers");
        let tessellation = params.integer("tessellation");
        check_triangles(&[layers, tessellation])?;

        let rows = (tessellation / 2).isqrt();
        let columns = tessellation / 2 / rows;
        let height = 2.0 * params.number("size");
        let mut depths: Vec<f32> =
            spaced(layers, params.number("gap") * layers.saturating_sub(1) as f32).collect();
        match params.word("order") {
            "back_to_front" => depths.reverse(),
            "alternating" => depths = outward(&depths),
            _ => {}
        }

        let mut mesh = Mesh::default();
        for (i, z) in (0..).zip(depths) {
            let rgba = part_colour(i, params.number("alpha"));
            let size = [height * ASPECT, height];
            push_rectangle(&mut mesh, [0.0, 0.0, z], size, [columns, rows], rgba);
        }
        Ok(mesh)
    }
}

/// The middle one first, then its neighbours on either side in turn.
fn outward(sorted: &[f32]) -> Vec<f32> {
    let (before, after) = sorted.split_at(sorted.len() / 2);
    let mut nearer = before.iter().rev();
    after
        .iter()
        .flat_map(|farther| std::iter::once(farther).chain(nearer.next()))
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::outward;

    #[test]
    fn outward_keeps_every_layer() {
        assert_eq!(outward(&[5.0, 4.0, 3.0, 2.0, 1.0]), [3.0, 4.0, 2.0, 5.0, 1.0]);
        assert_eq!(outward(&[4.0, 3.0, 2.0, 1.0]), [2.0, 3.0, 1.0, 4.0]);
        assert!(outward(&[]).is_empty());
    }
}
