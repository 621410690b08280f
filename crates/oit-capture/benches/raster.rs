//! The CPU rasteriser: random triangles, and the Stanford dragon where `just assets` fetched it.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use oit_capture::{rasterize, rasterize_counts};
use oit_scene::{Camera, Mesh, Projection, Shading, SplitMix64, Vertex};

const SHADING: Shading = Shading { light: [0.0, 0.6, 0.8], ambient: 0.3, stripes: None };

fn camera(center: [f32; 3], radius: f32) -> Camera {
    let [x, y, z] = center;
    Camera {
        eye: [x, y, z + 2.5 * radius],
        target: center,
        up: [0.0, 1.0, 0.0],
        projection: Projection::Perspective {
            fov_y_degrees: 45.0,
            near: radius,
            far: 4.0 * radius,
        },
    }
}

/// 10,000 triangles with sides of about a tenth of the picture.
fn random_mesh() -> Mesh {
    let mut random = SplitMix64::new(1);
    let mut vertices = Vec::new();
    for _ in 0..10_000 {
        let hub = [0; 3].map(|_| random.between(-0.8, 0.8));
        for _ in 0..3 {
            let position = hub.map(|hub| hub + random.between(-0.1, 0.1));
            let rgba = (random.next_u64() as u32).to_le_bytes();
            vertices.push(Vertex { position, normal: [0.0, 0.0, 1.0], rgba });
        }
    }
    Mesh { indices: (0..vertices.len() as u32).collect(), vertices }
}

fn bench(criterion: &mut Criterion, name: &str, mesh: &Mesh, camera: &Camera) {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(20);
    let fragments = rasterize(mesh, &SHADING, camera, 960, 540).fragments().len();
    println!("{name}: {} triangles, {fragments} fragments", mesh.triangle_count());
    group.bench_function("count", |b| {
        b.iter(|| black_box(rasterize_counts(mesh, camera, 960, 540)));
    });
    group.bench_function("rasterize", |b| {
        b.iter(|| black_box(rasterize(mesh, &SHADING, camera, 960, 540)));
    });
    group.finish();
}

fn raster(criterion: &mut Criterion) {
    bench(criterion, "random", &random_mesh(), &camera([0.0; 3], 1.0));
}
criterion_group!(benches, raster);
criterion_main!(benches);
