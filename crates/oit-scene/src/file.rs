//! The format of scene files, and reading them.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use serde::Deserialize;
use toml::{Spanned, Value};

use crate::scene::FRAME_MARK;
use crate::{
    Camera, CameraPath, Fault, GENERATORS, Generator, Mesh, Params, Problem, Projection, Scene,
    SceneError, Shading, Stripes, View, import, parse_toml, shuffle_triangles,
};

/// The override that every scene has: a seed, with which its triangles are submitted in a random order
/// ([`shuffle_triangles`]). Without it they keep their own.
pub const SHUFFLE: &str = "shuffle";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    about: Spanned<String>,
    /// Camera paths by name, as files beside this one.
    #[serde(default)]
    paths: BTreeMap<Spanned<String>, PathBuf>,
    mesh: Spanned<MeshFile>,
    #[serde(default)]
    shading: Option<Spanned<ShadingFile>>,
    views: Spanned<Vec<Spanned<ViewFile>>>,
}

/// Either `generator`, with or without `parameters`, or `import`, with or without `rgba`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshFile {
    generator: Option<Spanned<String>>,
    #[serde(default)]
    parameters: BTreeMap<Spanned<String>, Spanned<Value>>,
    import: Option<PathBuf>,
    rgba: Option<[u8; 4]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShadingFile {
    light: [f32; 3],
    ambient: f32,
    stripes: Option<StripesFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StripesFile {
    direction: [f32; 3],
    period: f32,
    rgba: [u8; 4],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewFile {
    name: String,
    eye: [f32; 3],
    target: [f32; 3],
    #[serde(default = "y_up")]
    up: [f32; 3],
    projection: Projection,
}

pub(crate) fn y_up() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}

/// What `list` knows of a scene without building it.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneEntry {
    /// The file's name without its ending.
    pub name: String,
    /// The scene file.
    pub path: PathBuf,
    /// Prose: what the scene is and where it comes from.
    pub about: String,
    /// Names of the views, in the order of the file.
    pub views: Vec<String>,
    /// Its camera paths, by name.
    pub paths: Vec<PathEntry>,
    /// Whether the mesh file it needs is there.
    pub asset: Asset,
}

/// What `list` knows of a camera path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathEntry {
    /// As experiments and the command line call it; frame 3 of `fly` is the view `fly@3`.
    pub name: String,
    /// How many frames it has.
    pub frames: u32,
}

/// The mesh file of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asset {
    /// The mesh is generated.
    None,
    /// The file, found.
    Present(PathBuf),
    /// The path in the scene file; nothing is there.
    Missing(PathBuf),
}

