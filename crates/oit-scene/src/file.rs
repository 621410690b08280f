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
    Camera, CameraPath, Coloring, Fault, GENERATORS, Generator, Mesh, Parameter, Params, Problem,
    Projection, SPHERE_GENERATORS, Scene, SceneError, Shading, SphereGenerator, Splitting, Stripes,
    StructureOptions, View, import, parse_toml,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    about: Spanned<String>,
    /// Camera paths by name, as files beside this one.
    #[serde(default)]
    paths: BTreeMap<Spanned<String>, PathBuf>,
    mesh: Option<Spanned<MeshFile>>,
    spheres: Option<Spanned<SpheresFile>>,
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
    parameters: Parameters,
    import: Option<PathBuf>,
    rgba: Option<[u8; 4]>,
}

/// Either `generator`, with or without `parameters`, or `import` with its options.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpheresFile {
    generator: Option<Spanned<String>>,
    #[serde(default)]
    parameters: Parameters,
    import: Option<PathBuf>,
    colors: Option<Coloring>,
    objects: Option<Splitting>,
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
    /// Whether the file it needs is there.
    pub asset: Asset,
    /// Whether it is made of spheres rather than triangles.
    pub spheres: bool,
}

/// What `list` knows of a camera path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathEntry {
    /// As experiments and the command line call it; frame 3 of `fly` is the view `fly@3`.
    pub name: String,
    /// How many frames it has.
    pub frames: u32,
}

/// The file with a scene's mesh or structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asset {
    /// The scene is generated.
    None,
    /// The file, found.
    Present(PathBuf),
    /// The path in the scene file; nothing is there.
    Missing(PathBuf),
}

/// Where the mesh or the spheres come from.
enum Source {
    Generate(&'static dyn Generator, Params),
    Import(PathBuf, [u8; 4]),
    GenerateSpheres(&'static dyn SphereGenerator, Params),
    ImportStructure(PathBuf, StructureOptions),
}

/// A scene file that has been read and checked, without its mesh or spheres.
struct Checked {
    about: String,
    source: Source,
    shading: Shading,
    views: Vec<View>,
    paths: Vec<(String, CameraPath)>,
}

/// Reads a scene file and makes its mesh or spheres. `overrides` replace generator parameters: experiments
/// vary them.
///
/// # Errors
/// [`SceneError::Fault`] for a mistake in the file or in an override, with line, word and the
/// nearest valid words; [`SceneError::MissingAsset`], [`SceneError::Import`],
/// [`SceneError::Generate`] and [`SceneError::Io`].
pub fn load(path: &Path, overrides: &BTreeMap<String, Value>) -> Result<Scene, SceneError> {
    let Checked { about, source, shading, views, paths } = check(path, overrides)?;
    let generated = |source| SceneError::Generate { path: path.to_owned(), source };
    let find = |asset: PathBuf| {
        find_asset(path, &asset)
            .ok_or_else(|| SceneError::MissingAsset { scene: path.to_owned(), asset })
    };
    let mut mesh = Mesh::default();
    let mut spheres = None;
    match source {
        Source::Generate(generator, params) => {
            mesh = generator.generate(&params).map_err(generated)?;
        }
        Source::GenerateSpheres(generator, params) => {
            spheres = Some(Arc::new(generator.generate(&params).map_err(generated)?));
        }
        Source::Import(asset, rgba) => {
            let found = find(asset)?;
            mesh = import::import(&found)
                .map_err(|source| SceneError::Import { path: found, source })?;
            tint(&mut mesh, rgba);
        }
        Source::ImportStructure(asset, options) => {
            let found = find(asset)?;
            let structure = import::import_structure(&found, &options)
                .map_err(|source| SceneError::Import { path: found, source })?;
            spheres = Some(Arc::new(structure));
        }
    }
    let mesh = Arc::new(mesh);
    Ok(Scene { name: stem(path), about, mesh, spheres, shading, views, paths })
}

/// Every scene file (`*.toml`) of a folder, by name, without building meshes or spheres.
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
            let spheres =
                matches!(source, Source::GenerateSpheres(..) | Source::ImportStructure(..));
            let asset = match source {
                Source::Generate(..) | Source::GenerateSpheres(..) => Asset::None,
                Source::Import(asset, _) | Source::ImportStructure(asset, _) => {
                    match find_asset(&path, &asset) {
                        Some(found) => Asset::Present(found),
                        None => Asset::Missing(asset),
                    }
                }
            };
            let views = views.into_iter().map(|view| view.name).collect();
            let paths = paths.into_iter();
            let paths = paths.map(|(name, path)| PathEntry { name, frames: path.frames() });
            let paths = paths.collect();
            Ok(SceneEntry { name: stem(&path), path, about, views, paths, asset, spheres })
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

/// As a scene file gives them.
type Parameters = BTreeMap<Spanned<String>, Spanned<Value>>;

fn check(path: &Path, overrides: &BTreeMap<String, Value>) -> Result<Checked, SceneError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| SceneError::Io { path: path.to_owned(), source })?;
    let file: SceneFile = parse_toml(path, &text)?;
    let fault = |span, problem| Fault::at(path, &text, span, problem);
    let invalid = |span, sentence: &str| fault(span, Problem::Invalid(sentence.to_owned()));

