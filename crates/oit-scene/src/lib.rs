//! Meshes, spheres, cameras and shading: generators, importers and the scene files that name them.
//!
//! A scene is one triangle mesh or one set of spheres, its shading and the views it is seen from. It is
//! read from a TOML file by [`load`], with the camera paths it names ([`CameraPath`]). A mesh comes from
//! a [`Generator`] (a pure function of its parameters) or from a glTF or PLY file, spheres from a
//! [`SphereGenerator`] or from a PDB or mmCIF file. Triangles and spheres are kept in the order in
//! which they are to be submitted, because sorts that adapt to sorted input are measured with it.

mod camera;
mod detail;
mod fault;
mod file;
pub mod generate;
pub mod import;
mod mesh;
mod nearest;
mod parameter;
mod path;
mod random;
mod reorder;
mod scene;
mod shading;
mod spheres;

pub use camera::{Camera, Projection};
pub use detail::{DETAIL_PIXELS, pixels_at_one};
pub use fault::{Fault, Problem, parse_toml};
pub use file::{Asset, PathEntry, SceneEntry, list, load};
pub use generate::{GENERATORS, GenerateError, Generator, SPHERE_GENERATORS, SphereGenerator};
pub use import::{Coloring, ImportError, Splitting, StructureOptions};
pub use mesh::{MAX_TRIANGLES, Mesh, Vertex, shuffle_triangles};
pub use nearest::nearest;
pub use parameter::{Kind, Parameter, Params};
pub use path::{CameraPath, MAX_FRAMES};
pub use random::SplitMix64;
pub use reorder::ObjectOrder;
pub use scene::{Scene, SceneError, View, frame_view, no_such_frame, split_frame_view};
pub use shading::{Shading, Stripes};
pub use spheres::{Atom, Kind as SphereKind, Level, MAX_ATOMS, MAX_OBJECTS, Object, Spheres};
