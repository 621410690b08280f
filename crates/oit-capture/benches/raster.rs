//! The CPU rasteriser: random triangles, and the Stanford dragon where `just assets` fetched it.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use oit_capture::{rasterize, rasterize_counts};
use oit_scene::{Camera, Mesh, Projection, Shading, SplitMix64, Vertex};

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 540;

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

fn bench(criterion: &mut Criterion, name: &str, mesh: &Mesh, shading: &Shading, camera: &Camera) {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(20);
    let fragments = rasterize(mesh, shading, camera, WIDTH_PX, HEIGHT_PX).fragments().len();
    println!("{name}: {} triangles, {fragments} fragments", mesh.triangle_count());
    group.bench_function("count", |b| {
        b.iter(|| black_box(rasterize_counts(mesh, camera, WIDTH_PX, HEIGHT_PX)));
    });
    group.bench_function("rasterize", |b| {
        b.iter(|| black_box(rasterize(mesh, shading, camera, WIDTH_PX, HEIGHT_PX)));
    });
    group.finish();
}

fn raster(criterion: &mut Criterion) {
    let shading = Shading { light: [0.0, 0.6, 0.8], ambient: 0.3, stripes: None };
    let camera = Camera {
        eye: [0.0, 0.0, 2.5],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Perspective { fov_y_degrees: 45.0, near: 1.0, far: 4.0 },
    };
    bench(criterion, "random", &random_mesh(), &shading, &camera);

    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/dragon.toml");
    match oit_scene::load(&file, &BTreeMap::new()) {
        Ok(scene) => {
            bench(criterion, "dragon", &scene.mesh, &scene.shading, &scene.views[0].camera);
        }
        Err(error) => println!("dragon: left out: {error}"),
    }
}

criterion_group!(benches, raster);
criterion_main!(benches);
