//! How many pixels have how many fragments on the frames of a scene's camera path, as CSV.
//!
//!     cargo run --release -p oit-capture --example path_populations -- atrium flythrough 1680x1050 100
//!
//! The last word is how many frames are drawn, evenly spaced; all of them without it.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use oit_capture::rasterize_counts;
use oit_fragments::DepthHistogram;
use oit_scene::load;

/// The intervals of the BMA paper's Figure 7.
const INTERVALS: [[u32; 2]; 7] =
    [[0, 0], [1, 8], [9, 16], [17, 32], [33, 64], [65, 128], [129, u32::MAX - 1]];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, path, size, rest @ ..] = arguments.as_slice() else {
        return Err("SCENE PATH WIDTHxHEIGHT [FRAMES]".into());
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let (width_px, height_px): (u32, u32) = (width.parse()?, height.parse()?);
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scene = load(&scenes.join(format!("{scene}.toml")), &BTreeMap::new())?;
    let known = scene.paths.iter().find(|(name, _)| name == path);
    let (_, path) = known.ok_or_else(|| format!("no path `{path}`"))?;
    let frames = path.frames();
    let drawn: u32 = rest.first().map_or(Ok(frames), |count| count.parse())?;
    let drawn = drawn.clamp(1, frames);
    println!("frame,fragments,peak,0,1-8,9-16,17-32,33-64,65-128,129-");
    for index in 0..drawn {
        let frame = (u64::from(index) * u64::from(frames) / u64::from(drawn)) as u32;
        let camera = path.camera(frame);
        let counts = rasterize_counts(&scene.mesh, &camera, width_px, height_px);
        let histogram = DepthHistogram::from_counts(counts);
        print!("{frame},{},{}", histogram.total(), histogram.peak());
        for [low, high] in INTERVALS {
            print!(",{}", histogram.pixels_in(low, high));
        }
        println!();
    }
    Ok(())
}
