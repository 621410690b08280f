//! Fragments and peak depth complexity of our scenes beside those that the papers give, and the
//! parameters of the grid for the LFB chapter's Figures 20.11 and 20.12, as Markdown.
//!
//!     cargo run --release -p oit-capture --example scene_totals
//!
//! With `--write` the tables in docs/scenes.md are replaced. Scenes whose asset is missing are left
//! out, so then nothing is written.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use oit_capture::rasterize_counts;
use oit_fragments::DepthHistogram;
use oit_scene::{Asset, Scene, SceneError, list, load};
use toml::Value;

/// A view as a paper gives it.
#[derive(Clone, Copy, Debug)]
pub struct Published {
    /// Our scene.
    pub scene: &'static str,
    /// Our view.
    pub view: &'static str,
    /// Width and height.
    pub size_px: [u32; 2],
    /// Of the paper's mesh, where it says.
    pub triangles: Option<u64>,
    /// In all.
    pub fragments: u64,
    /// The most on one pixel, where the paper says.
    pub peak: Option<u32>,
    /// Where it says so.
    pub source: &'static str,
}

const HD: [u32; 2] = [1920, 1080];

const fn view(
    scene: &'static str,
    view: &'static str,
    triangles: Option<u64>,
    fragments: u64,
    peak: Option<u32>,
    source: &'static str,
) -> Published {
    Published { scene, view, size_px: HD, triangles, fragments, peak, source }
}

const LFB: &str = "LFB chapter, Figures 20.7 and 20.8";
const BMA: &str = "BMA paper, Table 2";
const RBS: &str = "RBS paper, Table 2";

/// Every view with published totals, of the LFB chapter (Knowles, Leach, Zambetta, OpenGL Insights
/// 2012, chapter 20), the BMA paper (2013) and the RBS paper (2014) of the same authors.
pub const PUBLISHED: &[Published] = &[
    view("dragon", "front", Some(871_414), 1_300_000, None, LFB),
    view("atrium", "lfb", Some(279_095), 17_500_000, None, LFB),
    view("atrium", "rbs-v1", None, 17_000_000, Some(45), RBS),
    view("atrium", "rbs-v2", None, 16_000_000, Some(27), RBS),
    Published {
        size_px: [1680, 1050],
        ..view("atrium", "bma", Some(279_178), 14_449_340, Some(46), BMA)
    },
    Published {
        size_px: [1680, 1050],
        ..view("smoke", "bma", Some(13_468), 10_072_458, Some(136), BMA)
    },
    // The BMA paper's mesh has 12,701,147 triangles, which ours has at full detail only.
    Published {
        size_px: [1680, 1050],
        ..view("powerplant", "bma", None, 18_479_488, Some(278), BMA)
    },
    view("powerplant", "rbs-v1", None, 28_000_000, Some(424), RBS),
    view("powerplant", "rbs-v2", None, 53_000_000, Some(250), RBS),
    view("powerplant", "rbs-v3", None, 19_000_000, Some(118), RBS),
    view("hairball", "inside-front", None, 113_000_000, Some(200), RBS),
    view("hairball", "inside-back", None, 82_000_000, Some(206), RBS),
    view("planes", "front", None, 40_000_000, Some(128), RBS),
    view("planes", "back", None, 40_000_000, Some(128), RBS),
    view("planes2", "front", None, 40_000_000, Some(128), RBS),
    view("planes2", "back", None, 40_000_000, Some(128), RBS),
];

/// What one of [`PUBLISHED`] is here.
#[derive(Debug)]
pub struct Row {
    /// The paper's.
    pub published: Published,
    /// Of our mesh.
    pub triangles: u64,
    /// How many pixels have how many fragments.
    pub histogram: DepthHistogram,
}

/// The scene files.
pub fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// One scene of ours, with some of its parameters replaced.
///
/// # Errors
/// Those of [`load`].
pub fn scene(name: &str, overrides: &[(&str, Value)]) -> Result<Scene, SceneError> {
    let overrides = overrides.iter().map(|(key, value)| ((*key).to_owned(), value.clone()));
    load(&scenes().join(format!("{name}.toml")), &overrides.collect())
}