/// Where the mesh comes from.
enum Source {
    Generate(&'static dyn Generator, Params),
    Import(PathBuf, [u8; 4]),
}

/// A scene file that has been read and checked, without its mesh.
struct Checked {
    about: String,
    source: Source,
    shuffle: Option<u64>,
    shading: Shading,
    views: Vec<View>,
    paths: Vec<(String, CameraPath)>,
}

/// Reads a scene file and makes its mesh. `overrides` replace generator parameters: experiments
/// vary them. One more, [`SHUFFLE`], every scene has.
///
/// # Errors
/// [`SceneError::Fault`] for a mistake in the file or in an override, with line, word and the
/// nearest valid words; [`SceneError::MissingAsset`], [`SceneError::Import`],
/// [`SceneError::Generate`] and [`SceneError::Io`].
pub fn load(path: &Path, overrides: &BTreeMap<String, Value>) -> Result<Scene, SceneError> {
    let Checked { about, source, shuffle, shading, views, paths } = check(path, overrides)?;
    let mut mesh = match source {
        Source::Generate(generator, params) => generator
            .generate(&params)
            .map_err(|source| SceneError::Generate { path: path.to_owned(), source })?,
        Source::Import(asset, rgba) => {
            let Some(found) = find_asset(path, &asset) else {
                return Err(SceneError::MissingAsset { scene: path.to_owned(), asset });
            };
            let mut mesh = import::import(&found)
                .map_err(|source| SceneError::Import { path: found.clone(), source })?;
            tint(&mut mesh, rgba);
            mesh
        }
    };
    if let Some(seed) = shuffle {
        mesh = shuffle_triangles(&mesh, seed);
    }
    Ok(Scene { name: stem(path), about, mesh: Arc::new(mesh), shading, views, paths })
}

/// Every scene file (`*.toml`) of a folder, by name, without building meshes.
///
/// # Errors
/// Those of [`load`] that concern the file itself, for the first file that has one.
pub fn list(dir: &Path) -> Result<Vec<SceneEntry>, SceneError> {
    let io_error = |source| SceneError::Io { path: dir.to_owned(), source };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(io_error)? {
        let path = entry.map_err(io_error)?.path();
        if path.extension() == Some(OsStr::new("toml")) {
            paths.push(path);
        }
    }
    paths.sort();
    paths
        .into_iter()
        .map(|path| {
            let Checked { about, source, views, paths, .. } = check(&path, &BTreeMap::new())?;
            let asset = match source {
                Source::Generate(..) => Asset::None,
                Source::Import(asset, _) => match find_asset(&path, &asset) {
                    Some(found) => Asset::Present(found),
                    None => Asset::Missing(asset),
                },
            };
            let views = views.into_iter().map(|view| view.name).collect();
            let paths = paths.into_iter();
            let paths = paths.map(|(name, path)| PathEntry { name, frames: path.frames() });
            let paths = paths.collect();
            Ok(SceneEntry { name: stem(&path), path, about, views, paths, asset })
        })
        .collect()
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// An asset lies in the scene file's folder or in a folder above it (scenes/x.toml names
/// `assets/...` in the repository's root).
fn find_asset(scene: &Path, asset: &Path) -> Option<PathBuf> {
    let folder = scene.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().ok()?;
    folder.ancestors().map(|above| above.join(asset)).find(|candidate| candidate.is_file())
}

/// Multiplies every vertex colour by the material's.
fn tint(mesh: &mut Mesh, rgba: [u8; 4]) {
    for vertex in &mut mesh.vertices {
        for (channel, factor) in vertex.rgba.iter_mut().zip(rgba) {
            *channel = ((u32::from(*channel) * u32::from(factor) + 127) / 255) as u8;
        }
    }
}

fn check(path: &Path, overrides: &BTreeMap<String, Value>) -> Result<Checked, SceneError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| SceneError::Io { path: path.to_owned(), source })?;
    let file: SceneFile = parse_toml(path, &text)?;
    let fault = |span, problem| Fault::at(path, &text, span, problem);
    let invalid = |span, sentence: &str| fault(span, Problem::Invalid(sentence.to_owned()));

    if file.about.get_ref().trim().is_empty() {
        return Err(invalid(file.about.span(), "`about` must say what the scene is").into());
    }

    let unplaced = |problem| Fault { path: path.to_owned(), line: None, problem };
    let mut overrides = overrides.clone();
    let shuffle = overrides.remove(SHUFFLE).map(|value| seed(&value)).transpose();
    let shuffle = shuffle.map_err(unplaced)?;

