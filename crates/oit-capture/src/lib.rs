//! Capture methods: how each fills a layered fragment buffer, as a plan and as a CPU twin.

mod capture;
mod captures;
mod draw;
mod frame;
mod geometry;
mod method;
mod raster;
mod scan;
mod spheres;

pub use capture::{Capture, CaptureError, CapturePasses, CaptureRequest, Demand, Lists, Usage};
pub use captures::{
    Array3d, Array3dNearest, CAPTURES, FAULTY, Interleaved, InterleavedLists, Linearized,
    LinearizedNearest, LinearizedUnclipped, LinkedList, LinkedPages, UnknownCapture, capture,
};
pub use draw::count_plan;
pub use frame::Frame;
pub use geometry::{Drawn, Geometry, LfbReader, MeshBytes};
pub(crate) use geometry::{fragments_buffer, words_buffer};
pub use method::{Accuracy, Method, MethodRequest, PICTURE, Size, scene_wgsl};
pub use raster::{rasterize, rasterize_counts, rasterize_sphere_counts, rasterize_spheres};
pub use spheres::{MOST_SPHERES, PlacedSphere, PlacedSpheres, SphereView, TooManySpheres};
