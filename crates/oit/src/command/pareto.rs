//! `oit pareto`: what one view costs by exact techniques, by truncated ones and by methods: time, error
//! and memory of each, and which of them nothing beats.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use miette::{IntoDiagnostic, miette};
use oit_advise::{Evidence, Measured};
use oit_lab::{Experiment, Overrides, methods};
use oit_record::Record;

use crate::command::advise::{bytes, error_text, milliseconds};
use crate::command::render::{overrides, size};
use crate::command::sweep::{profile, run_with_bar, setup, summary};
use crate::command::{device_id, report};

/// Which view, and with what.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// A scene file.
    scene: PathBuf,
    /// One of the scene's views; the first if none is named.
    #[arg(long)]
    view: Option<String>,
    /// A scene parameter, `name=value`; may be given several times.
    #[arg(long = "set")]
    set: Vec<String>,
    /// Techniques that capture and sort, by coordinate or alias, joined by commas.
    #[arg(long, value_delimiter = ',', default_values_t = TECHNIQUES.map(str::to_owned))]
    techniques: Vec<String>,
    /// Methods, joined by commas, or `none`; if not given all there are, those with a size in half, one
    /// and two times that which they have by default.
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// The device: auto, cpu, vulkan:N, wgpu:N.
    #[arg(long, default_value = "auto")]
    device: String,
    /// 160x90 or 1920x1080.
    #[arg(long, value_parser = ["quick", "full"], default_value = "quick")]
    profile: String,
    /// Another width and height in pixels.
    #[arg(long)]
    size: Option<String>,
    /// Samples of each cell, in the place of the profile's.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    samples: Option<u32>,
    /// The run folder.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Go on with the run that is in the folder.
    #[arg(long)]
    resume: bool,
}

/// Exact ones of each layout that is fast somewhere, and one with arrays too small for deep pixels.
const TECHNIQUES: [&str; 9] = [
    "linked_list/bma-list/network+rbs/compute/peak",
    "linked_list/base/insertion/compute/peak",
    "linearized/bma-list/network+network_merge/compute/peak",
    "array3d/bma-list/network+rbs/compute/peak",
    "linked_list/bma-stencil/network+rbs/fragment/peak",
    "linked_list/bma-list/network+rbs/compute/max8",
    "linked_list/bma-list/network+rbs/compute/max16",
    "linked_list/bma-list/network+rbs/compute/max32",
    "linked_list/base/passthrough/compute/peak",
];

/// Every method, and other sizes of those that have one by default.
fn all_methods() -> Vec<String> {
    let mut names = Vec::new();
    for method in methods() {
        names.push(method.name().to_owned());
        let Some(size) = method.size() else { continue };
        for other in size.default.iter().flat_map(|n| [n / 2, n * 2]) {
            if size.range.contains(&other) {
                names.push(format!("{}/{}{other}", method.name(), size.word));
            }
        }
    }
    names
}

fn list(words: &[String]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
    quoted.join(", ")
}

fn experiment(
    arguments: &Arguments,
    scene: &str,
    view: &str,
    set: &Overrides,
) -> miette::Result<Experiment> {
    let sizes = match &arguments.size {
        Some(text) => {
            let size = size(text)?;
            [[size.width_px, size.height_px]; 2]
        }
        None => [[160, 90], [1920, 1080]],
    };
    let samples = |profile: u32| arguments.samples.unwrap_or(profile);
    let methods = match arguments.methods.as_slice() {
        [] => all_methods(),
        [none] if none == "none" => Vec::new(),
        named => named.to_vec(),
    };
    let values: Vec<String> = set.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    let text = format!(
        "about = \"Time, error and memory on one view.\"\nsource = \"oit pareto\"\n\
         [profile.quick]\nresolution = {:?}\nsamples = {}\nwarmup_ms = 50\ntimeout_s = 120\n\
         perceptual = true\n\
         [profile.full]\nresolution = {:?}\nsamples = {}\nwarmup_ms = 200\ntimeout_s = 60\n\
         perceptual = true\n\
         [[sweep]]\nviews = [{:?}]\nscene = {{ {} }}\ntechniques = [{}]\nmethods = [{}]\n",
        sizes[0],
        samples(5),
        sizes[1],
        samples(7),
        format!("{scene}:{view}"),
        values.join(", "),
        list(&arguments.techniques),
        list(&methods),
    );
    Experiment::parse(Path::new("pareto.toml"), text).map_err(report)
}