/// Counts the fragments of a view.
///
/// # Errors
/// Where the scene has no such view.
pub fn histogram(
    scene: &Scene,
    view: &str,
    [width_px, height_px]: [u32; 2],
) -> Result<DepthHistogram, SceneError> {
    let camera = &scene.view(view)?.camera;
    let counts = rasterize_counts(&scene.mesh, camera, width_px, height_px);
    Ok(DepthHistogram::from_counts(counts))
}

/// Draws every view of [`PUBLISHED`] whose asset is there.
///
/// # Errors
/// Where a scene cannot be loaded.
pub fn rows() -> Result<Vec<Row>, SceneError> {
    let entries = list(&scenes())?;
    let missing =
        |name: &str| entries.iter().any(|e| e.name == name && matches!(e.asset, Asset::Missing(_)));
    let mut loaded: BTreeMap<&str, Scene> = BTreeMap::new();
    let mut rows = Vec::new();
    for &published in PUBLISHED.iter().filter(|published| !missing(published.scene)) {
        if !loaded.contains_key(published.scene) {
            // One at a time: the hairball alone is 300 MB.
            loaded.clear();
            loaded.insert(published.scene, scene(published.scene, &[])?);
        }
        let scene = &loaded[published.scene];
        let triangles = scene.mesh.triangle_count() as u64;
        let histogram = histogram(scene, published.view, published.size_px)?;
        rows.push(Row { published, triangles, histogram });
    }
    Ok(rows)
}

/// How far ours is from the paper's, in percent of the paper's.
pub fn difference_percent(ours: u64, papers: u64) -> f64 {
    (ours as f64 / papers as f64 - 1.0) * 100.0
}

/// The rows as a Markdown table.
pub fn totals_table(rows: &[Row]) -> String {
    let mut text = "\
        | scene | view | resolution | triangles | paper | fragments | paper | difference | peak | \
        paper | difference | source |\n|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|---|\n"
        .to_owned();
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    for Row { published: p, triangles, histogram } in rows {
        let (total, peak) = (histogram.total(), histogram.peak());
        let [width, height] = p.size_px;
        let peak_difference =
            p.peak.map(|papers| difference_percent(u64::from(peak), u64::from(papers)));
        let _ = writeln!(
            text,
            "| `{}` | `{}` | {width}x{height} | {triangles} | {} | {:.2} M | {:.2} M | {:+.1} % | \
            {peak} | {} | {} | {} |",
            p.scene,
            p.view,
            or_dash(p.triangles.map(|n| n.to_string())),
            total as f64 / 1e6,
            p.fragments as f64 / 1e6,
            difference_percent(total, p.fragments),
            or_dash(p.peak.map(|n| n.to_string())),
            or_dash(peak_difference.map(|percent| format!("{percent:+.1} %"))),
            p.source,
        );
    }
    text
}

/// Intervals of depth complexity, as the BMA and RBS papers have them.
pub const INTERVALS: [[u32; 2]; 8] =
    [[0, 0], [1, 8], [9, 16], [17, 32], [33, 64], [65, 128], [129, 256], [257, 512]];

/// The share of each interval in the pixels of each view, as a Markdown table.
pub fn intervals_table(rows: &[Row]) -> String {
    let mut text = "| scene | view | mean |".to_owned();
    for [low, high] in INTERVALS {
        let _ =
            if low == high { write!(text, " {low} |") } else { write!(text, " {low}–{high} |") };
    }
    text += "\n|---|---|--:|";
    text += &"--:|".repeat(INTERVALS.len());
    text.push('\n');
    for Row { published: p, histogram, .. } in rows {
        let pixels = f64::from(p.size_px[0]) * f64::from(p.size_px[1]);
        let mean = histogram.total() as f64 / pixels;
        let _ = write!(text, "| `{}` | `{}` | {mean:.1} |", p.scene, p.view);
        for [low, high] in INTERVALS {
            let share = histogram.pixels_in(low, high) as f64 / pixels * 100.0;
            let _ = write!(text, " {share:.2} % |");
        }
        text.push('\n');
    }
    text
}

