//! `oit render`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use miette::{IntoDiagnostic, miette};
use oit_image::{false_color_png, write_exr, write_png};
use oit_lab::{
    FrameSize, STORED_VIEW, SphereVerifier, Technique, Tuner, Verifier, ViewData, is_stored,
    load_stored, open_engine,
};

use crate::command::{TUNING, cache_folder, device_id, report};

/// What is rendered, and where to.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A scene file, or a file of captured fragments: a trace (.oitt), a deep image (.exr).
    scene: PathBuf,
    /// One of the scene's views; the first if none is named.
    #[arg(long)]
    view: Option<String>,
    /// The technique, by coordinate or alias, or a method.
    #[arg(long, default_value = "linked_list/bma-list/rbs/compute/peak")]
    technique: String,
    /// Width and height in pixels; 1920x1080 if not given, and a file's own for captured fragments.
    #[arg(long)]
    size: Option<String>,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// A scene parameter, `name=value`; may be given several times.
    #[arg(long = "set")]
    set: Vec<String>,
    /// The background that the PNG is composited over: red, green, blue from 0 to 1.
    #[arg(long, default_value = "1,1,1")]
    background: String,
    /// The folder of tuning files, for the sort `auto` and for `intervals-optimal`.
    #[arg(long, default_value = TUNING)]
    tuning: PathBuf,
    /// The folder the files go to: NAME.png, NAME.exr (float RGBA and depth complexity) and
    /// NAME-depth.png (depth complexity in false colour), NAME being the scene's and the view's.
    #[arg(long, default_value = "renders")]
    out: PathBuf,
}

/// `1920x1080`.
pub(crate) fn size(text: &str) -> miette::Result<FrameSize> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((width_px @ 1..=16384, height_px @ 1..=16384)) => {
            Ok(FrameSize { width_px, height_px })
        }
        _ => {
            Err(miette!("{text:?} is no size: write width x height, each 1 to 16384, as 1920x1080"))
        }
    }
}

/// Scene parameters from `name=value` pairs, each value as TOML.
pub(crate) fn overrides(pairs: &[String]) -> miette::Result<oit_lab::Overrides> {
    let mut values = BTreeMap::new();
    for pair in pairs {
        let Some((name, value)) = pair.split_once('=') else {
            return Err(miette!("{pair:?} is not of the form name=value"));
        };
        let table = format!("value = {value}").parse::<toml::Table>();
        let table = table.or_else(|_| format!("value = {value:?}").parse()).into_diagnostic()?;
        values.extend(table.into_iter().map(|(_, value)| (name.to_owned(), value)));
    }
    Ok(values)
}

fn background(text: &str) -> miette::Result<[f32; 3]> {
    let channels: Vec<f32> =
        text.split(',').filter_map(|channel| channel.trim().parse().ok()).collect();
    channels.try_into().map_err(|_| miette!("{text:?} is no colour: write three numbers, as 1,1,1"))
}

/// What is rendered, and the names of its scene and view.
fn view_data(arguments: &Arguments, opaque: bool) -> miette::Result<(ViewData, String, String)> {
    let Arguments { scene: path, view, size: asked, set, .. } = arguments;
    if is_stored(path) {
        if view.is_some() || asked.is_some() || !set.is_empty() {
            let path = path.display();
            return Err(miette!("{path} has one view of one size, and no parameters to set"));
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let lfb = load_stored(path).map_err(report)?.lfb;
        return Ok((ViewData::stored(lfb), name, STORED_VIEW.into()));
    }
    let size = size(asked.as_deref().unwrap_or("1920x1080"))?;
    let scene = oit_scene::load(path, &overrides(set)?).map_err(report)?;
    let view = view.clone().unwrap_or_else(|| scene.views[0].name.clone());
    let open = if opaque { ViewData::uncounted } else { ViewData::new };
    Ok((open(&scene, &view, size).map_err(report)?, scene.name, view))
}

/// Renders, says how right it is, and writes the files.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let technique: Technique = arguments.technique.parse().map_err(report)?;
    let background = background(&arguments.background)?;
    let opaque = matches!(technique, Technique::Spheres(_));
    let (data, name, view) = view_data(arguments, opaque)?;
    let (size, triangles, of_spheres) = (data.size, data.triangles(), data.spheres());
    let mut spheres = SphereVerifier::new(&data);
    let device = device_id(&arguments.device)?;
    let mut engine = open_engine(&device, &cache_folder()).map_err(report)?;
    let histogram = engine.open_view(data).map_err(report)?;
    let tuner = Tuner::open(&arguments.tuning, engine.info());
    let technique = tuner.choose(&technique, &histogram, size).map_err(report)?;
    let (ready, preparation) = engine.prepare(&technique).map_err(report)?;
    let (result, counts) = match (&technique, &mut spheres) {
        (Technique::Spheres(variation), Some(verifier)) => {
            let result = verifier.verify(&mut *engine, variation, ready, &preparation, None);
            (result.map_err(report)?, None)
        }
        _ => {
            let mut verifier = Verifier::new(&mut *engine).map_err(report)?;
            let result = verifier.verify(&mut *engine, &technique, ready, &preparation);
            let counts: Vec<u32> = verifier.reference().counts().collect();
            (result.map_err(report)?, Some(counts))
        }
    };
    let image = engine.picture(ready).map_err(report)?;
    std::fs::create_dir_all(&arguments.out).into_diagnostic()?;
    let path = |ending: &str| arguments.out.join(format!("{name}-{view}{ending}"));
    write_png(&path(".png"), &image, background).map_err(report)?;
    write_exr(&path(".exr"), &image, counts.as_deref()).map_err(report)?;
    let (width, height) = (size.width_px, size.height_px);
    let drawn = of_spheres.map_or_else(
        || format!("{triangles} triangles"),
        |spheres| format!("up to {spheres} spheres"),
    );
    if let Some(counts) = counts {
        false_color_png(&path("-depth.png"), width, height, &counts).map_err(report)?;
        println!(
            "{drawn}, {} fragments, up to {} on one of {} covered pixels",
            histogram.total(),
            histogram.peak(),
            histogram.covered()
        );
    } else {
        println!("{drawn}");
    }
    println!(
        "{technique} on {device}: {:?}{}",
        result.verdict,
        result.note.map_or_else(String::new, |note| format!(", {note}"))
    );
    println!("{}", path(".png").display());
    Ok(())
}