/// Measures, then prints what nothing beats.
pub(crate) fn run(arguments: &Arguments) -> miette::Result<()> {
    let set = overrides(&arguments.set)?;
    let scene = oit_scene::load(&arguments.scene, &set).map_err(report)?;
    let view = match &arguments.view {
        Some(name) => scene.view(name).map_err(report)?.name.clone(),
        None => scene.views[0].name.clone(),
    };
    let folder = arguments.scene.parent().filter(|folder| *folder != Path::new(""));
    let scenes = oit_scene::list(folder.unwrap_or(Path::new("."))).map_err(report)?;
    let experiment = experiment(arguments, &scene.name, &view, &set)?;
    let profile = profile(&arguments.profile);
    // A mistake in a name is found before anything runs.
    experiment.cells(profile, &scenes).map_err(report)?;
    let device = device_id(&arguments.device)?;
    let out = arguments.out.clone().unwrap_or_else(|| {
        let device = device.replace(':', "-");
        PathBuf::from(format!("runs/pareto-{}-{view}-{device}", scene.name))
    });
    let mut setup = setup(&device, profile, &scenes, out.clone())?;
    setup.resume = arguments.resume;
    let outcome = run_with_bar(&experiment, &setup, &|_| true)?;
    println!("{} in {}\n", summary(&outcome), out.display());
    let record = Record::read(&out).map_err(report)?;
    let evidence = Evidence::of_records(&[record]);
    let evidence = evidence.first().ok_or_else(|| miette!("no technique has a time"))?;
    print!("{}", page(&evidence.cells));
    std::io::Write::flush(&mut std::io::stdout()).into_diagnostic()
}

/// Every technique by rising error, then time; marked where no other is better in one of error and time
/// and as good in the other.
fn page(cells: &[Measured]) -> String {
    let mut cells: Vec<&Measured> = cells.iter().collect();
    cells.sort_by(|a, b| a.rmse.total_cmp(&b.rmse).then(a.total_ns.total_cmp(&b.total_ns)));
    let beaten = |cell: &Measured| {
        cells.iter().any(|other| {
            other.rmse <= cell.rmse
                && other.total_ns <= cell.total_ns
                && (other.rmse < cell.rmse || other.total_ns < cell.total_ns)
        })
    };
    let mut text =
        "By error, the exact first; * where no other is both faster and nearer to exact.\n\
                    Errors: root mean square, and the largest of a colour channel.\n\n"
            .to_owned();
    for cell in &cells {
        let mark = if beaten(cell) { ' ' } else { '*' };
        let (rmse, most) = (error_text(cell.rmse), error_text(cell.max_error));
        let errors = if cell.rmse == 0.0 { rmse } else { format!("{rmse}, {most}") };
        let _ = writeln!(
            text,
            "{mark} {:>12} {:>12}  {:<52} {errors}",
            milliseconds(cell.total_ns),
            bytes(cell.memory_bytes),
            cell.technique
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_marked() {
        let cell = |technique: &str, rmse: f64, total_ns: f64| Measured {
            technique: technique.into(),
            rmse,
            total_ns,
            ..Measured::default()
        };
        let cells = [
            cell("slow", 0.0, 3e6),
            cell("exact", 0.0, 2e6),
            cell("off", 0.1, 2e6),
            cell("fast", 0.2, 1e6),
        ];
        let text = page(&cells);
        let marked: Vec<&str> = text.lines().filter(|line| line.starts_with('*')).collect();
        assert_eq!(marked.len(), 2, "{text}");
        assert!(marked[0].contains("exact") && marked[1].contains("fast"), "{text}");
    }

    #[test]
    fn every_method_is_swept() {
        let names = all_methods();
        for method in methods() {
            assert!(names.iter().any(|name| name == method.name()));
        }
        for name in &names {
            assert!(oit_lab::parse_method(name).is_ok(), "{name}");
        }
    }
}