/// One setting of the scene `grid` at 1920x1080.
#[derive(Debug)]
pub struct GridSetting {
    /// The parameter.
    pub layers: u64,
    /// The parameter, a fraction of the view's side.
    pub size: f64,
    /// The parameter, triangles a layer.
    pub tessellation: u64,
    /// Fragments wanted.
    pub wanted: u64,
    /// Triangles in all.
    pub triangles: u64,
    /// Fragments there are.
    pub fragments: u64,
}

fn grid(layers: u64, tessellation: u64, wanted: u64) -> Result<GridSetting, SceneError> {
    // A layer of `size` 1 covers the view; four decimals are finer than a pixel.
    let view = f64::from(HD[0]) * f64::from(HD[1]);
    let size = (wanted as f64 / layers as f64 / view).sqrt();
    let size = (size * 1e4).round() / 1e4;
    let scene = scene(
        "grid",
        &[
            ("layers", Value::Integer(layers as i64)),
            ("size", Value::Float(size)),
            ("tessellation", Value::Integer(tessellation as i64)),
        ],
    )?;
    let triangles = scene.mesh.triangle_count() as u64;
    let fragments = histogram(&scene, "front", HD)?.total();
    Ok(GridSetting { layers, size, tessellation, wanted, triangles, fragments })
}

/// Ten layers of 20,000 triangles, scaled (LFB chapter, Figure 20.11).
///
/// # Errors
/// Where the scene cannot be loaded.
pub fn figure_20_11() -> Result<Vec<GridSetting>, SceneError> {
    let millions = [1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20];
    millions.into_iter().map(|million| grid(10, 20_000, million * 1_000_000)).collect()
}

/// More and more layers with 8 M fragments and 500 to 1000 triangles (LFB chapter, Figure 20.12).
///
/// # Errors
/// Where the scene cannot be loaded.
pub fn figure_20_12() -> Result<Vec<GridSetting>, SceneError> {
    let layers = [5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 125, 150, 200, 250];
    // Two triangles a cell, about 750 in all.
    let tessellation = |layers: u64| (750 / layers).div_ceil(2) * 2;
    layers.into_iter().map(|layers| grid(layers, tessellation(layers), 8_000_000)).collect()
}

/// Settings as a Markdown table.
pub fn grid_table(settings: &[GridSetting]) -> String {
    let mut text =
        "| layers | size | tessellation | triangles | fragments | wanted | difference |\n\
        |--:|--:|--:|--:|--:|--:|--:|\n"
            .to_owned();
    for s in settings {
        let _ = writeln!(
            text,
            "| {} | {:.4} | {} | {} | {:.3} M | {} M | {:+.2} % |",
            s.layers,
            s.size,
            s.tessellation,
            s.triangles,
            s.fragments as f64 / 1e6,
            s.wanted / 1_000_000,
            difference_percent(s.fragments, s.wanted),
        );
    }
    text
}

/// docs/scenes.md.
pub fn document() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenes.md")
}

/// Replaces what stands between the lines `<!-- name -->` and `<!-- end -->`; none where they are
/// not there.
pub fn replaced(document: &str, name: &str, table: &str) -> Option<String> {
    let (before, rest) = document.split_once(&format!("<!-- {name} -->\n"))?;
    let (_, after) = rest.split_once("<!-- end -->")?;
    Some(format!("{before}<!-- {name} -->\n{table}<!-- end -->{after}"))
}

fn main() -> ExitCode {
    match run(std::env::args().any(|argument| argument == "--write")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("scene_totals: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(write: bool) -> Result<(), Box<dyn std::error::Error>> {
    let rows = rows()?;
    let tables = [
        ("totals", totals_table(&rows)),
        ("intervals", intervals_table(&rows)),
        ("figure-20.11", grid_table(&figure_20_11()?)),
        ("figure-20.12", grid_table(&figure_20_12()?)),
    ];
    for (name, table) in &tables {
        println!("## {name}\n\n{table}");
    }
    if write {
        if rows.len() < PUBLISHED.len() {
            return Err("an asset is missing (`just assets`): nothing is written".into());
        }
        let mut text = std::fs::read_to_string(document())?;
        for (name, table) in &tables {
            text = replaced(&text, name, table)
                .ok_or_else(|| format!("docs/scenes.md has no place for `{name}`"))?;
        }
        std::fs::write(document(), text)?;
    }
    Ok(())
}