    let mesh_span = file.mesh.span();
    let mesh = file.mesh.into_inner();
    let source = match (mesh.generator, mesh.import) {
        (Some(name), None) => {
            if mesh.rgba.is_some() {
                return Err(invalid(mesh_span, "`rgba` goes with `import` only").into());
            }
            let Some(generator) = GENERATORS.iter().find(|known| known.name() == name.get_ref())
            else {
                let names = GENERATORS.iter().map(|known| known.name());
                let problem = Problem::unknown("generator", name.get_ref(), names);
                return Err(fault(name.span(), problem).into());
            };
            let mut params = Params::new(generator.parameters());
            for (key, value) in mesh.parameters {
                params
                    .set(key.get_ref(), value.get_ref())
                    .map_err(|problem| fault(key.span(), problem))?;
            }
            for (key, value) in &overrides {
                params.set(key, value).map_err(unplaced)?;
            }
            Source::Generate(*generator, params)
        }
        (None, Some(asset)) => {
            if let Some((key, _)) = mesh.parameters.first_key_value() {
                let sentence = "`parameters` go with `generator` only";
                return Err(invalid(key.span(), sentence).into());
            }
            if let Some(key) = overrides.keys().next() {
                return Err(unplaced(Problem::unknown("parameter", key, [SHUFFLE])).into());
            }
            Source::Import(asset, mesh.rgba.unwrap_or([255; 4]))
        }
        _ => {
            let sentence = "`mesh` needs either `generator` or `import`";
            return Err(invalid(mesh_span, sentence).into());
        }
    };

    let shading = match file.shading {
        None => Shading { light: [0.0, 0.0, 1.0], ambient: 1.0, stripes: None },
        Some(shading) => check_shading(shading.get_ref())
            .map_err(|sentence| invalid(shading.span(), sentence))?,
    };

    let mut views: Vec<View> = Vec::new();
    let views_span = file.views.span();
    for view in file.views.into_inner() {
        let span = view.span();
        let ViewFile { name, eye, target, up, projection } = view.into_inner();
        let camera = Camera { eye, target, up, projection };
        if let Some(sentence) = camera.fault() {
            return Err(invalid(span, &format!("view `{name}`: {sentence}")).into());
        }
        if views.iter().any(|earlier| earlier.name == name) {
            return Err(invalid(span, &format!("a second view `{name}`")).into());
        }
        if name.contains(FRAME_MARK) {
            return Err(
                invalid(span, &format!("view `{name}`: `{FRAME_MARK}` names frames")).into()
            );
        }
        views.push(View { name, camera });
    }
    if views.is_empty() {
        return Err(invalid(views_span, "`views` must hold at least one view").into());
    }
    let mut paths = Vec::new();
    for (name, beside) in file.paths {
        let span = name.span();
        let name = name.into_inner();
        if name.contains(FRAME_MARK) || views.iter().any(|view| view.name == name) {
            let sentence = format!("path `{name}`: a view's name, or one with `{FRAME_MARK}`");
            return Err(invalid(span, &sentence).into());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        paths.push((name, CameraPath::load(&folder.join(beside))?));
    }
    Ok(Checked { about: file.about.into_inner(), source, shuffle, shading, views, paths })
}

/// A seed, as generators take them.
fn seed(value: &Value) -> Result<u64, Problem> {
    let seed = value.as_integer().and_then(|seed| u32::try_from(seed).ok());
    let invalid = || {
        let most = u32::MAX;
        Problem::Invalid(format!("`{SHUFFLE}` is a whole number from 0 to {most}, not {value}"))
    };
    seed.map(u64::from).ok_or_else(invalid)
}

fn check_shading(shading: &ShadingFile) -> Result<Shading, &'static str> {
    let unit = |vector: [f32; 3]| Vec3::from(vector).try_normalize().map(|unit| unit.to_array());
    if !(0.0..=1.0).contains(&shading.ambient) {
        return Err("`ambient` must be from 0 to 1");
    }
    let stripes = match &shading.stripes {
        None => None,
        Some(stripes) => {
            if !(stripes.period > 0.0 && stripes.period.is_finite()) {
                return Err("`period` of stripes must be above 0");
            }
            let direction = unit(stripes.direction).ok_or("`direction` must not be zero")?;
            Some(Stripes { direction, period: stripes.period, rgba: stripes.rgba })
        }
    };
    let light = unit(shading.light).ok_or("`light` must not be zero")?;
    Ok(Shading { light, ambient: shading.ambient, stripes })
}
