//! Generators: one file each, listed in [`GENERATORS`] or [`SPHERE_GENERATORS`].

mod atrium;
mod cyclic;
mod grid;
mod hairball;
mod intersecting;
mod planes;
mod powerplant;
mod random_triangles;
mod shapes;
mod shells;
mod smoke;
mod solids;
mod sphere_stack;
mod stack;
mod virus;

use crate::{MAX_OBJECTS, MAX_TRIANGLES, Mesh, Parameter, Params, Spheres};

/// Makes a mesh. A pure function of its parameters, a seed among them where it draws at random.
pub trait Generator: Sync {
    /// The word in scene files.
    fn name(&self) -> &'static str;
    /// Every parameter with its default and range.
    fn parameters(&self) -> &'static [Parameter];
    /// Makes the mesh. `params` were made from [`Generator::parameters`].
    ///
    /// # Errors
    /// [`GenerateError`] when the parameters ask for too large a mesh; nothing is allocated then.
    fn generate(&self, params: &Params) -> Result<Mesh, GenerateError>;
}

/// Every generator there is.
pub const GENERATORS: &[&dyn Generator] = &[
    &planes::Planes,
    &grid::Grid,
    &stack::Stack,
    &hairball::Hairball,
    &random_triangles::RandomTriangles,
    &atrium::Atrium,
    &smoke::Smoke,
    &cyclic::Cyclic,
    &intersecting::Intersecting,
    &shells::Shells,
    &powerplant::PowerPlant,
];

/// Makes spheres. A pure function of its parameters, as a [`Generator`] is.
pub trait SphereGenerator: Sync {
    /// The word in scene files.
    fn name(&self) -> &'static str;
    /// Every parameter with its default and range.
    fn parameters(&self) -> &'static [Parameter];
    /// Makes the spheres. `params` were made from [`SphereGenerator::parameters`].
    ///
    /// # Errors
    /// [`GenerateError`] when the parameters ask for too much; nothing is allocated then.
    fn generate(&self, params: &Params) -> Result<Spheres, GenerateError>;
}

/// Every generator of spheres there is.
pub const SPHERE_GENERATORS: &[&dyn SphereGenerator] = &[&sphere_stack::SphereStack, &virus::Virus];

/// Why a generator refuses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GenerateError {
    /// Too many triangles.
    #[error("these parameters make {triangles} triangles, more than {MAX_TRIANGLES}")]
    TooLarge {
        /// How many they would be.
        triangles: u64,
    },
    /// Too many objects made of spheres.
    #[error("these parameters make {objects} objects, more than {MAX_OBJECTS}")]
    TooManyObjects {
        /// How many they would be.
        objects: u64,
    },
}

/// Refuses a product of counts that is too large.
fn check_triangles(counts: &[u64]) -> Result<(), GenerateError> {
    let triangles = counts.iter().fold(1, |product: u64, count| product.saturating_mul(*count));
    if triangles > MAX_TRIANGLES { Err(GenerateError::TooLarge { triangles }) } else { Ok(()) }
}

/// Values of the parameter `order` of generators whose parts lie behind one another.
const ORDERS: &[&str] = &["front_to_back", "back_to_front"];

/// `count` positions, equally spaced over `extent` about 0, the largest (nearest to a camera on +z)
/// first.
fn spaced(count: u64, extent: f32) -> impl Iterator<Item = f32> {
    let step = if count > 1 { extent / (count - 1) as f32 } else { 0.0 };
    let first = if count > 1 { extent / 2.0 } else { 0.0 };
    (0..count).map(move |i| first - i as f32 * step)
}
