//! Draws a scene of spheres in given ways on every device, and says what is wrong with the pictures and
//! how long each stage took: `draw_spheres SCENE.toml VIEW WIDTH HEIGHT VARIATION...`, without
//! variations all named ones.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use oit_gpu::GpuError;
use oit_spheres::{Detail, PICTURE, SphereBytes, SphereRequest, VARIATIONS, Variation, expected};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, view, width, height, names @ ..] = words.as_slice() else {
        return Err("SCENE.toml VIEW WIDTH HEIGHT VARIATION...".into());
    };
    let scene = oit_scene::load(Path::new(scene), &Default::default())?;
    let camera = scene.view(view)?.camera;
    let spheres = scene.spheres.ok_or("a scene of spheres")?;
    let (width, height) = (width.parse()?, height.parse()?);
    let started = Instant::now();
    let draw = |detail| expected(&spheres, detail, &scene.shading, &camera, width, height);
    let by_distance = draw(Detail::ByDistance);
    println!("expected: {:.1} s", started.elapsed().as_secs_f64());
    let all: Vec<String> = VARIATIONS.iter().map(|&name| name.to_owned()).collect();
    let bytes = SphereBytes::new(&spheres);
    let cache = std::env::temp_dir().join("draw_spheres");
    for listed in oit_gpu::enumerate() {
        let Ok(mut device) = oit_gpu::open(&listed.id, &cache) else { continue };
        for name in if names.is_empty() { &all } else { names } {
            let variation: Variation = name.parse()?;
            let request = SphereRequest {
                spheres: &bytes,
                shading: &scene.shading,
                camera: &camera,
                width_px: width,
                height_px: height,
            };
            let prepared = variation
                .plan(&request)
                .map_err(GpuError::Unsupported)
                .and_then(|plan| device.prepare(&plan));
            let id = match prepared {
                Ok(id) => id,
                Err(error) => {
                    println!("{} {name}: {error}", listed.id);
                    continue;
                }
            };
            let mut timings = Vec::new();
            for _ in 0..5 {
                timings.push(device.run(id)?);
            }
            timings.sort_by_key(|timing| timing.total_ns);
            let stages: Vec<String> = timings[2]
                .stages
                .iter()
                .map(|(stage, ns)| format!("{stage} {:.3} ms", *ns as f64 / 1e6))
                .collect();
            let picture: Vec<[f32; 4]> = device
                .read(id, PICTURE)?
                .chunks_exact(16)
                .map(|pixel| {
                    std::array::from_fn(|channel| {
                        let word = &pixel[4 * channel..][..4];
                        f32::from_le_bytes([word[0], word[1], word[2], word[3]])
                    })
                })
                .collect();
            let comparison = match variation.detail {
                Detail::ByDistance => by_distance.compare(&picture),
                Detail::Full => draw(Detail::Full).compare(&picture),
            };
            println!("{} {name}: {}; {comparison:?}", listed.id, stages.join(", "));
            device.reset();
        }
    }
    Ok(())
}