    if file.about.get_ref().trim().is_empty() {
        return Err(invalid(file.about.span(), "`about` must say what the scene is").into());
    }

    // The values of a generator's parameters: what the file says, then the overrides.
    let params = |declared: &'static [Parameter], given: Parameters| -> Result<Params, Fault> {
        let mut params = Params::new(declared);
        for (key, value) in given {
            params
                .set(key.get_ref(), value.get_ref())
                .map_err(|problem| fault(key.span(), problem))?;
        }
        for (key, value) in overrides {
            params.set(key, value).map_err(|problem| Fault {
                path: path.to_owned(),
                line: None,
                problem,
            })?;
        }
        Ok(params)
    };
    // What is imported has none.
    let no_params = |given: Parameters| -> Result<(), Fault> {
        if let Some((key, _)) = given.first_key_value() {
            return Err(invalid(key.span(), "`parameters` go with `generator` only"));
        }
        overrides.keys().next().map_or(Ok(()), |key| {
            let problem = Problem::unknown("parameter", key, []);
            Err(Fault { path: path.to_owned(), line: None, problem })
        })
    };
    let unknown = |name: &Spanned<String>, names: Vec<&str>| {
        fault(name.span(), Problem::unknown("generator", name.get_ref(), names))
    };

    let source = match (file.mesh, file.spheres) {
        (Some(mesh), None) => {
            let span = mesh.span();
            let mesh = mesh.into_inner();
            match (mesh.generator, mesh.import) {
                (Some(name), None) => {
                    if mesh.rgba.is_some() {
                        return Err(invalid(span, "`rgba` goes with `import` only").into());
                    }
                    let mut known = GENERATORS.iter();
                    let Some(generator) = known.find(|known| known.name() == name.get_ref()) else {
                        let names = GENERATORS.iter().map(|known| known.name());
                        return Err(unknown(&name, names.collect()).into());
                    };
                    Source::Generate(*generator, params(generator.parameters(), mesh.parameters)?)
                }
                (None, Some(asset)) => {
                    no_params(mesh.parameters)?;
                    Source::Import(asset, mesh.rgba.unwrap_or([255; 4]))
                }
                _ => {
                    let sentence = "`mesh` needs either `generator` or `import`";
                    return Err(invalid(span, sentence).into());
                }
            }
        }
        (None, Some(spheres)) => {
            let span = spheres.span();
            let SpheresFile { generator, parameters, import, colors, objects, rgba } =
                spheres.into_inner();
            match (generator, import) {
                (Some(name), None) => {
                    if colors.is_some() || objects.is_some() || rgba.is_some() {
                        let sentence = "`colors`, `objects` and `rgba` go with `import` only";
                        return Err(invalid(span, sentence).into());
                    }
                    let mut known = SPHERE_GENERATORS.iter();
                    let Some(generator) = known.find(|known| known.name() == name.get_ref()) else {
                        let names = SPHERE_GENERATORS.iter().map(|known| known.name());
                        return Err(unknown(&name, names.collect()).into());
                    };
                    let params = params(generator.parameters(), parameters)?;
                    Source::GenerateSpheres(*generator, params)
                }
                (None, Some(asset)) => {
                    no_params(parameters)?;
                    let options = StructureOptions {
                        colors: colors.unwrap_or_default(),
                        objects: objects.unwrap_or_default(),
                        rgba: rgba.unwrap_or([255; 4]),
                    };
                    Source::ImportStructure(asset, options)
                }
                _ => {
                    let sentence = "`spheres` needs either `generator` or `import`";
                    return Err(invalid(span, sentence).into());
                }
            }
        }
        (Some(_), Some(spheres)) => {
            let sentence = "a scene has either `mesh` or `spheres`, not both";
            return Err(invalid(spheres.span(), sentence).into());
        }
        (None, None) => {
            let sentence = "a scene needs either `mesh` or `spheres`";
            return Err(invalid(file.about.span(), sentence).into());
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
    Ok(Checked { about: file.about.into_inner(), source, shading, views, paths })
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
